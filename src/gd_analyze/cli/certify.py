"""`gd-analyze certify`: a bound on a model's torque error that no state of a box exceeds."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import click

import gd_analyze as gd
from gd_analyze.cli.options import FILE, TRAJECTORY
from gd_analyze.cli.output import Output, reporting
from gd_analyze.cli.terminal import line, sentence
from gd_analyze.formatting import rounded_up

if TYPE_CHECKING:
    from gd_analyze.certification import Certificate, Definiteness
    from gd_analyze.levels import Promise
    from gd_analyze.vectors import FloatArray


@dataclass(frozen=True, eq=False)
class _Shown:
    """A model, what is proven of it, where, and the largest exact torque found there, N m (N), shape (n,).

    `definiteness` is None where D need not be symmetric.
    """

    model: gd.SimplifiedModel
    certificate: Certificate
    definiteness: Definiteness | None
    where: str
    largest: FloatArray


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
    help="Positions per joint at which the error is evaluated, and D at a thirtieth as many. More bring the "
    "bounds closer to the truth; they are proven with any number.",
)
@reporting
def certify(model: Path, along: str | None, effort: int, output: Output) -> None:
    r"""Bound the torque error of a simplified model over a whole box of states.

    No state of the box has a larger error than the certified one; the largest error that a search found
    stands beside it, and the truth lies between. What is bounded is the error of the program in the file.
    Shares are of the torque at the states that the model was made for. Allowed and sampled errors are
    measured again where those are at hand: drawn ones, a shipped trajectory's, or those of --along. Otherwise
    they are shown as the file states them. Of a model of level energy also the smallest eigenvalue of D is
    bounded. The same input gives the same figures on any machine.

    \b
    Examples:
      gd-analyze certify model.json
      gd-analyze certify model.json --along pick-and-place --effort 1000000
    """
    with output.working() as stage:
        stage("reading")
        from gd_analyze.certification import certificate as bounds
        from gd_analyze.certification import largest_torque, positive_definite
        from gd_analyze.levels.statements import measured_at

        loaded = gd.load_model(model)
        if along is None:
            box, where = gd.Box.of(loaded.arm), "the arm's limits"
        else:
            motion = gd.read_trajectory(along, loaded.arm)
            box, where = gd.Box.around(motion.q, motion.qd, motion.qdd), f"the extremes of {motion.name}"
            if loaded.promise.made_for.get("trajectory_fingerprint") == motion.fingerprint:
                loaded = measured_at(loaded, gd.states_of(motion))
        stage("certifying")
        harmonics = gd.harmonics_of(loaded.arm)
        of_inertia = max(1, effort * positive_definite.EFFORT // bounds.EFFORT)
        shown = _Shown(
            loaded,
            gd.certify(loaded, box, effort=effort, harmonics=harmonics),
            gd.certify_positive_definite(loaded, box, effort=of_inertia)
            if loaded.level.is_mechanical
            else None,
            where,
            largest_torque(loaded, box, harmonics=harmonics),
        )
    output.give(lambda: _document(shown) | {"effort": effort}, lambda: _show(shown))


def _document(shown: _Shown) -> dict[str, object]:
    from gd_analyze.cli.joint_table import joint_rows
    from gd_analyze.levels.promise import share_of

    model, certificate, definiteness = shown.model, shown.certificate, shown.definiteness
    promise, box = model.promise, certificate.box
    states = zip(*(values.tolist() for values in certificate.worst_states), strict=True)
    columns: dict[str, object] = {
        "allowed_error": promise.allowed,
        "largest_error": promise.errors.largest,
        "worst_found": certificate.worst_found,
        "worst_state": [dict(zip(("q", "qd", "qdd"), state, strict=True)) for state in states],
        "certified": certificate.certified,
        "largest_torque_found": shown.largest,
        "certified_share_of_largest_found": share_of(certificate.certified, shown.largest),
        "certified_share_of_peak_made_for": share_of(certificate.certified, promise.errors.peak_torque),
        "certified_of_allowed": share_of(certificate.certified, promise.allowed),
        "within_allowed": certificate.within(promise.allowed),
        "ratio": certificate.ratio,
    }
    return {
        "arm": model.arm.name,
        "level": model.level.name,
        "budget": promise.budget,
        "allowed_and_largest_error": "measured" if promise.measured else "stated by the file",
        "from": shown.where,
        "box": {name: getattr(box, name).tolist() for name in ("lower", "upper", "rate", "acceleration")},
        "joints": joint_rows(model.arm, columns),
        "positive_definite": definiteness
        and {
            "proven": definiteness.is_proven,
            "singular": definiteness.is_singular,
            "smallest_eigenvalue_at_least": definiteness.proven,
            "smallest_eigenvalue_found": definiteness.smallest_found,
            "position": definiteness.position.tolist(),
        },
    }


def _show(shown: _Shown) -> None:
    import numpy as np

    from gd_analyze.cli.joint_table import arm_in_words, joint_table, numbers
    from gd_analyze.levels.promise import share_of
    from gd_analyze.results.summary import measure_told, worst_error

    model, certificate = shown.model, shown.certificate
    arm, promise = model.arm, model.promise
    worst = worst_error(model, certificate.certified)
    of = {"peak torque": measure_told(model)}.get(worst.of, worst.of)
    sentence(
        f"{arm_in_words(arm, model.drives)}: no state within {shown.where} has a torque error above "
        f"{worst.size}{of and f' of the {of}'} (joint {worst.joint}).",
        bold=True,
    )
    within = certificate.within(promise.allowed)
    joint_table(
        "Torque error, {units}" + ("" if promise.measured else "; sampled and allowed as the file states"),
        arm,
        [
            ("sampled", promise.errors.largest),
            ("found", certificate.worst_found),
            ("certified", np.array([rounded_up(float(bound)) for bound in certificate.certified])),
            ("allowed", promise.allowed),
            ("× allowed", numbers(map(rounded_up, share_of(certificate.certified, promise.allowed)))),
            ("within", ["proven" if x else "no" for x in within]),
        ],
    )
    line()
    ratio = certificate.ratio[certificate.worst_found > 0.0]
    sentence(
        "Sampled: over the states the model was made for. Found: by a search over the whole box. Certified: "
        "no state of the box exceeds it"
        + (f"; at most {rounded_up(float(ratio.max())):.2f} times what was found. " if ratio.size else ". ")
        + _verdict(int(within.sum()), len(within), promise)
    )
    if not promise.measured:
        sentence(_stated(promise))
    if shown.definiteness is not None:
        sentence(_definite(shown.definiteness, all(arm.is_revolute)))


def _stated(promise: Promise) -> str:
    from gd_analyze.states import in_words

    where = in_words(promise.made_for) if promise.made_for else "states without a name"
    return (
        f"The allowed and the sampled errors are stated by the file, for {where}, which are not at hand"
        + (": --along with that trajectory measures them again." if "trajectory" in promise.made_for else ".")
    )


def _verdict(proven: int, joints: int, promise: Promise) -> str:
    budget = f"{'' if promise.measured else 'stated '}budget of {promise.budget}"
    if proven == joints:
        return f"Every joint stays within the {budget} everywhere in the box."
    return f"{proven} of {joints} joints are proven to stay within the {budget} everywhere in the box."


def _definite(definiteness: Definiteness, all_turning: bool) -> str:
    unit = " kg m^2" if all_turning else ""
    bound, found = (
        f"{value:.4g}{unit}" for value in (-rounded_up(-definiteness.proven, 4), definiteness.smallest_found)
    )
    place = ", ".join(f"{q:.4g}" for q in definiteness.position)
    if definiteness.is_proven:
        return f"D is positive definite everywhere in the box: no eigenvalue below {bound}, {found} found."
    if definiteness.is_singular:
        return (
            f"D is singular at q = ({place}): an eigenvalue of zero, up to round-off, was found, so some "
            f"motion has no inertia and the model cannot be simulated. No eigenvalue lies below {bound}."
        )
    if definiteness.smallest_found < 0.0:
        return (
            f"D is not positive definite: it has an eigenvalue of {found} at q = ({place}). "
            f"None lies below {bound}."
        )
    return (
        f"D is not shown to be positive definite: an eigenvalue as low as {bound} cannot be ruled out, the "
        f"smallest found is {found}. A larger --effort may show it."
    )
