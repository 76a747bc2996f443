"""A study of control as plain values: what terminal, JSON, HTML and PDF show."""

from __future__ import annotations

import math
import warnings
from typing import Any

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.robots.description import fingerprint
from gd_analyze.studies.control_verdict import (
    EXACT,
    FIXED_GAINS,
    SIMPLIFIED,
    WITHOUT_H,
    error_scale,
    good_enough,
    judged,
    rate_told,
    sentences,
    worst_of,
)
from gd_analyze.studies.controllers import CONTROLLERS, Controller
from gd_analyze.studies.settings import CONTINUOUS
from gd_analyze.studies.study import ControlStudy, TrackedLoop
from gd_analyze.text import number, percent, rounded_up


def control_document(study: ControlStudy) -> dict[str, Any]:
    """Lay a study out as JSON values, SI units and full precision.

    Returns
    -------
    dict
        `loops` has one entry per controller, rate and speed; a rate of None is a loop in continuous time, an
        error of None that of a loop that lost the motion. `tables` are the same as text.
    """
    settings, arm = study.settings, study.arm
    first, *rest = sentences(study)
    return {
        "title": arm.title or arm.name,
        "subtitle": f"controlled along {study.motion.name}",
        "headline": first,
        "sentences": rest,
        "facts": _facts(study),
        "arm": study.model.arm.name,
        "moved": arm.name,
        "trajectory": study.motion.name,
        "duration": float(study.motion.time[-1] - study.motion.time[0]),
        "level": study.model.level.name,
        "budget": study.model.accuracy.budget,
        "drives": study.model.drives,
        "friction": settings.friction,
        "bandwidth": settings.bandwidth,
        "damping": settings.damping,
        "rates": [_finite(rate) for rate in settings.rates],
        "speeds": list(settings.speeds),
        "fastest_within_limits": _finite(study.fastest_within_limits),
        "usual": {"rate": _finite(study.usual_rate), "speed": study.usual_speed},
        "good_enough": good_enough(study) or None,
        "feedback": {"share": study.feedback.share, "joints": list(study.feedback.joints)},
        "fixed_excess": study.fixed_excess,
        "tracks_up_to": {c.title: _up_to(study, c) for c in CONTROLLERS},
        "joints": _joints(study),
        "loops": [_loop(loop) for loop in study.loops],
        "tables": control_tables(study),
        "warnings": list(study.warnings),
        "provenance": dict(provenance_rows(study)),
    }


def control_tables(study: ControlStudy) -> dict[str, Any]:
    """Tables as text: caption, heads and rows of cells, the first of words."""
    arm, rate, speed = study.arm, study.usual_rate, study.usual_speed
    unit = {"mrad" if turns else "mm" for turns in arm.is_revolute}
    is_mixed = len(unit) > 1
    units = "mrad; mm where the joint slides" if is_mixed else unit.pop()
    joints = [f"joint {i}" for i in range(1, arm.n_joints + 1)]
    here = f"{rate_told(rate)}" + ("" if speed == 1.0 else f", at {speed:g} times the speed")

    def by_joint(values: str) -> list[list[str]]:
        return [[c.title, *_errors(study, getattr(study.loop(c, rate, speed), values))] for c in CONTROLLERS]

    def worst(loop: TrackedLoop) -> str:
        told = "lost" if loop.lost_at is not None else worst_of(study, loop.peak_error).told
        return told if is_mixed else told.split()[0]

    def beside(loops: list[list[TrackedLoop]]) -> list[list[str]]:
        return [[row[0].controller.title, *map(worst, row)] for row in loops]

    return {
        "peak": _table(
            f"Largest tracking error {here}, {units}: computed torque by what it knows, and PD",
            joints,
            by_joint("peak_error"),
        ),
        "rms": _table(f"RMS tracking error {here}, {units}", joints, by_joint("rms_error")),
        "rates": _table(
            f"Largest tracking error of any joint by loop rate, {units}",
            ["continuous" if r == CONTINUOUS else f"{r:g} Hz" for r in study.settings.rates],
            beside([[study.loop(c, r, speed) for r in study.settings.rates] for c in CONTROLLERS]),
        ),
        "speeds": _table(
            f"Largest tracking error of any joint by speed of the motion, {rate_told(rate)}, {units}",
            [f"{s:g}×" for s in study.settings.speeds],
            beside([[study.loop(c, rate, s) for s in study.settings.speeds] for c in CONTROLLERS]),
        ),
        "torque": _torque_table(study, here),
        "bounds": _bounds_table(study, units),
        "rest": _rest_table(study, units),
    }


