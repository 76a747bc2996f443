"""An identification as a Result: residuals, parameters, friction, and the operations that logs support."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np

from gd_analyze.arrays import FloatArray, evenly
from gd_analyze.figures.figure import (
    Area,
    Figure,
    Item,
    Key,
    Panel,
    in_columns,
    joint_label,
    over_time,
    time_axis,
    value_axis,
)
from gd_analyze.identification.identification import Identification, Residuals
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.result import Column, Drawing, Fact, Result, Section, Table, joint_columns
from gd_analyze.simplification.budget import Budget
from gd_analyze.simplification.exact import ExactDynamics
from gd_analyze.simplification.levels import SearchOptions
from gd_analyze.simplification.simplify import simplify_exact
from gd_analyze.text import named_joints, number, percent, with_error

# The budget that equals the uncertainty left by the log.
SUPPORTED = "uncertainty"
# States of a log used to search that model; number of base parameters listed as changed most.
_STATES, _MOST_CHANGED = 300, 5
# Neighbouring rows more than this many steps apart belong to different stretches.
_GAP = 3.0


def _models(found: Identification) -> dict[str, str]:
    """Names of the models compared."""
    first = {"file": "file as given", "rods": "uniform rods"}[found.start]
    return {"file": first, "friction": f"{found.start}, friction fitted", "identified": "identified"}


class Supported(NamedTuple):
    """The simplified model with a torque error up to the identified arm's uncertainty, along the log."""

    operations: int
    operations_exact: int
    share: FloatArray  # uncertainty over each joint's peak torque, (n,)


def supported(found: Identification, motion: Trajectory) -> Supported:
    """Simplify the identified arm along a log, as far as the uncertainty of its torque allows.

    Parameters
    ----------
    found
        The identification.
    motion
        One of its logs; a long one is represented by some of its set points.

    Returns
    -------
    Supported
        Operations of the model and of the exact torque.
    """
    taken = evenly(motion.n_set_points, _STATES)
    few = Trajectory(motion.time[taken], motion.q[taken], motion.qd[taken], motion.qdd[taken], motion.name)
    exact = ExactDynamics.of(found.arm, few, drives=True)
    model = simplify_exact(exact, Budget.of(SUPPORTED), SearchOptions(thorough=False))
    assert exact.uncertainty is not None  # of an identified arm
    count = model.operations.total, model.operations_full.total
    return Supported(*count, exact.uncertainty / np.maximum(exact.peak_torque, 1e-300))


def identification_result(
    found: Identification, answer: Supported | None, provenance: Mapping[str, str]
) -> Result:
    """Facts, tables and drawings."""
    arm, known = found.given, [one for one in found.parameters if one.identifiable]
    held = f"held out: {', '.join(found.held_out) or 'the last third of each'}"
    loaded = f", with a payload {', '.join(found.loaded)}" if found.loaded else ""
    facts = [
        Fact("", "Base parameters identifiable", f"{len(known)} of {len(found.parameters)}", shown="text"),
        Fact("condition", "Condition number", found.estimate.condition),
        Fact("physical", "Physically consistent", found.physical, shown="flag"),
        *(
            Fact(key, "", list(getattr(found, key)))
            for key in ("logs", "held_out", "loaded", "kept", "doubts")
        ),
    ]
    if answer is not None:
        share = float(answer.share.max())
        note = f"joint {int(answer.share.argmax()) + 1}"
        facts[:0] = [
            Fact("supported_operations", "Operations supported", answer.operations, text=_operations(answer)),
            Fact("torque_uncertainty", "Uncertainty of torque, of its peak", share, "", "percent", note=note),
        ]
    return Result(
        title=arm.title or arm.name,
        subtitle=f"identified from {', '.join(found.logs)}{loaded}; {held}",
        headline=_headline(found, answer),
        facts=tuple(facts),
        parts=(
            _residual_table(found),
            *_payload_table(found),
            Section(
                "",
                "Torque over time",
                (
                    Drawing(
                        "torque",
                        f"Torque measured, of the {found.start} and identified.",
                        torque_figure(found),
                        _SHADED,
                    ),
                    Drawing(
                        "residuals",
                        "Measured torque minus that of each model.",
                        residual_figure(found),
                        _SHADED,
                    ),
                ),
            ),
            _friction_table(found),
            _changed_table(found),
            _parameter_table(found),
        ),
        notices=tuple(_notices(found)),
        provenance=dict(provenance),
    )


_SHADED = "Grey: rows that were predicted, not fitted."


def _operations(answer: Supported) -> str:
    return f"{answer.operations} of {answer.operations_exact}"


