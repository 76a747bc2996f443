"""A simplified model: it evaluates torque, D, h and c, and states its accuracy."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from gd_analyze.arrays import FloatArray, set_points_last
from gd_analyze.errors import ModelError, require_type
from gd_analyze.formulas.formula import Formula, Legend
from gd_analyze.formulas.languages import Plain, Written
from gd_analyze.formulas.writing import element_formulas, factor_legend
from gd_analyze.guesses import DYNAMICS, guessing
from gd_analyze.harmonics.expansion import Expansion, expanded
from gd_analyze.harmonics.terms import Torques
from gd_analyze.motions.states import broadcast_states
from gd_analyze.operations.functions import Functions, functions_of, inertia_program
from gd_analyze.operations.program import OperationCount, Program
from gd_analyze.robots.arm import RobotArm
from gd_analyze.simplification.accuracy import STATED, Accuracy, SearchStep, budget_notice
from gd_analyze.simplification.exact import ExactForm
from gd_analyze.simplification.exact_dynamics import ExactDynamics
from gd_analyze.simplification.harmonic import TERM, HarmonicLevel
from gd_analyze.simplification.inertia_error import gammas
from gd_analyze.simplification.level import Level, Terms
from gd_analyze.simplification.torque_program import COUNTING, FINAL, functions_of_terms
from gd_analyze.text import amount, html_of, joint_name, percent

if TYPE_CHECKING:
    from gd_analyze.exporting.export import Exported

# Most terms of equations shown in a notebook.
_MOST_SHOWN = 500


@dataclass(frozen=True, eq=False, kw_only=True)
class SimplifiedModel:
    """A simplified torque model of an arm, with its stated error.

    Parameters
    ----------
    level
        How far the dynamics were split, a value of `LEVELS`.
    form
        The exact dynamics that it approximates.
    terms
        Coefficients by kept term, of the level's own type; all else follows.
    accuracy
        Budget, errors, and the states at which they were measured.
    provenance
        Versions, time, command.
    """

    level: Level
    form: ExactForm
    terms: Terms
    accuracy: Accuracy
    provenance: Mapping[str, str] = field(default_factory=dict)

    if not TYPE_CHECKING:  # checkers are to refuse unknown names
        __getattr__ = guessing(DYNAMICS)

    def __repr__(self) -> str:
        return f"SimplifiedModel({self.arm.name!r}, level {self.level.name}, {self._summary})"

    @property
    def _summary(self) -> str:
        """Operations and error."""
        accuracy = self.accuracy
        joint = int(accuracy.shares.argmax())
        states = "set points" if "trajectory" in accuracy.fitted_on else "states tried"
        states += "" if accuracy.measured else f", {STATED}"
        return (
            f"{self.operations.total} of {self.operations_full.total} operations, "
            f"{self.operations.sines_cosines} of {self.operations_full.sines_cosines} sines and cosines, "
            f"error up to {percent(float(accuracy.shares[joint]))} of {accuracy.asked.shares_of} "
            f"(joint {joint + 1}) at the {states}"
        )

    def _repr_html_(self) -> str:
        """Its accuracy and equations, for a notebook."""
        errors = self.accuracy.errors
        columns = np.array([errors.peak_torque, self.accuracy.allowed, errors.largest, errors.rms])
        rows = [
            [joint_name(i + 1, joint.name), *(amount(x, joint.effort_unit) for x in columns[:, i].tolist())]
            for i, joint in enumerate(self.arm.joints)
        ]
        printer = Plain()
        written = Written(())
        if len(self.terms) <= _MOST_SHOWN:
            written = self.equations if self.level is TERM else Written(self.formulas, self.legend)
        lines = [printer.wrapped(formula, 100) for formula in written.formulas]
        legend = ", ".join(printer.legend(written.legend)) if written.legend else ""
        return html_of(
            f"{self.arm.title or self.arm.name}: {self.size[0]} of {self.size[1]} {self.level.keeps}",
            ["joint", "peak torque", "allowed error", "error up to", "RMS error"],
            rows,
            f"{self._summary}; budget {self.accuracy.budget}.",
            "\n".join([*lines, *filter(None, [legend])]),
        )

    @property
    def size(self) -> tuple[int, int]:
        """Number of its `level.keeps`, and of all."""
        return len(self.terms), len(self.level.terms(self.form))

    @property
    def has_terms(self) -> bool:
        """Whether it is a sum of harmonic terms, so that its D is symmetric, rather than of parts."""
        return isinstance(self.level, HarmonicLevel)

    @property
    def is_of_some_parts(self) -> bool:
        """Whether it is a sum of parts, and not of all."""
        return not (self.has_terms or self.drops_nothing)

    def promised(self, accuracy: Accuracy) -> FloatArray:
        """Largest error, N m (N), that it promises at the states of an accuracy of it, shape (n,).

        A model of some parts may miss its budget: it promises the error that it has there.
        """
        if self.is_of_some_parts:
            return np.maximum(accuracy.allowed, accuracy.errors.largest)
        return accuracy.allowed

    @property
    def arm(self) -> RobotArm:
        """The arm that it models."""
        return self.form.arm

    @property
    def drives(self) -> bool:
        """Whether drive inertia is part of it."""
        return self.form.drives

    @property
    def operations_full(self) -> OperationCount:
        """Operations of the cheapest exact torque known; beside a model of some parts a bound of them.

        Such a model seldom saves any, which the exact program at hand shows without a search.
        """
        if self.is_of_some_parts:
            at_hand = self.form.program_at_hand.count
            if self.operations.total >= at_hand.total:
                return at_hand
        return self.form.operations

    @property
    def functions_full(self) -> Functions:
        """Exact D, h and c in the fewest operations known; for some parts, those at hand."""
        return self.form.functions_at_hand if self.is_of_some_parts else self.form.functions

    @property
    def saves(self) -> bool:
        """Whether it takes fewer operations than exact in anything that it is offered for."""
        return self.saves_torque or self.saves_functions

    @property
    def saves_torque(self) -> bool:
        """Whether its torque takes fewer operations than the exact one."""
        return self.operations.total < self.operations_full.total

    @property
    def saves_functions(self) -> bool:
        """Whether its D, h and c take fewer operations than the exact ones, at a level that offers them."""
        if self.level is not TERM:
            return False
        return self.functions.operations.total < self.functions_full.operations.total

    @property
    def operations_minimized(self) -> OperationCount:
        """Operations that its search minimised: of D, h and c at level term, else of the torque."""
        return self.functions.operations if self.level is TERM else self.operations

    @property
    def is_exact(self) -> bool:
        """Whether it is the exact torque, with no saving and no error."""
        return not (self.accuracy.errors.largest.any() or self.saves)

    @property
    def is_torque_only(self) -> bool:
        """Whether its D is unfit for feedback and forward dynamics: gamma is known, and not below 1."""
        return self.accuracy.gamma is not None and not self.accuracy.gamma < 1.0

    @property
    def notice(self) -> str:
        """Joints whose budget is below friction or uncertainty, and what to do; "" if none."""
        return budget_notice(self.arm, self.accuracy)

    @cached_property
    def torques(self) -> Torques:
        """Its torques as harmonic terms; a ModelError if its level has none."""
        return self.level.torques(self.form, self.terms)

    @property
    def formulas(self) -> tuple[Formula, ...]:
        """Its torques as equations, one per joint."""
        return self.level.formulas(self.form, self.terms)

    @property
    def equations(self) -> Written:
        """Its D, J (drives), h and c in joint velocities, an element per line; prints, also in a notebook.

        Raises a ModelError if its level has no torque terms.
        """
        return self.by_element(self.torques)

    def by_element(self, torques: Torques) -> Written:
        """Write any torque terms of its arm as `equations` does."""
        printed = self.form.printed(torques)
        drives = self.arm.drive_inertia.tolist() if self.drives else ()
        factors = {factor for term in printed for factor in term.monomial}
        return Written(element_formulas(printed, drives), factor_legend(factors))

    @property
    def legend(self) -> Legend:
        """Meaning of the names in its equations."""
        return self.level.legend(self.form, self.terms)

    @cached_property
    def operations(self) -> OperationCount:
        """Operations of one evaluation of all torques."""
        return self.program.count

    def torque(self, q: FloatArray, qd: FloatArray, qdd: FloatArray) -> FloatArray:
        """Generalized torque of the simplified model.

        Parameters
        ----------
        q, qd, qdd
            Joint variables, velocities and accelerations, rad (m) and per s, s^2, shape (..., n).

        Returns
        -------
        numpy.ndarray
            N m (N), shape (..., n).

        Raises
        ------
        ModelError
            If shapes do not fit, or a value is not a number, not finite or too large.
        """
        return self._evaluated(self.program, q, qd, qdd)

    def inertia(self, q: FloatArray) -> FloatArray:
        """Simplified D, kg m^2, shape (..., n, n); drive inertia, if included, is on the diagonal."""
        return self._matrix(self.functions.inertia, q)

    def coriolis_centrifugal(self, q: FloatArray, qd: FloatArray) -> FloatArray:
        """Simplified h, N m, shape (..., n)."""
        return self._evaluated(self.functions.coriolis_centrifugal, q, qd)

    def gravity_loading(self, q: FloatArray) -> FloatArray:
        """Simplified c, N m, shape (..., n)."""
        return self._evaluated(self.functions.gravity_loading, q)

    def save(self, path: str | Path) -> None:
        """Write the model as JSON, see `gd_analyze.save_model`."""
        import gd_analyze as gd  # whose functions are on floors above

        gd.save_model(self, path)

    def export(
        self, languages: str | Sequence[str], folder: str | Path | None = None, **options: Any
    ) -> Exported:
        """Write the model in other languages, see `gd_analyze.export`."""
        import gd_analyze as gd

        return gd.export(self, languages, folder, **options)

    def stating(
        self, accuracy: Accuracy | None = None, provenance: Mapping[str, str] | None = None
    ) -> SimplifiedModel:
        """The same model with other statements; what was derived from its terms is not derived again."""
        model = copy(self)
        if accuracy is not None:
            object.__setattr__(model, "accuracy", accuracy)
        if provenance is not None:
            object.__setattr__(model, "provenance", dict(provenance))
        return model

    def drafted(self) -> SimplifiedModel:
        """The same model with a program written in milliseconds, to be looked at in a search."""
        model = copy(self)
        vars(model)["program"] = self.level.write(self.form, self.terms, COUNTING)
        return model

    @cached_property
    def drops_nothing(self) -> bool:
        """Whether it keeps all terms of its level, and is the exact dynamics."""
        return self.terms == self.level.terms(self.form)

    @cached_property
    def program(self) -> Program:
        """Its torques as a straight-line program of few operations."""
        if self.drops_nothing:
            return self.form.program
        return self.level.write(self.form, self.terms, FINAL)

    @cached_property
    def expansion(self) -> Expansion:
        """Its program written out; a ModelError if that is no torque of an arm, or too long."""
        return expanded(self.program, [not revolute for revolute in self.arm.is_revolute])

    @cached_property
    def functions(self) -> Functions:
        """D, h and c as programs of their own, from their terms or, without terms, from the torque."""
        if self.drops_nothing:
            return self.form.functions
        if not self.has_terms:
            return functions_of(self.program, self.arm.n_joints)
        by_terms = functions_of_terms(self.form.velocities, self.torques, FINAL)
        return by_terms.cheapest(functions_of(self.program, self.arm.n_joints, symmetric=True))

    def gamma(self, exact: ExactDynamics) -> float:
        """Largest magnitude of the eigenvalues of D^-1 Ds - I at given states, with its own D as Ds.

        Below 1, a symmetric Ds is positive definite there, and feedback through it converges.
        """
        return float(self.gammas(exact).max(initial=0.0))

    def gammas(self, exact: ExactDynamics) -> FloatArray:
        """The same at every position, shape (N,), with D from the torque's program, as a search has it."""
        inertia = inertia_program(self.program, self.arm.n_joints, self.has_terms)
        return gammas(exact.inertia, self._matrix(inertia, exact.states.q))

    def _matrix(self, program: Program, q: FloatArray) -> FloatArray:
        rows = self._evaluated(program, q)
        return rows.reshape(*rows.shape[:-1], self.arm.n_joints, self.arm.n_joints)

    def _evaluated(self, program: Program, *states: FloatArray) -> FloatArray:
        quantities = dict(zip(("q", "qd", "qdd"), states, strict=False))
        arrays = broadcast_states(self.arm, ModelError, **quantities)
        inputs = {
            f"{name}{i + 1}": row
            for name, array in zip(quantities, arrays, strict=True)
            for i, row in enumerate(set_points_last(array))
        }
        values = program.run(inputs)
        return np.ascontiguousarray(values.T).reshape(*arrays[0].shape[:-1], len(values))


