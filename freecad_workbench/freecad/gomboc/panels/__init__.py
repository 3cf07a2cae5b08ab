"""Task panels, the dialog of the first use, and what the status bar shows."""
