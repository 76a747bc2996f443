"""`gd-analyze simplify`: the fewest operations that meet a torque error budget."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from gd_analyze.cli.levels import level_option, require_coefficients, simplify_options
from gd_analyze.cli.options import ROBOT, ROBOT_HELP, command_line, reporting
from gd_analyze.cli.payload import load_arm_carrying, payload_option
from gd_analyze.cli.states import described, states_given, states_options, trajectory_argument

if TYPE_CHECKING:
    from gd_analyze.certification import Certificate
    from gd_analyze.levels import SimplifiedModel
    from gd_analyze.operations import OperationCount

# What every terminal shows, and a file or a mail as well.
_WIDTH = 80

# A double has no more.
_MOST_DIGITS = 17


@click.command(short_help="Find a model of few terms within a torque budget.")
@click.argument("robot", type=ROBOT, help=ROBOT_HELP)
@trajectory_argument
@click.option(
    "--budget",
    default="1%",
    show_default=True,
    metavar="LIST",
    help="Allowed torque error: a share of each joint's peak torque (1%) or N m (0.5); one for all joints, "
    "or one per joint, comma-separated.",
)
@level_option("term", "term")
@simplify_options
@click.option(
    "--certified",
    is_flag=True,
    help="Make the budget hold, proven, for every state within the arm's limits (between the extremes of the "
    "trajectory, where one is given), not only for the states the model is made for.",
)
@click.option("--drives", is_flag=True, help="Include drive inertia.")
@payload_option
@states_options
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
    operations: int | None,
    certified: bool,
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

    The error is that at the states the model is made for; elsewhere it may be larger, unless --certified.
    Rates and torques are in absolute rates, see docs/simplification.md.

    \b
    Examples:
      gd-analyze simplify puma560 --drives
      gd-analyze simplify puma560 pick-and-place --level energy --budget 0.5%
      gd-analyze simplify puma560 --drives --operations 80
      gd-analyze simplify puma560 --drives --certified -o model.json
      gd-analyze simplify my_arm.toml --refit --level energy -o model.json
    """
    from gd_analyze.cli.terminal import line, print_json, stages, warnings_told

    require_coefficients(level, refit)
    if certified and (level == "element" or refit or operations is not None):
        raise click.UsageError(
            "--certified goes with --level term or energy, and without --refit and --operations"
        )
    with warnings_told(quiet) as told, stages(quiet) as stage:
        import time

        from gd_analyze.levels import Budget, ExactDynamics, level_named, save_model
        from gd_analyze.provenance import provenance
        from gd_analyze.search import How, simplify_exact

        allowed = Budget.parse(budget)
        arm = load_arm_carrying(robot, payload)
        start = time.perf_counter()
        exact = ExactDynamics.of(arm, states_given(arm, trajectory, states, seed), drives)
        source = provenance(command_line())
        certificate = None
        model: SimplifiedModel
        if certified:
            from gd_analyze.certification import Box, simplify_certified

            stage("searching and certifying")
            model, certificate = simplify_certified(
                exact,
                allowed,
                Box.of(arm) if trajectory is None else Box.around(*exact.states.arrays),
                level=level_named(level),
                provenance=source,
                progress=stage.advance,
            )
        else:
            stage("searching")
            model = simplify_exact(
                exact,
                allowed,
                How(level_named(level), refit, operations),
                provenance=source,
                progress=stage.advance,
            )
        seconds = time.perf_counter() - start
        if out is not None:
            stage(f"writing {out.name}")
            save_model(model, out)
    if as_json:
        print_json(_document(model, certificate, seconds, digits, told, out))
    elif not quiet:
        _show(model, certificate, seconds, digits)
        if out is not None:
            line(f"wrote {out}")


