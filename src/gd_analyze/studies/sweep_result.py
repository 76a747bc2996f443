"""A sweep as a Result: where verdicts change, shares of verdicts, peak torques, operations, and drawings."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from gd_analyze.dynamics.many_arms import VERDICT_NAMES
from gd_analyze.figures.sweep import changing, maps_figure, torque_figure, verdict_figure
from gd_analyze.result import Column, Drawing, Fact, Part, Result, Table, joint_columns
from gd_analyze.results.model_facts import drives_text
from gd_analyze.robots.arm import RobotArm
from gd_analyze.studies.sweep import QUICK
from gd_analyze.text import number, pretty

if TYPE_CHECKING:
    import xarray as xr

# Changes shown to people, for one parameter and for several.
_TOP, _FEW = 40, 12
_WHITE = "White: negligible, zero, or within budget."


def sweep_result(found: xr.Dataset, arm: RobotArm, provenance: Mapping[str, str]) -> Result:
    """Facts, tables and drawings of what `sweep` found."""
    attrs, drawn = found.attrs, "sample" in found.dims
    names = [str(name) for name in found.parameter.values]
    units = [pretty(str(unit)) for unit in found.unit.values]
    lows, highs = ([float(of(found[name])) for name in names] for of in (np.min, np.max))
    ranges = [
        f"{name} {number(low)} to {number(high)} {unit}".rstrip()
        for name, low, high, unit in zip(names, lows, highs, units, strict=True)
    ]
    size, counted = found.verdict.shape[:-1], found.operations.values[found.operations.notnull().values]
    points = f"{size[0]} draws, seed {attrs['seed']}" if drawn else " by ".join(map(str, size))
    span = [int(counted.min()), int(counted.max())] if counted.size else None
    quick = attrs["operations_by"] == QUICK
    facts = [
        Fact("varied", "Varied", names, text=", ".join(ranges)),
        Fact("low", "", lows),
        Fact("high", "", highs),
        Fact("points", "Points", int(np.prod(size)), text=points),
        Fact("budget", "Budget", attrs["budget"]),
        Fact("threshold", "Dominance", attrs["threshold"], "of the element's peak", "percent"),
        Fact("operations", "Operations of the model" if span else "", span, shown="count",
             text=None if span is None else f"{span[0]} to {span[1]}",
             note="quick count" if quick else attrs["operations_by"]),
    ]  # fmt: skip
    if not drawn:
        within = found.precision.values
        close = ", ".join(f"{number(x)} {unit}".rstrip() for x, unit in zip(within, units, strict=True))
        facts.insert(-1, Fact("precision", "Changes located within", within, text=close))
    notices = []
    if quick and not counted.size:
        notices.append("The arm has too many terms for a quick count; give --operations fast.")
    which = ", ".join(filter(None, [f"swept along {attrs['trajectory']}", drives_text(arm, attrs["drives"])]))
    return Result(
        title=arm.title or arm.name,
        subtitle=which,
        headline=_headline(found, units),
        facts=tuple(facts),
        parts=(*_tables(found, arm, units), *_drawings(found, names)),
        notices=tuple(notices),
        provenance={
            "arm": f"{arm.name}, SHA-256 {attrs['arm_fingerprint'][:16]}",
            "trajectory": f"{attrs['trajectory']}, SHA-256 {attrs['trajectory_fingerprint'][:16]}",
            **provenance,
        },
    )


def _headline(found: xr.Dataset, units: list[str]) -> str:
    """Where verdicts change, or which of them differ among draws."""
    if "sample" in found.dims or found.sizes["parameter"] > 1:
        some = changing(found)
        more = f" and {len(some) - _FEW} more" if len(some) > _FEW else ""
        return f"Verdicts differ on {', '.join(some[:_FEW])}{more}." if some else "No verdict changes."
    places = zip(found.change_element.values, found.change_at.values[:, 0].tolist(), strict=True)
    told = [f"{label} at {number(at)} {units[0]}".rstrip() for label, at in places]
    more = f", and {len(told) - _FEW} more" if len(told) > _FEW else ""
    return f"Verdicts change: {', '.join(told[:_FEW])}{more}." if told else "No verdict changes."


def _tables(found: xr.Dataset, arm: RobotArm, units: list[str]) -> list[Part]:
    names = [str(name) for name in found.parameter.values]
    parts: list[Part] = []
    if "sample" not in found.dims:
        along = [names.index(name) for name in found.change_parameter.values]
        rows, unit = np.arange(len(along)), [units[k] for k in along]
        columns = [
            Column("element", "verdict on", found.change_element.values, shown="name"),
            Column("before", "below", found.change_from.values, shown="text"),
            Column("after", "above", found.change_to.values, shown="text"),
            Column("parameter", "", found.change_parameter.values),
            Column("at", "changes at", found.change_at.values[rows, along], unit),
            Column("seen", "next grid point" * (len(names) == 1), found.change_seen.values, unit),
        ]  # fmt: skip
        for k, name in enumerate(names if len(names) > 1 else ()):
            others = np.where(np.array(along) == k, np.nan, found.change_at.values[:, k])
            columns.append(Column(name, name, others, units[k]))
        title = "Changes of verdicts" + ", each along the parameter with a dash" * (len(names) > 1)
        parts.append(Table("changes", title, tuple(columns), top=_TOP if len(names) == 1 else _FEW))
    differ = changing(found)
    torque = found.peak_torque.transpose("joint", ...).values.reshape(arm.n_joints, -1)
    verdicts = found.verdict.sel(element=differ).values.reshape(torque.shape[1], len(differ)).T
    shares = [
        Column(name.replace(" ", "_"), name, (verdicts == name).mean(axis=1), shown="percent")
        for name in VERDICT_NAMES.tolist()
        if (verdicts == name).any()
    ]
    label = Column("element", "verdict on", differ, shown="name")
    parts += [Table("shares", "Shares of the points by verdict", (label, *shares))] * bool(differ)
    efforts = [joint.effort_unit for joint in arm.joints]
    spread = zip(("least", "median", "largest"), np.quantile(torque, [0.0, 0.5, 1.0], axis=1), strict=True)
    columns = [Column(key, key, values, efforts) for key, values in spread]
    parts.append(Table("peak_torque", "Peak torque over the points", (*joint_columns(arm.joints), *columns)))
    largest = found.contribution.max([d for d in found.contribution.dims if d not in ("joint", "of")])
    columns = [
        Column(name.replace(" ", "_"), re.sub(r" (.).*", lambda m: f" {m[1].upper()}", name), values, efforts)
        for name, values in zip(
            found.of.values.tolist(), largest.transpose("of", "joint").values, strict=True
        )
    ]
    note = "T: translation. R: rotation. Inertia: D qdd. Velocity: h."
    title = "Largest peak of each contribution over the points"
    parts.append(Table("contributions", title, (*joint_columns(arm.joints), *columns), note))
    return parts


def _drawings(found: xr.Dataset, names: list[str]) -> list[Drawing]:
    drawn = "sample" in found.dims
    if len(names) == 2 and not drawn:
        return [Drawing("maps", f"{names[0]} across, {names[1]} upward.", maps_figure(found), _WHITE)]
    if len(names) > 1 and not drawn:
        return []
    torques = Drawing("torques", f"Peak torque over {names[0]}", torque_figure(found))
    if drawn:
        return [torques]
    return [Drawing("verdicts", f"Verdicts over {names[0]}.", verdict_figure(found), _WHITE), torques]
