"""`gd-analyze certify`: a bound on a model's torque error that no state of a box exceeds."""

from __future__ import annotations

from decimal import ROUND_CEILING, Decimal
from pathlib import Path
from typing import TYPE_CHECKING

import click

from gd_analyze.cli.options import TRAJECTORY, reporting
from gd_analyze.errors import UsageError

if TYPE_CHECKING:
    from gd_analyze.certification.certificate import Certificate
    from gd_analyze.certification.positive_definite import Definiteness
    from gd_analyze.levels import SimplifiedModel

# Shares of peak torque below this are printed as "< 0.01 %".
_LEAST_SHARE = 1e-4


@click.command(short_help="Bound a model's torque error over all states of a box.")
@click.argument("model", type=click.Path(path_type=Path), help="A model.json that `simplify` wrote.")
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
def certify(model: Path, along: str | None, effort: int, as_json: bool, quiet: bool, debug: bool) -> None:
    r"""Bound the torque error of a simplified model over a whole box of states.

    No state of the box has a larger error than the certified one; the largest error that a search found
    stands beside it, and the truth lies between. Of a model of level energy also the smallest eigenvalue of
    D is bounded. The same input gives the same figures on any machine.

    \b
    Examples:
      gd-analyze certify model.json
      gd-analyze certify model.json --along pick-and-place --effort 1000000
    """
    from gd_analyze.cli.terminal import print_json, stages, warnings_told

    with warnings_told(quiet), stages(quiet) as stage:
        stage("reading")
        from gd_analyze.certification.box import Box
        from gd_analyze.certification.certificate import certify as run
        from gd_analyze.certification.positive_definite import certify_positive_definite
        from gd_analyze.levels import load_model
        from gd_analyze.trajectories import read_trajectory

        loaded = load_model(model)
        if not loaded.level.has_torque_terms:
            raise UsageError(
                "an element-level model has no harmonic terms to bound",
                where=str(model),
                expected="a model of level term or energy",
                found=f"level {loaded.level}",
                next_step="make one with `gd-analyze simplify`",
            )
        if along is None:
            box, where = Box.of(loaded.arm), "the arm's limits"
        else:
            motion = read_trajectory(along, loaded.arm)
            box, where = Box.around(motion.q, motion.qd, motion.qdd), f"the extremes of {motion.name}"
        stage("certifying")
        certificate = run(loaded, box, effort=effort)
        definiteness = certify_positive_definite(loaded, box) if loaded.level.is_mechanical else None
    if as_json:
        print_json(_document(loaded, certificate, definiteness, where, effort))
    elif not quiet:
        _show(loaded, certificate, definiteness, where)


def _document(
    model: SimplifiedModel,
    certificate: Certificate,
    definiteness: Definiteness | None,
    where: str,
    effort: int,
) -> dict[str, object]:
    within = certificate.within(model.promise.allowed)
    return {
        "arm": model.arm.name,
        "level": model.level.name,
        "budget": model.promise.budget,
        "effort": effort,
        "box": {
            "from": where,
            "lower": certificate.box.lower.tolist(),
            "upper": certificate.box.upper.tolist(),
            "rate": certificate.box.rate.tolist(),
            "acceleration": certificate.box.acceleration.tolist(),
        },
        "joints": [
            {
                "joint": i + 1,
                "name": joint.name,
                "unit": joint.effort_unit,
                "allowed": float(model.promise.allowed[i]),
                "sampled": float(model.promise.errors.largest[i]),
                "worst_found": float(certificate.worst_found[i]),
                "worst_state": {
                    name: values[i].tolist()
                    for name, values in zip(("q", "qd", "qdd"), certificate.worst_states, strict=True)
                },
                "certified": float(certificate.certified[i]),
                "within_allowed": bool(within[i]),
                "ratio": float(certificate.ratio[i]),
            }
            for i, joint in enumerate(model.arm.joints)
        ],
        "positive_definite": definiteness
        and {
            "proven": definiteness.is_proven,
            "smallest_eigenvalue_at_least": definiteness.proven,
            "smallest_eigenvalue_found": definiteness.smallest_found,
            "position": definiteness.position.tolist(),
        },
    }


def _show(
    model: SimplifiedModel, certificate: Certificate, definiteness: Definiteness | None, where: str
) -> None:
    from gd_analyze.cli.joint_table import joint_table
    from gd_analyze.cli.terminal import line, sentence
    from gd_analyze.formatting import number, percent

    # A bound is never shown smaller than it is.
    shown = [_rounded_up(float(bound)) for bound in certificate.certified]
    arm, peak = model.arm, model.promise.errors.peak_torque
    pairs = zip(certificate.certified, peak, strict=True)
    shares = [_rounded_up(float(bound / p), 2) if p > 0.0 else 0.0 for bound, p in pairs]
    worst = max(range(len(shares)), key=shares.__getitem__)
    sentence(
        f"{arm.title or arm.name}: no state within {where} has a torque error above "
        f"{percent(max(shares[worst], _LEAST_SHARE))} of peak torque (joint {worst + 1}).",
        bold=True,
    )
    within = certificate.within(model.promise.allowed)
    joint_table(
        "Torque error, {units}",
        arm,
        [
            ("sampled", "right", [number(float(x)) for x in model.promise.errors.largest]),
            ("found", "right", [number(float(x)) for x in certificate.worst_found]),
            ("certified", "right", [number(x) for x in shown]),
            ("of peak", "right", [percent(x) for x in shares]),
            ("allowed", "right", [number(float(x)) for x in model.promise.allowed]),
            ("within", "left", ["proven" if x else "no" for x in within]),
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
        sentence(_definite(definiteness, {joint.effort_unit for joint in arm.joints}))


def _verdict(proven: int, joints: int, budget: str) -> str:
    if proven == joints:
        return f"Every joint stays within the budget of {budget} everywhere in the box."
    return (
        f"{proven} of {joints} joints are proven to stay within the budget of {budget} everywhere in the box."
    )


def _definite(definiteness: Definiteness, units: set[str]) -> str:
    unit = " kg m^2" if units == {"N m"} else ""
    bound, found = (
        f"{-_rounded_up(-definiteness.proven, 4):.4g}{unit}",
        f"{definiteness.smallest_found:.4g}{unit}",
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
