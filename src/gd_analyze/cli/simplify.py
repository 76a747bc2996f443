"""`gd-analyze simplify`: the fewest harmonic terms that meet a torque error budget."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from gd_analyze.cli.options import ROBOT, ROBOT_HELP, TRAJECTORY, TRAJECTORY_HELP, command_line, reporting
from gd_analyze.cli.payload import load_arm_carrying, payload_option

if TYPE_CHECKING:
    from gd_analyze.models import HarmonicModel
    from gd_analyze.operations import OperationCount

# What every terminal shows, and a file or a mail as well.
_WIDTH = 80

# A double has no more.
_MOST_DIGITS = 17


@click.command(short_help="Find a model of few terms within a torque budget.")
@click.argument("robot", type=ROBOT, help=ROBOT_HELP)
@click.argument(
    "trajectory",
    type=TRAJECTORY,
    required=False,
    help=f"{TRAJECTORY_HELP} Without one: states drawn from the arm's limits.",
)
@click.option(
    "--budget",
    default="1%",
    show_default=True,
    metavar="LIST",
    help="Allowed torque error: a share of each joint's peak torque (1%) or N m (0.5); one for all joints, "
    "or one per joint, comma-separated.",
)
@click.option(
    "--level",
    type=click.Choice(["term", "energy"]),
    default="term",
    show_default=True,
    help="term: the fewest operations; energy: the model remains a mechanical system, with symmetric D and "
    "its own energy.",
)
@click.option(
    "--refit",
    is_flag=True,
    help="Refit what is kept, to absorb what is dropped; at level energy.",
)
@click.option("--drives", is_flag=True, help="Include drive inertia.")
@payload_option
@click.option(
    "--states",
    type=click.IntRange(1, 1_000_000),
    default=4000,
    show_default=True,
    metavar="NUMBER",
    help="States to draw where there is no trajectory.",
)
@click.option(
    "--seed",
    type=click.IntRange(min=0),
    default=0,
    show_default=True,
    metavar="NUMBER",
    help="Seed of these states: the same seed draws the same.",
)
@click.option(
    "--digits",
    type=click.IntRange(1, _MOST_DIGITS),
    default=3,
    show_default=True,
    help="Significant digits of the equations printed; files keep all.",
)
@click.option("-o", "--out", type=click.Path(path_type=Path), help="Write the model into this JSON file.")
@reporting
def simplify(
    robot: str,
    trajectory: str | None,
    budget: str,
    level: str,
    refit: bool,
    drives: bool,
    payload: str | None,
    states: int,
    seed: int,
    digits: int,
    out: Path | None,
    as_json: bool,
    quiet: bool,
    debug: bool,
) -> None:
    r"""Simplify an arm's equations of motion to few terms within a torque budget.

    The error is that at the states the model is made for; elsewhere it may be larger. Rates and torques are
    in absolute rates, see docs/simplification.md.

    \b
    Examples:
      gd-analyze simplify puma560 --drives
      gd-analyze simplify puma560 pick-and-place --level energy --budget 0.5%
      gd-analyze simplify my_arm.toml --refit --level energy -o model.json
    """
    from gd_analyze.cli.terminal import line, print_json, stages, warnings_told

    if refit and level != "energy":
        raise click.UsageError("--refit goes with --level energy: at level term coefficients stay exact")
    with warnings_told(quiet) as told, stages(quiet) as stage:
        import time

        from gd_analyze.harmonics import identify
        from gd_analyze.models import save_model
        from gd_analyze.provenance import provenance
        from gd_analyze.simplification import Budget
        from gd_analyze.simplification.harmonic_level import simplify_harmonics
        from gd_analyze.simplification.states import states_in_box, states_of
        from gd_analyze.trajectories import read_trajectory

        allowed = Budget.parse(budget)
        arm = load_arm_carrying(robot, payload)
        if trajectory is None:
            given = states_in_box(arm, states, seed)
        else:
            given = states_of(read_trajectory(trajectory, arm))
        start = time.perf_counter()
        stage("identifying")
        harmonics = identify(arm)
        stage("dropping terms")
        model = simplify_harmonics(
            arm,
            given,
            allowed,
            level="energy" if level == "energy" else "term",
            refit=refit,
            drives=drives,
            provenance=provenance(command_line()),
            harmonics=harmonics,
            progress=stage.advance,
        )
        seconds = time.perf_counter() - start
        if out is not None:
            stage(f"writing {out.name}")
            save_model(model, out)
    if as_json:
        print_json(_document(model, seconds, digits, told, out))
    elif not quiet:
        _show(model, seconds, digits)
        if out is not None:
            line(f"wrote {out}")


def _document(
    model: HarmonicModel, seconds: float, digits: int, told: list[str], out: Path | None
) -> dict[str, Any]:
    from gd_analyze.harmonics import Basis
    from gd_analyze.harmonics.torque_rendering import torque_legend, torques_to_text

    basis, promise = Basis.of(model.arm), model.promise
    return {
        "arm": model.arm.name,
        "level": model.level,
        "refitted": model.refitted,
        "drives": model.drives,
        "budget": model.budget_stated,
        "made_for": dict(model.made_for),
        "operations": _counts(model.operations),
        "operations_full": _counts(model.operations_full),
        "joints": [
            {
                "joint": i + 1,
                "name": joint.name,
                "unit": joint.effort_unit,
                "peak_torque": float(promise.peak_torque[i]),
                "allowed_error": float(model.budget[i]),
                "largest_error": float(promise.largest[i]),
                "largest_share": float(promise.largest_share[i]),
                "rms_error": float(promise.rms[i]),
                "rms_share": float(promise.rms_share[i]),
            }
            for i, joint in enumerate(model.arm.joints)
        ],
        "terms": len(model.energy) if model.level == "energy" else len(model.torques),
        "equations": list(torques_to_text(basis, model.torques, digits)),
        "legend": list(torque_legend(basis, model.torques)),
        "seconds": seconds,
        "warnings": told,
        "files": [str(out)] if out is not None else [],
    }


def _counts(operations: OperationCount) -> dict[str, int]:
    from dataclasses import asdict

    return {**asdict(operations), "total": operations.total}


def _show(model: HarmonicModel, seconds: float, digits: int) -> None:
    from gd_analyze.cli.terminal import line, sentence, table
    from gd_analyze.harmonics import Basis
    from gd_analyze.harmonics.torque_rendering import torque_legend, torques_to_text
    from gd_analyze.report.context import number, percent

    promise, arm = model.promise, model.arm
    full, left = model.operations_full, model.operations
    worst = int(promise.largest_share.argmax())
    drives = ", with drives" if model.drives else ""
    sentence(
        f"{arm.title or arm.name}{drives}: {left.total} instead of {full.total} operations, largest error "
        f"{percent(float(promise.largest_share[worst]))} of peak torque (joint {worst + 1})",
        bold=True,
    )
    line(f"operations  {full}")
    line(f"         -> {left}")
    kind = "energy terms" if model.level == "energy" else "torque terms"
    count = len(model.energy) if model.level == "energy" else len(model.torques)
    refitted = ", refitted" if model.refitted else ""
    sentence(
        f"{count} {kind}{refitted}, budget {model.budget_stated}, for {_made_for(model)}; in {seconds:.2g} s"
    )
    units = {joint.effort_unit for joint in arm.joints}
    headings = [("joint", "left"), ("peak torque", "right"), ("allowed", "right"), ("largest", "right")]
    headings += [("share", "right"), ("RMS", "right"), ("share", "right")]
    headings += [("unit", "left")] if len(units) > 1 else []
    rows = [
        [
            f"{i + 1} {joint.name}" if joint.name != str(i + 1) else joint.name,
            number(float(promise.peak_torque[i])),
            number(float(model.budget[i])),
            number(float(promise.largest[i])),
            percent(float(promise.largest_share[i])),
            number(float(promise.rms[i])),
            percent(float(promise.rms_share[i])),
            *([joint.effort_unit] if len(units) > 1 else []),
        ]
        for i, joint in enumerate(arm.joints)
    ]
    table(
        f"Torque error, {' or '.join(sorted(units, reverse=True))}, and its share of peak torque",
        headings,
        rows,
    )
    basis = Basis.of(arm)
    line()
    sentence("The model, in kg, m, s, rad", bold=True)
    for text in torques_to_text(basis, model.torques, digits, _WIDTH):
        line(text)
    meanings = torque_legend(basis, model.torques)
    if meanings:
        line()
        sentence("; ".join(meanings) + ".")


def _made_for(model: HarmonicModel) -> str:
    made_for = model.made_for
    if "trajectory" in made_for:
        return f"{made_for['set_points']} set points of {made_for['trajectory']}"
    return f"{made_for['states']} states drawn from {made_for['box']}, seed {made_for['seed']}"
