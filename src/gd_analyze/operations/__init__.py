"""Arithmetic as data: trace array code into a straight-line program, count it, run it."""
