"""`gd-analyze certify`: a bound on a model's torque error that no state of a box exceeds."""

from __future__ import annotations

from decimal import ROUND_CEILING, Decimal
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING

import click

import gd_analyze as gd
from gd_analyze.cli.options import FILE, TRAJECTORY
from gd_analyze.cli.output import Output, reporting
from gd_analyze.cli.terminal import line, sentence

if TYPE_CHECKING:
    from gd_analyze.certification import Certificate, Definiteness

# Shares of peak torque below this are printed as "< 0.01 %".
_LEAST_SHARE = 1e-4


@click.command(short_help="Bound a model's torque error over all states of a box.")
@click.argument("model", type=FILE, help="A model.json that `simplify` wrote.")
@click.option(
    "--along",
    type=TRAJECTORY,
    metavar="TRAJECTORY",
    help="Take the box between the extremes of a trajectory: a CSV file, a shipped name, or - for standard "
    "input. Without it, the arm's ranges and its rate and acceleration limits.",
)
@click.option(
    "--effort",
    type=click.IntRange(min=1),
    default=250_000,
    show_default=True,
    help="Positions per joint at which the error is evaluated. More bring the bound closer to the truth; it "
    "is proven with any number.",
)
@reporting
def certify(model: Path, along: str | None, effort: int, output: Output) -> None:
    r"""Bound the torque error of a simplified model over a whole box of states.

    No state of the box has a larger error than the certified one; the largest error that a search found
    stands beside it, and the truth lies between. Of a model of level energy also the smallest eigenvalue of
    D is bounded. The same input gives the same figures on any machine.

    \b
    Examples:
      gd-analyze certify model.json
      gd-analyze certify model.json --along pick-and-place --effort 1000000
    """
    with output.working() as stage:
        stage("reading")
        loaded = gd.load_model(model)
        if along is None:
            box, where = gd.Box.of(loaded.arm), "the arm's limits"
        else:
            motion = gd.read_trajectory(along, loaded.arm)
            box, where = gd.Box.around(motion.q, motion.qd, motion.qdd), f"the extremes of {motion.name}"
        stage("certifying")
        certificate = gd.certify(loaded, box, effort=effort)
        definiteness = gd.certify_positive_definite(loaded, box) if loaded.level.is_mechanical else None
    output.give(
        lambda: _document(loaded, certificate, definiteness) | {"effort": effort, "from": where},
        lambda: _show(loaded, certificate, definiteness, where),
    )


def _document(
    model: gd.SimplifiedModel, certificate: Certificate, definiteness: Definiteness | None
) -> dict[str, object]:
    from gd_analyze.cli.joint_table import joint_rows

    allowed, box = model.promise.allowed, certificate.box
    states = zip(*(values.tolist() for values in certificate.worst_states), strict=True)
    columns: dict[str, object] = {
        "allowed_error": allowed,
        "largest_error": model.promise.errors.largest,
        "worst_found": certificate.worst_found,
        "worst_state": [dict(zip(("q", "qd", "qdd"), state, strict=True)) for state in states],
        "certified": certificate.certified,
        "within_allowed": certificate.within(allowed),
        "ratio": certificate.ratio,
    }
    return {
        "arm": model.arm.name,
        "level": model.level.name,
        "budget": model.promise.budget,
        "box": {name: getattr(box, name).tolist() for name in ("lower", "upper", "rate", "acceleration")},
        "joints": joint_rows(model.arm, columns),
        "positive_definite": definiteness
        and {
            "proven": definiteness.is_proven,
            "smallest_eigenvalue_at_least": definiteness.proven,
            "smallest_eigenvalue_found": definiteness.smallest_found,
            "position": definiteness.position.tolist(),
        },
    }


def _show(
    model: gd.SimplifiedModel, certificate: Certificate, definiteness: Definiteness | None, where: str
) -> None:
    from gd_analyze.cli.joint_table import arm_in_words, joint_table, numbers, percents
    from gd_analyze.formatting import percent

    # A bound is never shown smaller than it is.
    shown = [_rounded_up(float(bound)) for bound in certificate.certified]
    arm, peak = model.arm, model.promise.errors.peak_torque
    pairs = zip(certificate.certified, peak, strict=True)
    # Any error is beyond all measure at a joint that needs no torque.
    shares = [
        _rounded_up(float(bound / p), 2) if p > 0.0 else (inf if bound > 0.0 else 0.0) for bound, p in pairs
    ]
    worst = max(range(len(shares)), key=shares.__getitem__)
    sentence(
        f"{arm_in_words(arm)}: no state within {where} has a torque error above "
        f"{percent(max(shares[worst], _LEAST_SHARE))} of peak torque (joint {worst + 1}).",
        bold=True,
    )
    within = certificate.within(model.promise.allowed)
    joint_table(
        "Torque error, {units}",
        arm,
        [
            ("sampled", numbers(model.promise.errors.largest)),
            ("found", numbers(certificate.worst_found)),
            ("certified", numbers(shown)),
            ("of peak", percents(shares)),
            ("allowed", numbers(model.promise.allowed)),
            ("within", ["proven" if x else "no" for x in within]),
        ],
    )
    line()
    ratio = certificate.ratio[certificate.worst_found > 0.0]
    sentence(
        "Sampled: over the states the model was made for. Found: by a search over the whole box. Certified: "
        "no state of the box exceeds it"
        + (f"; at most {_rounded_up(float(ratio.max())):.2f} times what was found. " if ratio.size else ". ")
        + _verdict(int(within.sum()), len(within), model.promise.budget)
    )
    if definiteness is not None:
        sentence(_definite(definiteness, all(arm.is_revolute)))


def _verdict(proven: int, joints: int, budget: str) -> str:
    if proven == joints:
        return f"Every joint stays within the budget of {budget} everywhere in the box."
    return (
        f"{proven} of {joints} joints are proven to stay within the budget of {budget} everywhere in the box."
    )


def _definite(definiteness: Definiteness, all_turning: bool) -> str:
    unit = " kg m^2" if all_turning else ""
    bound, found = (
        f"{value:.4g}{unit}" for value in (-_rounded_up(-definiteness.proven, 4), definiteness.smallest_found)
    )
    if definiteness.is_proven:
        return f"D is positive definite everywhere in the box: no eigenvalue below {bound}, {found} found."
    return (
        f"D is not shown to be positive definite: an eigenvalue as low as {bound} cannot be ruled out, the "
        f"smallest found is {found}."
    )


def _rounded_up(value: float, digits: int = 3) -> float:
    """Round to significant digits, never down."""
    if value == 0.0:
        return value
    exact = Decimal(value)
    step = Decimal(1).scaleb(exact.adjusted() - digits + 1)
    return float(exact.quantize(step, rounding=ROUND_CEILING))
