"""Names and sentences that an arm carries into terminals, tables, figures and pages."""

from __future__ import annotations

from collections.abc import Iterable

from gd_analyze.errors import ArmError, Location
from gd_analyze.text import in_python, visible

# More than any column or figure has room for.
LONGEST_NAME = 200


def require_name(name: object, what: str, where: Location | str) -> None:
    """Raise an ArmError unless a name is text of one line that only shows.

    Parameters
    ----------
    name
        What was given.
    what
        Whose: "a joint's name".
    where
        For the message.
    """
    if not isinstance(name, str):
        raise ArmError(f"{what} is not text", where=where, expected="text", found=in_python(name))
    if visible(name) != name:
        raise ArmError(
            f"{what} holds signs that do not show",
            where=where,
            expected="one line without control and formatting characters",
            found=visible(name),
            next_step="retype the name",
        )
    if len(name) > LONGEST_NAME:
        raise ArmError(
            f"{what} is too long", where=where, expected=f"at most {LONGEST_NAME} characters", found=name
        )


def require_sentences(texts: Iterable[object], what: str, where: Location | str) -> None:
    """Raise an ArmError unless texts of one or more lines show all they hold."""
    for text in texts:
        shown = " ".join(text.split()) if isinstance(text, str) else text
        if not isinstance(shown, str) or visible(shown) != shown:
            raise ArmError(
                f"{what} is not text that shows",
                where=where,
                expected="text without control and formatting characters, but for ends of lines",
                found=in_python(text),
                next_step="retype it",
            )
