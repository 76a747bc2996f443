"""From logs to numbers: rows of linear equations, their solution, and bodies that are physically possible."""
