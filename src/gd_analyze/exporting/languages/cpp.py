"""C++: a header of templates on the scalar, so that types that differentiate themselves work; Eigen, too."""

from __future__ import annotations

from typing import ClassVar

from gd_analyze.exporting.language import Language


class Cpp(Language):
    """C++11 and later."""

    files: ClassVar = {".hpp": "cpp.hpp.jinja"}
    comment = ("/*\n", " *", " */\n")

    def number(self, value: float) -> str:
        """Write a number of the scalar's type."""
        return f"T({value!r})"


LANGUAGE = Cpp
