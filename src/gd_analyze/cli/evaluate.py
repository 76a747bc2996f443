"""`gd-analyze evaluate`: a simplified model elsewhere than it was made for."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

import gd_analyze as gd
from gd_analyze.cli.given import carrying, payload_option, states_options, trajectory_or_states
from gd_analyze.cli.log_options import log_options, read_motion
from gd_analyze.cli.options import FILE, out_option
from gd_analyze.cli.output import Output, reporting
from gd_analyze.cli.outputs import require_outputs
from gd_analyze.cli.recursion_view import losses_of_changes
from gd_analyze.cli.terminal import line, sentence

if TYPE_CHECKING:
    from gd_analyze.robots.payload import Payload
    from gd_analyze.simplification.evaluation import Evaluation, Loss, PayloadEffect

# Shares of peak torque below this are printed as "< 0.01 %".
_WORTH_A_LINE = 1e-4


@dataclass(frozen=True, eq=False)
class _Trial:
    """A model, what the arm carried, and what came of it.

    The model's promise is that along the motion, where it is one of several that the model was made for;
    `fitted_on` is all of them.
    `without_payload` is the evaluation for the arm without the payload, None where there is none.
    """

    model: gd.SimplifiedModel
    fitted_on: Mapping[str, str | int]
    payload: Payload | None
    evaluation: Evaluation
    without_payload: Evaluation | None
    effect: PayloadEffect
    lost: tuple[Loss, ...]


@click.command(short_help="Try a simplified model elsewhere than it was made for.")
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
    r"""Evaluate a simplified model elsewhere than it was made for, and report its torque error there.

    What may be dropped depends on the states: the error stated for some says nothing of others. This is for
    a look at one motion, or at drawn states, and for torques over time; `gd-analyze validate` gives a verdict
    over files. With
    --payload the exact torque is that of the arm carrying it; the model remains as it was made.

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
        # At the other levels what is dropped is single terms, and with a payload it is not what the error
        # comes from.
        tells = motion is not None and body is None and not loaded.level.has_torque_terms
        lost: tuple[Loss, ...] = ()
        if tells and loaded.level is gd.LEVELS["recursive"]:
            lost = losses_of_changes(loaded, given)
        elif tells:
            lost = losses(loaded, evaluation.dynamics)
        if out is not None and motion is not None:
            stage(f"writing {out.name}")
            write_text(out, torque_csv(motion, evaluation))
        without = None if body is None else gd.evaluate(loaded, given)
        trial = _Trial(loaded, fitted_on, body, evaluation, without, gd.payload_effect(loaded, given), lost)
    output.give(lambda: _document(trial) | output.about(out), lambda: _show(trial), out)


def _document(trial: _Trial) -> dict[str, Any]:
    from dataclasses import asdict

    from gd_analyze.cli.joint_table import error_values, joint_rows, norm_rows
    from gd_analyze.simplification.accuracy import share_of

    model, effect, body = trial.model, trial.effect, trial.payload
    errors, promised, bare = trial.evaluation.errors, model.accuracy.errors, trial.without_payload
    exact, where = trial.evaluation.dynamics, trial.evaluation.dynamics.states.described
    allowed = model.accuracy.allowed if model.accuracy.asked.norm is None else None
    columns = {
        **error_values(errors, allowed),
        "peak_torque_made_for": promised.peak_torque,
        "largest_share_of_peak_made_for": share_of(errors.largest, promised.peak_torque),
        "promised_largest_error": promised.largest,
        "promised_of_allowed": None if allowed is None else share_of(promised.largest, allowed),
        "largest_error_without_payload": None if bare is None else bare.errors.largest,
        "torque_per_kg": effect.torque_per_kg,
        "mass_within_budget": effect.mass_within_budget,
    }
    return {
        "arm": model.arm.name,
        "level": model.level.name,
        "fitted_on": dict(trial.fitted_on),
        "budget": model.accuracy.budget,
        "promised": "measured" if model.accuracy.measured else "stated by the file",
        "held_against": {
            "arm": exact.arm.name,
            "drives": model.drives,
            "payload": body
            and {"mass": body.mass, "position": body.position.tolist(), "inertia": body.inertia.tolist()},
        },
        **{key: where.get(key) for key in ("trajectory", "set_points", "box", "states", "seed")},
        "joints": joint_rows(model.arm, columns),
        "norms": norm_rows(trial.evaluation.norms),
        "promised_norms": norm_rows(model.accuracy.norms),
        "mass_within_budget": effect.largest_mass,
        "limiting_joint": effect.limiting_joint,
        "largest_losses": [asdict(loss) for loss in trial.lost],
    }


