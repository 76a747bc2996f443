"""`gd-analyze evaluate`: a simplified model on another trajectory."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from gd_analyze.cli.options import TRAJECTORY, reporting

if TYPE_CHECKING:
    from gd_analyze.models import Evaluation, SimplifiedModel
    from gd_analyze.simplification import Loss
    from gd_analyze.trajectories import Trajectory


@click.command()
@click.argument("model", type=click.Path(path_type=Path))
@click.argument("trajectory", type=TRAJECTORY)
@click.option(
    "-o", "--out", type=click.Path(path_type=Path), help="CSV file for exact and simplified torque over time."
)
@reporting
def evaluate(
    model: Path, trajectory: str, out: Path | None, as_json: bool, quiet: bool, debug: bool
) -> None:
    """Evaluate a simplified model (model.json) on another trajectory and report its torque error there.

    What may be dropped depends on the trajectory: the error promised for one says nothing of another.

    \b
    Example:
      gd-analyze evaluate reports/puma560-pick-and-place/model.json large-slew
    """
    from gd_analyze.cli.terminal import print_json, warnings_told
    from gd_analyze.decomposition import decompose
    from gd_analyze.files import write_text
    from gd_analyze.models import evaluate as run
    from gd_analyze.models import load_model, torque_csv
    from gd_analyze.simplification import losses
    from gd_analyze.trajectories import read_trajectory

    with warnings_told(quiet):
        loaded = load_model(model)
        motion = read_trajectory(trajectory, loaded.arm)
    dataset = decompose(loaded.arm, motion, coupling=False, drives=loaded.drives)
    evaluation = run(loaded, motion, dataset)
    lost = losses(loaded, dataset)
    if out is not None:
        write_text(out, torque_csv(motion, evaluation))
    if as_json:
        print_json(_document(loaded, motion, evaluation, lost))
    elif not quiet:
        _show(loaded, motion, evaluation, lost)
        if out is not None:
            click.echo(f"wrote {out}")


def _document(
    model: SimplifiedModel, motion: Trajectory, evaluation: Evaluation, lost: tuple[Loss, ...]
) -> dict[str, Any]:
    from dataclasses import asdict

    return {
        "arm": model.arm.name,
        "made_for": dict(model.made_for),
        "trajectory": motion.name,
        "joints": [
            {
                "joint": i + 1,
                "name": joint.name,
                "unit": joint.effort_unit,
                "peak_torque": float(evaluation.table.peak_torque[i]),
                "largest_error": float(evaluation.table.largest[i]),
                "rms_error": float(evaluation.table.rms[i]),
                "promised_largest_error": float(model.promise.largest[i]),
            }
            for i, joint in enumerate(model.arm.joints)
        ],
        "largest_losses": [asdict(loss) for loss in lost],
    }


def _show(
    model: SimplifiedModel, motion: Trajectory, evaluation: Evaluation, lost: tuple[Loss, ...]
) -> None:
    from gd_analyze.cli.terminal import console, table
    from gd_analyze.report.context import number, percent

    screen = console()
    here, promised = evaluation.table, model.promise
    rows = [
        [
            f"{i + 1} {joint.name}",
            number(float(here.peak_torque[i])),
            number(float(here.largest[i])),
            percent(float(here.largest_share[i])),
            number(float(here.rms[i])),
            percent(float(promised.largest_share[i])),
            joint.effort_unit,
        ]
        for i, joint in enumerate(model.arm.joints)
    ]
    screen.print(
        f"[bold]{model.arm.title or model.arm.name}[/bold], made for {model.made_for['trajectory']} "
        f"({model.budget_stated}), evaluated on {motion.name}, {motion.n_set_points} set points"
    )
    headings = [("joint", "left"), ("peak", "right"), ("largest", "right"), ("of peak", "right")]
    headings += [("RMS", "right"), ("was promised", "right"), ("unit", "left")]
    screen.print(table(f"Torque error on {motion.name}", headings, rows))
    worst = int(here.largest_share.argmax())
    made_for = model.made_for["trajectory"]
    if (here.largest_share <= promised.largest_share.max()).all():
        screen.print(f"The model errs no more here than on {made_for}.")
        return
    screen.print(
        f"Joint {worst + 1} errs by {percent(float(here.largest_share[worst]))} of its peak here, "
        f"{percent(float(promised.largest_share[worst]))} on {made_for}. What was dropped and matters most here:"
    )
    for loss in lost[:5]:
        screen.print(
            f"  {loss.part:18} up to {number(loss.torque_peak)} at joint {loss.torque_joint}, "
            f"{percent(loss.torque_share)} of its peak"
        )
