"""The result of planning: extremes of the motion beside the arm's limits."""

from __future__ import annotations

import math

from gd_analyze.motions.planning import Plan
from gd_analyze.result import Column, Fact, Result, Table, columns_of

# Extremes are found by calculation, which leaves round-off where they are zero.
_ZERO = 1e-12
_REACHED = ("lowest", "highest", "velocity", "acceleration")
_LIMITS = ("lower", "upper", "velocity_limit", "acceleration_limit")
_PAIRS = (
    ("motion", "lowest", "highest", " .. ", {"rad": "°"}),
    ("range", "lower", "upper", " .. ", {"rad": "°"}),
    ("velocity / limit", "velocity", "velocity_limit", " / ", {"rad": "rad/s", "m": "m/s"}),
    ("acc. / limit", "acceleration", "acceleration_limit", " / ", {"rad": "rad/s²", "m": "m/s²"}),
)


def plan_result(made: Plan) -> Result:
    """Facts of a plan; people see angles in degrees, as they are typed."""
    motion, rows, shortest = made.trajectory, made.limits.rows, made.shortest_duration
    joints = [row.joint for row in rows]
    known = columns_of(rows, *((name, "", "number") for name in _REACHED))
    known += columns_of(joints, *((name, "", "number") for name in _LIMITS))
    values = {column.key: column.values for column in known}
    columns = [Column("joint", "joint", range(1, len(joints) + 1), shown="count")]
    columns += [*columns_of(joints, ("name", "name", "text"), ("unit", "", "text")), *known]
    for label, first, second, between, units in _PAIRS:
        shown_in = [units.get(joint.unit, joint.unit) for joint in joints]
        cells = [
            between.join(_cell(value, unit) for value in pair)
            for *pair, unit in zip(values[first], values[second], shown_in, strict=True)
        ]
        columns.append(Column("", label, cells, shown_in, "text"))
    return Result(
        title=f"Plan {motion.name}",
        facts=(
            Fact("trajectory", "", motion.name),
            Fact("set_points", "Set points", motion.n_set_points, shown="count"),
            Fact("knot_times", "", made.knot_times),
            Fact("shortest_duration", "" if shortest is None else "Shortest duration", shortest, "s"),
            *(Fact(name, "", getattr(motion, name)) for name in ("time", "q", "qd", "qdd")),
        ),
        parts=(Table("joints", "Extremes, between the set points too", tuple(columns)),),
    )


def _cell(value: float | None, unit: str) -> str:
    if value is None:
        return "?"
    scale = math.degrees(1.0) if unit == "°" else 1.0
    return f"{value * scale if abs(value) > _ZERO else 0.0:.3g}"
