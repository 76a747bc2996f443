"""An identification as a Result: residuals, parameters, friction, and the operations that logs support."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np

from gd_analyze.arrays import FloatArray, evenly, runs
from gd_analyze.dynamics.friction import FRICTION_TERMS
from gd_analyze.errors import GdAnalyzeError
from gd_analyze.figures.figure import (
    Area,
    Figure,
    Item,
    LegendKey,
    Panel,
    in_columns,
    over_time,
    short_joint_label,
    time_axis,
    value_axis,
)
from gd_analyze.identification.identification import Identification, Residuals
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.operations.program import OperationCount
from gd_analyze.result import (
    AnyFact,
    Drawing,
    Fact,
    Result,
    Section,
    Shown,
    Table,
    Value,
    attributes_of,
    joint_values,
)
from gd_analyze.results.diagnosis_result import table_of_faults
from gd_analyze.schema import SCHEMA_UNITS, declared, declared_table
from gd_analyze.simplification.budget import Budget
from gd_analyze.simplification.exact_dynamics import ExactDynamics
from gd_analyze.simplification.search import SearchOptions
from gd_analyze.simplification.simplify import simplify_exact
from gd_analyze.text import named_joints, number, percent, with_error

# The budget that equals the uncertainty left by the log.
SUPPORTED = "uncertainty"


def _models(identification: Identification) -> dict[str, str]:
    """Names of the models compared."""
    first = {"file": "file as given", "rods": "uniform rods"}[identification.start]
    return {"file": first, "friction": f"{identification.start}, friction fitted", "identified": "identified"}


class Supported(NamedTuple):
    """The simplified model with a torque error up to the identified arm's uncertainty, along the log."""

    operations: OperationCount
    operations_exact: OperationCount
    share: FloatArray  # uncertainty over each joint's peak torque, (n,)


# States of a log used to search the readable model.
_SEARCHED_STATES = 300


def supported(identification: Identification, motion: Trajectory) -> Supported | str:
    """Simplify the identified arm along a log, as far as the uncertainty of its torque allows.

    The search is an extra: what it fails of does not take the identified arm back.

    Parameters
    ----------
    identification
        The identification.
    motion
        One of its logs; a long one is represented by some of its set points.

    Returns
    -------
    Supported or str
        Operations of the model and of the exact torque; or why there is no model.
    """
    points = evenly(motion.n_set_points, _SEARCHED_STATES)
    sample = Trajectory(
        motion.time[points], motion.q[points], motion.qd[points], motion.qdd[points], motion.name
    )
    exact = ExactDynamics.of(identification.arm, sample, drives=True)
    try:
        model = simplify_exact(exact, Budget.of(SUPPORTED), SearchOptions(thorough=False))
    except GdAnalyzeError as error:
        return error.what
    except MemoryError:
        return "out of memory"
    assert exact.uncertainty is not None  # of an identified arm
    count = model.operations, model.operations_full
    return Supported(*count, exact.uncertainty / np.maximum(exact.peak_torque, 1e-300))


def identification_result(
    identification: Identification, answer: Supported | str | None, provenance: Mapping[str, str]
) -> Result:
    """Facts, tables and drawings; `answer` is the model, why there is none, or None if none was asked for."""
    arm, identifiable = (
        identification.stated_arm,
        [parameter for parameter in identification.parameters if parameter.identifiable],
    )
    held_out = f"held out: {', '.join(identification.held_out) or 'the last third of each log'}"
    loaded = f", with a payload {', '.join(identification.loaded)}" if identification.loaded else ""
    facts: list[AnyFact] = [
        Shown("Base parameters identifiable", f"{len(identifiable)} of {len(identification.parameters)}"),
        Fact("condition", "Condition number", identification.estimate.condition),
        Fact("physical", "Physically consistent", identification.physical, shown="flag"),
        *(
            Value(key, list(getattr(identification, key)))
            for key in ("logs", "held_out", "loaded", "kept", "doubts")
        ),
    ]
    if isinstance(answer, Supported):
        share = float(answer.share.max())
        note = f"joint {int(answer.share.argmax()) + 1}"
        facts[:0] = [
            Fact(
                "supported_operations",
                "Operations supported",
                answer.operations.total,
                text=_operations(answer),
            ),
            Fact("torque_uncertainty", "Uncertainty of torque, of its peak", share, "", "percent", note=note),
        ]
    return Result(
        title=arm.title or arm.name,
        subtitle=f"identified from {', '.join(identification.logs)}{loaded}; {held_out}",
        headline=_headline(identification, answer),
        facts=tuple(facts),
        parts=(
            _residual_table(identification),
            *_payload_table(identification),
            Section(
                None,
                "Torque over time",
                (
                    Drawing(
                        "torque",
                        f"Torque measured, of the {identification.start} and identified.",
                        identified_torque_figure(identification),
                        _SHADED,
                    ),
                    Drawing(
                        "residuals",
                        "Measured torque minus that of each model.",
                        residual_figure(identification),
                        _SHADED,
                    ),
                ),
            ),
            _friction_table(identification),
            *_faults_table(identification),
            _changed_table(identification),
            _parameter_table(identification),
        ),
        notices=tuple(_notices(identification, answer)),
        provenance=dict(provenance),
    )