def _show(trial: _Trial) -> None:
    from gd_analyze.cli.joint_table import arm_in_words, joint_table, times
    from gd_analyze.motions.states import in_words
    from gd_analyze.results.error_words import norms_told
    from gd_analyze.results.summary import measure_told

    model, exact = trial.model, trial.evaluation.dynamics
    errors, allowed = trial.evaluation.errors, model.accuracy.allowed
    fitted_on = str(model.accuracy.fitted_on.get("trajectory", "the arm's box"))
    where = exact.states.described
    over = f"over {exact.states.in_words}"
    if "trajectory" in where:
        over = f"along {where['trajectory']}, {where['set_points']} set points"
    sentence(f"{arm_in_words(exact.arm, model.drives)}, {over}", bold=True)
    unaware = "without this payload, " if trial.payload is not None else ""
    several = trial.fitted_on != model.accuracy.fitted_on
    whole = f", one of {in_words(trial.fitted_on).partition(' of ')[2]}," if several else ""
    sentence(f"by a model made {unaware}for {fitted_on}{whole} with a budget of {model.accuracy.budget}.")
    if model.accuracy.asked.norm is not None:
        _show_by_norm(trial)
        return
    if trial.without_payload is not None:
        beside, heading = trial.without_payload.errors, "unloaded"
    else:
        # Not measured again: the file's word.
        beside, heading = model.accuracy.errors, "promised" if model.accuracy.measured else "stated"
    joint_table(
        f"Torque error, {{units}}, and as a multiple of the allowed one: here, and {heading}",
        exact.arm,
        [
            ("peak here", errors.peak_torque),
            ("largest", errors.largest),
            ("allowed", allowed),
            ("× allowed", times(errors.largest, allowed)),
            (heading, times(beside.largest, allowed)),
            ("within", ["yes" if holds else "no" for holds in trial.evaluation.within(allowed)]),
        ],
    )
    line()
    measure = "" if where == model.accuracy.fitted_on else measure_told(model)
    meant = f"; the {measure} is meant, not that here" if measure else ""
    sentence(f"Allowed: {model.accuracy.budget}{meant}.")
    sentence(f"{norms_told(trial.evaluation.norms, exact.arm)}.")
    _compare(trial, fitted_on)
    _say_what_may_be_carried(trial)


def _show_by_norm(trial: _Trial) -> None:
    """Show the errors under a budget of the norm, which allows no joint a number of its own."""
    from gd_analyze.cli.joint_table import joint_table, percents
    from gd_analyze.results.error_words import norms_in_words, norms_told

    model, evaluation, asked = trial.model, trial.evaluation, trial.model.accuracy.asked.norm
    errors, bare, promised = trial.evaluation.errors, trial.without_payload, model.accuracy.norms
    joint_table(
        "Torque error here, {units}, and its share of the peak torque here",
        evaluation.dynamics.arm,
        [
            ("peak here", errors.peak_torque),
            ("largest", errors.largest),
            ("share", percents(errors.largest_share)),
            ("RMS", errors.rms),
            ("share", percents(errors.rms_share)),
        ],
    )
    line()
    kept = "kept" if asked and evaluation.keeps(asked) else "not kept"
    sentence(f"Allowed: {model.accuracy.budget}, which is {kept} here.")
    sentence(f"{norms_told(evaluation.norms, model.arm)}.")
    if bare is not None:
        sentence(f"Without the payload: {norms_in_words(bare.norms)}.")
    stated = "" if model.accuracy.measured else ", as its file states"
    sentence(f"Where the model was made{stated}: {norms_in_words(promised)}.")


def _compare(trial: _Trial, fitted_on: str) -> None:
    """Say how the error here compares to the one promised, or to the one without the payload."""
    from gd_analyze.simplification.accuracy import share_of
    from gd_analyze.text import number

    model, here, allowed = trial.model, trial.evaluation.errors.largest, trial.model.accuracy.allowed

    def torque(value: float, joint: int) -> str:
        return f"{number(value)} {model.arm.joints[joint].effort_unit}"

    if trial.without_payload is not None:
        unloaded = trial.without_payload.errors.largest
        most = int(share_of(here - unloaded, allowed).argmax())
        sentence(
            f"The payload tells most at joint {most + 1}, which errs by {torque(here[most], most)} with it "
            f"and by {torque(unloaded[most], most)} without."
        )
        return
    promised = model.accuracy.errors.largest
    worst = int(share_of(here, allowed).argmax())
    there = f"{'on' if 'trajectory' in model.accuracy.fitted_on else 'over'} {fitted_on}"
    if (share_of(here, allowed) <= share_of(promised, allowed).max()).all():
        sentence(f"The model errs no more here than {there}.")
        return
    sentence(
        f"Joint {worst + 1} errs by {torque(here[worst], worst)} here, "
        f"{number(here[worst] / allowed[worst])} times what is allowed, "
        f"and by {torque(promised[worst], worst)} {there}."
        + (" What was dropped and matters most here:" if trial.lost else "")
    )
    for loss in [loss for loss in trial.lost if loss.torque_share >= _WORTH_A_LINE][:5]:
        joint = loss.torque_joint - 1
        sentence(
            f"{loss.part:18} up to {torque(loss.torque_peak, joint)} at joint {joint + 1}, "
            f"{number(loss.torque_peak / allowed[joint])} times what is allowed",
            indent="  ",
        )


def _say_what_may_be_carried(trial: _Trial) -> None:
    from gd_analyze.text import named_joints, number

    effect = trial.effect
    within = (trial.without_payload or trial.evaluation).within(trial.model.accuracy.allowed)
    beyond = [i for i, holds in enumerate(within, start=1) if not holds]
    if beyond:
        sentence(f"Beyond the budget here, even without any payload: {named_joints(beyond, len(within))}.")
    elif effect.limiting_joint is not None:
        sentence(
            f"A point mass of up to {number(effect.largest_mass)} kg in the hand keeps every joint within "
            f"the budget here; joint {effect.limiting_joint} leaves it first."
        )