def _document(
    model: SimplifiedModel,
    certificate: Certificate | None,
    seconds: float,
    digits: int,
    told: list[str],
    out: Path | None,
) -> dict[str, Any]:

    promise = model.promise.errors
    document: dict[str, Any] = {
        "arm": model.arm.name,
        "level": model.level.name,
        "refitted": model.refitted,
        "drives": model.drives,
        "budget": model.promise.budget,
        "made_for": dict(model.promise.made_for),
        "operations": _counts(model.operations),
        "operations_full": _counts(model.operations_full),
        "search": model.promise.search,
        "joints": [
            {
                "joint": i + 1,
                "name": joint.name,
                "unit": joint.effort_unit,
                "peak_torque": float(promise.peak_torque[i]),
                "allowed_error": float(model.promise.allowed[i]),
                "largest_error": float(promise.largest[i]),
                "largest_share": float(promise.largest_share[i]),
                "rms_error": float(promise.rms[i]),
                "rms_share": float(promise.rms_share[i]),
                "certified_error": None if certificate is None else float(certificate.certified[i]),
            }
            for i, joint in enumerate(model.arm.joints)
        ],
    }
    if not model.level.has_torque_terms:
        document |= {"kept": _labels(model), "dropped": _labels(model, dropped=True)}
    if model.level.has_torque_terms:
        from gd_analyze.harmonics import Basis
        from gd_analyze.harmonics.torque_rendering import torque_legend

        basis = Basis.of(model.arm)
        document |= {
            "terms": _terms(model)[0],
            "equations": list(model_equations(model, digits)),
            "legend": list(torque_legend(basis, model.torques)),
        }
    return document | {
        "seconds": seconds,
        "warnings": told,
        "files": [str(out)] if out is not None else [],
    }


def model_equations(model: SimplifiedModel, digits: int = 3, width: int | None = None) -> tuple[str, ...]:
    """A harmonic model as equations, one per joint; nothing for a model of parts."""
    from gd_analyze.harmonics import Basis
    from gd_analyze.harmonics.torque_rendering import torques_to_text

    if not model.level.has_torque_terms:
        return ()
    return torques_to_text(Basis.of(model.arm), model.torques, digits, width)


def _counts(operations: OperationCount) -> dict[str, int]:
    from dataclasses import asdict

    return {**asdict(operations), "total": operations.total}


def _terms(model: SimplifiedModel) -> tuple[int, str]:
    """How many of what the model keeps."""
    return len(model.terms), model.level.keeps


def _labels(model: SimplifiedModel, dropped: bool = False) -> list[str]:
    from gd_analyze.levels import parts_of

    return [p.label for p in parts_of(model.arm.n_joints) if (p in model.terms) != dropped]


def _show(model: SimplifiedModel, certificate: Certificate | None, seconds: float, digits: int) -> None:
    from gd_analyze.cli.joint_table import error_table
    from gd_analyze.cli.terminal import line, sentence
    from gd_analyze.formatting import number, percent

    promise, arm = model.promise.errors, model.arm
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
    count, kind = _terms(model)
    refitted = ", refitted" if model.refitted else ""
    where = described(model.promise.made_for)
    sentence(f"{count} {kind}{refitted}, budget {model.promise.budget}, for {where}; in {seconds:.2g} s")
    sentence(f"Operations after each step of the search: {model.promise.search}.")
    error_table(
        "Torque error, {units}, and its share of peak torque", arm, promise, model.promise.allowed
    )
    line()
    if certificate is not None:
        where = "the arm's limits" if "box" in model.promise.made_for else "the extremes of the trajectory"
        bounds = ", ".join(f"{number(float(bound))}" for bound in certificate.certified)
        sentence(f"Certified: no state within {where} has an error above {bounds} at the joints.")
        line()
    if not model.level.has_torque_terms:
        sentence("Kept", bold=True)
        sentence(", ".join(_labels(model)) or "nothing")
        sentence("Dropped", bold=True)
        sentence(", ".join(_labels(model, dropped=True)) or "nothing")
    if model.level.has_torque_terms:
        from gd_analyze.harmonics import Basis
        from gd_analyze.harmonics.torque_rendering import torque_legend

        basis = Basis.of(arm)
        sentence("The model, in kg, m, s, rad", bold=True)
        for text in model_equations(model, digits, _WIDTH):
            line(text)
        meanings = torque_legend(basis, model.torques)
        if meanings:
            line()
            sentence("; ".join(meanings) + ".")
