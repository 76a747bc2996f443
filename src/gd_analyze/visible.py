r"""What others wrote, such as names and cells of files, made fit to be shown on one line.

A name may hold an escape sequence that clears the terminal, a newline that feigns a message, or a sign that
turns the direction of writing around. Such signs are written out: \x1b, \n, \u202e.
"""

from __future__ import annotations

import unicodedata

# Of a long text so much of the end stays: where a path has its name, and a message its line and column.
_END = 40


def visible(text: str) -> str:
    r"""Write out every sign of a text that shows nothing but acts: control, format and line signs.

    Examples
    --------
    >>> visible("red \x1b[31m")
    'red \\x1b[31m'
    """
    if text.isprintable():
        return text
    return "".join(sign if _shows(sign) else _written_out(sign) for sign in text)


def in_python(value: object) -> str:
    """Write a value as Python does; of one that Python refuses to write, such as 10**5000, only its kind.

    Examples
    --------
    >>> in_python("0.1"), in_python(10**5000)
    ("'0.1'", 'int, too large to be shown')
    """
    try:
        return repr(value)
    except (ValueError, RecursionError):
        return f"{type(value).__name__}, too large to be shown"


def shortened(text: str, most: int) -> str:
    """Cut the middle out of a text of more than `most` signs, and say how long it was.

    Examples
    --------
    >>> shortened("x" * 1000, 100)
    'xxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxx ... (1000 characters) ... xxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxx'
    """
    if len(text) <= most:
        return text
    gap = f" ... ({len(text)} characters) ... "
    return f"{text[: most - _END - len(gap)]}{gap}{text[-_END:]}"


def _shows(sign: str) -> bool:
    # Spaces of every width are no printable signs to Python, yet do no harm.
    return sign.isprintable() or unicodedata.category(sign) == "Zs"


def _written_out(sign: str) -> str:
    return sign.encode("unicode_escape").decode("ascii")