_SHADED = "Grey: rows that were predicted, not fitted."


def _operations(answer: Supported) -> str:
    return f"{answer.operations.in_words} of {answer.operations_exact.pair}"


def _headline(identification: Identification, answer: Supported | str | None) -> str:
    shares = [residuals.share("identified") for residuals in identification.residuals]
    worst = int(np.nanargmax(shares))
    residuals = identification.residuals[worst]
    verb = "errs" if identification.start == "file" else "err"
    text = (
        f"The identified model predicts held-out torque to {percent(shares[worst])} RMS or better "
        f"(joint {worst + 1}); there the {identification.start} {verb} by "
        f"{percent(residuals.share('file'))}, with friction {percent(residuals.share('friction'))}."
    )
    n = identification.stated_arm.n_joints
    if len(identification.kept) == n:
        text = (
            "The logs do not improve the file's links at any joint: its values stay, with fitted friction. "
            f"It predicts held-out torque to {percent(shares[worst])} RMS or better (joint {worst + 1})."
        )
    elif identification.kept:
        kept_joints = named_joints(identification.kept, n)
        text += (
            f" At {kept_joints} the torque along the logs stays that of the file, which they do not improve; "
            "numbers of these links may change with the others'."
        )
    if identification.doubts:
        remark = f" ({len(identification.doubts) - 1} more below)" if len(identification.doubts) > 1 else ""
        return f"Doubtful: {identification.doubts[0]}{remark}. {text}"
    if isinstance(answer, Supported):
        return f"Your log supports {_operations(answer)}. {text}"
    return text


# Ratio of two RMS that clearly differ.
_CLEAR_RATIO = 1.1
# Correlation length, in rows, above which residuals are not noise.
_CORRELATED_ROWS = 5.0


def _notices(identification: Identification, answer: Supported | str | None) -> Iterator[str]:
    if isinstance(answer, str):
        yield f"How many operations the log supports is not stated: {answer}."
    if identification.doubts:
        yield (
            "Log and file may not both be right. The identified arm carries these doubts: "
            f"{'; '.join(identification.doubts)}."
        )
    if identification.torque_scale is not None:
        scale = with_error(*identification.torque_scale)
        yield f"All torques are multiplied by {scale}, which meets the mass of the payload."
    elif identification.payload is not None:
        yield (
            "The payload's mass is as uncertain as the scale of the torques, judged by gravity torques "
            "beside those of the file. A known mass (--mass) calibrates it."
        )
    if identification.silent:
        still_joints = named_joints(identification.silent, identification.stated_arm.n_joints)
        yield f"{still_joints} does not move, or has no usable torque: its friction is not identifiable."
    unidentifiable = ", ".join(
        parameter.symbol for parameter in identification.parameters if not parameter.identifiable
    )
    if unidentifiable:
        yield (
            "Not identifiable from the logs, or smaller than the standard error, and near the values of "
            f"the {identification.start}: {unidentifiable}. "
            "`gd-analyze plan ROBOT --exciting --duration 20` plans a motion that tells more."
        )
    if not identification.stated_arm.mass.any():
        yield "The file states no masses: links begin as uniform rods of invented density."
    ratio = {
        i + 1: residuals.rms("identified") / residuals.rms("friction")
        for i, residuals in enumerate(identification.residuals)
        if residuals.rms("friction") > 0.0
    }
    worse = [joint for joint, value in ratio.items() if value > _CLEAR_RATIO]
    if worse:
        yield (
            f"At {named_joints(worse, identification.stated_arm.n_joints)} the {identification.start} with "
            "friction predicts better: the logs tell less there than the standard errors suggest."
        )
    lengths = identification.estimate.correlated
    rough = [i + 1 for i, length in enumerate(lengths) if length > _CORRELATED_ROWS]
    if rough:
        joints = named_joints(rough, identification.stated_arm.n_joints)
        yield (
            f"Residuals of {joints} are correlated over more "
            f"than {_CORRELATED_ROWS:.0f} rows: not noise, but an effect that the model lacks. "
            "Standard errors allow for it, and biases may be larger."
        )


