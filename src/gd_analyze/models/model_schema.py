"""What a model file may hold: one schema per level, and the way from a model to it and back."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any, Literal, TypeVar

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from gd_analyze.errors import ModelError
from gd_analyze.harmonics.absolute_rates import AbsoluteRates
from gd_analyze.harmonics.lagrangian import torques_of_energies
from gd_analyze.harmonics.terms import Energies, EnergyTerm, Factor, Monomial, Rate, Torques, TorqueTerm
from gd_analyze.harmonics.waves import DEGREE
from gd_analyze.models.element import ElementModel
from gd_analyze.models.harmonic import HarmonicModel
from gd_analyze.models.nested_torque import nested_torque
from gd_analyze.models.simplified import ErrorTable, ModelFacts, SimplifiedModel
from gd_analyze.operations import OperationCount, Program
from gd_analyze.operations.written import read_back, written
from gd_analyze.robots import RobotArm, arm_from_description, describe, fingerprint
from gd_analyze.vectors import FloatArray

FORMAT = "gd-analyze simplified model"
VERSION = 1

_Term = TypeVar("_Term", EnergyTerm, TorqueTerm)

# Kind, how often every joint goes into the argument, exponent; rates as order and joint, from 0.
_FactorEntry = tuple[Literal["cos", "sin", "power"], list[int], Annotated[int, Field(ge=1, le=DEGREE)]]
_RateEntry = tuple[Literal[1, 2], int]


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", allow_inf_nan=False)


class _Operations(_Strict):
    multiplications: int
    additions: int
    sines_cosines: int


class _JointError(_Strict):
    joint: str
    unit: str
    peak_torque: float
    allowed_error: float
    largest_error: float
    rms_error: float


class ModelDocument(_Strict):
    """What the files of all levels hold."""

    format: Literal["gd-analyze simplified model"]
    version: Literal[1]
    drives: bool
    refitted: bool
    budget: str
    errors_are: Literal["sampled at the states of made_for"]
    errors: list[_JointError]
    made_for: dict[str, str | int]
    operations: _Operations
    operations_full: _Operations
    arm_fingerprint: str
    arm: dict[str, Any]
    provenance: dict[str, str]
    digest: str

    def column(self, name: str) -> FloatArray:
        """One column of the error table, shape (n,)."""
        return np.array([getattr(row, name) for row in self.errors])


class _ElementFile(ModelDocument):
    level: Literal["element"]
    kept: list[str]
    dropped: list[str]


class _EnergyEntry(_Strict):
    i: int
    j: int
    factors: list[_FactorEntry]
    coefficient: float


class _TorqueEntry(_Strict):
    row: int
    rates: Annotated[list[_RateEntry], Field(max_length=2)]
    factors: list[_FactorEntry]
    weight: float


class _HarmonicFile(ModelDocument):
    steps: list[list[str | float]]
    outputs: list[str | float]


class _EnergyFile(_HarmonicFile):
    level: Literal["energy"]
    energy: list[_EnergyEntry]


class _TermFile(_HarmonicFile):
    level: Literal["term"]
    torques: list[_TorqueEntry]


SCHEMAS: dict[str, type[ModelDocument]] = {"element": _ElementFile, "energy": _EnergyFile, "term": _TermFile}


def document_of(model: SimplifiedModel) -> ModelDocument:
    """Write a model into its schema; the digest is left empty."""
    promise = model.promise
    common: dict[str, Any] = {
        "format": FORMAT,
        "version": VERSION,
        "level": model.level,
        "drives": model.drives,
        "refitted": model.refitted,
        "budget": model.budget_stated,
        "errors_are": "sampled at the states of made_for",
        "errors": [
            _JointError(
                joint=joint.name,
                unit=joint.effort_unit,
                peak_torque=promise.peak_torque[i],
                allowed_error=model.budget[i],
                largest_error=promise.largest[i],
                rms_error=promise.rms[i],
            )
            for i, joint in enumerate(model.arm.joints)
        ],
        "made_for": dict(model.made_for),
        "operations": _count(model.operations),
        "operations_full": _count(model.operations_full),
        "arm_fingerprint": fingerprint(model.arm, model.drives),
        "arm": describe(model.arm),
        "provenance": dict(model.provenance),
        "digest": "",
    }
    if isinstance(model, ElementModel):
        return _ElementFile(**common, kept=list(model.kept), dropped=list(model.dropped))
    assert isinstance(model, HarmonicModel)  # there is no other kind
    steps, outputs = written(model.programs["torque"])
    common |= {"steps": steps, "outputs": outputs}
    if model.level == "energy":
        return _EnergyFile(
            **common,
            energy=[
                _EnergyEntry(i=t.i, j=t.j, factors=_entries(t.monomial), coefficient=coefficient)
                for t, coefficient in model.energy.items()
            ],
        )
    return _TermFile(
        **common,
        torques=[
            _TorqueEntry(
                row=term.row,
                rates=[(rate.order, rate.joint) for rate in term.rates],
                factors=_entries(term.monomial),
                weight=weight,
            )
            for term, weight in model.torques.items()
        ],
    )


def model_of(document: ModelDocument) -> SimplifiedModel:
    """Rebuild the model; a ValueError or an error of this project's where the parts do not fit the arm."""
    arm = arm_from_description(document.arm)
    full = document.operations_full
    facts = ModelFacts(
        arm=arm,
        drives=document.drives,
        refitted=document.refitted,
        budget=document.column("allowed_error"),
        budget_stated=document.budget,
        promise=ErrorTable(
            document.column("peak_torque"), document.column("largest_error"), document.column("rms_error")
        ),
        made_for=document.made_for,
        operations_full=OperationCount(full.multiplications, full.additions, full.sines_cosines),
        provenance=document.provenance,
    )
    if isinstance(document, _ElementFile):
        return ElementModel(level=document.level, kept=tuple(document.kept), **facts)
    assert isinstance(document, _EnergyFile | _TermFile)  # there is no other schema
    energy: Energies = {}
    torques: Torques
    if isinstance(document, _EnergyFile):
        stated = [
            (EnergyTerm(entry.i, entry.j, _monomial(arm, entry.factors)), entry.coefficient)
            for entry in document.energy
        ]
        _require([term for term, _ in stated], lambda term: _fits(term, arm.n_joints), lambda term: term)
        energy = dict(stated)
        torques = torques_of_energies(energy, AbsoluteRates.of(arm))
    else:
        entries = [
            (
                TorqueTerm(
                    entry.row,
                    tuple(Rate(*rate) for rate in entry.rates),
                    _monomial(arm, entry.factors),
                ),
                entry.weight,
            )
            for entry in document.torques
        ]
        _require([term for term, _ in entries], lambda term: _acts(term, arm.n_joints), lambda term: term)
        torques = dict(entries)
    program = read_back(
        document.steps,
        document.outputs,
        {f"{name}{i + 1}" for name in ("q", "qd", "qdd") for i in range(arm.n_joints)},
    )
    _require_same(arm, torques, program)
    return HarmonicModel(
        level=document.level, energy=energy, torques=torques, written_program=program, **facts
    )