def _headline(found: Identification, answer: Supported | None) -> str:
    shares = [each.share("identified") for each in found.residuals]
    worst = int(np.nanargmax(shares))
    each = found.residuals[worst]
    text = (
        f"The identified model predicts held-out torque to {percent(shares[worst])} RMS or better "
        f"(joint {worst + 1}); there the {found.start} err{'s' * (found.start == 'file')} by "
        f"{percent(each.share('file'))}, with friction {percent(each.share('friction'))}."
    )
    n = found.given.n_joints
    if len(found.kept) == n:
        text = (
            "The logs do not improve the file's links at any joint: its values stay, with fitted friction. "
            f"It predicts held-out torque to {percent(shares[worst])} RMS or better (joint {worst + 1})."
        )
    elif found.kept:
        text += f" At {named_joints(found.kept, n)} the file's values stay: the logs do not improve them."
    if found.doubts:
        others = f" ({len(found.doubts) - 1} more below)" if len(found.doubts) > 1 else ""
        return f"Doubtful: {found.doubts[0]}{others}. {text}"
    return text if answer is None else f"Your log supports {_operations(answer)} operations. {text}"


def _notices(found: Identification) -> Iterator[str]:
    if found.doubts:
        yield (
            "Log and file may not both be right. The identified arm carries these doubts: "
            f"{'; '.join(found.doubts)}."
        )
    if found.torque_scale is not None:
        scale = with_error(*found.torque_scale, 1)
        yield f"All torques are multiplied by {scale}, which meets the mass of the payload."
    elif found.payload is not None:
        yield (
            "The payload's mass is as uncertain as the scale of the torques, judged by gravity torques "
            "beside those of the file. A known mass (--mass) calibrates it."
        )
    if found.silent:
        still = named_joints(found.silent, found.given.n_joints)
        yield f"{still} does not move: its friction is not identifiable."
    others = ", ".join(one.symbol for one in found.parameters if not one.identifiable)
    if others:
        yield (
            "Not identifiable from the logs, or smaller than the standard error, and near the values of "
            f"the {found.start}: {others}. "
            "`gd-analyze plan ROBOT --exciting` plans a motion that tells more."
        )
    if not found.given.mass.any():
        yield "The file states no masses: links begin as uniform rods of invented density."
    ratio = {
        i + 1: each.rms("identified") / each.rms("friction")
        for i, each in enumerate(found.residuals)
        if each.rms("friction") > 0.0
    }
    worse = [joint for joint, value in ratio.items() if value > _CLEARLY]
    if worse:
        yield (
            f"At {named_joints(worse, found.given.n_joints)} the {found.start} with friction predicts "
            "better: the logs tell less there than the standard errors suggest."
        )
    rough = [i + 1 for i, share in enumerate(found.estimate.correlated) if share > _CORRELATED]
    if rough:
        yield (
            f"Residuals of {named_joints(rough, found.given.n_joints)} are correlated over more "
            f"than {_CORRELATED:.0f} rows: not noise, but an effect that the model lacks."
        )


# Correlation length, in rows, above which residuals are not noise; ratio of two RMS that clearly differ.
_CORRELATED, _CLEARLY = 5.0, 1.1


def _payload_table(found: Identification) -> Iterator[Table]:
    if found.payload is None:
        return
    values, errors = found.payload
    cells = [with_error(float(x), float(error), 1) for x, error in zip(values, errors, strict=True)]
    units = ["kg", "m", "m", "m"]
    columns = (
        Column("quantity", "quantity", ["mass", "x", "y", "z"], shown="name"),
        Column("value", "", values),
        Column("error", "", errors),
        Column(
            "", "value", [f"{cell} {unit}" for cell, unit in zip(cells, units, strict=True)], shown="text"
        ),
    )
    frame = found.given.tip or f"link {found.given.n_joints}"
    yield Table("payload", "Payload", columns, f"Centre of mass in the frame of {frame}; standard errors.")


def _residual_table(found: Identification) -> Table:
    units, rows = [joint.effort_unit for joint in found.given.joints], found.residuals
    measured = np.array([each.rms("measured") for each in rows])
    columns = [*joint_columns(found.given.joints), Column("measured", "measured", measured, units)]
    keys = {"file": found.start}
    columns += [
        Column(keys.get(model, model), label, np.array([each.rms(model) for each in rows]), units)
        for model, label in _models(found).items()
    ]
    columns += [
        Column("share", "of measured", [each.share("identified") for each in rows], shown="percent"),
        Column("noise", "", found.estimate.noise),
        Column("correlated_rows", "", found.estimate.correlated),
    ]
    note = "RMS of the measured torque, and of each model's residual."
    return Table("joints", "Held-out torque, by joint", tuple(columns), note)


