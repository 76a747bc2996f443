"""Python: one module that needs NumPy alone."""

from __future__ import annotations

import keyword
import sys
from typing import Any, ClassVar

from gd_analyze.exporting.export_input import ExportInput
from gd_analyze.exporting.language import Language


class Python(Language):
    """Python with NumPy, or a module that has the same functions."""

    files: ClassVar = {".py": "python.py.jinja"}
    comment = ('"""', "", '"""\n')
    # A file with the name of one of Python's own modules would hide that.
    reserved = frozenset(
        {*keyword.kwlist, *keyword.softkwlist, *sys.stdlib_module_names, "numpy", "np", "print", "len"}
    )

    # The module with sin, cos and arrays, and the name it is imported by.
    module: ClassVar[str] = "numpy"
    short: ClassVar[str] = "np"

    @property
    def functions(self) -> dict[str, str]:
        """Names of sine and cosine."""
        return {name: f"{self.short}.{name}" for name in ("sin", "cos")}

    def values(self, given: ExportInput) -> dict[str, Any]:
        """The module's names."""
        return super().values(given) | {"module": self.module, "short": self.short}


LANGUAGE = Python
