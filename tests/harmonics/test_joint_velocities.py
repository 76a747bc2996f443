"""A model in joint velocities is the same model, in other terms."""

from __future__ import annotations

import re

import numpy as np
import pytest
from hypothesis import given

import gd_analyze as gd
from gd_analyze.harmonics.absolute_velocities import AbsoluteVelocities
from gd_analyze.harmonics.terms import Torques
from gd_analyze.types import ExactForm
from long_cases import long
from strategies import arms, examples, random_states


def torques_of(torques: Torques, states, velocities: AbsoluteVelocities | None = None) -> np.ndarray:
    """Torques and sizes of their summands, (2, N, n), in joint velocities unless others are given."""
    q, qd, qdd = states.arrays
    moving = (
        {1: qd.T, 2: qdd.T}
        if velocities is None
        else {1: velocities.absolute(qd.T), 2: velocities.absolute(qdd.T)}
    )
    out = np.zeros((2, q.shape[1], len(q)))
    for term, weight in torques.items():
        value = np.full(len(q), weight)
        for velocity in term.velocities:
            value = value * moving[velocity.order][velocity.joint]
        for factor in term.monomial:
            angle = q @ np.array(factor.multiples)
            value = value * {"cos": np.cos, "sin": np.sin, "power": lambda x: x}[factor.kind](angle)
        out[:, term.row] += value, np.abs(value)
    rows = out if velocities is None else np.array([velocities.joint_rows([*part]) for part in out])
    return np.moveaxis(rows, -1, 1)


@examples(25)
@given(arms(max_joints=4, massive=True))
def test_torques_are_the_same(arm):
    form, states = ExactForm(arm), random_states(arm.n_joints, 20, 1)
    there = torques_of(form.torques, states, form.velocities)[0]
    here, size = torques_of(form.velocities.in_joint_velocities(form.torques), states)
    # Some hundred summands, each rounded at its own size.
    assert np.abs(here - there).max() <= 1e-13 * size.max()


@pytest.mark.parametrize("level", [long("term"), "energy"])
def test_equations_by_element_are_the_model(puma, level):
    model = gd.simplify(puma, "pick-and-place", level=level, sine_price=0)
    own, states = model.form.velocities.in_joint_velocities(model.torques), gd.tables.states_in_box(puma, 50)
    found, size = torques_of(own, states)
    assert np.abs(found - model.torque(*states.arrays)).max() <= 1e-13 * size.max()
    lines = dict(re.findall(r"(?m)^(\w+) = (.*)$", str(model.equations)))
    drives = {f"J{k + 1}": f"{drive.inertia:g}" for k, drive in enumerate(puma.drives)}
    assert {name: lines[name] for name in drives} == drives
    assert "D21" not in lines  # D is symmetric: its upper triangle is shown
    assert lines["D33"].startswith("0.334")
    assert model.equations._repr_latex_().count(r"\\") == len(model.equations.formulas) - 1


def test_elements_print_by_themselves():
    found = gd.equations("two_link", ["D12", "c2"])
    assert str(found).splitlines() == ["D12 = 0.5 C2 + 0.333", "c2 = 4.9 C12"]
    assert found._repr_latex_().startswith("$\\begin{aligned} D_{12} &= 0.5")