def _require_same(arm: RobotArm, torques: Torques, program: Program) -> None:
    """Hold the written program against the terms at some states: one of them must not be out of step."""
    if len(program.outputs) != arm.n_joints:
        raise ValueError(f"the program has {len(program.outputs)} outputs, not {arm.n_joints}")
    again = nested_torque(AbsoluteRates.of(arm), torques)
    states = np.random.default_rng(0).uniform(-1.0, 1.0, (3, arm.n_joints, 5))
    inputs = {
        f"{name}{i + 1}": states[k, i]
        for k, name in enumerate(("q", "qd", "qdd"))
        for i in range(arm.n_joints)
    }
    one, other = again.run(inputs), program.run(inputs)
    # Two ways to sum some hundred products: far below any term that a change could touch and matter.
    if not np.abs(one - other).max(initial=0.0) <= 1e-9 * np.abs(one).max(initial=1e-300):
        raise ValueError("the program does not compute the terms")


def _count(operations: OperationCount) -> _Operations:
    return _Operations(
        multiplications=operations.multiplications,
        additions=operations.additions,
        sines_cosines=operations.sines_cosines,
    )


def _entries(monomial: Monomial) -> list[_FactorEntry]:
    return [(f.kind, list(f.multiples), monomial.count(f)) for f in dict.fromkeys(monomial)]


def _monomial(arm: RobotArm, entries: list[_FactorEntry]) -> Monomial:
    """Factors that an arm of this make can have."""
    monomial = tuple(sorted(Factor(kind, tuple(m)) for kind, m, exponent in entries for _ in range(exponent)))
    for factor in monomial:
        revolute = [arm.is_revolute[j] for j in factor.joints[: arm.n_joints]]
        # Beyond the degree of D no multiple of an angle and no further power occurs.
        known = len(factor.multiples) == arm.n_joints and all(abs(m) <= DEGREE for m in factor.multiples)
        if factor.kind == "power":
            fitting = revolute == [False] and sum(factor.multiples) == 1
        else:
            fitting = bool(revolute) and all(revolute)
        if not (known and fitting):
            raise ModelError(f"{factor.kind} of {list(factor.multiples)} is no factor of the arm's equations")
    return monomial


def _fits(term: EnergyTerm, n: int) -> bool:
    return (term.i, term.j) == (-1, -1) or 0 <= term.i <= term.j < n


def _acts(term: TorqueTerm, n: int) -> bool:
    orders = [rate.order for rate in term.rates]
    joints = [rate.joint for rate in term.rates]
    return (
        0 <= term.row < n
        and orders in ([], [2], [1, 1])
        and joints == sorted(joints)
        and all(0 <= joint < n for joint in joints)
    )


def _require(
    terms: tuple[_Term, ...] | list[_Term], fits: Callable[[_Term], bool], key: Callable[[_Term], Any]
) -> None:
    for term in terms:
        if not fits(term):
            raise ModelError(f"{term} is no term of the arm's equations")
    if len({key(term) for term in terms}) < len(terms):
        raise ModelError("a term is stated twice")
