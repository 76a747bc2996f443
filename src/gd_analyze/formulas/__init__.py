"""Formulas of an arm's dynamics as values, and their printers."""
