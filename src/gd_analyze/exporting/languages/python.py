"""Python: one module that needs NumPy alone."""

from __future__ import annotations

from typing import Any, ClassVar

from gd_analyze.exporting.export_input import ExportInput
from gd_analyze.exporting.language import Language


class Python(Language):
    """Python with NumPy, or a module that has the same functions."""

    files: ClassVar = {".py": "python.py.jinja"}
    comment = ('"""', "", '"""\n')

    # The module with sin, cos and arrays, and the name it is imported by.
    module: ClassVar[str] = "numpy"
    short: ClassVar[str] = "np"

    def function(self, name: str) -> str:
        """What sin or cos is called."""
        return f"{self.short}.{name}"

    def values(self, given: ExportInput) -> dict[str, Any]:
        """The module's names."""
        return super().values(given) | {"module": self.module, "short": self.short}


LANGUAGE = Python
