"""Level "program": the exact torque of an arm whose terms nobody could choose from, as the program alone."""

from __future__ import annotations

from typing import Any, ClassVar

from gd_analyze.errors import ModelError
from gd_analyze.formulas.formula import Formula
from gd_analyze.operations.program import Program
from gd_analyze.simplification.exact import ExactForm
from gd_analyze.simplification.level import Level, Terms
from gd_analyze.simplification.torque_program import Effort


class ProgramLevel(Level):
    """A model without terms, which the main job makes where no other can be read; no search takes it."""

    name: ClassVar[str] = "program"
    keeps: ClassVar[str] = "operations"
    is_program: ClassVar[bool] = True

    def terms(self, form: ExactForm) -> Terms:
        """None: the program is the model."""
        return {}

    def write(self, form: ExactForm, terms: Terms, effort: Effort) -> Program:
        """The exact program."""
        return form.program

    def formulas(self, form: ExactForm, terms: Terms) -> tuple[Formula, ...]:
        """None: equations are those of the program, see `SimplifiedModel.formulas`."""
        return ()

    def entry(self, term: Any) -> Any:
        """There are no terms."""
        raise ModelError("a model of level program has no terms")


PROGRAM: ProgramLevel = ProgramLevel()