def _faults_table(identification: Identification) -> Iterator[Table]:
    faults = identification.faults
    return table_of_faults([vars(fault) | {"joint": fault.joint + 1} for fault in faults])


def _payload_table(identification: Identification) -> Iterator[Table]:
    if identification.payload is None:
        return
    numbers, errors = identification.payload
    texts = [with_error(float(x), float(error)) for x, error in zip(numbers, errors, strict=True)]
    units = ["kg", "m", "m", "m"]
    values = {"quantity": ["mass", "x", "y", "z"], "value": numbers, "error": errors}
    seen = {"value": [f"{text} {unit}" for text, unit in zip(texts, units, strict=True)]}
    frame = identification.stated_arm.tip or f"link {identification.stated_arm.n_joints}"
    note = f"Centre of mass in the frame of {frame}; standard errors."
    names = ["quantity", "value"]
    yield declared_table("identified_payload", "payload", "Payload", values, names, note=note, seen=seen)


def _residual_table(identification: Identification) -> Table:
    rows, models = identification.residuals, _models(identification)
    residuals = {model: [of_joint.rms(model) for of_joint in rows] for model in ("measured", *models)}
    seen = {f"model_{model}": residuals[model] for model in models}
    values = joint_values(identification.stated_arm.joints)
    values |= {identification.start if name == "file" else name: rms for name, rms in residuals.items()}
    values |= {
        "share": [of_joint.share("identified") for of_joint in rows],
        "noise": identification.estimate.noise,
        "correlated_rows": identification.estimate.correlated,
    }
    return declared_table(
        "identified",
        "joints",
        "Held-out torque, by joint",
        values,
        ["joint", "measured", *seen, "share"],
        note="RMS of the measured torque, and of each model's residual.",
        seen=seen,
        words={f"model_{model}": words for model, words in models.items()},
    )


def _friction_table(identification: Identification) -> Table:
    arm = identification.stated_arm
    terms = (*FRICTION_TERMS, "drive_inertia")
    numbers = np.column_stack([identification.friction, identification.drive_inertia]).T
    deviations = np.column_stack([identification.friction_error, identification.drive_error]).T
    values, seen, words = joint_values(arm.joints), dict[str, Any](), dict[str, str]()
    for name, of_joints, errors in zip(terms, numbers, deviations, strict=True):
        values |= {name: of_joints, f"{name}_error": errors}
        seen[name] = [
            with_error(float(value), float(error)) if np.isfinite(error) else "–"
            for value, error in zip(of_joints, errors, strict=True)
        ]
        sliding, *_, turning = SCHEMA_UNITS[declared("identified", name)[0].unit]
        words[name] = turning if all(arm.is_revolute) else f"{turning} ({sliding})"
    note = (
        "With standard errors, by held-out residuals; –: not identifiable. Drive inertia is only partly "
        "separable from the links'."
    )
    return declared_table(
        "identified",
        "friction",
        "Friction and drives, at the joint",
        values,
        ["joint", *terms],
        note=note,
        seen=seen,
        words=words,
    )


# Number of base parameters listed as changed most.
_MOST_CHANGED = 5


