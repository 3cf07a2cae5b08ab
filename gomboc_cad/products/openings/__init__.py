"""What opens the outer surface: where it may be, and what it does."""
