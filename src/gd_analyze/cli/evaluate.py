"""`gd-analyze evaluate`: a simplified model elsewhere than it was fitted on."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

import gd_analyze as gd
from gd_analyze.cli.given import carrying, payload_option, states_options, trajectory_or_states
from gd_analyze.cli.log_options import log_options, read_motion
from gd_analyze.cli.options import FILE, out_option
from gd_analyze.cli.output import Output, reporting
from gd_analyze.cli.outputs import require_outputs

if TYPE_CHECKING:
    from gd_analyze.result import Result
    from gd_analyze.robots.parts import Link
    from gd_analyze.simplification.evaluation import Evaluation, Loss, PayloadEffect

# Smallest share of peak torque that people see a loss of.
_WORTH_A_LINE = 1e-4
_LOSS = ("part", "torque_peak", "torque_joint", "torque_share")


@dataclass(frozen=True, eq=False)
class _Trial:
    """A model, what the arm carried, and what came of it.

    The model's accuracy is that along the motion, where it is one of several that the model was fitted on;
    `fitted_on` is all of them.
    `without_payload` is the evaluation for the arm without the payload, None where there is none.
    """

    model: gd.SimplifiedModel
    fitted_on: Mapping[str, str | int]
    payload: Link | None
    evaluation: Evaluation
    without_payload: Evaluation | None
    effect: PayloadEffect
    lost: tuple[Loss, ...]


@click.command(short_help="Try a simplified model elsewhere than it was fitted on.")
@click.argument("model", type=FILE, help="A model.json that gd-analyze wrote.")
@trajectory_or_states
@log_options
@payload_option
@states_options
@out_option("CSV file for exact and simplified torque over time.")
@reporting
def evaluate(
    model: Path,
    trajectory: str | None,
    payload: str | None,
    states: int,
    seed: int,
    out: Path | None,
    output: Output,
) -> None:
    r"""Evaluate a simplified model elsewhere than it was fitted on, and report its torque error there.

    What may be dropped depends on the states: the error stated for some says nothing of others. This is for
    a look at one motion, or at drawn states, and for torques over time; `gd-analyze validate` gives a verdict
    over files. With --payload the exact torque is that of the arm carrying it; the model stays as it is.

    \b
    Examples:
      gd-analyze evaluate reports/puma560-pick-and-place/model.json large-slew
      gd-analyze evaluate model.json
      gd-analyze evaluate model.json large-slew --payload 1.5,0,0,0.1
    """
    if out is not None and trajectory is None:
        raise click.UsageError("-o writes torque over time, and needs a trajectory")
    require_outputs(out)
    with output.working() as stage:
        stage("reading")
        from gd_analyze.files import write_text
        from gd_analyze.robots.payload import parse_payload
        from gd_analyze.simplification.evaluation import losses, torque_csv

        body = None if payload is None else parse_payload(payload)
        loaded = gd.load_model(model)
        held = loaded.arm if body is None else carrying(loaded.arm, body)
        motion = None if trajectory is None else read_motion(trajectory, loaded.arm)
        given = gd.states_in_box(loaded.arm, states, seed) if motion is None else gd.states_of(motion)
        fitted_on = loaded.accuracy.fitted_on
        if motion is not None:
            loaded = replace(loaded, accuracy=loaded.accuracy.along(motion.fingerprint))
        stage("evaluating")
        evaluation = gd.evaluate(loaded, given, held)
        # With a payload, what is dropped is not what the error comes from.
        lost = losses(loaded, evaluation.dynamics) if motion is not None and body is None else ()
        if out is not None and motion is not None:
            stage(f"writing {out.name}")
            write_text(out, torque_csv(motion, evaluation))
        without = None if body is None else gd.evaluate(loaded, given)
        trial = _Trial(loaded, fitted_on, body, evaluation, without, gd.payload_effect(loaded, given), lost)
    output.give(_result(trial), wrote=out)


def _result(trial: _Trial) -> Result:
    import numpy as np

    from gd_analyze.motions.states import in_words
    from gd_analyze.result import Column, Fact, Result, Table, joint_columns
    from gd_analyze.results.model_facts import drives_text, norm_facts, norms_text
    from gd_analyze.simplification.accuracy import share_of

    model, effect, body, found = trial.model, trial.effect, trial.payload, trial.evaluation
    errors, promised, bare, asked = (
        found.errors,
        model.accuracy.errors,
        trial.without_payload,
        model.accuracy.asked,
    )
    exact, where, arm = found.dynamics, found.dynamics.states.described, model.arm
    nothing, units = [None] * arm.n_joints, [joint.effort_unit for joint in arm.joints]
    per_kg = [f"{unit}/kg" for unit in units]
    per_joint = asked.norm is None
    allowed = model.accuracy.allowed if per_joint else np.full(arm.n_joints, np.nan)
    # Not measured again: the file's word.
    beside, heading = (promised, "promised" if model.accuracy.measured else "stated")
    if bare is not None:
        beside, heading = bare.errors, "unloaded"
    joints = Table(
        "joints",
        "Torque error here",
        (
            *joint_columns(exact.arm.joints),
            Column("peak_torque", "peak here", errors.peak_torque, units),
            Column("largest_error", "error", errors.largest, units),
            Column("", "" if per_joint else "of peak", errors.largest_share, shown="percent"),
            Column("rms_error", "" if per_joint else "RMS", errors.rms, units),
            Column("", "allowed" if per_joint else "", allowed, units),
            Column("", "of allowed" if per_joint else "", share_of(errors.largest, allowed), shown="times"),
            Column("", heading if per_joint else "", share_of(beside.largest, allowed), shown="times"),
            Column(
                "within_allowed",
                "within" if per_joint else "",
                found.within(allowed) if per_joint else nothing,
                shown="flag",
            ),
            Column("allowed_error", "", model.accuracy.allowed if per_joint else nothing),
            Column("largest_of_allowed", "", share_of(errors.largest, allowed)),
            Column("largest_share_of_peak_here", "", errors.largest_share),
            Column("peak_torque_fitted_on", "", promised.peak_torque),
            Column("largest_share_of_peak_fitted_on", "", share_of(errors.largest, promised.peak_torque)),
            Column("promised_largest_error", "", promised.largest),
            Column("promised_of_allowed", "", share_of(promised.largest, allowed)),
            Column("largest_error_without_payload", "", nothing if bare is None else bare.errors.largest),
            Column("torque_per_kg", "", effect.torque_per_kg, per_kg),
            Column("mass_within_budget", "", effect.mass_within_budget, "kg"),
        ),
    )
    lost = [loss for loss in trial.lost if loss.torque_share >= _WORTH_A_LINE]
    places = [loss.torque_joint - 1 for loss in lost]
    beyond = bool((share_of(errors.largest, allowed) > share_of(promised.largest, allowed).max()).any())
    shown = Table(
        "",
        "Left out, by torque alone here",
        (
            Column("", "what", [loss.part for loss in lost], shown="text"),
            Column("", "torque", [loss.torque_peak for loss in lost], [units[joint] for joint in places]),
            Column("", "joint", [loss.torque_joint for loss in lost], shown="count"),
            Column(
                "",
                "of allowed",
                [x.torque_peak / allowed[k] for x, k in zip(lost, places, strict=True)],
                shown="times",
            ),
        ),
        top=5,
    )
    every = Table(
        "largest_losses",
        "",
        tuple(Column(name, "", [getattr(loss, name) for loss in trial.lost]) for name in _LOSS),
    )
    carried = body and {"mass": body.mass, "position": body.com, "inertia": body.inertia_com}
    within = (bare or found).within(model.accuracy.allowed).all()
    mass = "Point mass at the end effector within the budget" * bool(within and effect.limiting_joint)
    kept = "" if asked.norm is None else "kept here" if found.keeps(asked.norm) else "not kept here"
    stated = norms_text(model.accuracy.norms)
    fitted = in_words(trial.fitted_on) if trial.fitted_on else "states not named"
    return Result(
        title=f"{exact.arm.title or exact.arm.name}: torque error of a model of {arm.name}",
        subtitle=", ".join(filter(None, [f"over {exact.states.in_words}", drives_text(arm, model.drives)])),
        facts=(
            Fact("arm", "", arm.name),
            Fact("level", "Level", model.level.name),
            Fact("fitted_on", "Model fitted on", dict(trial.fitted_on), text=fitted),
            Fact("budget", "Budget", model.accuracy.budget, note=kept),
            Fact("promised", "", "measured" if model.accuracy.measured else "stated by the file"),
            Fact("held_against", "", {"arm": exact.arm.name, "drives": model.drives, "payload": carried}),
            *(Fact(key, "", where.get(key)) for key in ("trajectory", "set_points", "box", "states", "seed")),
            *norm_facts(found.norms, exact.arm),
            Fact(
                "",
                "Norm without the payload" if bare else "",
                None,
                text=norms_text(bare.norms if bare else ()),
            ),
            Fact(
                "promised_norms",
                "" if per_joint else "Norm where the model was fitted",
                [norm._asdict() for norm in model.accuracy.norms],
                text=stated,
            ),
            Fact(
                "mass_within_budget",
                mass,
                effect.largest_mass,
                "kg",
                note=f"joint {effect.limiting_joint} first",
            ),
            Fact("limiting_joint", "", effect.limiting_joint),
        ),
        parts=(joints, *((shown,) if beyond else ()), every),
    )