def _changed_table(identification: Identification) -> Table:
    identifiable = [parameter for parameter in identification.parameters if parameter.identifiable]
    changed = sorted(
        identifiable, key=lambda parameter: -abs(parameter.value - parameter.file) / parameter.error
    )[:_MOST_CHANGED]
    links = identification.stated_arm.links
    seen = {
        "link_name": [links[parameter.link - 1].name for parameter in changed],
        "start_text": [f"{number(parameter.file)} {parameter.unit}" for parameter in changed],
        "value_text": [
            f"{with_error(parameter.value, parameter.error)} {parameter.unit}" for parameter in changed
        ],
    }
    values = {
        "symbol": [parameter.symbol for parameter in changed],
        "change": [(parameter.value - parameter.file) / parameter.error for parameter in changed],
    }
    return declared_table(
        "identified_parameters",
        "changed_most",
        "What changed most",
        values,
        ["symbol", *seen, "change"],
        seen=seen,
        words={"start_text": identification.start},
    )


def _parameter_table(identification: Identification) -> Table:
    rows, start = identification.parameters, identification.start
    files = [parameter.file for parameter in rows]
    note = (
        "As defined by `gd-analyze equations ROBOT --parameters`. For a parameter that the logs do not tell "
        "the error is its plausible size; one below its standard error is not identifiable either."
    )
    names = ["least_squares", "value", "error", "identifiable"]
    return declared_table(
        "identified_parameters",
        "parameters",
        "Base parameters",
        attributes_of(rows, "symbol", "link", "unit") | {start: files} | attributes_of(rows, *names),
        ["symbol", "unit", "start", *names],
        note=note,
        seen={"start": files},
        words={"start": start},
    )


def identified_torque_figure(identification: Identification) -> Figure:
    """Measured torque of every joint, with the torques of the file and of the identified model."""
    looks = {"measured": ("combined", 2.2), "file": ("series-1", 0.7), "identified": ("accent", 0.9)}
    return _figure(identification, "Torque", looks, {"measured": "measured", **_models(identification)})


def residual_figure(identification: Identification) -> Figure:
    """Residual of every joint: measured torque minus that of the file, with friction, and identified."""
    looks = {"file": ("series-1", 0.7), "friction": ("series-2", 0.7), "identified": ("accent", 0.9)}
    return _figure(identification, "Measured less model", looks, _models(identification), residual=True)


def _held_out(residuals: Residuals, low: float, high: float) -> Iterator[Area]:
    """Shade the rows that were predicted."""
    for first, end in runs(residuals.held_out):
        time = residuals.time[[first, end - 1]]
        yield Area(time, np.full(2, low), np.full(2, high), "grid")


# Neighbouring rows more than this many steps apart belong to different stretches.
_GAP_STEPS = 3.0


def _figure(
    identification: Identification,
    label: str,
    looks: Mapping[str, tuple[str, float]],
    names: Mapping[str, str],
    *,
    residual: bool = False,
) -> Figure:
    panels = []
    for i, (joint, residuals) in enumerate(
        zip(identification.stated_arm.joints, identification.residuals, strict=True)
    ):
        if not len(residuals.time):
            continue
        curves = {name: getattr(residuals, name) for name in looks}
        if residual:
            curves = {name: residuals.measured - values for name, values in curves.items()}
        steps = np.diff(residuals.time)
        gaps = np.flatnonzero(steps > _GAP_STEPS * float(np.median(steps))) + 1
        x, y = time_axis(residuals.time), value_axis(joint.effort_unit, *curves.values(), most=3)
        items: list[Item] = [
            *_held_out(residuals, y.low, y.high),
            *(
                over_time(residuals.time, values, gaps, *looks[name], label=names[name])
                for name, values in curves.items()
            ),
        ]
        panels.append(
            Panel(
                f"{label}{i + 1}",
                short_joint_label(identification.stated_arm.joints, i, 150.0),
                x,
                y,
                tuple(items),
            )
        )
    legend = tuple(LegendKey(names[name], colour) for name, (colour, _) in looks.items())
    return in_columns(label, panels, 2, 100.0, legend)
