"""Mathematics for HTML: native MathML, so that a page needs no script and no font of its own."""

from __future__ import annotations

import re

from markupsafe import Markup, escape

_EFFECTS = {"translation": "tran", "rotation": "rot"}


def math(*content: Markup, block: bool = False) -> Markup:
    """One formula; in its own line if `block`."""
    display = Markup(' display="block"') if block else Markup("")
    return Markup("<math{}>{}</math>").format(display, row(*content))


def row(*content: Markup) -> Markup:
    """Side by side."""
    return Markup("<mrow>{}</mrow>").format(Markup("").join(content))


def name(letters: str) -> Markup:
    """Variable."""
    return Markup("<mi>{}</mi>").format(letters)


def num(digits: object) -> Markup:
    """Number."""
    return Markup("<mn>{}</mn>").format(digits)


def op(symbol: str) -> Markup:
    """Operator or bracket that keeps its size."""
    return Markup('<mo stretchy="false">{}</mo>').format(symbol)


def words(text: str) -> Markup:
    """Upright text inside a formula."""
    return Markup("<mtext>{}</mtext>").format(text)


def sub(base: Markup, index: Markup) -> Markup:
    """Index."""
    return Markup("<msub>{}{}</msub>").format(base, index)


def sup(base: Markup, exponent: Markup) -> Markup:
    """Exponent."""
    return Markup("<msup>{}{}</msup>").format(base, exponent)


def subsup(base: Markup, index: Markup, exponent: Markup) -> Markup:
    """Index and exponent."""
    return Markup("<msubsup>{}{}{}</msubsup>").format(base, index, exponent)


def over(base: Markup, accent: str) -> Markup:
    """Accent, such as the dots of a rate."""
    return Markup('<mover accent="true">{}<mo stretchy="false">{}</mo></mover>').format(base, accent)


def total(below: Markup, above: Markup) -> Markup:
    """Sum with its limits."""
    return Markup('<munderover><mo movablelimits="false">∑</mo>{}{}</munderover>').format(below, above)


def table(rows: list[list[Markup]]) -> Markup:
    """Matrix in brackets."""
    cells = Markup("").join(
        Markup("<mtr>{}</mtr>").format(Markup("").join(Markup("<mtd>{}</mtd>").format(cell) for cell in line))
        for line in rows
    )
    return Markup('<mo fence="true">[</mo><mtable>{}</mtable><mo fence="true">]</mo>').format(cells)


def element(label: str, kept: str = "both") -> Markup:
    """Symbol of an element, e.g. D_12; with the effect as exponent where only one is meant."""
    symbol, index = name(label[0]), num(label[1:])
    if kept not in _EFFECTS or symbol == name("c"):
        return sub(symbol, index)
    return subsup(symbol, index, words(_EFFECTS[kept]))


def part(label: str) -> Markup:
    """Formula for a part's label such as "D12 translation"; other text comes back escaped."""
    match = re.fullmatch(r"([Dhc][0-9,]+)(?: (translation|rotation))?", label)
    return math(element(match[1], match[2] or "both")) if match else escape(label)


def acceleration(joint: int | str) -> Markup:
    """Second derivative of a joint variable."""
    return _joint_rate("¨", joint)


def absolute_acceleration(joint: int) -> Markup:
    """Second derivative of a joint's angle from the first joint whose axis is parallel to its own."""
    return math(sub(over(name("p"), "¨"), num(joint)))


def rate(joint: int | str) -> Markup:
    """First derivative of a joint variable."""
    return _joint_rate("˙", joint)


def _joint_rate(dots: str, joint: int | str) -> Markup:
    index = num(joint) if isinstance(joint, int) else name(joint)
    return sub(over(name("q"), dots), index)
