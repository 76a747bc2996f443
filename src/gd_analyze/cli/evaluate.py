"""`gd-analyze evaluate`: a simplified model on another trajectory."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from gd_analyze.cli.options import TRAJECTORY, TRAJECTORY_HELP, reporting

if TYPE_CHECKING:
    from gd_analyze.models import Evaluation
    from gd_analyze.models.model_schema import AnyModel
    from gd_analyze.simplification import Loss
    from gd_analyze.trajectories import Trajectory

# Shares of peak torque below this are printed as "< 0.01 %".
_WORTH_A_LINE = 1e-4


@click.command(short_help="Try a simplified model on another trajectory.")
@click.argument("model", type=click.Path(path_type=Path), help="A model.json that gd-analyze wrote.")
@click.argument("trajectory", type=TRAJECTORY, help=TRAJECTORY_HELP)
@click.option(
    "-o", "--out", type=click.Path(path_type=Path), help="CSV file for exact and simplified torque over time."
)
@reporting
def evaluate(model: Path, trajectory: str, out: Path | None, as_json: bool, quiet: bool, debug: bool) -> None:
    r"""Evaluate a simplified model on another trajectory and report its torque error there.

    What may be dropped depends on the trajectory: the error stated for one says nothing of another.

    \b
    Example:
      gd-analyze evaluate reports/puma560-pick-and-place/model.json large-slew
    """
    from gd_analyze.cli.terminal import line, print_json, stages, warnings_told

    with warnings_told(quiet) as told, stages(quiet) as stage:
        stage("reading")
        from gd_analyze.decomposition import decompose
        from gd_analyze.files import write_text
        from gd_analyze.models import SimplifiedModel, load_model, torque_csv
        from gd_analyze.models import evaluate as run
        from gd_analyze.simplification import losses
        from gd_analyze.trajectories import read_trajectory

        loaded = load_model(model)
        motion = read_trajectory(trajectory, loaded.arm)
        stage("decomposing", motion.n_set_points)
        dataset = decompose(loaded.arm, motion, coupling=False, drives=loaded.drives, progress=stage.advance)
        stage("evaluating")
        evaluation = run(loaded, motion, dataset)
        # At the other levels what is dropped is no part that the decomposition knows.
        lost = losses(loaded, dataset) if isinstance(loaded, SimplifiedModel) else ()
        if out is not None:
            stage(f"writing {out.name}")
            write_text(out, torque_csv(motion, evaluation))
    if as_json:
        print_json(_document(loaded, motion, evaluation, lost, told, out))
    elif not quiet:
        _show(loaded, motion, evaluation, lost)
        if out is not None:
            line(f"wrote {out}")


def _document(
    model: AnyModel,
    motion: Trajectory,
    evaluation: Evaluation,
    lost: tuple[Loss, ...],
    told: list[str],
    out: Path | None,
) -> dict[str, Any]:
    from dataclasses import asdict

    here, promised = evaluation.table, model.promise
    return {
        "arm": model.arm.name,
        "level": model.level,
        "made_for": dict(model.made_for),
        "budget": model.budget_stated,
        "trajectory": motion.name,
        "set_points": motion.n_set_points,
        "joints": [
            {
                "joint": i + 1,
                "name": joint.name,
                "unit": joint.effort_unit,
                "peak_torque": float(here.peak_torque[i]),
                "largest_error": float(here.largest[i]),
                "largest_share": float(here.largest_share[i]),
                "rms_error": float(here.rms[i]),
                "rms_share": float(here.rms_share[i]),
                "promised_largest_error": float(promised.largest[i]),
                "promised_largest_share": float(promised.largest_share[i]),
            }
            for i, joint in enumerate(model.arm.joints)
        ],
        "largest_losses": [asdict(loss) for loss in lost],
        "warnings": told,
        "files": [str(out)] if out is not None else [],
    }


def _show(model: AnyModel, motion: Trajectory, evaluation: Evaluation, lost: tuple[Loss, ...]) -> None:
    from gd_analyze.cli.terminal import line, sentence, table
    from gd_analyze.report.context import number, percent

    here, promised = evaluation.table, model.promise
    on_trajectory = "trajectory" in model.made_for
    made_for = str(model.made_for["trajectory"]) if on_trajectory else "the arm's box"
    there = f"on {made_for}" if on_trajectory else f"over {made_for}"
    sentence(
        f"{model.arm.title or model.arm.name} along {motion.name}, {motion.n_set_points} set points",
        bold=True,
    )
    sentence(f"by a model made for {made_for} with a budget of {model.budget_stated}.")
    units = {joint.effort_unit for joint in model.arm.joints}
    headings = [("joint", "left"), ("peak torque", "right"), ("largest", "right"), ("share", "right")]
    headings += [
        ("RMS", "right"),
        ("share", "right"),
        ("promised" if not on_trajectory else f"on {made_for}", "right"),
    ]
    headings += [("unit", "left")] if len(units) > 1 else []
    rows = [
        [
            f"{i + 1} {joint.name}" if joint.name != str(i + 1) else joint.name,
            number(float(here.peak_torque[i])),
            number(float(here.largest[i])),
            percent(float(here.largest_share[i])),
            number(float(here.rms[i])),
            percent(float(here.rms_share[i])),
            percent(float(promised.largest_share[i])),
            *([joint.effort_unit] if len(units) > 1 else []),
        ]
        for i, joint in enumerate(model.arm.joints)
    ]
    table(
        f"Torque error, {' or '.join(sorted(units, reverse=True))}, and its share of peak torque",
        headings,
        rows,
    )
    line()
    worst = int(here.largest_share.argmax())
    if (here.largest_share <= promised.largest_share.max()).all():
        sentence(f"The model errs no more here than {there}.")
        return
    sentence(
        f"Joint {worst + 1} errs by {percent(float(here.largest_share[worst]))} of its peak torque here, "
        f"by {percent(float(promised.largest_share[worst]))} {there}."
        + (" What was dropped and matters most here:" if lost else "")
    )
    for loss in [loss for loss in lost if loss.torque_share >= _WORTH_A_LINE][:5]:
        unit = model.arm.joints[loss.torque_joint - 1].effort_unit
        line(
            f"  {loss.part:18} up to {number(loss.torque_peak)} {unit} at joint {loss.torque_joint}, "
            f"{percent(loss.torque_share)} of its peak"
        )
