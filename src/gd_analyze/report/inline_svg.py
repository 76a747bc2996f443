"""A drawing made for paper as part of a page: its colours follow the theme, its text the page's font."""

from __future__ import annotations

import re
from xml.sax.saxutils import quoteattr

from markupsafe import Markup

from gd_analyze.figures.colours import ON_PAPER

# Colours that several names share are the same on a page, too, but for white, which is paper.
_VARIABLES = {colour: f"var(--{name})" for name, colour in reversed(ON_PAPER.items())}


def inline_svg(svg: str, name: str, label: str) -> Markup:
    """Prepare what `Canvas.svg` wrote for a page.

    Parameters
    ----------
    svg
        The drawing.
    name
        A word that no other drawing of the page has: its marks are named by it.
    label
        What it shows, for those who do not see it.
    """
    size = re.search(r'viewBox="[^"]*"', svg)
    inside = svg[svg.index("<defs>") : svg.rindex("</svg>")]
    inside = re.sub(r"<defs>\s*<style.*?</defs>", "", inside, count=1, flags=re.DOTALL)
    inside = re.sub(r'<g id="[^"]*">', "<g>", inside)
    inside = re.sub(r'(id="|xlink:href="#)m', lambda found: f"{found[1]}{name}-m", inside)
    inside = inside.replace("xlink:href", "href")
    inside = re.sub(r"font-family: [^;]*; ", "", inside)
    inside = re.sub("#[0-9a-f]{6}", lambda found: _VARIABLES.get(found[0], found[0]), inside)
    return Markup(
        f'<svg xmlns="http://www.w3.org/2000/svg" {size[0] if size else ""} role="img" '
        f'aria-label={quoteattr(label)} stroke-linejoin="round">{inside}</svg>'
    )
