"""What a run found: labelled tables, what is said of them, and their file."""
