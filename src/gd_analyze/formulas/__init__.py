"""Formulas of an arm's dynamics as values, and what writes them in a language."""
