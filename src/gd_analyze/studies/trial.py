"""A simplified model at other states than it was fitted on: errors, payload effect, and losses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from gd_analyze.motions.states import States, in_words, states_of
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.result import Column, Fact, Result, Table, columns_of, joint_columns
from gd_analyze.results.model_facts import drives_text, norm_facts, norms_text
from gd_analyze.robots.parts import Link
from gd_analyze.robots.payload import carrying
from gd_analyze.simplification.accuracy import Accuracy, share_of
from gd_analyze.simplification.evaluation import (
    Evaluation,
    Loss,
    PayloadEffect,
    evaluate,
    losses,
    payload_effect,
)
from gd_analyze.simplification.model import SimplifiedModel

# Smallest loss shown to people, as a share of peak torque.
_WORTH_A_LINE = 1e-4


def tried(
    model: SimplifiedModel, given: Trajectory | States, body: Link | None = None
) -> tuple[Evaluation, Result]:
    """Evaluate a model along a motion or at states, with a payload on its arm if there is one.

    The result compares each joint's error with the model's promise. Along a motion without a payload it also
    lists the largest losses, if dropped parts cause the error.
    """
    along, fitted_on, arm = isinstance(given, Trajectory), model.accuracy.fitted_on, model.arm
    if isinstance(given, Trajectory):
        model = replace(model, accuracy=model.accuracy.along(given.fingerprint))
        given = states_of(given)
    found = evaluate(model, given, arm if body is None else carrying(arm, body))
    lost = losses(model, found.dynamics) if along and body is None else ()
    bare = None if body is None else evaluate(model, given)
    effect, accuracy, exact = payload_effect(model, given), model.accuracy, found.dynamics
    where = exact.states.described
    carried = body and {"mass": body.mass, "position": body.com, "inertia": body.inertia_com}
    within = (bare or found).within(accuracy.allowed).all()
    fitted = in_words(fitted_on) if fitted_on else "states not named"
    promised = "measured" if accuracy.measured else "stated by the file"
    return found, Result(
        title=f"{exact.arm.title or exact.arm.name}: torque error of a model of {arm.name}",
        subtitle=", ".join(filter(None, [f"over {exact.states.in_words}", drives_text(arm, model.drives)])),
        facts=(
            Fact("arm", "", arm.name),
            Fact("level", "Level", model.level.name),
            Fact("fitted_on", "Model fitted on", dict(fitted_on), text=fitted),
            Fact("budget", "Budget", accuracy.budget),
            Fact("promised", "", promised),
            Fact("held_against", "", {"arm": exact.arm.name, "drives": model.drives, "payload": carried}),
            *(Fact(key, "", where.get(key)) for key in ("trajectory", "set_points", "box", "states", "seed")),
            *norm_facts(found.norms, exact.arm),
            Fact("", "Norm without the payload" * bool(bare), norms_text(bare.norms if bare else ())),
            Fact("promised_norms", "", [norm._asdict() for norm in accuracy.norms]),
            Fact(
                "mass_within_budget",
                "Point mass at the end effector within the budget" * bool(within and effect.limiting_joint),
                effect.largest_mass,
                "kg",
                note=f"joint {effect.limiting_joint} first",
            ),
            Fact("limiting_joint", "", effect.limiting_joint),
        ),
        parts=(_joints(accuracy, found, bare, effect), *_lost(accuracy, found, lost)),
    )


def _joints(accuracy: Accuracy, found: Evaluation, bare: Evaluation | None, effect: PayloadEffect) -> Table:
    arm, errors, promised = found.dynamics.arm, found.errors, accuracy.errors
    units = [joint.effort_unit for joint in arm.joints]
    # A promise that was not measured again is taken from the file.
    heading = "unloaded" if bare else "promised" if accuracy.measured else "stated"
    beside = bare.errors if bare else promised
    columns = [
        *joint_columns(arm.joints),
        Column("peak_torque", "peak here", errors.peak_torque, units),
        Column("largest_error", "error", errors.largest, units),
        Column("largest_share_of_peak_here", "", errors.largest_share, shown="percent"),
        Column("rms_error", "", errors.rms, units),
    ]
    for key, label, values, of in (
        ("allowed_error", "allowed", accuracy.allowed, units),
        ("largest_of_allowed", "of allowed", share_of(errors.largest, accuracy.allowed), ""),
        ("", heading, share_of(beside.largest, accuracy.allowed), ""),
        ("promised_of_allowed", "", share_of(promised.largest, accuracy.allowed), ""),
    ):
        columns.append(Column(key, label, values, of, "number" if of else "times"))
    columns += [
        Column("within_allowed", "within", found.within(accuracy.allowed), shown="flag"),
        Column("peak_torque_fitted_on", "", promised.peak_torque),
        Column("largest_share_of_peak_fitted_on", "", share_of(errors.largest, promised.peak_torque)),
        Column("promised_largest_error", "", promised.largest),
        Column("largest_error_without_payload", "", bare.errors.largest if bare else [None] * arm.n_joints),
        Column("torque_per_kg", "", effect.torque_per_kg),
        Column("mass_within_budget", "", effect.mass_within_budget),
    ]
    return Table("joints", "Torque error here", tuple(columns))


def _lost(accuracy: Accuracy, found: Evaluation, lost: Sequence[Loss]) -> list[Table]:
    """Dropped parts; people see them only if the error exceeds the promise."""
    arm, allowed = found.dynamics.arm, accuracy.allowed
    keys = ("part", "torque_peak", "torque_joint", "torque_share")
    tables = [Table("largest_losses", "", tuple(columns_of(lost, *((key, "", "number") for key in keys))))]
    here, promised = (share_of(x.largest, allowed) for x in (found.errors, accuracy.errors))
    if not (here > promised.max()).any():
        return tables
    lost = tuple(loss for loss in lost if loss.torque_share >= _WORTH_A_LINE)
    units = [arm.joints[loss.torque_joint - 1].effort_unit for loss in lost]
    shares = [loss.torque_peak / allowed[loss.torque_joint - 1] for loss in lost]
    columns = (
        Column("", "what", [loss.part for loss in lost], shown="text"),
        Column("", "torque", [loss.torque_peak for loss in lost], units),
        Column("", "joint", [loss.torque_joint for loss in lost], shown="count"),
        Column("", "of allowed", shares, shown="times"),
    )
    return [Table("", "Omissions by torque of each alone", columns, top=5), *tables]
