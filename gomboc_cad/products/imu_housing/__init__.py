"""The IMU calibration housing."""
