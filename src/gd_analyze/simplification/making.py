"""From candidates that are kept to a model that has been measured."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from gd_analyze.errors import GdAnalyzeError
from gd_analyze.harmonics.absolute_rates import AbsoluteRates
from gd_analyze.harmonics.lagrangian import gathered
from gd_analyze.harmonics.terms import Energies, Torques
from gd_analyze.models.element import ElementModel, part_operations
from gd_analyze.models.element_level import parts_of
from gd_analyze.models.harmonic import HarmonicModel
from gd_analyze.models.nested_torque import nested_torque
from gd_analyze.models.simplified import ErrorTable, Level, ModelFacts, SimplifiedModel
from gd_analyze.models.torque_program import shared_torque, torque_programs
from gd_analyze.operations import OperationCount, Program
from gd_analyze.simplification.exact import ExactDynamics
from gd_analyze.vectors import FloatArray

Kept = NDArray[np.bool_]

# Terms up to which sharing between rows is looked for: while searching, some hundredths of a second; for a
# quick model, tenths; when a program is written for good, seconds.
_FEW, _SOME, _MANY = 80, 250, 600


def operations_of(
    exact: ExactDynamics, level: Level, kept: Kept, scale: FloatArray, *, thorough: bool = True
) -> OperationCount:
    """Operations of one torque evaluation, as a program takes them that is written in milliseconds.

    With `thorough`, and few terms, also what rows share is looked for: some hundredths of a second.
    """
    if level == "element":
        return part_operations(exact.arm, _labels(exact, kept), exact.drives)
    _, torques = _harmonic(exact, level, kept, scale)
    basis = exact.harmonics.rates
    if thorough and len(torques) <= _FEW:
        return shared_torque(basis, torques).count
    return nested_torque(basis, torques).count


def make_model(
    exact: ExactDynamics,
    level: Level,
    kept: Kept,
    scale: FloatArray,
    *,
    allowed: FloatArray,
    budget_stated: str,
    thorough: bool = True,
    provenance: Mapping[str, str] | None = None,
) -> SimplifiedModel:
    """Make the model that keeps some candidates, and measure its error at the states.

    Parameters
    ----------
    exact
        Exact dynamics at the states it is made for.
    level, kept, scale
        Level, which of its candidates are kept, and factors of their coefficients; shape (K,) each.
    allowed
        Allowed error per joint, N m, shape (n,).
    budget_stated
        The budget as the user put it.
    thorough
        Spend seconds on a program of few operations.
    provenance
        Stored with the model.

    Raises
    ------
    GdAnalyzeError
        If the measured error is beyond `allowed`.
    """
    facts = ModelFacts(
        arm=exact.arm,
        drives=exact.drives,
        refitted=bool((scale[kept] != 1.0).any()),
        budget=allowed,
        budget_stated=budget_stated,
        promise=ErrorTable.nothing(exact.arm.n_joints),
        made_for=exact.states.described,
        operations_full=exact.operations_full(level, thorough=thorough),
        provenance=dict(provenance or {}),
    )
    draft: SimplifiedModel
    if level == "element":
        draft = ElementModel(level=level, kept=_labels(exact, kept), **facts)
    else:
        energy, torques = _harmonic(exact, level, kept, scale)
        basis = exact.harmonics.rates
        if len(torques) > _MANY:
            program = nested_torque(basis, torques)
        else:
            program = torque_programs(basis, torques)["torque"] if thorough else _quick(basis, torques)
        draft = HarmonicModel(level=level, energy=energy, torques=torques, written_program=program, **facts)
    states = exact.states
    promise = ErrorTable.of(exact.torque, draft.torque(states.q, states.qd, states.qdd))
    if not (promise.largest <= allowed).all():
        raise GdAnalyzeError(
            "the simplified model misses its budget",
            expected=str(allowed.tolist()),
            found=str(promise.largest.tolist()),
            next_step="please report this with the arm file and the states",
        )
    model = dataclasses.replace(draft, promise=promise)
    # The same programs; making them again would take longer than all the rest here.
    model.__dict__["programs"] = draft.programs
    return model


def _quick(basis: AbsoluteRates, torques: Torques) -> Program:
    """The better of two quick ways to write a program."""
    ways = [nested_torque(basis, torques)]
    if len(torques) <= _SOME:
        ways.append(shared_torque(basis, torques))
    return min(ways, key=lambda program: program.count.total)


def _labels(exact: ExactDynamics, kept: Kept) -> tuple[str, ...]:
    parts = parts_of(exact.arm.n_joints)
    return tuple(part.label for part, keep in zip(parts, kept, strict=True) if keep)


def _harmonic(exact: ExactDynamics, level: Level, kept: Kept, scale: FloatArray) -> tuple[Energies, Torques]:
    """Energy terms, at that level, and torque terms that are kept."""
    if level == "term":
        weights = zip(exact.torques.items(), kept, scale, strict=True)
        return {}, {term: float(factor * weight) for (term, weight), keep, factor in weights if keep}
    members = np.flatnonzero(kept)
    every = list(exact.energy.items())
    energy = {every[k][0]: float(scale[k] * every[k][1]) for k in members}
    sources = (exact.sources[k] for k in members)
    return energy, gathered(zip(energy.values(), sources, strict=True))
