"""[FGL87]'s own simplified model: the dominant part of every element of D and h."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from gd_analyze.dynamics.dominance import DOMINANCE_THRESHOLD, elements, text_verdicts
from gd_analyze.dynamics.generalized_dalembert import EFFECTS
from gd_analyze.errors import UsageError
from gd_analyze.operations.program import Program
from gd_analyze.simplification.effort import ROUGH
from gd_analyze.simplification.element import ELEMENT, ElementPart, parts_of, trace_parts
from gd_analyze.simplification.exact import ExactForm
from gd_analyze.simplification.exact_dynamics import ExactDynamics
from gd_analyze.simplification.level import Level
from gd_analyze.simplification.model import SimplifiedModel, exactly, measured
from gd_analyze.text import rounded_up

VERDICT_SOURCES = ("own", "text")


def model_by_verdicts(
    exact: ExactDynamics, verdicts: str = "own", threshold: float = DOMINANCE_THRESHOLD
) -> SimplifiedModel:
    """Keep the dominant parts by verdicts over the states ("own"), or by [FGL87]'s ("text").

    The stated budget is the resulting torque error. UsageError if the text has no verdicts on the arm.
    """
    parts = dict.fromkeys(_own(exact, threshold) if verdicts == "own" else _of_text(exact.form), 1.0)
    everything = exactly(exact, ELEMENT, np.zeros(exact.arm.n_joints), "0 N m")
    program = ELEMENT.write(exact.form, parts, ROUGH)
    model = measured(exact, replace(everything, terms=parts, program=program))
    largest = model.accuracy.errors.largest
    # Along each of several motions the budget is a share of the peak torque there, unless a joint needs none.
    tables = [model.accuracy.errors, *(motion.errors for motion in model.accuracy.motions)]
    largest_shares = [errors.largest_share for errors in tables]
    shares = np.where(np.isfinite(largest_shares), largest_shares, -1.0).max(axis=0)
    budget = ", ".join(
        f"{rounded_up(100 * share, 6):.12g}%" if share >= 0.0 else f"{rounded_up(error, 6):.12g} N m"
        for error, share in zip(largest.tolist(), shares.tolist(), strict=True)
    )
    exact = exact.weighed(None).under(budget)
    accuracy = replace(model.accuracy, budget=budget, allowed=exact.allowed(budget))
    return measured(exact, model.stating(accuracy))


def require_no_budget(level: Level, value: str) -> None:
    """Raise a UsageError for a budget, or a limit on operations, at level element."""
    if level is ELEMENT:
        message, expected = "level element keeps no budget: verdicts say what it keeps", "neither"
        next_step = "take another level, or state the error that it has"
        raise UsageError(message, where="level", expected=expected, found=value, next_step=next_step)


def _own(exact: ExactDynamics, threshold: float) -> Iterator[ElementPart]:
    """Parts whose loss changes their element by more than the threshold of its peak."""
    all_elements = elements(exact.arm.n_joints)
    quantities = {
        name: np.asarray(exact.quantities[name]) for name in {element.quantity for element in all_elements}
    }
    for element in all_elements:
        parts = element.parts(quantities)
        # As in `rank`, round-off is not a part.
        noise = 64 * np.finfo(float).eps * np.abs(quantities[element.quantity]).max()
        threshold_torque = max(threshold * float(np.abs(parts.sum(axis=0)).max()), noise)
        yield from (
            ElementPart(element, effect)
            for effect, values in zip(EFFECTS, parts, strict=True)
            if np.abs(values).max() > threshold_torque
        )


def _of_text(form: ExactForm) -> Iterator[ElementPart]:
    """Parts that [FGL87] calls dominant, and gravity loading."""
    text = text_verdicts(form.arm.name)
    if text is None:
        raise UsageError(
            f"[FGL87] has no verdicts on {form.arm.name}",
            where="verdicts",
            expected="puma560, the arm of its Figs 3.10 and 3.11",
            next_step="use the verdicts over the states: own",
        )
    for part in parts_of(form.arm.n_joints):
        if text.verdicts.get(part.element.label, "both") in (part.effect, "both"):
            yield part


def operations_by_quantity(form: ExactForm, parts: Iterable[ElementPart]) -> dict[str, int]:
    """Multiplications and additions of D, h and c by element from some parts: each alone, and together."""
    traced = trace_parts(form.arm)
    inertia, h, c = traced.assembled(set(parts), form.drive_inertia)
    outputs = {"D": inertia[np.triu_indices(len(h))].tolist(), "h": h.tolist(), "c": c.tolist()}
    outputs["D, h and c"] = [value for values in outputs.values() for value in values]
    return {name: Program.of(traced.trace, values).count.total for name, values in outputs.items()}
