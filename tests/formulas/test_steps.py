"""A program's named steps: what is printed, evaluated as a reader would, is what the program computes."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import gd_analyze as gd
from changed_programs import pruned, rounded
from gd_analyze.arrays import FloatArray
from gd_analyze.formulas.formula import CircularFunction, Formula, Product, Symbol
from gd_analyze.formulas.languages import Plain
from gd_analyze.formulas.steps import NamedSteps
from gd_analyze.operations.program import Program, program_inputs
from gd_analyze.operations.trace import Expression, Trace
from gd_analyze.types import ExactForm, States
from strategies import arms, examples, random_states

EPS = float(np.finfo(float).eps)


class Reader:
    """Evaluates formulas by their symbols alone: S23 is sin(q2 + q3) unless the legend says otherwise."""

    def __init__(self, steps: NamedSteps, states: States) -> None:
        self.legend = {formula.left: formula for formula in steps.legend.factors}
        self.values = {
            Symbol("q", str(joint + 1), dots): row
            for dots, rows in enumerate(states.last)
            for joint, row in enumerate(rows)
        }
        for formula in steps.formulas:
            self.values[formula.left] = self.right_side(formula)

    def right_side(self, formula: Formula) -> FloatArray:
        assert not any(piece.opens or piece.behind for piece in formula.pieces)
        return self.total(piece.product for piece in formula.pieces)

    def total(self, products: Iterable[Product]) -> FloatArray:
        out = np.zeros_like(self.values[Symbol("q", "1")])
        for product in products:
            factor = np.full_like(out, product.weight)
            for base, exponent in product.powers:
                factor = factor * self.value(base) ** exponent
            out = out + factor
        return out

    def value(self, base: Symbol | CircularFunction) -> FloatArray:
        if isinstance(base, CircularFunction):
            return {"cos": np.cos, "sin": np.sin}[base.name](self.total(base.argument))
        if base in self.legend:
            return self.right_side(self.legend[base])
        if base.letter in "CS":
            assert not base.primes
            angle = np.sum([self.values[Symbol("q", digit)] for digit in base.index], axis=0)
            return {"C": np.cos, "S": np.sin}[base.letter](angle)
        return self.values[base]


def assert_read_alike(program: Program, states: States) -> NamedSteps:
    steps = NamedSteps(program)
    inputs, values = program_inputs(states), Reader(steps, states).values
    found = np.array([values[Symbol("tau", str(joint + 1))] for joint in range(len(program.outputs))])
    every = [*program.steps, *(x for x in program.outputs if not isinstance(x, Expression))]
    # Sums are added in another order, and numbers multiplied first: every step rounds by eps of what is, or
    # was on the way, at most twice the largest value of any step, in both evaluations.
    allowed = 4 * EPS * len(program.steps) * np.abs(Program(program.steps, tuple(every)).run(inputs)).max()
    assert np.abs(found - program.run(inputs)).max() <= allowed
    return steps


@pytest.mark.parametrize("drives", [False, True])
@pytest.mark.parametrize("name", ["puma560", "stanford", "scara", "two_link"])
def test_exact_programs(name, drives):
    arm = gd.load_arm(name)
    if drives and not arm.drives:
        return
    form, states = ExactForm(arm, drives), random_states(arm.n_joints, 200, 4)
    for program in (form.program, form.recursion, rounded(form.program)):
        steps = assert_read_alike(program, states)
        # Nothing is multiplied out or printed twice.
        assert operations_of(steps.formulas) <= program.count.total
        names = [formula.left for formula in steps.formulas]
        assert len(set(names)) == len(names)


def operations_of(formulas: Iterable[Formula]) -> int:
    """Multiplications and additions that a reader carries out."""
    total = 0
    for formula in formulas:
        total += len(formula.pieces) - 1
        for piece in formula.pieces:
            factors = sum(exponent for _, exponent in piece.product.powers)
            total += max(factors - (abs(piece.product.weight) == 1.0), 0)
    return total


@examples(15)
@given(arms(max_joints=5), st.integers(0, 2**32 - 1))
def test_programs_with_something_left_out(arm, seed):
    states = random_states(arm.n_joints, 50, seed)
    assert_read_alike(ExactForm(arm).recursion, states)
    assert_read_alike(pruned(arm, 0.1, np.random.default_rng(seed)).program, states)


def made(make: Callable[..., list[object]]) -> Program:
    trace = Trace()
    return Program.of(trace, make(*(trace.inputs(name, 3)[:, 0] for name in ("q", "qd", "qdd"))))


def shared_sums(q, qd, qdd):
    force = qdd[0] + 2.0 * (np.cos(q[0]) * qdd[1])
    return [force + qdd[2], np.sin(q[0]) * force, force - qd[0] * qd[1]]


def negatives_of_sums(q, qd, qdd):
    speed = qd[0] + qd[1]
    return [-(speed * qd[2]), -(qdd[0] + qdd[1]), 3.0 - (-(qdd[0] + qdd[1]) + np.cos(q[1]))]


def squares(q, qd, qdd):
    speed = qd[0] + qd[1]
    return [speed * speed, 0.5 * (qd[2] * qd[2]), (np.cos(q[0]) * np.cos(q[0])) * qdd[0]]


def numbers_in_a_row(q, qd, qdd):
    return [2.0 * (0.1 * (qdd[0] * np.sin(q[0]))), -1.5 * (qdd[1] + 0.5), 7.0 * (-(qdd[2] + q[0]))]


def angles(q, qd, qdd):
    """Sums, differences and multiples of angles, with and without a number; the same joints twice."""
    own = [q[0] + q[1], q[0] - q[1], q[0] + q[1] + 0.3, -(q[1] + q[2]), 2.0 * q[2], q[2]]
    return [sum(np.cos(x) + 2.0 * np.sin(x) for x in own[k::3]) for k in range(3)]


def nothing(q, qd, qdd):
    return [0.0, 2.5, qdd[2]]


def the_same_twice(q, qd, qdd):
    torque = qdd[0] + qdd[1]
    return [torque, torque, -torque]


@pytest.mark.parametrize(
    "make",
    [shared_sums, negatives_of_sums, squares, numbers_in_a_row, angles, nothing, the_same_twice],
)
def test_programs_made_by_hand(make):
    assert_read_alike(made(make), random_states(3, 100, 1))


def test_as_a_reader_sees_them():
    def lines(make: Callable[..., list[object]]) -> list[str]:
        return [Plain().line(formula) for formula in NamedSteps(made(make)).formulas]

    assert lines(shared_sums) == [
        "u1 = qdd1 + 2 C1 qdd2",
        "tau1 = u1 + qdd3",
        "tau2 = S1 u1",
        "tau3 = u1 - qd1 qd2",
    ]
    assert lines(squares)[:2] == ["u1 = qd1 + qd2", "tau1 = u1²"]
    assert lines(nothing) == ["tau1 = 0", "tau2 = 2.5", "tau3 = qdd3"]
    shown = Plain().legend(NamedSteps(made(angles)).legend)
    assert "C12 = cos(q1 + q2)" in shown
    assert any(line.endswith("= cos(q1 - q2)") for line in shown)
