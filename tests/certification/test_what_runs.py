"""The certificate is of the program, whatever the terms beside it say, and of nothing that a file states."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

from gd_analyze.certification.box import Box
from gd_analyze.certification.certificate import Certificate, certify, largest_torque
from gd_analyze.certification.certified_model import simplify_certified
from gd_analyze.certification.positive_definite import certify_positive_definite
from gd_analyze.errors import ModelError, UsageError
from gd_analyze.motions.states import states_in_box
from gd_analyze.operations.program import Program
from gd_analyze.operations.trace import Trace
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.catalogue import load_arm
from gd_analyze.simplification.accuracy import ErrorTable
from gd_analyze.simplification.budget import Budget
from gd_analyze.simplification.energy import ENERGY
from gd_analyze.simplification.exact import ExactDynamics
from gd_analyze.simplification.exact_form import ExactForm
from gd_analyze.simplification.model import SimplifiedModel
from made_models import exact_model


def with_added(model: SimplifiedModel, height: float) -> SimplifiedModel:
    """A model whose first torque is off by height cos(q1 - q2) qd2^2, and its terms say nothing of it."""
    trace = Trace()
    of = model.program.folded(trace, {})
    q1, q2, velocity = (trace.record("input", name) for name in ("q1", "q2", "qd2"))
    first, *others = (of(output) for output in model.program.outputs)
    added = height * np.cos(q1 - q2) * velocity * velocity
    return dataclasses.replace(model, program=Program.of(trace, [first + added, *others]))


def test_what_the_program_adds_is_in_the_bound(two_link: RobotArm) -> None:
    model = exact_model(two_link)
    box = Box.of(two_link)
    plain, off = certify(model, box), certify(with_added(model, 0.5), box)
    most = 0.5 * float(box.velocity[1]) ** 2
    assert plain.certified[0] < 1e-9
    # The arm's ranges reach q1 = q2.
    assert off.worst_found[0] == pytest.approx(most, rel=1e-3)
    assert most <= off.certified[0] < 1.1 * most
    assert off.certified[1] == plain.certified[1]


def test_a_program_of_another_kind_has_no_certificate(two_link: RobotArm) -> None:
    model = exact_model(two_link)
    trace = Trace()
    of = model.program.folded(trace, {})
    first, *others = (of(output) for output in model.program.outputs)
    bad = Program.of(trace, [first + trace.record("input", "q1"), *others])
    for prove in (certify, certify_positive_definite):
        with pytest.raises(ModelError, match="computes no torque"):
            prove(dataclasses.replace(model, program=bad))


def test_it_holds_whatever_the_file_states(two_link: RobotArm) -> None:
    """Peak torque and errors of a promise are in no figure of the certificate."""
    model = with_added(exact_model(two_link), 0.5)
    accuracy = dataclasses.replace(
        model.accuracy,
        errors=ErrorTable(np.full(2, 1e9), np.zeros(2), np.zeros(2)),
        allowed=np.full(2, 1e7),
    )
    lying = dataclasses.replace(model, accuracy=accuracy)
    assert certify(lying).certified.tolist() == certify(model).certified.tolist()
    assert largest_torque(lying).tolist() == largest_torque(model).tolist()


@pytest.mark.parametrize(("name", "drives"), [("two_link", False), ("puma560", True), ("stanford", False)])
def test_the_largest_torque_is_of_the_box(name: str, drives: bool) -> None:
    """No drawing beats it, and it is reached: it lies within what the magnitudes add up to."""
    arm = load_arm(name)
    model = exact_model(arm, drives)
    found = largest_torque(model)
    drawn = ExactDynamics(ExactForm(arm, drives), states_in_box(arm, 20_000)).peak_torque
    assert (found >= drawn).all()
    assert (found <= 3.0 * drawn).all()
    half = Box(
        *(0.5 * getattr(Box.of(arm), limit) for limit in ("lower", "upper", "velocity", "acceleration"))
    )  # A half as large box is within the whole where all ranges hold zero.
    if (Box.of(arm).lower <= 0.0).all():
        assert (largest_torque(model, half) <= found * (1 + 1e-9)).all()


def test_no_motion_and_no_gravity_is_no_torque(two_link: RobotArm) -> None:
    weightless = dataclasses.replace(two_link, gravity=np.zeros(3))
    still = Box(np.zeros(2), np.ones(2), np.zeros(2), np.zeros(2))
    assert largest_torque(exact_model(weightless, level=ENERGY), still).tolist() == [0.0, 0.0]


def test_a_box_of_another_arm(two_link: RobotArm, puma: RobotArm) -> None:
    with pytest.raises(UsageError, match="does not fit the arm"):
        largest_torque(exact_model(two_link), Box.of(puma))


def test_a_certified_model_is_certified_as_it_is_returned(two_link: RobotArm) -> None:
    """The certificate is of the program that is stored, to the last bit, not of one written on the way."""
    exact = ExactDynamics.of(two_link, states_in_box(two_link, 300))
    box = Box.of(two_link)
    model, certificate = simplify_certified(exact, Budget.parse("40%"), box)
    assert certify(model, box).certified.tolist() == certificate.certified.tolist()
    assert certificate.within(model.accuracy.allowed).all()


def test_it_is_certified_after_it_was_written(two_link: RobotArm, monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[SimplifiedModel] = []

    def watched(model: SimplifiedModel, *args: Any, **named: Any) -> Certificate:
        seen.append(model)
        return certify(model, *args, **named)

    monkeypatch.setattr("gd_analyze.certification.certified_model.certify", watched)
    exact = ExactDynamics.of(two_link, states_in_box(two_link, 300))
    model, _ = simplify_certified(exact, Budget.parse("40%"), Box.of(two_link))
    assert seen[-1] is model
