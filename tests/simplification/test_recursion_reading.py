"""A recursion in words: its equations are its program, and names mean what they say."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from changed_recursions import random_changes
from gd_analyze.dynamics.kinematics import solve_kinematics
from gd_analyze.dynamics.regrouped_links import regrouped
from gd_analyze.formulas.formula import Formula, Function, Product, Symbol
from gd_analyze.formulas.languages import Plain
from gd_analyze.motions.states import States
from gd_analyze.operations.program import Program
from gd_analyze.operations.trace import Expression, reached
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.catalogue import load_arm
from gd_analyze.simplification.exact_form import ExactForm
from gd_analyze.simplification.program_cache import inputs_of
from gd_analyze.simplification.recursion import CONSTANT, NUMBER, Change, Quantity, Recursion
from gd_analyze.simplification.recursion_losses import link_parameters, omissions
from gd_analyze.simplification.recursion_reading import Names, Reading, read, scales, unsigned
from gd_analyze.simplification.recursive import RECURSIVE
from parallel_axes import scara
from strategies import arms, examples, random_states

# An equation has some twenty summands and there are some hundred in a row, each rounded once; relative to
# what is added up, which no random state makes larger than a thousand times the torque.
_ROUNDED = 1e-10
PUMA = load_arm("puma560")


def evaluated(reading: Reading, states: States) -> dict[Symbol, np.ndarray]:
    """Carry equations out in their order."""
    values = {
        Symbol("q", str(joint + 1), dots): row
        for dots, rows in enumerate(states.last)
        for joint, row in enumerate(rows)
    }
    for formula in (*reading.functions, *reading.formulas):
        values[formula.left] = total([piece.product for piece in formula.pieces], values)
    return values


def total(products: list[Product], values: Mapping[Symbol, np.ndarray]) -> np.ndarray:
    out = np.zeros_like(values[Symbol("q", "1")])
    for product in products:
        factor = np.full_like(out, product.weight)
        for base, exponent in product.powers:
            if isinstance(base, Function):
                value = getattr(np, base.name)(total([*base.argument], values))
            else:
                value = values[base]
            factor = factor * value**exponent
        out = out + factor
    return out


def assert_same_torque(form: ExactForm, changes: Mapping[Change, float], states: States) -> None:
    found = evaluated(RECURSIVE.reading(form, changes), states)
    wanted = form.recursion.changed(changes).run(inputs_of(states))
    torque = np.array([found[Symbol("tau", str(i + 1))] for i in range(form.arm.n_joints)])
    assert np.abs(torque - wanted).max() <= _ROUNDED * max(np.abs(wanted).max(), 1.0)


@examples(7)
@given(arms(max_joints=7), st.integers(0, 99), st.sampled_from([0.0, 0.1, 0.4]))
def test_the_equations_are_the_program(arm: RobotArm, seed: int, share: float):
    form = ExactForm(arm)
    assert_same_torque(
        form, random_changes(form.recursion, share, seed), random_states(arm.n_joints, 5, seed)
    )


@pytest.mark.parametrize("arm", [PUMA, scara(), load_arm("stanford")], ids=lambda arm: arm.name)
def test_they_are_with_drives_and_parallel_axes(arm):
    form, states = ExactForm(arm, bool(arm.drives)), random_states(arm.n_joints, 5, 0)
    for seed, share in enumerate((0.0, 0.05, 0.3)):
        assert_same_torque(form, random_changes(form.recursion, share, seed), states)


@examples(5)
@given(arms(max_joints=6), st.integers(0, 99))
def test_omega_is_the_angular_velocity_of_the_link(arm: RobotArm, seed: int):
    states = random_states(arm.n_joints, 4, seed)
    recursion = ExactForm(arm).recursion
    values = told_values(recursion, states)
    axes = solve_kinematics(arm, states.last[0]).joint_axes
    omega = np.zeros((3, 4))
    for link, regrouped_link in enumerate(regrouped(arm).links):
        if arm.is_revolute[link]:
            omega = omega + axes[link] * states.last[1][link]
        own = np.array([values[Quantity("omega", link, axis)] for axis in "xyz"])
        # The frame is turned about an unknown angle: lengths are those in any frame. A sum of as many unit
        # vectors times velocities as there are joints rounds below that many eps of the largest.
        assert np.allclose(np.linalg.norm(own, axis=0), np.linalg.norm(omega, axis=0), atol=1e-12)
        if arm.is_revolute[link] and not regrouped_link.is_round:
            along = regrouped_link.sign * np.einsum("an,an->n", omega, axes[link])
            assert np.allclose(np.abs(own[2]), np.abs(along), atol=1e-12)


def told_values(recursion: Recursion, states: States) -> dict[Quantity, np.ndarray]:
    """Every quantity at states, by running all steps."""
    expressions = [value for _, value in recursion.quantities]
    rows = Program(recursion.steps, tuple(expressions)).run(inputs_of(states))
    return {quantity: row for (quantity, _), row in zip(recursion.quantities, rows, strict=True)}


@examples(4)
@given(arms(max_joints=6), st.integers(0, 99))
def test_the_field_a_is_what_omega_and_its_rate_make(arm: RobotArm, seed: int):
    states = random_states(arm.n_joints, 4, seed)
    values = told_values(ExactForm(arm).recursion, states)
    for link in range(arm.n_joints):
        omega, velocity = (
            np.array([values[Quantity(kind, link, axis)] for axis in "xyz"]) for kind in ("omega", "omegad")
        )
        for b, point in enumerate(np.eye(3)):
            made = np.cross(velocity.T, point) + np.cross(omega.T, np.cross(omega.T, point))
            stated = [values[Quantity("A", link, "xyz"[a] + "xyz"[b])] for a in range(3)]
            # Two products and a sum each: a few eps of the squares of the velocities.
            assert np.allclose(np.transpose(stated), made, rtol=0.0, atol=1e-13 * (1.0 + np.abs(made).max()))


def test_dropped_torque_is_the_difference_of_two_evaluations():
    form, states = ExactForm(PUMA, True), random_states(6, 50, 3)
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


def place_of(form: ExactForm, kind: str, link: int, component: str = "") -> int:
    (value,) = [x for q, x in form.recursion.quantities if q == Quantity(kind, link, component)]
    return form.recursion.steps.index(value)


def test_a_summand_that_is_dropped_is_named_where_it_was():
    form, states = ExactForm(PUMA), random_states(6, 20, 0)
    place = place_of(form, "omegad", 4, "x")
    step = form.recursion.steps[place]
    kept = form.recursion.steps.index(step.arguments[0])
    (one,) = omissions(form, {Change(place, kept): 1.0}, states)
    assert one.quantity == Quantity("omegad", 4, "x")
    assert not one.instead
    assert not one.changed_by
    assert Plain().product(one.exact[0]) in Plain().right(equation(form, {}, "omegad5x"))
    assert Plain().product(one.exact[0]) not in Plain().right(
        equation(form, {Change(place, kept): 1.0}, "omegad5x")
    )


def test_a_quantity_that_is_a_step_turned_round_is_told_by_its_name():
    form, states = ExactForm(load_arm("stanford")), random_states(6, 20, 0)
    needed = set(reached(form.recursion.outputs))
    turned = {
        value.order: quantity
        for quantity, value in form.recursion.quantities
        if isinstance(value, Expression) and value.operation == "negative" and value.order in needed
    }
    places = {step.order: place for place, step in enumerate(form.recursion.steps)}
    assert turned
    for order, quantity in turned.items():
        for one in omissions(form, {Change(places[order], NUMBER): 0.3}, states):
            assert one.quantity == quantity
            assert [Plain().product(term) for term in one.exact] == [Plain().symbol(quantity.symbol)]
            assert Plain().sum(one.instead) == "0.3"


def equation(form: ExactForm, changes: Mapping[Change, float], left: str) -> Formula:
    formulas = read(form.recursion, changes).formulas
    return next(formula for formula in formulas if Plain().symbol(formula.left) == left)


def test_parameters_that_are_kept_refitted_and_dropped():
    form = ExactForm(PUMA, True)
    recursion = form.recursion
    before = {(one.link, one.kind): one for one in link_parameters(form, {})}
    assert len(before) == 6 * 11
    for one in before.values():
        assert one.state in ("kept", "never acts")
        assert one.number != 0.0 or not one.places
    # Gravity turns about the first axis: that link's mass and first moments never act, its inertia does.
    assert [before[0, kind].state for kind in ("M", "MX", "MY", "Pxx", "J")] == [
        *3 * ["never acts"],
        *2 * ["kept"],
    ]
    drive = place_of(form, "tau", 3)
    (product,) = [
        k for k, s in enumerate(recursion.steps)
        if s in recursion.steps[drive].arguments and s.operation == "multiply"
    ]  # fmt: skip
    number = before[3, "J"].number
    refitted = link_parameters(form, {Change(product, CONSTANT): 2.0 * number})
    gone = link_parameters(form, {Change(product, NUMBER): 0.0})
    assert [one.state for one in refitted if (one.link, one.kind) == (3, "J")] == ["refitted"]
    assert [one.kept for one in refitted if (one.link, one.kind) == (3, "J")] == [(2.0 * number,)]
    assert [one.state for one in gone if (one.link, one.kind) == (3, "J")] == ["dropped"]
    others = [one for one in gone if (one.link, one.kind) != (3, "J")]
    assert others == [one for one in before.values() if (one.link, one.kind) != (3, "J")]


def twice_the_force(form: ExactForm) -> dict[Change, float]:
    """Forces twice as large, with levers of half the length: the same torque."""
    recursion = form.recursion
    told = {quantity: unsigned(value) for quantity, value in recursion.quantities}
    names = Names(recursion.steps, told)
    of, changes = names.parts(recursion.steps), {}
    for k in recursion.carried_out({}).images:
        step = recursion.steps[k]
        if step.operation == "multiply" and not isinstance(step.arguments[0], Expression):
            number, operand = step.arguments
            into, factor = of[step.order].kind[0], names.quantity.get(operand.order)
            if into == "f" and factor and factor.kind == "A":
                changes[Change(k, CONSTANT)] = 2.0 * number
            elif into == "n" and factor and factor.kind[0] == "f":
                changes[Change(k, CONSTANT)] = 0.5 * number
    return changes


def test_factors_that_cancel_are_taken_out():
    form, states = ExactForm(load_arm("puma560")), random_states(6, 20, 0)
    changes = twice_the_force(form)
    assert len(changes) > 10
    assert_same_torque(form, changes, states)
    factors = scales(form, changes)
    # Whatever the sums that tell a factor round to: they are over hundreds of states.
    assert {quantity.kind[0] for quantity in factors} == {"f"}
    assert np.allclose([*factors.values()], 2.0, rtol=1e-10)
    assert all(one.share.max() < 1e-9 for one in omissions(form, changes, states))
    exact, model = read(form.recursion, {}), RECURSIVE.reading(form, changes)
    assert [Plain().line(formula) for formula in model.formulas] == [
        Plain().line(formula) for formula in exact.formulas
    ]
    assert {one.state for one in link_parameters(form, changes)} == {"kept", "never acts"}
