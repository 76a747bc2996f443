"""The elements of D, h and c as numbers at one posture, each with its parts."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.dynamics.decomposition import decompose_states
from gd_analyze.dynamics.dominance import Element
from gd_analyze.dynamics.dominance import elements as all_elements
from gd_analyze.formulas.languages import formatted
from gd_analyze.harmonics.equations import elements_named
from gd_analyze.motions.states import States
from gd_analyze.result import Fact, Result, Value, values_of
from gd_analyze.robots.arm import RobotArm
from gd_analyze.schema import declared_table, unit_of
from gd_analyze.text import counted, number, pretty

# Quantities by the letter of their elements, with the kind of their unit.
_LETTERS = {
    "inertia": ("D", "inertia"),
    "christoffel": ("h", "christoffel"),
    "coriolis_centrifugal": ("h", "effort"),
    "gravity_loading": ("c", "effort"),
}
# Share of the largest part of a quantity below which another is zero up to round-off.
_ROUND_OFF = 1e-14


def posture_result(
    arm: RobotArm,
    q: Sequence[float],
    qd: Sequence[float] | None = None,
    labels: Sequence[str] = (),
    *,
    digits: int = 3,
) -> Result:
    """D, h and c at joint variables q, rad (m); h by its coefficients h_ijk or, at velocities qd, its value.

    `labels` name elements as for `equations`; UsageError if one does not exist.
    """
    still = np.zeros(arm.n_joints)
    state = States(np.array([q]), np.array([still if qd is None else qd]), still[None])
    decomposed = decompose_states(arm, state, christoffel=True)
    arrays = {name: _without_round_off(decomposed[name]) for name in _LETTERS}
    rows = [_row(arm, element, arrays) for element in _chosen(arm, labels, arrays, qd is not None)]
    has_drives = arm.counts_drives()
    names = ["element", "value", "translation", "rotation", *(["drive"] if has_drives else []), "unit"]
    seen: dict[str, Any] = {name: [formatted(row[name], digits) for row in rows] for name in names[1:-1]} | {
        "unit": [pretty(row["unit"]) for row in rows]
    }
    note = "Parts: masses at their centres (translation), inertias about these (rotation)"
    note += ", and drives. " if has_drives else ". "
    if any(row["element"].startswith("h") for row in rows) and qd is None:
        note += "h_i is the sum over all j and k of h_ijk qd_j qd_k: one with j ≠ k counts twice. "
    values = values_of(rows, "element", "value", "translation", "rotation", "drive", "unit")
    return Result(
        title=f"{arm.title or arm.name}: D, h and c at one posture",
        facts=(
            Value("arm", arm.name),
            Fact("q", "Positions", list(q), text=_in_words(arm, q)),
            *([] if qd is None else [Fact("qd", "Velocities", list(qd), text=_in_words(arm, qd, "/s"))]),
        ),
        parts=(
            declared_table("posture", "elements", "Elements", values, names, note=note.strip(), seen=seen),
        ),
        notices=tuple(_beyond(arm, np.array(q))),
    )


def _chosen(
    arm: RobotArm, labels: Sequence[str], arrays: dict[str, FloatArray], has_velocities: bool
) -> Iterator[Element]:
    """Elements to show: those named, of h its values at velocities or else its coefficients beside zeros."""
    named = {(kind, indices): alone for kind, indices, alone in elements_named(labels, arm.n_joints)}
    quantities = list(_LETTERS)
    for element in sorted(
        all_elements(arm.n_joints, christoffel=True), key=lambda element: quantities.index(element.quantity)
    ):
        letter = _LETTERS[element.quantity][0]
        if element.quantity == "coriolis_centrifugal":
            if has_velocities and any(key[0] == "h" and key[1][0] == element.i for key in named):
                yield element
        elif (alone := named.get((letter, element.index))) is not None:
            is_coefficient = element.quantity == "christoffel"
            is_zero = not element.parts(arrays).any()
            if alone or not is_coefficient or not (has_velocities or is_zero):
                yield element


def _without_round_off(values: FloatArray) -> FloatArray:
    sizes = np.abs(values)
    return np.where(sizes > _ROUND_OFF * sizes.max(), values, 0.0)


def _row(arm: RobotArm, element: Element, arrays: dict[str, FloatArray]) -> dict[str, Any]:
    translation, rotation = element.parts(arrays)[:, 0].tolist()
    is_diagonal = element.quantity == "inertia" and element.is_diagonal
    drive = float(arm.drive_inertia[element.i]) if is_diagonal and arm.counts_drives() else 0.0
    kind = _LETTERS[element.quantity][1]
    return {
        "element": element.label,
        "value": translation + rotation + drive,
        "translation": translation,
        "rotation": rotation,
        "drive": drive,
        "unit": unit_of(kind, *(arm.is_revolute[joint] for joint in element.index)),
    }


def _in_words(arm: RobotArm, values: Sequence[float], per: str = "") -> str:
    units = [("°", np.degrees(1.0)) if turns else (" m", 1.0) for turns in arm.is_revolute]
    return ", ".join(
        f"{number(scale * x)}{unit}{per}" for x, (unit, scale) in zip(values, units, strict=True)
    )


def _beyond(arm: RobotArm, q: FloatArray) -> Iterator[str]:
    """Joints that are beyond their ranges."""
    outside = np.flatnonzero((q < arm.limits("lower") - 1e-9) | (q > arm.limits("upper") + 1e-9))
    if outside.size:
        joints = ", ".join(arm.joints[k].name for k in outside)
        yield f"The posture is beyond the arm's range of {counted(len(outside), 'joint')}: {joints}."
