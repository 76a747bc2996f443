"""Level "fast": a program of few operations found by a search, without terms to keep or drop."""

from __future__ import annotations

from importlib.util import find_spec
from typing import Any, ClassVar

from pydantic import TypeAdapter

from gd_analyze.errors import ModelError, UsageError
from gd_analyze.formulas.formula import Formula
from gd_analyze.operations.program import Program
from gd_analyze.simplification.exact import ExactForm
from gd_analyze.simplification.level import Checked, Level, Terms
from gd_analyze.simplification.torque_program import Effort


class FastLevel(Level):
    """The shortest torque program within the budget that a search finds; the program is the model."""

    name: ClassVar[str] = "fast"
    keeps: ClassVar[str] = "operations"
    is_program: ClassVar[bool] = True
    entries: ClassVar[TypeAdapter[Any]] = TypeAdapter(list[Checked])

    def terms(self, form: ExactForm) -> Terms:
        """None: the program is the model."""
        return {}

    def write(self, form: ExactForm, terms: Terms, effort: Effort) -> Program:
        """The exact program: without a search there is no other."""
        return form.program

    def formulas(self, form: ExactForm, terms: Terms) -> tuple[Formula, ...]:
        """None: equations are those of the program, see `SimplifiedModel.formulas`."""
        return ()

    def to_entry(self, term: Any, weight: float) -> Checked:
        """There are no terms."""
        raise ModelError("a model of level fast has no terms")

    def from_entry(self, form: ExactForm, entry: Any) -> tuple[Any, float]:
        """There are no terms."""
        raise ModelError("a model of level fast has no terms", expected="none")


FAST: FastLevel = FastLevel()


def require_numba() -> None:
    """Raise a UsageError, with the command that installs it, without the package that compiles the search."""
    if find_spec("numba") is None:
        raise UsageError(
            "level fast needs Numba, which is not installed",
            where="level",
            next_step="run `pip install numba`, or take the default level term",
        )
