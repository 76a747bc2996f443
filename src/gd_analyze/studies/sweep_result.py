"""A sweep as a Result: where verdicts change, shares of verdicts, peak torques, operations, and drawings."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from gd_analyze.dynamics.many_arms import VERDICT_NAMES
from gd_analyze.figures.sweep import changing, maps_figure, peak_torque_figure, verdict_figure
from gd_analyze.result import Column, Drawing, Fact, Part, Result, Table, joint_columns
from gd_analyze.results.model_facts import drives_text
from gd_analyze.robots.arm import RobotArm
from gd_analyze.studies.sweep import QUICK
from gd_analyze.text import number, pretty

if TYPE_CHECKING:
    import xarray as xr

# Changes shown to people for one parameter.
_SHOWN_OF_ONE_PARAMETER = 40
# Changes shown to people for several parameters.
_SHOWN_OF_SEVERAL = 12
_WHITE = "White: negligible, zero, or within budget."


def sweep_result(dataset: xr.Dataset, arm: RobotArm, provenance: Mapping[str, str]) -> Result:
    """Facts, tables and drawings of what `sweep` found."""
    attrs, is_drawn = dataset.attrs, "sample" in dataset.dims
    names = [str(name) for name in dataset.parameter.values]
    units = [pretty(str(unit)) for unit in dataset.unit.values]
    lows, highs = ([float(extreme(dataset[name])) for name in names] for extreme in (np.min, np.max))
    ranges = [
        f"{name} {number(low)} to {number(high)} {unit}".rstrip()
        for name, low, high, unit in zip(names, lows, highs, units, strict=True)
    ]
    size, counted = dataset.verdict.shape[:-1], dataset.operations.values[dataset.operations.notnull().values]
    points = f"{size[0]} draws, seed {attrs['seed']}" if is_drawn else " by ".join(map(str, size))
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
    if not is_drawn:
        precision = dataset.precision.values
        precision_text = ", ".join(
            f"{number(x)} {unit}".rstrip() for x, unit in zip(precision, units, strict=True)
        )
        facts.insert(-1, Fact("precision", "Changes located within", precision, text=precision_text))
    notices = []
    if quick and not counted.size:
        notices.append("The arm has too many terms for a quick count; give --operations element.")
    subtitle = ", ".join(
        filter(None, [f"swept along {attrs['trajectory']}", drives_text(arm, attrs["drives"])])
    )
    return Result(
        title=arm.title or arm.name,
        subtitle=subtitle,
        headline=_headline(dataset, units),
        facts=tuple(facts),
        parts=(*_tables(dataset, arm, units), *_drawings(dataset, names)),
        notices=tuple(notices),
        provenance={
            "arm": f"{arm.name}, SHA-256 {attrs['arm_fingerprint'][:16]}",
            "trajectory": f"{attrs['trajectory']}, SHA-256 {attrs['trajectory_fingerprint'][:16]}",
            **provenance,
        },
    )


def _headline(dataset: xr.Dataset, units: list[str]) -> str:
    """Where verdicts change, or which of them differ among draws."""
    if "sample" in dataset.dims or dataset.sizes["parameter"] > 1:
        differing = changing(dataset)
        beyond = len(differing) - _SHOWN_OF_SEVERAL
        remark = f" and {beyond} more" if beyond > 0 else ""
        if not differing:
            return "No verdict changes."
        return f"Verdicts differ on {', '.join(differing[:_SHOWN_OF_SEVERAL])}{remark}."
    places = zip(dataset.change_element.values, dataset.change_at.values[:, 0].tolist(), strict=True)
    changes = [f"{label} at {number(at)} {units[0]}".rstrip() for label, at in places]
    if not changes:
        return "No verdict changes."
    beyond = len(changes) - _SHOWN_OF_SEVERAL
    remark = f", and {beyond} more" if beyond > 0 else ""
    return f"Verdicts change: {', '.join(changes[:_SHOWN_OF_SEVERAL])}{remark}."


def _tables(dataset: xr.Dataset, arm: RobotArm, units: list[str]) -> list[Part]:
    names = [str(name) for name in dataset.parameter.values]
    parts: list[Part] = []
    if "sample" not in dataset.dims:
        along = [names.index(name) for name in dataset.change_parameter.values]
        rows, unit = np.arange(len(along)), [units[k] for k in along]
        columns = [
            Column("element", "verdict on", dataset.change_element.values, shown="name"),
            Column("before", "below", dataset.change_from.values, shown="text"),
            Column("after", "above", dataset.change_to.values, shown="text"),
            Column("parameter", "", dataset.change_parameter.values),
            Column("at", "changes at", dataset.change_at.values[rows, along], unit),
            Column("seen", "next grid point" if len(names) == 1 else "", dataset.change_seen.values, unit),
        ]  # fmt: skip
        for k, name in enumerate(names if len(names) > 1 else ()):
            coordinates = np.where(np.array(along) == k, np.nan, dataset.change_at.values[:, k])
            columns.append(Column(name, name, coordinates, units[k]))
        title = "Changes of verdicts"
        if len(names) > 1:
            title += ", each along the parameter with a dash"
        top = _SHOWN_OF_ONE_PARAMETER if len(names) == 1 else _SHOWN_OF_SEVERAL
        parts.append(Table("changes", title, tuple(columns), top=top))
    differ = changing(dataset)
    torque = dataset.peak_torque.transpose("joint", ...).values.reshape(arm.n_joints, -1)
    verdicts = dataset.verdict.sel(element=differ).values.reshape(torque.shape[1], len(differ)).T
    shares = [
        Column(name.replace(" ", "_"), name, (verdicts == name).mean(axis=1), shown="percent")
        for name in VERDICT_NAMES.tolist()
        if (verdicts == name).any()
    ]
    label = Column("element", "verdict on", differ, shown="name")
    if differ:
        parts.append(Table("shares", "Shares of the points by verdict", (label, *shares)))
    efforts = [joint.effort_unit for joint in arm.joints]
    spread = zip(("least", "median", "largest"), np.quantile(torque, [0.0, 0.5, 1.0], axis=1), strict=True)
    columns = [Column(key, key, values, efforts) for key, values in spread]
    parts.append(Table("peak_torque", "Peak torque over the points", (*joint_columns(arm.joints), *columns)))
    largest = dataset.contribution.max([d for d in dataset.contribution.dims if d not in ("joint", "of")])
    columns = [
        Column(name.replace(" ", "_"), re.sub(r" (.).*", lambda m: f" {m[1].upper()}", name), values, efforts)
        for name, values in zip(
            dataset.of.values.tolist(), largest.transpose("of", "joint").values, strict=True
        )
    ]
    note = "T: translation. R: rotation. Inertia: D qdd. Velocity: h."
    title = "Largest peak of each contribution over the points"
    parts.append(Table("contributions", title, (*joint_columns(arm.joints), *columns), note))
    return parts


def _drawings(dataset: xr.Dataset, names: list[str]) -> list[Drawing]:
    is_drawn = "sample" in dataset.dims
    if len(names) == 2 and not is_drawn:
        return [Drawing("maps", f"{names[0]} across, {names[1]} upward.", maps_figure(dataset), _WHITE)]
    if len(names) > 1 and not is_drawn:
        return []
    torques = Drawing("torques", f"Peak torque over {names[0]}", peak_torque_figure(dataset))
    if is_drawn:
        return [torques]
    return [Drawing("verdicts", f"Verdicts over {names[0]}.", verdict_figure(dataset), _WHITE), torques]
