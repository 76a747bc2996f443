"""Python with CasADi: a casadi.Function of each, to differentiate and generate code of."""

from __future__ import annotations

from typing import ClassVar

from gd_analyze.exporting.languages.python import Python


class Casadi(Python):
    """Functions of CasADi's symbols."""

    files: ClassVar = {"_casadi.py": "casadi.py.jinja"}
    module = short = "casadi"


LANGUAGE = Casadi