def _friction_table(found: Identification) -> Table:
    columns = [*joint_columns(found.given.joints)]
    terms = {
        "coulomb": ("Coulomb", "N m", "N"),
        "viscous": ("viscous", "N m s", "N s/m"),
        "offset": ("offset", "N m", "N"),
        "drive_inertia": ("drive inertia", "kg m^2", "kg"),
    }
    numbers = np.column_stack([found.friction, found.drive_inertia])
    deviations = np.column_stack([found.friction_error, found.drive_error])
    slides = not all(found.given.is_revolute)
    for (key, (label, turning, sliding)), values, errors in zip(
        terms.items(), numbers.T, deviations.T, strict=True
    ):
        cells = [
            with_error(float(value), float(error), 1) if np.isfinite(error) else "–"
            for value, error in zip(values, errors, strict=True)
        ]
        unit = f"{turning} ({sliding})" if slides else turning
        columns += [Column(key, "", values), Column(f"{key}_error", "", errors)]
        columns.append(Column("", f"{label}, {unit}", cells, shown="text"))
    note = (
        "With standard errors; –: not identifiable. Drive inertia is only partly separable from the links'."
    )
    return Table("friction", "Friction and drives, at the joint", tuple(columns), note)


def _changed_table(found: Identification) -> Table:
    known = [one for one in found.parameters if one.identifiable]
    order = sorted(known, key=lambda one: -abs(one.value - one.file) / one.error)[:_MOST_CHANGED]
    columns = (
        Column("symbol", "parameter", [one.symbol for one in order], shown="text"),
        Column("", "link", [found.given.links[one.link - 1].name for one in order], shown="name"),
        Column("", found.start, [f"{number(one.file)} {one.unit}" for one in order], shown="text"),
        Column(
            "",
            "identified",
            [f"{with_error(one.value, one.error, 1)} {one.unit}" for one in order],
            shown="text",
        ),
        Column("change", "change, standard errors", [(one.value - one.file) / one.error for one in order]),
    )
    return Table("changed_most", "What changed most", columns)


def _parameter_table(found: Identification) -> Table:
    rows = found.parameters
    columns = (
        Column("symbol", "parameter", [one.symbol for one in rows], shown="text"),
        Column("link", "", [one.link for one in rows]),
        Column("unit", "unit", [one.unit for one in rows], shown="text"),
        Column(found.start, found.start, [one.file for one in rows]),
        Column("least_squares", "least squares", [one.least_squares for one in rows]),
        Column("value", "identified", [one.value for one in rows]),
        Column("error", "standard error", [one.error for one in rows]),
        Column("identifiable", "identifiable", [one.identifiable for one in rows], shown="flag"),
    )
    note = (
        "As defined by `gd-analyze equations ROBOT --parameters`. For a parameter that the logs do not tell "
        "the error is its plausible size; one below its standard error is not identifiable either."
    )
    return Table("parameters", "Base parameters", columns, note)


def torque_figure(found: Identification) -> Figure:
    """Measured torque of every joint, with the torques of the file and of the identified model."""
    looks = {"measured": ("combined", 2.2), "file": ("series-1", 0.7), "identified": ("accent", 0.9)}
    return _figure(found, "Torque", looks, {"measured": "measured", **_models(found)})


def residual_figure(found: Identification) -> Figure:
    """Residual of every joint: measured torque minus that of the file, with friction, and identified."""
    looks = {"file": ("series-1", 0.7), "friction": ("series-2", 0.7), "identified": ("accent", 0.9)}
    return _figure(found, "Measured less model", looks, _models(found), residual=True)


def _held_out(each: Residuals, low: float, high: float) -> Iterator[Area]:
    """Shade the rows that were predicted."""
    edges = np.flatnonzero(np.diff(each.held_out.astype(int), prepend=0, append=0)).reshape(-1, 2)
    for first, end in edges:
        time = each.time[[first, end - 1]]
        yield Area(time, np.full(2, low), np.full(2, high), "grid")


def _figure(
    found: Identification,
    label: str,
    looks: Mapping[str, tuple[str, float]],
    names: Mapping[str, str],
    *,
    residual: bool = False,
) -> Figure:
    panels = []
    for i, (joint, each) in enumerate(zip(found.given.joints, found.residuals, strict=True)):
        if not len(each.time):
            continue
        curves = {name: getattr(each, name) for name in looks}
        if residual:
            curves = {name: each.measured - values for name, values in curves.items()}
        gaps = np.flatnonzero(np.diff(each.time) > _GAP * float(np.median(np.diff(each.time)))) + 1
        x, y = time_axis(each.time), value_axis(joint.effort_unit, *curves.values(), most=3)
        items: list[Item] = [
            *_held_out(each, y.low, y.high),
            *(
                over_time(each.time, values, gaps, *looks[name], label=names[name])
                for name, values in curves.items()
            ),
        ]
        panels.append(Panel(f"{label}{i + 1}", joint_label(found.given.joints, i, 150.0), x, y, tuple(items)))
    legend = tuple(Key(names[name], colour) for name, (colour, _) in looks.items())
    return in_columns(label, panels, 2, 100.0, legend)
