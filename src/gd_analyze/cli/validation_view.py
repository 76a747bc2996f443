"""What a validation found, as terminal and JSON show it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from gd_analyze.cli.joint_table import (
    arm_in_words,
    error_values,
    joint_rows,
    joint_table,
    norm_rows,
    percents,
)
from gd_analyze.cli.measured_torque import show_friction
from gd_analyze.cli.terminal import line, sentence, table
from gd_analyze.motions.states import in_words
from gd_analyze.results.motion_tables import measured_torque_table
from gd_analyze.results.torque_words import rows_told, torque_sentence
from gd_analyze.simplification.accuracy import share_of
from gd_analyze.text import joint_name, number, percent, short_name

if TYPE_CHECKING:
    from gd_analyze.cli.joint_table import Column
    from gd_analyze.dynamics.measured_torque import TorqueComparison
    from gd_analyze.results.rows import Row
    from gd_analyze.studies.along import ValidatedMotion
    from gd_analyze.studies.box_exits import BoxExit
    from gd_analyze.studies.validate import Validation

# Characters of names of motions and joints in tables that hold much else.
_NAME, _MOTION = 12, 24


def document(found: Validation, fit_friction: bool) -> dict[str, Any]:
    """What was found, as JSON has it."""
    model, box = found.model, found.box
    return {
        "arm": model.arm.name,
        "drives": model.drives,
        "level": model.level.name,
        "fitted_on": dict(model.accuracy.fitted_on),
        "budget": model.accuracy.budget,
        "fail_over": None if found.fail_over is None else str(found.fail_over),
        "passed": None if found.fail_over is None else found.passed,
        "box": {
            "where": box.where,
            **{name: getattr(box, name).tolist() for name in ("lower", "upper", "velocity", "acceleration")},
        },
        "motions": [_motion(one, found, fit_friction) for one in found.motions],
    }


def _motion(one: ValidatedMotion, found: Validation, fit_friction: bool) -> dict[str, Any]:
    arm, fails = found.model.arm, one.fails
    columns = error_values(one.evaluation.errors, one.allowed) | {
        "largest_error_at": one.at,
        "fail_over": one.most,
        "passed": None if one.most is None else ~fails,
    }
    return {
        "trajectory": one.name,
        "set_points": one.trajectory.n_set_points,
        "begin": float(one.trajectory.time[0]),
        "end": float(one.trajectory.time[-1]),
        "passed": None if one.most is None else not fails.any(),
        "keeps_promise": bool(one.keeps_promise.all()),
        "joints": joint_rows(arm, columns),
        "norms": norm_rows(one.evaluation.norms),
        "set_points_outside_box": int(one.outside.sum()),
        "box_exits": [_exit(each) for each in one.exits],
        "measured_torque": one.measured
        and {
            "exact": _compared(one, one.measured.exact, fit_friction),
            "simplified": _compared(one, one.measured.simplified, fit_friction),
        },
    }


def _exit(found: BoxExit) -> dict[str, Any]:
    farthest = found.farthest
    return {
        "joint": farthest.joint,
        "joint_name": farthest.name,
        "quantity": farthest.quantity,
        "unit": farthest.unit,
        "limit": farthest.limit,
        "farthest": farthest.value,
        "farthest_at": farthest.time,
        "set_points": found.set_points,
        "first": found.first,
        "longest_stretch": [found.begin, found.end],
    }


def _compared(one: ValidatedMotion, comparison: TorqueComparison, fit_friction: bool) -> list[Row]:
    tabled = measured_torque_table(comparison, one.trajectory, fit_friction=fit_friction)
    return rows_told(tabled, comparison.arm)


def show(found: Validation, fit_friction: bool) -> None:
    """Print the verdict, then each motion."""
    model, count = found.model, len(found.motions)
    fitted_on = in_words(model.accuracy.fitted_on) if model.accuracy.fitted_on else "states without a name"
    sentence(_verdict(found), bold=True)
    sentence(
        f"{arm_in_words(model.arm, model.drives)}: a model made for {fitted_on}, with a budget of "
        f"{model.accuracy.budget}, along {count} motion{'s' * (count > 1)}."
    )
    if count > 1:
        _show_all(found)
    for one in found.motions:
        _show_errors(one, found)
        _show_exits(one, found)
        if one.measured is not None:
            _show_measured(one, fit_friction)


def _verdict(found: Validation) -> str:
    one, joint = found.worst
    name = joint_name(joint + 1, found.model.arm.joints[joint].name)
    worst = f"joint {name} along {one.name}: {one.error_told(joint)}"
    exact = "" if one.evaluation.errors.largest[joint] else "No joint errs by more than round-off."
    if found.fail_over is None:
        return f"Not judged, as there is no --fail-over. {exact or f'Farthest off is {worst}.'}"
    asked = f"--fail-over {found.fail_over}"
    if found.passed:
        return f"Passed: no error is above {asked}. {exact or f'Nearest to it is {worst}.'}"
    failed, tried = sum(one.fails.any() for one in found.motions), len(found.motions)
    many = f"{len(found.failures)} of {tried * found.model.arm.n_joints} errors" + (
        f", on {failed} of {tried} motions," if tried > 1 else ""
    )
    return f"Failed: {many} are above {asked}; most {worst}."


def _show_all(found: Validation) -> None:
    """A row per motion."""
    rows = []
    for one in found.motions:
        errors, unkept = one.evaluation.errors, int((~one.keeps_promise).sum())
        rows.append(
            [
                short_name(one.name, _MOTION),
                str(one.trajectory.n_set_points),
                percent(float(errors.largest_share.max())),
                str(errors.worst + 1),
                str(unkept),
                str(int(one.outside.sum())),
                *([] if one.most is None else ["fails" if one.fails.any() else "passes"]),
            ]
        )
    headings = ["motion", "points", "of peak", "joint", "broken", "outside"]
    verdict = [] if found.fail_over is None else ["verdict"]
    table(
        "Largest error as a share of the joint's peak torque along each motion, joints at which the model's "
        "promise is broken, and set points outside the arm's limits",
        [*headings, *verdict],
        rows,
        "lrrrrr" + "l" * len(verdict),
    )


def _show_errors(one: ValidatedMotion, found: Validation) -> None:
    errors = one.evaluation.errors
    columns: list[Column] = [
        ("peak", errors.peak_torque),
        ("largest", errors.largest),
        ("of peak", percents(errors.largest_share)),
    ]
    if one.most is None:
        columns.append(("at, s", ["–" if np.isnan(at) else f"{float(at):.4g}" for at in one.at]))
        if one.allowed is not None:
            columns.append(("promised", one.allowed))
    else:
        columns += [("may be", one.most), ("verdict", ["fails" if x else "passes" for x in one.fails])]
    if one.allowed is not None and found.fail_over != "promise":
        columns.append(("promise", ["kept" if x else "broken" for x in one.keeps_promise]))
    points = f"{one.trajectory.n_set_points} set points"
    joint_table(f"{one.name}, {points}: torque error, {{units}}", found.model.arm, columns)
    asked = one.accuracy.asked.norm
    if asked is not None:
        kept = "kept" if one.keeps_promise.all() else "not kept"
        line()
        sentence(f"Promised: {one.accuracy.budget}, which is {kept} along this motion.")


def _show_exits(one: ValidatedMotion, found: Validation) -> None:
    """Where the motion is outside the box; nothing where it never is."""
    if not one.exits:
        return
    rows = [
        [
            short_name(joint_name(each.farthest.joint, each.farthest.name), _NAME),
            each.farthest.quantity,
            f"{number(each.farthest.limit)} {each.farthest.unit}",
            number(each.farthest.excess),
            str(each.set_points),
            f"{each.first:.4g}",
            f"{each.begin:.4g} to {each.end:.4g}",
        ]
        for each in one.exits
    ]
    table(
        f"{one.name}: {int(one.outside.sum())} of {one.trajectory.n_set_points} set points lie outside "
        f"{found.box.where}, where no certificate for them holds (times in s)",
        ["joint", "quantity", "limit", "by", "points", "first", "longest"],
        rows,
        "lllrrrr",
    )


def _show_measured(one: ValidatedMotion, fit_friction: bool) -> None:
    """Exact and simplified torque side by side, each against what was measured."""
    assert one.measured is not None  # who calls has asked
    exact, simplified = one.measured.exact, one.measured.simplified
    columns: list[Column] = [("measured", exact.peak_measured)]
    for heading, of in (("exact", exact), ("simplified", simplified)):
        columns.append((heading, of.rms))
        if fit_friction:
            columns.append(("left", of.friction.rms))
    # To nine digits: what is left out may be nothing, but for round-off.
    adds = np.round(share_of(simplified.rms - exact.rms, exact.rms), 9) + 0.0
    columns.append(("more", ["–" if np.isnan(x) else percent(float(x)) for x in adds]))
    joint_table(
        f"{one.name}: largest measured torque; RMS of measured minus exact and minus simplified, {{units}}"
        + ("; left: beside friction fitted to each" if fit_friction else ""),
        exact.arm,
        columns,
    )
    if fit_friction:
        show_friction(_compared(one, exact, fit_friction=True), " from the exact torque")
    line()
    sentence(torque_sentence(measured_torque_table(exact, one.trajectory)))
    pairs = enumerate(zip(exact.verdicts, simplified.verdicts, strict=True), start=1)
    others = [f"joint {i}: {verdict}" for i, (before, verdict) in pairs if verdict != before]
    if others:
        sentence(f"Beside the simplified torque it is otherwise: {'; '.join(others)}.")
