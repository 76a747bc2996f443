"""A torque is D(q) qdd + h(q, qd) + c(q): exact programs are, and what is accepted scales as one."""

from __future__ import annotations

import math
import operator
import re
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import gd_analyze as gd
from changed_programs import pruned, rounded, sums_of, without_first
from gd_analyze import builtin_arms
from gd_analyze.operations.program import Program, plain_program
from gd_analyze.operations.torque_structure import structure_fault
from gd_analyze.operations.trace import Trace
from gd_analyze.types import ExactForm
from random_programs import program_of, trees
from strategies import arms, examples


@pytest.mark.parametrize("name", builtin_arms())
def test_exact_programs_are_torques(name):
    arm = gd.load_arm(name)
    for drives in {False, bool(arm.drives)}:
        form = ExactForm(arm, drives)
        for program in (form.program, form.recursion, rounded(form.program)):
            assert structure_fault(program) == ""


@examples(10)
@given(arms(max_joints=4), st.integers(0, 2**32 - 1))
def test_so_are_those_of_any_arm_with_or_without_some_steps(arm, seed):
    rng = np.random.default_rng(seed)
    program = ExactForm(arm).recursion
    sums = sums_of(program)
    dropped = without_first(program, [place for place in sums if rng.random() < 0.2])
    for each in (program, dropped, pruned(arm, 0.1, rng).program):
        assert structure_fault(each) == ""


# Trees of a degree in the motion, over q1, q2, qd1, qd2, qdd1, qdd2.
NAMES = ("q1", "q2", "qd1", "qd2", "qdd1", "qdd2")


def typed(degree: int, depth: int) -> st.SearchStrategy[Any]:
    leaves = st.sampled_from([2 * degree, 2 * degree + 1])
    if degree == 0:
        leaves |= st.sampled_from([0.5, -1.0, 3.0])
    if depth == 0:
        return leaves
    signs, inner = st.sampled_from(["add", "subtract"]), typed(degree, depth - 1)
    product = st.just("multiply")
    ways = [leaves, st.tuples(signs, inner, inner), st.tuples(st.just("negative"), inner)]
    ways.append(st.tuples(product, typed(0, depth - 1), inner))
    if degree == 0:
        ways.append(st.tuples(st.sampled_from(["cos", "sin"]), inner))
    if degree == 2:
        ways.append(st.tuples(product, typed(1, depth - 1), typed(1, depth - 1)))
        ways.append(st.tuples(signs, typed(0, depth - 1), inner))
    return st.one_of(ways)


def exactly(program: Program, speed: int) -> list[Fraction]:
    """Outputs at one state, of which the motion runs faster, in fractions: nothing is rounded.

    Sines and cosines, which are of positions, are some fraction near.
    """
    state = {"q1": "3/7", "q2": "-5/3", "qd1": "2/3", "qd2": "-7/5", "qdd1": "11/3", "qdd2": "-13/7"}
    operations = {
        "add": operator.add,
        "subtract": operator.sub,
        "multiply": operator.mul,
        "negative": operator.neg,
        "cos": lambda x: Fraction(math.cos(x % 7)),
        "sin": lambda x: Fraction(math.sin(x % 7)),
    }

    def apply(operation: str, *arguments: Any) -> Fraction:
        return operations[operation](*map(Fraction, arguments))

    def given(name: str) -> Fraction:
        return Fraction(state[name]) * speed ** (name.count("d"))

    of = program.carried_out(given, apply)
    return [Fraction(of(output)) for output in program.outputs]


def assert_scales(program: Program) -> None:
    """What is not gravity grows with the square of the speed."""
    rest, once, thrice = (exactly(program, speed) for speed in (0, 1, 3))
    for still, slow, fast in zip(rest, once, thrice, strict=True):
        assert fast - still == 9 * (slow - still)


@examples(150)
@given(st.one_of(typed(2, 4), typed(0, 3)))
def test_every_torque_is_accepted(root):
    program = program_of(root, names=NAMES)
    assert structure_fault(program) == ""
    assert_scales(program)


@examples(300)
@given(trees)
def test_what_is_accepted_scales_as_a_torque(root):
    program = program_of(root, names=("q1", "qd1", "qdd1"))
    if not structure_fault(program):
        assert_scales(program)


WRONG = {
    "is a cos of the motion": lambda q, qd, qdd: np.cos(q + qd * qd) * qdd,
    "is a sin of the motion": lambda q, qd, qdd: np.sin(qdd) + q,
    "is of degree 3 in the motion": lambda q, qd, qdd: np.cos(q) * qd * qdd,
    "is of degree 4 in the motion": lambda q, qd, qdd: qdd * (1.0 + qdd),
    "adds degrees 0 and 1 in the motion": lambda q, qd, qdd: (qd - 2.0) * qd,
    "adds degrees 1 and 2 in the motion": lambda q, qd, qdd: qd * np.sin(q) + qdd,
}


@pytest.mark.parametrize("why", WRONG)
def test_a_wrong_step_is_named(why):
    trace = Trace()
    (q, other), (qd, _), (qdd, _) = (trace.inputs(name, 2)[:, 0] for name in ("q", "qd", "qdd"))
    program = Program.of(trace, [qdd + np.cos(other), WRONG[why](q, qd, qdd)])
    fault = structure_fault(program)
    assert fault.endswith(why)
    number = int(re.match(r"step s(\d+) ", fault)[1])
    operation = plain_program(program)[0][number][0]
    assert operation in {"is": ("cos", "sin", "multiply"), "adds": ("add", "subtract")}[why.split()[0]]
    # Before the wrong step there is nothing wrong.
    before = program.steps[:number]
    assert structure_fault(Program(before, before[:0])) == ""


def test_friction_is_no_torque_of_this_kind():
    trace = Trace()
    qd, qdd = (trace.inputs(name, 2)[:, 0] for name in ("qd", "qdd"))
    viscous = Program.of(trace, [qdd[0], 0.3 * qd[1]])
    fault = structure_fault(viscous)
    assert "joint 2" in fault
    assert "linear" in fault


def test_numbers_and_inputs_alone_are_torques():
    trace = Trace()
    assert structure_fault(Program.of(trace, [0.0, trace.record("input", "qdd1"), -3.0])) == ""
