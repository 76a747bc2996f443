"""One table of colours: the page's style, the figures on paper and Typst's templates take theirs from it.

Translation and rotation have Okabe and Ito's blue and vermillion, told apart by all forms of colour vision
and lightened on dark paper; forms for letters meet a contrast of 4.5 to 1.
"""

from __future__ import annotations

import json
from itertools import cycle
from pathlib import Path
from typing import Any

from gd_analyze.text import LEVEL_NAMES

# Name: colour on light and on dark paper.
COLOURS: dict[str, list[str]] = json.loads(
    (Path(__file__).parent / "colours.json").read_text(encoding="utf-8")
)
ON_PAPER = {name: light for name, (light, _) in COLOURS.items()}

# Colour and mark of every level of simplification in the trade-off.
_SERIES: tuple[tuple[str, Any], ...] = (
    ("series-6", "square"),
    ("series-3", "circle"),
    ("series-2", "triangle"),
    ("series-4", "diamond"),
)
OF_LEVEL = dict(zip(LEVEL_NAMES, cycle(_SERIES)))


def css_variables() -> str:
    """Style of a page: every colour as a variable that follows the theme."""
    pairs = (f"--{name}: light-dark({light}, {dark});" for name, (light, dark) in COLOURS.items())
    return f":root {{ {' '.join(pairs)} }}\n"
