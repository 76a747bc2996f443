"""Levels of simplification, what each does by its name; a new one is a file in `levels/` and a line here.

Apart from the levels themselves, so that the command line can offer them without loading NumPy.
"""

from __future__ import annotations

LEVEL_NAMES = {
    "element": "parts of D and h as a whole, the founding text's method",
    "term": "torque terms one by one: the fewest operations for arms of few terms",
    "recursive": "the recursion of Newton and Euler, pruned step by step: for arms of many terms",
    "energy": "the model remains a mechanical system, with symmetric D and its own energy",
}
