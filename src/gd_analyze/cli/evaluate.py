"""`gd-analyze evaluate`: a simplified model elsewhere than it was made for."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from gd_analyze.cli.options import reporting
from gd_analyze.cli.payload import carrying, payload_option
from gd_analyze.cli.states import states_options, trajectory_argument

if TYPE_CHECKING:
    from gd_analyze.levels import Evaluation, Loss, SimplifiedModel
    from gd_analyze.levels.payload_effect import PayloadEffect
    from gd_analyze.robots import Payload, RobotArm
    from gd_analyze.states import States

# Shares of peak torque below this are printed as "< 0.01 %".
_WORTH_A_LINE = 1e-4


@dataclass(frozen=True, eq=False)
class _Trial:
    """A model, what it was held against and where, and what came of it.

    `without_payload` is the evaluation for the arm without the payload, None where there is none.
    """

    model: SimplifiedModel
    arm: RobotArm
    payload: Payload | None
    states: States
    evaluation: Evaluation
    without_payload: Evaluation | None
    effect: PayloadEffect
    lost: tuple[Loss, ...]


@click.command(short_help="Try a simplified model elsewhere than it was made for.")
@click.argument("model", type=click.Path(path_type=Path), help="A model.json that gd-analyze wrote.")
@trajectory_argument
@payload_option
@states_options
@click.option(
    "-o", "--out", type=click.Path(path_type=Path), help="CSV file for exact and simplified torque over time."
)
@reporting
def evaluate(
    model: Path,
    trajectory: str | None,
    payload: str | None,
    states: int,
    seed: int,
    out: Path | None,
    as_json: bool,
    quiet: bool,
    debug: bool,
) -> None:
    r"""Evaluate a simplified model elsewhere than it was made for, and report its torque error there.

    What may be dropped depends on the states: the error stated for some says nothing of others. With
    --payload the exact torque is that of the arm carrying it; the model remains as it was made.

    \b
    Examples:
      gd-analyze evaluate reports/puma560-pick-and-place/model.json large-slew
      gd-analyze evaluate model.json
      gd-analyze evaluate model.json large-slew --payload 1.5,0,0,0.1
    """
    from gd_analyze.cli.terminal import line, print_json, stages, warnings_told

    if out is not None and trajectory is None:
        raise click.UsageError("-o writes torque over time, and needs a trajectory")
    with warnings_told(quiet) as told, stages(quiet) as stage:
        stage("reading")
        from gd_analyze.decomposition import decompose
        from gd_analyze.files import write_text
        from gd_analyze.levels import evaluate as along
        from gd_analyze.levels import load_model, losses, torque_csv
        from gd_analyze.levels.evaluation import evaluate_states
        from gd_analyze.levels.payload_effect import payload_effect
        from gd_analyze.robots import parse_payload
        from gd_analyze.states import states_in_box, states_of
        from gd_analyze.trajectories import read_trajectory

        body = None if payload is None else parse_payload(payload)
        loaded = load_model(model)
        held = loaded.arm if body is None else carrying(loaded.arm, body)
        lost: tuple[Loss, ...] = ()
        if trajectory is None:
            given = states_in_box(loaded.arm, states, seed)
            stage("evaluating")
            evaluation = evaluate_states(loaded, given, held)
        else:
            motion = read_trajectory(trajectory, loaded.arm)
            stage("decomposing", motion.n_set_points)
            dataset = decompose(held, motion, coupling=False, drives=loaded.drives, progress=stage.advance)
            # Of the arm without the payload, whose decomposition is at hand where there is none.
            given = states_of(motion)
            stage("evaluating")
            evaluation = along(loaded, motion, dataset, arm=held)
            # At the other levels what is dropped is no part that the decomposition knows, and with a payload
            # it is not what the error comes from.
            if not loaded.level.has_torque_terms and body is None:
                lost = losses(loaded, dataset)
            if out is not None:
                stage(f"writing {out.name}")
                write_text(out, torque_csv(motion, evaluation))
        without = None if body is None else evaluate_states(loaded, given)
        trial = _Trial(loaded, held, body, given, evaluation, without, payload_effect(loaded, given), lost)
    if as_json:
        print_json(_document(trial, told, out))
    elif not quiet:
        _show(trial)
        if out is not None:
            line(f"wrote {out}")


def _document(trial: _Trial, told: list[str], out: Path | None) -> dict[str, Any]:
    from dataclasses import asdict

    model, effect = trial.model, trial.effect
    here, promised = trial.evaluation.table, model.promise.errors
    bare = trial.without_payload.table if trial.without_payload is not None else None
    where = trial.states.described
    return {
        "arm": model.arm.name,
        "level": model.level.name,
        "made_for": dict(model.promise.made_for),
        "budget": model.promise.budget,
        "held_against": {
            "arm": trial.arm.name,
            "drives": model.drives,
            "payload": _payload(trial.payload),
        },
        **{key: where.get(key) for key in ("trajectory", "set_points", "box", "states", "seed")},
        "joints": [
            {
                "joint": i + 1,
                "name": joint.name,
                "unit": joint.effort_unit,
                "peak_torque": float(here.peak_torque[i]),
                "allowed_error": float(model.promise.allowed[i]),
                "largest_error": float(here.largest[i]),
                "largest_share": float(here.largest_share[i]),
                "rms_error": float(here.rms[i]),
                "rms_share": float(here.rms_share[i]),
                "promised_largest_error": float(promised.largest[i]),
                "promised_largest_share": float(promised.largest_share[i]),
                "largest_error_without_payload": None if bare is None else float(bare.largest[i]),
                "largest_share_without_payload": None if bare is None else float(bare.largest_share[i]),
                "torque_per_kg": float(effect.torque_per_kg[i]),
                "point_mass_within_budget": float(effect.mass_within_budget[i]),
            }
            for i, joint in enumerate(model.arm.joints)
        ],
        "point_mass_within_budget": effect.largest_mass,
        "limiting_joint": effect.limiting_joint,
        "largest_losses": [asdict(loss) for loss in trial.lost],
        "warnings": told,
        "files": [str(out)] if out is not None else [],
    }


def _payload(body: Payload | None) -> dict[str, Any] | None:
    if body is None:
        return None
    return {"mass": body.mass, "position": body.position.tolist(), "inertia": body.inertia.tolist()}


def _show(trial: _Trial) -> None:
    from gd_analyze.cli.joint_table import joint_table
    from gd_analyze.cli.terminal import line, sentence
    from gd_analyze.formatting import number, percent

    model, arm = trial.model, trial.arm
    here, promised = trial.evaluation.table, model.promise.errors
    made_for = str(model.promise.made_for.get("trajectory", "the arm's box"))
    sentence(f"{arm.title or arm.name} {_where(trial.states)}", bold=True)
    unaware = "without this payload, " if trial.payload is not None else ""
    sentence(f"by a model made {unaware}for {made_for} with a budget of {model.promise.budget}.")
    if trial.without_payload is not None:
        beside, heading = trial.without_payload.table, "unloaded"
    else:
        beside, heading = promised, "promised"
    joint_table(
        "Torque error, {units}, and its share of peak torque",
        arm,
        [
            ("peak torque", "right", [number(float(x)) for x in here.peak_torque]),
            ("largest", "right", [number(float(x)) for x in here.largest]),
            ("share", "right", [percent(float(x)) for x in here.largest_share]),
            ("RMS", "right", [number(float(x)) for x in here.rms]),
            ("share", "right", [percent(float(x)) for x in here.rms_share]),
            (heading, "right", [percent(float(x)) for x in beside.largest_share]),
        ],
    )
    line()
    _compare(trial, made_for)
    _say_what_may_be_carried(trial)


def _where(states: States) -> str:
    where = states.described
    if "trajectory" in where:
        return f"along {where['trajectory']}, {where['set_points']} set points"
    return f"over {where['states']} states drawn from {where['box']}, seed {where['seed']}"


def _compare(trial: _Trial, made_for: str) -> None:
    """Say how the error here compares to the one promised, or to the one without the payload."""
    from gd_analyze.cli.terminal import line, sentence
    from gd_analyze.formatting import number, percent

    here, promised = trial.evaluation.table, trial.model.promise.errors
    if trial.without_payload is not None:
        unloaded = trial.without_payload.table
        growth = [
            float(with_it - without) / float(peak) if peak > 0.0 else 0.0
            for with_it, without, peak in zip(here.largest, unloaded.largest, here.peak_torque, strict=True)
        ]
        most = max(range(len(growth)), key=growth.__getitem__)
        sentence(
            f"The payload tells most at joint {most + 1}, which errs by "
            f"{percent(float(here.largest_share[most]))} of its peak torque with it and by "
            f"{percent(float(unloaded.largest_share[most]))} without."
        )
        return
    worst = int(here.largest_share.argmax())
    there = f"{'on' if 'trajectory' in trial.model.promise.made_for else 'over'} {made_for}"
    if (here.largest_share <= promised.largest_share.max()).all():
        sentence(f"The model errs no more here than {there}.")
        return
    sentence(
        f"Joint {worst + 1} errs by {percent(float(here.largest_share[worst]))} of its peak torque here, "
        f"by {percent(float(promised.largest_share[worst]))} {there}."
        + (" What was dropped and matters most here:" if trial.lost else "")
    )
    for loss in [loss for loss in trial.lost if loss.torque_share >= _WORTH_A_LINE][:5]:
        unit = trial.arm.joints[loss.torque_joint - 1].effort_unit
        line(
            f"  {loss.part:18} up to {number(loss.torque_peak)} {unit} at joint {loss.torque_joint}, "
            f"{percent(loss.torque_share)} of its peak"
        )


def _say_what_may_be_carried(trial: _Trial) -> None:
    from gd_analyze.cli.terminal import sentence
    from gd_analyze.formatting import number

    effect = trial.effect
    unloaded = trial.evaluation if trial.without_payload is None else trial.without_payload
    within = unloaded.within(trial.model.promise.allowed)
    beyond = [
        str(i) for i, within in enumerate(unloaded.within(trial.model.promise.allowed), start=1) if not within
    ]
    if beyond:
        sentence(f"Beyond the budget here even without any payload: joint {', '.join(beyond)}.")
    elif effect.limiting_joint is not None:
        sentence(
            f"A point mass of up to {number(effect.largest_mass)} kg in the hand keeps every joint within "
            f"the budget here; joint {effect.limiting_joint} leaves it first."
        )
