"""Text of others, such as an arm's title, made fit to stand in a comment of any language.

What could end a comment or continue a line there (*/, a backslash, ??/, three quotes), or turns the reading
around, is written out as <U+2A>.
"""

from __future__ import annotations

import re

from gd_analyze.text import shortened

_UNFIT = re.compile(r'[^\x20-\x7e]|[*\\?"`]')
_LONGEST = 120

_TEX = {
    "#": r"\#",
    "$": r"\$",
    "%": r"\%",
    "&": r"\&",
    "_": r"\_",
    "{": r"\{",
    "}": r"\}",
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    "<": r"\textless{}",
    ">": r"\textgreater{}",
    "|": r"\textbar{}",
}


def comment(text: str) -> str:
    """Write a foreign text for a comment.

    Examples
    --------
    >>> comment('arm */ int x; "??/')
    'arm <U+2A>/ int x; <U+22><U+3F><U+3F>/'
    """
    return _UNFIT.sub(lambda sign: f"<U+{ord(sign[0]):02X}>", shortened(text, _LONGEST))


def tex(text: str) -> str:
    r"""Write a foreign text for LaTeX.

    Examples
    --------
    >>> tex("50% of \\input{x}")
    '50\\% of \\textless{}U+5C\\textgreater{}input\\{x\\}'
    """
    return "".join(_TEX.get(sign, sign) for sign in comment(text))
