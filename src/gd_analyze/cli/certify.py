"""`gd-analyze certify`: a bound on a model's torque error that no state exceeds."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

import gd_analyze as gd
from gd_analyze.cli.log_options import log_options, read_motion
from gd_analyze.cli.options import FILE, TRAJECTORY, margin_option
from gd_analyze.cli.output import Output, reporting
from gd_analyze.cli.terminal import line, sentence
from gd_analyze.text import number, rounded_up

if TYPE_CHECKING:
    from gd_analyze.arrays import FloatArray
    from gd_analyze.certification.certificate import Certificate
    from gd_analyze.certification.positive_definite import Definiteness
    from gd_analyze.cli.joint_table import Column
    from gd_analyze.simplification.accuracy import Accuracy


@dataclass(frozen=True, eq=False)
class _Shown:
    """A model, what is proven of it, and the largest exact torque found there, N m (N), shape (n,).

    `extremes` is the bound between the extremes of a trajectory, None without one; `elsewhere` says that this
    is another one than the model was made for; `definiteness` is None where D need not be symmetric.
    """

    model: gd.SimplifiedModel
    certificate: Certificate
    extremes: Certificate | None
    definiteness: Definiteness | None
    largest: FloatArray
    elsewhere: bool


@click.command(short_help="Bound a model's torque error along a motion or over a box.")
@click.argument("model", type=FILE, help="A model.json that `simplify` wrote.")
@click.option(
    "--along",
    type=TRAJECTORY,
    metavar="TRAJECTORY",
    help="Take all states within --margin of a motion: a CSV file, a shipped name, or - for standard input. "
    "Without it, all within the arm's ranges and its rate and acceleration limits.",
)
@log_options
@margin_option("With --along: how far states may be from the motion")
@click.option(
    "--effort",
    type=click.IntRange(min=1),
    default=250_000,
    show_default=True,
    help="Positions per joint at which the error is evaluated, ten times as many for every angle beyond the "
    "fourth that it knows, up to the seventh; along a motion a twentieth as many small boxes, and D at "
    "a thirtieth as many positions. More bring the bounds closer to the truth; any number proves them.",
)
@reporting
def certify(model: Path, along: str | None, margin: str | None, effort: int, output: Output) -> None:
    r"""Bound the torque error of a simplified model along a motion, or over all that the arm can do.

    Along a motion: no state within the margins of it, between its set points too, has a larger error than the
    certified one; beside it stands what is certified of any combination of what lies between the motion's
    extremes. Otherwise: no state within the arm's limits has. The largest error that a search found stands
    beside the bound, and the truth lies between. What is bounded is the error of the program in the file.
    Shares are of the torque at the states that the model was made for. Allowed and sampled errors are
    measured again where those are at hand: drawn ones, a shipped trajectory's, or those of --along. Otherwise
    they are shown as the file states them. Of a model of level energy also the smallest eigenvalue of D is
    bounded. The same input gives the same figures on any machine.

    \b
    Examples:
      gd-analyze certify model.json
      gd-analyze certify model.json --along pick-and-place
      gd-analyze certify model.json --along my.csv --margin 0.5deg,qd=1%
    """
    if margin is not None and along is None:
        raise click.UsageError("--margin goes with --along")
    with output.working() as stage:
        stage("reading")
        from gd_analyze.simplification.model_checks import measured_at

        around = gd.Margin.of(margin)
        loaded = gd.load_model(model)
        motion = None if along is None else read_motion(along, loaded.arm)
        if motion:
            loaded = replace(loaded, accuracy=loaded.accuracy.along(motion.fingerprint))
        if motion and loaded.accuracy.fitted_on.get("trajectory_fingerprint") == motion.fingerprint:
            loaded = measured_at(loaded, gd.states_of(motion))
        stage("certifying", 100 * loaded.arm.n_joints * (1 if motion is None else 2))
        shown = _certified(loaded, motion, around, effort, stage.advance)
    output.give(lambda: _document(shown) | {"effort": effort}, lambda: _show(shown))


def _certified(
    model: gd.SimplifiedModel,
    motion: gd.Trajectory | None,
    margin: gd.Margin,
    effort: int,
    progress: Callable[[int], None],
) -> _Shown:
    from gd_analyze.certification import certificate as bounds
    from gd_analyze.certification import positive_definite
    from gd_analyze.certification.certificate import largest_torque

    harmonics = gd.harmonics_of(model.arm)
    extremes, region = (
        None,
        gd.Box.of(model.arm) if motion is None else gd.Tube.along(model.arm, motion, margin),
    )
    certificate = gd.certify(model, region, effort=effort, harmonics=harmonics, progress=progress)
    if motion is not None:
        between = gd.Box.around(motion.q, motion.qd, motion.qdd)
        extremes = gd.certify(model, between, effort=effort, harmonics=harmonics, progress=progress)
    definiteness = None
    if model.level.is_mechanical:
        of_inertia = max(1, effort * positive_definite.EFFORT // bounds.EFFORT)
        definiteness = gd.certify_positive_definite(model, certificate.box, effort=of_inertia)
    largest = largest_torque(model, region, harmonics=harmonics)
    elsewhere = motion is not None and motion.name != model.accuracy.fitted_on.get("trajectory")
    return _Shown(model, certificate, extremes, definiteness, largest, elsewhere)


def _document(shown: _Shown) -> dict[str, object]:
    from gd_analyze.cli.joint_table import joint_rows
    from gd_analyze.simplification.accuracy import share_of

    model, certificate, definiteness = shown.model, shown.certificate, shown.definiteness
    accuracy, box = model.accuracy, (shown.extremes or certificate).box
    allowed = accuracy.allowed if accuracy.asked.norm is None else None
    states = zip(*(values.tolist() for values in certificate.worst_states), strict=True)
    columns: dict[str, object] = {
        "allowed_error": allowed,
        "largest_error": accuracy.errors.largest,
        "worst_found": certificate.worst_found,
        "worst_state": [dict(zip(("q", "qd", "qdd"), state, strict=True)) for state in states],
        "certified": certificate.certified,
        "largest_torque_found": shown.largest,
        "certified_share_of_largest_found": share_of(certificate.certified, shown.largest),
        "certified_share_of_peak_made_for": share_of(certificate.certified, accuracy.errors.peak_torque),
        "certified_of_allowed": None if allowed is None else share_of(certificate.certified, allowed),
        "within_allowed": None if allowed is None else certificate.within(allowed),
        "ratio": certificate.ratio,
    }
    if shown.extremes is not None:
        columns["certified_between_extremes"] = shown.extremes.certified
    return {
        "arm": model.arm.name,
        "level": model.level.name,
        "budget": accuracy.budget,
        "allowed_and_largest_error": "measured" if accuracy.measured else "stated by the file",
        "from": certificate.region.where,
        "box": {name: getattr(box, name).tolist() for name in ("lower", "upper", "velocity", "acceleration")},
        "joints": joint_rows(model.arm, columns),
        "tube": _tube(certificate),
        "positive_definite": definiteness
        and {
            "proven": definiteness.is_proven,
            "singular": definiteness.is_singular,
            "smallest_eigenvalue_at_least": definiteness.proven,
            "smallest_eigenvalue_found": definiteness.smallest_found,
            "position": definiteness.position.tolist(),
        },
    }


def _tube(certificate: Certificate) -> dict[str, object] | None:
    """The pieces of the motion as JSON; None where there is none."""
    tube, along = certificate.region, certificate.along
    if not isinstance(tube, gd.Tube) or along is None:
        return None
    pieces = zip(tube.begin.tolist(), tube.end.tolist(), along.tolist(), strict=True)
    return {
        "margins": dict(zip(("q", "qd", "qdd"), tube.margins.tolist(), strict=True)),
        "coarse": tube.coarse,
        "note": tube.note,
        "pieces": [dict(zip(("begin", "end", "certified"), piece, strict=True)) for piece in pieces],
    }


def _show(shown: _Shown) -> None:
    from gd_analyze.cli.joint_table import arm_in_words, joint_table, numbers
    from gd_analyze.results.summary import measure_told, worst_error
    from gd_analyze.simplification.accuracy import share_of

    model, certificate = shown.model, shown.certificate
    arm, accuracy = model.arm, model.accuracy
    worst = worst_error(model, certificate.certified)
    told = worst.size
    if not accuracy.measured:
        # What the file states is no measure.
        bound = rounded_up(float(certificate.certified[worst.joint - 1]))
        told = f"{number(bound)} {arm.joints[worst.joint - 1].effort_unit}"
    elif worst.of:
        measure = measure_told(model) if worst.of == "peak torque" else ""
        told += f" of the {measure or worst.of}"
    sentence(
        f"{arm_in_words(arm, model.drives)}: no state within {certificate.where} has a torque error above "
        f"{told} (joint {worst.joint}).",
        bold=True,
    )
    within = certificate.within(accuracy.allowed)
    # Both at once would be wider than a terminal; how far what was found lies below is said in words.
    extremes = [("extremes", _rounded_up(shown.extremes))] if shown.extremes else []
    sampled = "promised" if shown.elsewhere else "sampled"
    beside: list[Column] = [
        ("allowed", accuracy.allowed),
        ("× allowed", numbers(map(rounded_up, share_of(certificate.certified, accuracy.allowed)))),
        ("within", ["proven" if x else "no" for x in within]),
    ]
    joint_table(
        "Torque error, {units}"
        + ("" if accuracy.measured else f"; {sampled} and allowed as the file states"),
        arm,
        [
            (sampled, accuracy.errors.largest),
            *([] if extremes else [("found", certificate.worst_found)]),
            ("certified", _rounded_up(certificate)),
            *extremes,
            *([] if accuracy.asked.norm else beside),
        ],
    )
    line()
    ratio, there = certificate.ratio[certificate.worst_found > 0.0], _there(certificate)
    sentence(
        f"{sampled.capitalize()}: over the states the model was made for{', not here' * shown.elsewhere}. "
        + ("" if extremes else "Found: by a search over the whole box. ")
        + f"Certified: no state {there} exceeds it"
        + (f"; at most {rounded_up(float(ratio.max())):.2f} times what was found. " if ratio.size else ". ")
        + (
            "Extremes: certified of every combination of what lies between the motion's, without margins. "
            if extremes
            else ""
        )
        + _verdict(int(within.sum()), len(within), accuracy, there)
    )
    if certificate.note:
        sentence(certificate.note)
    if not accuracy.measured:
        sentence(_stated(accuracy))
    if shown.definiteness is not None:
        sentence(_definite(shown.definiteness, all(arm.is_revolute), certificate.along is not None))


def _stated(accuracy: Accuracy) -> str:
    from gd_analyze.motions.states import in_words

    where = in_words(accuracy.fitted_on) if accuracy.fitted_on else "states without a name"
    return (
        f"The allowed and the sampled errors are stated by the file, for {where}, which are not at hand"
        + (
            ": --along with that trajectory measures them again."
            if "trajectory" in accuracy.fitted_on
            else "."
        )
    )


def _rounded_up(certificate: Certificate) -> FloatArray:
    import numpy as np

    return np.array([rounded_up(float(bound)) for bound in certificate.certified])


def _there(certificate: Certificate) -> str:
    return "of the box" if certificate.along is None else "within the margins of the motion"


def _verdict(proven: int, joints: int, accuracy: Accuracy, there: str) -> str:
    if accuracy.asked.norm is not None:
        return f"The budget, {accuracy.budget}, is of the states the model was made for; it cannot be proven."
    budget = f"{'' if accuracy.measured else 'stated '}budget of {accuracy.budget}"
    if proven == joints:
        return f"Every joint stays within the {budget} at every state {there}."
    return f"{proven} of {joints} joints are proven to stay within the {budget} at every state {there}."


def _definite(definiteness: Definiteness, all_turning: bool, along: bool) -> str:
    unit, around = " kg m^2" if all_turning else "", " around the motion" if along else ""
    bound, found = (
        f"{value:.4g}{unit}" for value in (-rounded_up(-definiteness.proven, 4), definiteness.smallest_found)
    )
    place = ", ".join(f"{q:.4g}" for q in definiteness.position)
    if definiteness.is_proven:
        everywhere = f"everywhere in the box{around}"
        return f"D is positive definite {everywhere}: no eigenvalue below {bound}, {found} found."
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
