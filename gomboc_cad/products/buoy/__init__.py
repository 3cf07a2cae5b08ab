"""The buoy."""
