"""Simplified models: what one keeps at every level, how it is found, what is stated of its accuracy."""
