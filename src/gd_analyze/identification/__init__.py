"""Identification from logs: linear equations, their solution, and physically consistent bodies."""
