"""Facts and tables of a simplified model: operations, errors, and the reference of shares."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict
from typing import Any, NamedTuple

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.operations.program import OperationCount
from gd_analyze.result import AnyFact, Fact, Table, Value, joint_values, value_text
from gd_analyze.robots.arm import RobotArm
from gd_analyze.schema import declared_columns, declared_table
from gd_analyze.simplification.accuracy import FEEDFORWARD_ONLY, PROVEN, NormShare, gamma_words, share_of
from gd_analyze.simplification.harmonic import ENERGY, TERM
from gd_analyze.simplification.model import SimplifiedModel
from gd_analyze.text import named_joints, percent


class WorstError(NamedTuple):
    """The largest error of any joint, in the terms of the budget."""

    joint: int  # from 1
    value: float  # a share, or a torque in `unit`
    is_bound: bool  # a bound is rounded up
    of: str  # "peak torque", "the budget"; "" of a torque
    unit: str  # of a torque

    @property
    def reference(self) -> str:
        """What the value is a share of, or its unit."""
        return self.of or self.unit

    @property
    def size(self) -> str:
        """The figure alone: "0.94 %" or "0.93 N m"."""
        if self.of:
            return value_text(self.value, "", "bound_percent" if self.is_bound else "percent")
        return value_text(self.value, self.unit, "bound" if self.is_bound else "number")

    @property
    def text(self) -> str:
        """The figure and its reference: "0.94 % of peak torque"."""
        return f"{self.size} of {self.of}" if self.of else self.size

    def facts(self, key: str, label: str, lead: str = "", *, is_seen: bool = True) -> tuple[AnyFact, Value]:
        """Make it a fact, and a value of what it is a share of, or its unit.

        `lead` is "at most" for what is proven, "up to" for what is sampled.
        """
        text = f"{lead} {self.text}".lstrip()
        fact = Fact(key, label, self.value, text=text, note=f"joint {self.joint}")
        return fact.seen_if(is_seen), Value(f"{key}_of", self.reference)


def worst_error(model: SimplifiedModel, bound: FloatArray | None = None) -> WorstError:
    """Find the joint with the largest error, as stated by the model or by a bound, N m, shape (n,).

    The result is a share of peak torque for such a budget, in N m for a budget in N m for all joints, and
    otherwise a share of the budget.
    """
    budget, arm = model.accuracy.asked, model.arm
    error = model.accuracy.errors.largest if bound is None else bound
    in_torque = (
        budget.wholes == {"torque"} and len(set(budget.entries)) == 1 and len(set(arm.is_revolute)) == 1
    )
    sizes = error if in_torque else model.accuracy.shares_of(error)
    joint = int(sizes.argmax())
    if not np.isfinite(sizes[joint]):  # a joint without torque has no share of it
        sizes, in_torque = error, True
    reference, unit = ("", arm.joints[joint].effort_unit) if in_torque else (budget.shares_of, "")
    return WorstError(joint + 1, float(sizes[joint]), bound is not None, reference, unit)


# Kinds of operations in words.
_OPERATIONS = {
    "multiplications": "multiplications",
    "additions": "additions",
    "total": "both",
    "sines_cosines": "sines and cosines",
}


def counts_by_kind(count: OperationCount) -> dict[str, int]:
    """Operations of each kind, and their total."""
    return asdict(count) | {"total": count.total}


def operations_table(operations: OperationCount, exact: OperationCount) -> Table:
    """Operations of a model and of the exact torque by kind, for pages; `operation_facts` are for JSON."""
    simplified, full = counts_by_kind(operations), counts_by_kind(exact)
    values = {
        "kind": [*_OPERATIONS.values()],
        "exact": [full[kind] for kind in _OPERATIONS],
        "model": [simplified[kind] for kind in _OPERATIONS],
        "saved": [1.0 - simplified[kind] / full[kind] if full[kind] else 0.0 for kind in _OPERATIONS],
    }
    columns = declared_columns("operations", values, [*values])
    return Table("operations", "Operations for one evaluation of all torques", columns)


def operation_facts(model: SimplifiedModel) -> tuple[AnyFact, ...]:
    """Operations of a model, and of the exact dynamics."""
    simplified, full = model.operations, model.operations_full
    function_sets = model.functions, model.functions_full
    counts_apart = [
        {name: counts_by_kind(program.count) for name, program in functions._asdict().items()}
        for functions in function_sets
    ]
    return (
        Fact(
            "operations",
            "Torque, operations",
            counts_by_kind(simplified),
            text=f"{simplified}{_beside_exact(model)}{full.pair}",
        ),
        Value("operations_full", counts_by_kind(full)),
        Value("nanoseconds", model.operations.nanoseconds),
        Fact("operations_apart", "D h c, operations", counts_apart[0], text=apart_text(model)),
        Value("operations_apart_full", counts_apart[1]),
        gamma_fact(model),
        Value("saves", model.saves),
        Value("saves_torque", model.saves_torque),
        Value("saves_functions", model.saves_functions),
    )


def apart_text(model: SimplifiedModel) -> str:
    """Operations of D, h and c, each a function: "29 + 24 + 13 = 66, 20 sin and cos, instead of ..."."""
    sums = []
    for functions in (model.functions, model.functions_full):
        counts = [program.count.total for program in functions]
        angles = functions.operations.sines_cosines
        sums.append(f"{' + '.join(map(str, counts))} = {sum(counts)}, {angles} sin and cos")
    return _beside_exact(model).join(sums)


def _beside_exact(model: SimplifiedModel) -> str:
    """How the exact operations are introduced: of few parts, they are those that need no search."""
    return ", exact at most " if model.is_of_some_parts else " instead of "


def gamma_fact(model: SimplifiedModel) -> Fact | Value:
    """How far the mass matrix is off, and what that allows."""
    gamma = model.accuracy.gamma
    if gamma is None or structure_note(model):  # which says it
        return Value("gamma", gamma)
    return Fact("gamma", "Mass matrix", gamma, text=gamma_words(gamma))


MASS_MATRIX = "Mass matrix, difference from the exact one"
H_NOTE = "h is not derived from D, so energy is not conserved (`--level energy` keeps it)."


def structure_note(model: SimplifiedModel) -> str:
    """Uses of D and of h of a model of terms, a line each; "" if both are exact or the level has no terms."""
    if not model.has_terms or model.is_exact:
        return ""
    gamma = model.accuracy.gamma
    h_note = "" if model.level is ENERGY else H_NOTE
    return "\n".join(filter(None, [h_note, "" if gamma is None else f"Mass matrix {gamma_words(gamma)}."]))


# What people see of the errors by joint, in order; beside a bound a terminal has no room for the RMS error.
_ERRORS_ON_PAGE = [
    "joint", "peak_torque", "allowed_error", "largest_error", "share_of_whole", "rms_error",
    "bound", "bound_of_whole", "found",
]  # fmt: skip


def joint_error_values(model: SimplifiedModel) -> dict[str, FloatArray]:
    """Errors that a model states for its joints, by the names of the table "simplified_model"."""
    errors = model.accuracy.errors
    return {
        "peak_torque": errors.peak_torque,
        "allowed_error": model.accuracy.allowed,
        "largest_error": errors.largest,
        "rms_error": errors.rms,
        "largest_share": errors.largest_share,
        "rms_share": errors.rms_share,
    }


def joint_errors(
    model: SimplifiedModel,
    proven: FloatArray | None = None,
    proof: str = PROVEN,
    further: Mapping[str, FloatArray] | None = None,
) -> Table:
    """Errors that a model states for its joints, and bounds, N m, shape (n,), if known, proven or stated.

    `further` values are for JSON; of these people see the error "found".
    """
    accuracy, values = model.accuracy, joint_error_values(model)
    of_allowed = {"largest_of_allowed": share_of(values["largest_error"], accuracy.allowed)}
    is_proven = proven is not None and bool(np.isfinite(proven).all())
    seen: dict[str, Any] = {"share_of_whole": accuracy.shares, "bound": None, "bound_of_whole": None}
    if model.is_exact:
        seen |= {"largest_error": None, "share_of_whole": None, "rms_error": None}
    elif proven is not None and is_proven:
        seen |= {"bound": proven, "bound_of_whole": accuracy.shares_of(proven)}
    seen["found"] = (further or {}).get("found")
    whole = "peak" if accuracy.asked.shares_of == "peak torque" else "budget"
    of_all = "Peak, allowed and shares are over all motions; along each of them its own peak counts, too."
    return declared_table(
        "simplified_model",
        "joints",
        f"Torque error by joint, budget {accuracy.asked.words}",
        {**joint_values(model.arm.joints), **values, **of_allowed, **(further or {})},
        [name for name in _ERRORS_ON_PAGE if name != "rms_error" or not is_proven],
        _ERRORS_ON_PAGE,
        note=of_all if accuracy.motions else "",
        seen=seen,
        words={"share_of_whole": whole, "bound": proof, "bound_of_whole": whole},
    )


def norm_facts(norms: Sequence[NormShare], arm: RobotArm) -> tuple[AnyFact, ...]:
    """Norm of the torque error over norm of the torque, by share of states."""
    if not norms:
        return (Value("norms", []),)
    rows = [{"states": norm.states, "share": norm.share} for norm in norms]
    note = "revolute and prismatic joints apart" if len(set(arm.is_revolute)) > 1 else ""
    return (Fact("norms", "Norm, error/torque", rows, text=norms_text(norms), note=note),)


def norms_text(norms: Iterable[NormShare]) -> str:
    """Such shares: "0.91 % at 95 % of the states, 2.1 % at 99.9 % of the states"."""
    return ", ".join(
        f"{percent(norm.share)} at "
        + ("all states" if norm.states == 1.0 else f"{100 * norm.states:.10g} % of the states")
        for norm in norms
    )


def error_text(model: SimplifiedModel) -> str:
    """Largest error of a model, in the terms of its budget, in a few words."""
    worst = worst_error(model)
    return f"Torque error up to {worst.text} (joint {worst.joint}) at {_sampled_at(model)}"


def _sampled_at(model: SimplifiedModel) -> str:
    return "the set points" if "trajectory" in model.accuracy.fitted_on else "the states tried"


def headline(model: SimplifiedModel, error: str | None = None) -> str:
    """The result in a line: operations, what they save, and the error.

    "D, h and c in 66 operations and 20 sines and cosines instead of 359 and 30; torque in ...".
    """
    full = model.operations_full
    if model.is_exact:
        exact_dynamics = f"the exact torque, {full.in_words}"
        if model.level is TERM:
            exact_dynamics += f", or exact D, h and c, {model.form.functions.operations.pair}"
        return (
            f"Nothing saved: within the budget of {model.accuracy.asked.words} no model found takes fewer "
            f"operations than {exact_dynamics}. The exact dynamics are the result."
        )
    costs = f"{model.operations.in_words}{_beside_exact(model)}{full.pair}"
    if model.level is TERM:
        apart, exact = model.functions.operations, model.form.functions.operations
        functions = f"D, h and c in {apart.in_words} instead of {exact.pair}"
        costs = f"{functions}; torque in {model.operations.pair} instead of {full.pair}"
        if not model.saves_torque:
            costs = (
                f"{functions}, for equations and feedback. For the torque alone take the exact program: "
                f"{full.pair}, the model's {model.operations.pair}"
            )
        elif not model.saves_functions:
            costs = (
                f"Torque in {model.operations.in_words} instead of {full.pair}. For D, h and c apart take "
                f"the exact ones: {exact.pair}, the model's {apart.pair}"
            )
    use = f" {FEEDFORWARD_ONLY.capitalize()}." if model.is_torque_only else ""
    return f"{costs}. {error or error_text(model)}.{use}{_missed_budget(model)}"


def _missed_budget(model: SimplifiedModel) -> str:
    """The joints at which a model by verdicts misses its budget, in a sentence; "" if there are none."""
    accuracy = model.accuracy
    missed = (1 + np.flatnonzero(accuracy.errors.largest > accuracy.allowed)).tolist()
    if not missed:
        return ""
    return f" It misses the budget of {accuracy.asked.words} at {named_joints(missed, model.arm.n_joints)}."


def drives_text(arm: RobotArm, drives: bool) -> str:
    """Whether the drives' inertia is part of the torque; "" for an arm without drives."""
    if arm.counts_drives():
        return "drives included" if drives else "links alone"
    return "drives' inertia unknown" if arm.drives else ""
