"""The recursive level: changed recursions, what they read as, and how they are pruned."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import gd_analyze as gd
from changed_recursions import random_changes
from gd_analyze.arrays import FloatArray
from gd_analyze.dynamics.kinematics import solve_kinematics
from gd_analyze.dynamics.regrouped_links import regrouped
from gd_analyze.errors import ModelError, UsageError
from gd_analyze.formulas.formula import Function, Product, Symbol
from gd_analyze.harmonics.expansion import expanded
from gd_analyze.motions.states import States, states_in_box
from gd_analyze.operations.program import Program
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.catalogue import load_arm
from gd_analyze.simplification.effort import inputs_of
from gd_analyze.simplification.exact import ExactDynamics, ExactForm
from gd_analyze.simplification.levels import LEVELS, SearchOptions, level_named
from gd_analyze.simplification.pruning import prune
from gd_analyze.simplification.recursion import CONSTANT, NUMBER, Changes, Quantity
from gd_analyze.simplification.recursion_losses import omissions
from gd_analyze.simplification.recursive import RECURSIVE, Reading, scales
from gd_analyze.simplification.simplify import simplify_exact
from parallel_axes import scara
from psdm_measure import arm_of as published_arm
from strategies import arms, examples, random_states


def test_a_level_is_known_by_its_name_or_as_itself():
    assert list(LEVELS) == ["term", "element", "energy", "recursive"]
    for name, level in LEVELS.items():
        assert str(level) == level.name == name
        assert level_named(name) is level_named(level) is level
    with pytest.raises(UsageError, match="no such level") as caught:
        level_named("atom")
    assert caught.value.details["expected"] == "term, element, energy, recursive"


WRONG = {
    (-1, NUMBER): "has no step -1",
    (20, 10_000): "has no step 10000",
    (20, -3): "has no step -3",
    (0, CONSTANT): "step 0 of the recursion has no constant",
    (20, 20): "in a cycle",
}


@pytest.mark.parametrize("change", WRONG)
def test_what_no_recursion_has(two_link, change):
    step, source = change
    with pytest.raises(ModelError, match=WRONG[change]):
        RECURSIVE.from_entries(ExactForm(two_link), [{"step": step, "source": source, "number": 1.0}])


# An equation has some twenty summands and there are some hundred in a row, each rounded once; relative to
# what is added up, which no random state makes larger than a thousand times the torque.
_ROUNDED = 1e-10


def evaluated(reading: Reading, states: States) -> dict[Symbol, FloatArray]:
    """Carry equations out in their order."""
    q_and_slopes = enumerate(states.last)
    values = {Symbol("q", str(i + 1), dots): row for dots, rows in q_and_slopes for i, row in enumerate(rows)}

    def total(products: Iterable[Product]) -> FloatArray:
        out = np.zeros(len(states))
        for product in products:
            factor = np.full(len(states), product.weight)
            for base, exponent in product.powers:
                is_function = isinstance(base, Function)
                value = getattr(np, base.name)(total(base.argument)) if is_function else values[base]
                factor = factor * value**exponent
            out = out + factor
        return out

    for formula in (*reading.functions, *reading.formulas):
        values[formula.left] = total(piece.product for piece in formula.pieces)
    return values


@examples(7)
@given(arms(max_joints=7), st.integers(0, 99), st.sampled_from([0.0, 0.1, 0.4]))
def test_the_equations_are_the_program(arm: RobotArm, seed: int, share: float):
    for form in (ExactForm(arm), ExactForm(load_arm("puma560"), drives=True), ExactForm(scara())):
        changes = random_changes(form.recursion, share, seed)
        states = random_states(form.arm.n_joints, 5, seed)
        found = evaluated(RECURSIVE.reading(form, changes), states)
        wanted = form.recursion.changed(changes).run(inputs_of(states))
        torque = np.array([found[Symbol("tau", str(i + 1))] for i in range(form.arm.n_joints)])
        assert np.abs(torque - wanted).max() <= _ROUNDED * max(np.abs(wanted).max(), 1.0)


@examples(5)
@given(arms(max_joints=6), st.integers(0, 99))
def test_omega_is_the_angular_velocity_of_the_link_and_makes_the_field_a(arm: RobotArm, seed: int):
    states, recursion = random_states(arm.n_joints, 4, seed), ExactForm(arm).recursion
    told = Program(recursion.steps, tuple(value for _, value in recursion.quantities))
    rows = told.run(inputs_of(states))
    values = {quantity: row for (quantity, _), row in zip(recursion.quantities, rows, strict=True)}
    axes = solve_kinematics(arm, states.last[0]).joint_axes
    omega = np.zeros((3, 4))
    for link, regrouped_link in enumerate(regrouped(arm).links):
        if arm.is_revolute[link]:
            omega = omega + axes[link] * states.last[1][link]
        own, slope = (
            np.array([values[Quantity(kind, link, axis)] for axis in "xyz"]) for kind in ("omega", "omegad")
        )
        # The frame is turned about an unknown angle: lengths are those in any frame. A sum of as many unit
        # vectors times velocities as there are joints rounds below that many eps of the largest.
        assert np.allclose(np.linalg.norm(own, axis=0), np.linalg.norm(omega, axis=0), atol=1e-12)
        if arm.is_revolute[link] and not regrouped_link.is_round:
            along = regrouped_link.sign * np.einsum("an,an->n", omega, axes[link])
            assert np.allclose(np.abs(own[2]), np.abs(along), atol=1e-12)
        for b, point in zip("xyz", np.eye(3), strict=True):
            made = np.cross(slope.T, point) + np.cross(own.T, np.cross(own.T, point))
            stated = [values[Quantity("A", link, a + b)] for a in "xyz"]
            # Two products and a sum each: a few eps of the squares of the velocities.
            assert np.allclose(np.transpose(stated), made, rtol=0.0, atol=1e-13 * (1.0 + np.abs(made).max()))


def test_dropped_torque_is_the_difference_of_two_evaluations():
    form, states = ExactForm(load_arm("puma560"), True), random_states(6, 50, 3)
    drawn = (random_changes(form.recursion, 0.1, seed) for seed in range(20))
    # What is taken out of quantities would change the changes.
    changes = next(some for some in drawn if not scales(form, some))
    exact = form.recursion.program.run(inputs_of(states))
    found = omissions(form, changes, states)
    assert len(found) > 10
    for one in found:
        alone = {change: number for change, number in changes.items() if change.step in one.places}
        torque = form.recursion.changed(alone).run(inputs_of(states))
        # Both round as the torque does.
        wanted = np.abs(torque - exact).max(axis=1)
        assert np.allclose(one.torque, wanted, rtol=0.0, atol=1e-12 * np.abs(exact).max())
        assert np.allclose(one.share, one.torque / np.abs(exact).max(axis=1))
    shares = [one.share.max() for one in found]
    assert shares == sorted(shares, reverse=True)


# Of the usual effort: what tenths of a second find.
_QUICK = 0.02


def _largest(exact: ExactDynamics, changes: Changes, allowed: FloatArray) -> float:
    """Largest error over allowed of the program that the changes make, run by itself."""
    program = exact.form.recursion.changed(changes)
    return float((np.abs(program.run(inputs_of(exact.states)).T - exact.torque) / allowed).max())


@pytest.mark.slow
@examples(4)
@given(arm=arms(max_joints=4, massive=True), seed=st.integers(0, 2**16), share=st.sampled_from([0.003, 0.03]))
def test_the_budget_is_kept_and_nothing_dearer_comes_of_it(arm: RobotArm, seed: int, share: float) -> None:
    exact = ExactDynamics.of(arm, random_states(arm.n_joints, 60, seed))
    allowed = exact.allowed(f"{100 * share}%")
    changes = prune(exact, allowed, effort=_QUICK)
    # Statements of fitted numbers are rounded once more.
    assert _largest(exact, changes, allowed) <= 1.0 + 1e-9
    recursion = exact.form.recursion
    program = recursion.changed(changes)
    assert program.count.total <= recursion.program.count.total
    # It is still a torque: D(q) qdd + h(q, qd) + c(q), or it could not be written out.
    expanded(program, [not turns for turns in arm.is_revolute])


@pytest.mark.slow
def test_it_goes_on_from_changes_and_repeats_to_the_last_bit() -> None:
    exact = ExactDynamics.of(published_arm("KR6"), random_states(6, 40, 0))
    tight, wide = (exact.allowed(budget) for budget in ("0.5%", "2%"))
    first = prune(exact, tight, effort=_QUICK)
    assert first == prune(exact, tight, effort=_QUICK)
    further = prune(exact, wide, effort=_QUICK, way=[first])
    changed = exact.form.recursion.changed
    assert changed(further).count.total < changed(first).count.total
    assert _largest(exact, further, wide) <= 1.0 + 1e-9 < _largest(exact, further, tight)


@pytest.mark.slow
def test_roundings_decide_nothing() -> None:
    """With the states in another order every sum has other last digits, as on another processor."""
    states = random_states(4, 100, 3)  # as many as a search looks at
    order = np.random.default_rng(0).permutation(100)
    found = []
    for drawn in (states, states.at(order)):
        exact = ExactDynamics.of(scara(), drawn)
        found.append(prune(exact, exact.allowed("2%"), effort=_QUICK))
    first, second = found
    assert len(first) > 10
    assert first.keys() == second.keys()
    # A number that lies on the edge between two of seven digits may fall to either side.
    assert all(abs(first[change] - second[change]) <= 1e-6 * abs(first[change]) for change in first)


@pytest.mark.slow
def test_six_joints_of_general_make_take_little_more_than_half() -> None:
    """KR6 of PSDM's Table 1 at 1 % of every joint's peak: 485 operations are exact, 300 are asked for."""
    arm = published_arm("KR6")
    exact = ExactDynamics.of(arm, states_in_box(arm, 1000))
    changes = prune(exact, exact.allowed("1%"), effort=0.1)
    assert exact.form.recursion.changed(changes).count.total <= 300


@pytest.mark.slow
def test_the_budget_nearly_holds_near_the_motion():
    arm = gd.load_arm("stanford")
    start = np.array([0.1, -0.5, 0.4, 0.3, -0.6, 0.2])
    motion = gd.plan(arm, start, start + 0.3, schedule=gd.Schedule(2.0, "4-3-4", 15)).trajectory
    exact = ExactDynamics.of(arm, motion)
    model = simplify_exact(exact, "1%", SearchOptions(RECURSIVE, thorough=False))
    assert model.saves
    random = np.random.default_rng(7)
    q, qd, qdd = (np.repeat(x, 50, axis=0) for x in exact.states.arrays)
    margin = np.where([joint.kind == "revolute" for joint in arm.joints], np.radians(1.0), 1e-3)
    near = States(q + margin * random.uniform(-1.0, 1.0, q.shape), qd, qdd)
    off = np.abs(model.torque(*near.arrays) - exact.at(near).torque).max(axis=0)
    # Fitted to the set points alone it errs by more.
    assert (off <= 1.5 * model.accuracy.allowed).all()
