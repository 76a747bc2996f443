"""Level fast: what a search finds holds, costs no more, is the same again, and may be stopped.

Compiling the search takes more than a minute of processor time, so that what needs it is a long test;
test_searching runs the same search uncompiled.
"""

from __future__ import annotations

import dataclasses

import numpy as np
import pinocchio as pin
import pytest

import gd_analyze as gd
from changed_programs import fast_model, rounded
from gd_analyze.arrays import FloatArray
from gd_analyze.certification.holding import simplify_held
from gd_analyze.dynamics.pinocchio_check import pinocchio_model
from gd_analyze.errors import ModelError, UsageError
from gd_analyze.operations.program import plain_program
from gd_analyze.operations.torque_structure import structure_fault
from gd_analyze.simplification import fast
from gd_analyze.simplification.fast import FAST
from gd_analyze.simplification.levels import SearchOptions, level_named
from gd_analyze.simplification.simplify import simplify_exact
from gd_analyze.types import LEVELS, SimplifiedModel
from recordings import swung
from strategies import random_states

# Of the usual effort: a second.
QUICK = SearchOptions("fast", effort=0.02)


def errors_in(model: SimplifiedModel, tube: gd.types.Tube, count: int, seed: int) -> FloatArray:
    """Errors over allowed ones at states of a tube, shape (count, n); the exact torque is Pinocchio's."""
    rng = np.random.default_rng(seed)
    lower, upper, counts = tube.pieces(count, rng)
    # Most at limits, where errors are largest.
    inside = rng.random(lower.shape) < 0.3
    states = np.where(
        inside, rng.uniform(lower, upper), np.where(rng.random(lower.shape) < 0.5, lower, upper)
    )
    return errors_at(model, states) * counts


def errors_at(model: SimplifiedModel, states: FloatArray) -> FloatArray:
    robot, drives = pinocchio_model(model.arm), model.arm.drive_inertia if model.drives else 0.0
    data = robot.createData()
    exact = [pin.rnea(robot, data, *state) + drives * state[2] for state in zip(*states, strict=True)]
    return np.abs(model.torque(*states) - exact) / model.accuracy.allowed


# Pinocchio's torque, and the exact program's, are both off by some hundred eps of the largest one.
ROUNDED = 1.0 + 1e-9


def assert_cheaper_torque(model: SimplifiedModel) -> None:
    assert model.level is FAST
    assert model.operations.total < model.operations_full.total
    assert structure_fault(model.program) == ""


def test_a_level_is_known_by_its_name_or_as_itself():
    assert list(LEVELS) == ["term", "element", "energy", "fast"]
    for name, level in LEVELS.items():
        assert str(level) == level.name == name
        assert level_named(name) is level_named(level) is level
    with pytest.raises(UsageError) as caught:
        level_named("atom")
    assert caught.value.details["expected"] == "term, element, energy, fast"


@pytest.mark.slow
def test_near_a_motion_it_holds_and_is_the_same_again(two_link, swing):
    models = [gd.simplify(two_link, swing, "10%", level="fast", effort=0.02) for _ in range(2)]
    model, again = models
    assert_cheaper_torque(model)
    tube = gd.types.Tube.along(two_link, swing)
    np.testing.assert_array_equal(
        model.accuracy.allowed, gd.types.ExactDynamics.of(two_link, swing).allowed("10%")
    )
    found = errors_in(model, tube, 2000, 1)
    assert found.max() <= ROUNDED
    # What was allowed is used: a model that keeps a tenth of it would have more operations.
    assert found.max() > 0.1
    certificate = gd.certify(model, tube)
    assert certificate.within(model.accuracy.allowed).all()
    np.testing.assert_array_equal(model.accuracy.certificate.certified, certificate.certified)
    assert plain_program(again.program) == plain_program(model.program)
    assert model.accuracy.steps[-1].operations == model.operations.total


@pytest.mark.slow
def test_near_each_of_several_motions_its_own_budget_holds(two_link):
    motions = [swung(20.0, "slow"), swung(2.2, "fast")]
    model = gd.simplify(two_link, motions, "20%", level="fast", effort=0.02)
    assert_cheaper_torque(model)
    for motion in motions:
        own = dataclasses.replace(
            model.accuracy, allowed=gd.types.ExactDynamics.of(two_link, motion).allowed("20%")
        )
        assert errors_in(model.stating(own), gd.types.Tube.along(two_link, motion), 1000, 2).max() <= ROUNDED


