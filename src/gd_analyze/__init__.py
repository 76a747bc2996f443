"""gd-analyze."""