def _table(caption: str, heads: list[str], rows: list[list[str]], first: str = "knows") -> dict[str, Any]:
    return {"caption": caption, "heads": [first, *heads], "rows": rows}


def _errors(study: ControlStudy, values: FloatArray, *, bound: bool = False) -> list[str]:
    """Cells of tracking errors, mrad (mm)."""
    scaled = [error_scale(study, i)[0] * float(value) for i, value in enumerate(values)]
    return [number(rounded_up(x) if bound else x) if math.isfinite(x) else "–" for x in scaled]


def _torque_table(study: ControlStudy, here: str) -> dict[str, Any]:
    shown = {"exact": EXACT, "simplified": SIMPLIFIED, "without h": WITHOUT_H}
    loops = [study.loop(c, study.usual_rate, study.usual_speed) for c in shown.values()]
    units = {joint.effort_unit for joint in study.arm.joints}
    rows = [
        [
            f"joint {i + 1}",
            number(float(study.limits[i])) if math.isfinite(study.limits[i]) else "none",
            *(number(float(loop.peak_torque[i])) for loop in loops),
            *(number(float(loop.rms_torque[i])) for loop in loops[:2]),
            percent(max(float(loop.saturated[i]) for loop in loops)),
        ]
        for i in range(study.arm.n_joints)
    ]
    heads = ["limit", *(f"peak, {name}" for name in shown), "RMS, exact", "RMS, simplified", "at the limit"]
    return _table(
        f"Torque of computed torque {here}, {' or '.join(sorted(units, reverse=True))}, and the share of "
        "time at the limit",
        heads,
        rows,
        "",
    )


def _bounds_table(study: ControlStudy, units: str) -> dict[str, Any]:
    speed, rates = study.usual_speed, study.settings.rates
    controller = judged(study)
    loops = [study.loop(controller, rate, speed) for rate in rates]
    found = study.certified.get(speed) if controller == SIMPLIFIED else None
    columns = [] if found is None else [_errors(study, found.error, bound=True)]
    columns += [_errors(study, loops[0].expected), *(_errors(study, loop.peak_error) for loop in loops)]
    how = "" if controller == SIMPLIFIED else ", with fixed gains"
    heads = ["certified"] * (found is not None) + ["expected"]
    heads += ["continuous" if rate == CONTINUOUS else f"{rate:g} Hz" for rate in rates]
    return _table(
        f"Tracking error that the simplified model's torque error causes at most{how}, and simulated, "
        f"{units}",
        heads,
        [[f"joint {i + 1}", *cells] for i, cells in enumerate(zip(*columns, strict=True))],
        "",
    )


def _rest_table(study: ControlStudy, units: str) -> dict[str, Any]:
    stiffness = [number(float(x)) for x in study.stiffness]
    columns = [stiffness, *(_errors(study, error) for error in study.at_rest.values())]
    heads = ["stiffness", *(c.title for c in study.at_rest)]
    stiff = "N m/rad" if all(study.arm.is_revolute) else "N m/rad or N/m"
    return _table(
        f"Error with which PD rests at the worst position of the motion, {units}: gravity not made up for "
        f"over the stiffness, {stiff}",
        heads,
        [[f"joint {i + 1}", *cells] for i, cells in enumerate(zip(*columns, strict=True))],
        "",
    )