@pytest.mark.slow
@pytest.mark.parametrize("certified", [False, True])
def test_within_limits_it_holds(two_link, certified):
    exact, box = (
        gd.types.ExactDynamics.of(two_link, gd.tables.states_in_box(two_link, 300)),
        gd.types.Box.of(two_link),
    )
    held = simplify_held(exact, "40%", box, QUICK, certified=certified)
    assert_cheaper_torque(held.model)
    assert (held.certificate is not None) == certified
    assert (held.found <= held.model.accuracy.allowed).all()
    rng = np.random.default_rng(5)
    q = rng.uniform(box.lower, box.upper, (2000, 2))
    signs = rng.choice([-1.0, 1.0], (2, 2000, 2))
    states = np.stack([q, signs[0] * box.velocity, signs[1] * box.acceleration])
    assert errors_at(held.model, states).max() <= ROUNDED


@pytest.mark.slow
def test_at_set_points_of_six_joints_with_drives(puma, pick_and_place):
    exact = gd.types.ExactDynamics.of(puma, pick_and_place, drives=True)
    model = simplify_exact(exact, "1%", QUICK)
    assert_cheaper_torque(model)
    states = np.stack(exact.states.arrays)
    assert errors_at(model, states).max() <= ROUNDED
    np.testing.assert_allclose(
        model.accuracy.errors.largest / model.accuracy.allowed,
        errors_at(model, states).max(axis=0),
        # Some hundred eps of a torque a hundred times the error.
        rtol=1e-10,
    )


@pytest.mark.slow
def test_a_budget_of_hardly_anything_gives_the_exact_torque(two_link, swing):
    model = gd.simplify(two_link, swing, "1e-9%", level="fast", effort=0.02)
    assert model.is_exact
    assert plain_program(model.program) == plain_program(model.form.program)


@pytest.mark.slow
def test_a_budget_above_the_torque_leaves_nothing(two_link, swing):
    model = gd.simplify(two_link, swing, "1000%", level="fast", effort=0.02)
    assert model.operations.total == 0
    assert errors_in(model, gd.types.Tube.along(two_link, swing), 1000, 6).max() <= ROUNDED


@pytest.mark.slow
def test_a_search_ends_when_its_time_is_over(two_link, swing):
    exact, tube = gd.types.ExactDynamics.of(two_link, swing), gd.types.Tube.along(two_link, swing)
    held = simplify_held(exact, "10%", tube, SearchOptions("fast", within=0.001))
    assert held.stopped == "after 0.001 s"
    assert held.model.operations.total <= held.model.operations_full.total
    assert errors_in(held.model, tube, 2000, 3).max() <= ROUNDED
    unlimited = simplify_held(exact, "10%", tube, QUICK)
    assert unlimited.stopped == ""


@pytest.mark.slow
def test_an_interrupted_search_gives_the_best_that_holds(two_link, swing):
    exact, tube = gd.types.ExactDynamics.of(two_link, swing), gd.types.Tube.along(two_link, swing)
    saved = []

    def interrupt(operations: int) -> None:
        saved.append(operations)
        raise KeyboardInterrupt

    held = simplify_held(exact, "10%", tube, SearchOptions("fast"), progress=interrupt)
    assert len(saved) == 1
    assert saved[0] > 0
    assert held.stopped == "on request"
    assert_cheaper_torque(held.model)
    assert errors_in(held.model, tube, 2000, 4).max() <= ROUNDED


@pytest.mark.slow
def test_progress_counts_the_operations_saved(two_link, swing):
    """With sines and cosines at no price these are operations alone."""
    exact, saved = gd.types.ExactDynamics.of(two_link, swing), []
    how = SearchOptions("fast", effort=0.02, sine_price=0)
    model = simplify_exact(exact, "10%", how, progress=saved.append)
    assert min(saved) > 0
    assert sum(saved) == model.operations_full.total - model.operations.total


def test_without_numba_it_is_said_how_to_install_it(two_link, swing, monkeypatch):
    monkeypatch.setattr(fast, "find_spec", lambda name: None)
    for states in (swing, random_states(2, 20, 0)):
        with pytest.raises(UsageError) as caught:
            gd.simplify(two_link, states, level="fast")
        assert "`pip install numba`" in caught.value.details["next"]


def test_a_model_made_without_a_search_is_stated_as_one(puma, pick_and_place):
    """What other tests take for a model of this level."""
    exact = gd.types.ExactDynamics.of(puma, pick_and_place)
    model = fast_model(exact, "1%")
    assert_cheaper_torque(model)
    assert errors_at(model, np.stack(exact.states.arrays)).max() <= ROUNDED
    assert fast_model(exact, "1%", rounded(exact.form.program)).is_exact
    assert model.size == (model.operations.total, model.operations_full.total)
    with pytest.raises(ModelError, match="no harmonic terms"):
        _ = model.torques


@pytest.mark.parametrize(
    ("option", "where"),
    [({"refit": True}, "refit"), ({"operations": 12}, "operations"), ({"within": 0.0}, "within")],
)
def test_what_a_search_for_programs_does_not_take_is_refused(option, where):
    with pytest.raises(UsageError) as caught:
        SearchOptions("fast", **option)
    assert caught.value.details["where"] == where