def require_model(value: object) -> None:
    """Raise a UsageError unless an argument is a model."""
    require_type(value, SimplifiedModel, "model", "a model, as `simplify` or `load_model` returns it")


def exactly(exact: ExactDynamics, level: Level, allowed: FloatArray, budget: str) -> SimplifiedModel:
    """Make the exact model, in the fewest operations known."""
    return model_of_terms(exact, level, level.terms(exact.form), allowed, budget)


def model_of_terms(
    exact: ExactDynamics, level: Level, terms: Terms, allowed: FloatArray, budget: str
) -> SimplifiedModel:
    """Make the model of some terms, with its errors."""
    no_errors = exact.errors_of(exact.torque)
    accuracy = Accuracy(allowed, budget, no_errors, exact.states.described, uncertainty=exact.uncertainty)
    return measured(exact, SimplifiedModel(level=level, form=exact.form, terms=terms, accuracy=accuracy))


def with_rewriting(model: SimplifiedModel) -> SimplifiedModel:
    """State the last step of a search: its terms, written in fewer operations than the search counted."""
    steps, operations = model.accuracy.steps, model.operations_minimized.total
    if steps and operations < steps[-1].operations:
        steps = (*steps, SearchStep("rewriting", operations))
    return model.stating(replace(model.accuracy, steps=steps))


def measured(exact: ExactDynamics, model: SimplifiedModel) -> SimplifiedModel:
    """State the errors of a model's own program."""
    return model.stating(exact.held(model.accuracy, model.torque(*exact.states.arrays)))


def with_gamma(exact: ExactDynamics, model: SimplifiedModel) -> SimplifiedModel:
    """State gamma of a model over states, see `SimplifiedModel.gamma`."""
    return model.stating(replace(model.accuracy, gamma=model.gamma(exact)))