def _facts(study: ControlStudy) -> list[list[str]]:
    """Headline figures and their captions."""
    here = f"{rate_told(study.usual_rate)}"
    facts = []
    fixed = judged(study) == FIXED_GAINS
    simplified = (
        (FIXED_GAINS, "the simplified model and fixed gains")
        if fixed
        else (SIMPLIFIED, "the simplified model")
    )
    for controller, name in (simplified, (EXACT, "the exact one")):
        loop = study.loop(controller, study.usual_rate, study.usual_speed)
        if loop.lost_at is None:
            worst = worst_of(study, loop.peak_error)
            facts.append([worst.told, f"largest error with {name} {here}, joint {worst.joint}"])
        else:
            facts.append(["lost", f"with {name} {here}"])
    leaves = study.tracks_up_to(WITHOUT_H, study.usual_rate)
    within = study.settings.tolerance.in_words(study.arm)
    most = max(study.settings.speeds)
    told = "none" if leaves is None else f"{number(min(leaves, most))}×"
    sign = "≥ " if leaves == math.inf else ""
    facts.append([sign + told, f"speed up to which dropping h stays within {within}"])
    found = study.certified.get(study.usual_speed)
    if found is not None:
        worst = worst_of(study, found.error, bound=True)
        facts.append([worst.told, f"certified: no larger error by the model, joint {worst.joint}"])
    return facts


def _joints(study: ControlStudy) -> list[dict[str, Any]]:
    return [
        {
            "joint": i + 1,
            "joint_name": joint.name,
            "unit": joint.unit,
            "effort_unit": joint.effort_unit,
            "tolerance": float(study.tolerance[i]),
            "inertia": float(study.diagonal[i]),
            "stiffness": float(study.stiffness[i]),
            "torque_limit": _finite(float(study.limits[i])),
            "error_at_rest": {c.title: float(error[i]) for c, error in study.at_rest.items()},
            "certified": [
                {
                    "speed": speed,
                    "torque_error": float(bound.torque_error[i]),
                    "error": float(bound.error[i]),
                }
                for speed, bound in study.certified.items()
            ],
        }
        for i, joint in enumerate(study.arm.joints)
    ]


def _loop(loop: TrackedLoop) -> dict[str, Any]:
    return {
        "controller": loop.controller.title,
        "law": loop.controller.law,
        "knows": loop.controller.knows,
        "rate": _finite(loop.rate),
        "speed": loop.speed,
        "lost_at": loop.lost_at,
        **{
            name: [_finite(x) for x in np.asarray(getattr(loop, name)).tolist()]
            for name in ("peak_error", "rms_error", "expected", "peak_torque", "rms_torque", "saturated")
        },
        "work": loop.work,
        "dissipated": loop.dissipated,
        "energy_residual": loop.energy_residual,
    }


def _up_to(study: ControlStudy, controller: Controller) -> dict[str, float | bool | None]:
    """Speed up to which the tolerance holds, None for no speed, and whether it holds at every speed tried."""
    speed = study.tracks_up_to(controller, study.usual_rate)
    known = None if speed is None else min(speed, max(study.settings.speeds))
    return {"speed": known, "at_every_speed": speed == math.inf}


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _books(study: ControlStudy) -> str:
    """Say how far the energy of all loops that kept the motion is accounted for."""
    kept = [loop for loop in study.loops if loop.lost_at is None]
    residual = max((abs(loop.energy_residual) for loop in kept), default=0.0)
    work = max((abs(loop.work) for loop in kept), default=0.0)
    return f"accounted for to {number(residual)} J; work up to {number(work)} J"


def settings_rows(study: ControlStudy) -> list[tuple[str, str]]:
    """Say what was asked for, as (label, value)."""
    settings, limits = study.settings, np.isfinite(study.limits)
    scale = "" if settings.limits in (None, 1.0) else f", times {settings.limits:g}"
    return [
        ("gains", f"bandwidth {settings.bandwidth:g} rad/s, damping {settings.damping:g}"),
        ("torque limits", f"those of the drives{scale}" if limits.any() else "none"),
        ("friction", "the drives', unknown to every controller" if settings.friction else "none"),
        ("energy", _books(study)),
        ("drives", "inertia included" if study.model.drives else "links alone"),
        ("model", f"level {study.model.level.name}, budget {study.model.accuracy.budget}"),
    ]


def provenance_rows(study: ControlStudy) -> list[tuple[str, str]]:
    """Say where the result comes from, as (label, value)."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # already told when the arm was read
        arm = f"{study.arm.name}, SHA-256 {fingerprint(study.arm)[:16]}"
    return [
        *settings_rows(study),
        ("arm", arm),
        *(("payload", note) for note in study.arm.assumptions if "payload" in note),
        ("trajectory", f"{study.motion.name}, SHA-256 {study.motion.fingerprint[:16]}"),
        *study.provenance.items(),
    ]
