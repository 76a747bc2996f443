"""Torques from terms of the energies are the numeric ones, for any arm and state."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gd_analyze import load_arm
from gd_analyze.formulas.languages import Plain
from gd_analyze.formulas.writing import term_formula
from gd_analyze.harmonics.lagrangian import energy_terms, torques_of_energies
from gd_analyze.harmonics.terms import Torques
from gd_analyze.harmonics.transform import Harmonics
from gd_analyze.tables import decompose_states, harmonics_of
from gd_analyze.types import Drive, RobotArm
from harmonic_arms import states_of, tolerances
from parallel_axes import arms_with_runs, of_every_turn, scara
from strategies import States, arms, examples, two_link_of

BUILT_IN = ("puma560", "stanford", "two_link")
QUANTITIES = ("inertia", "coriolis_centrifugal", "gravity_loading")


def values(arm: RobotArm, torques: Torques, velocities: np.ndarray, states: States) -> dict[str, np.ndarray]:
    """D qdd, h and c by the definition of a torque term; tau = A^-T tau'."""
    back = np.linalg.inv(velocities)
    moving = {1: back @ states.qd.T, 2: back @ states.qdd.T}
    functions = {"cos": np.cos, "sin": np.sin, "power": lambda x: x}
    out = {quantity: np.zeros((arm.n_joints, len(states.q))) for quantity in QUANTITIES}
    for term, weight in torques.items():
        value = np.full(len(states.q), weight)
        for velocity in term.velocities:
            value = value * moving[velocity.order][velocity.joint]
        for kind, multiples in term.monomial:
            value = value * functions[kind](states.q @ np.array(multiples, dtype=float))
        out[term.quantity][term.row] += value
    return {quantity: (back.T @ rows).T for quantity, rows in out.items()}


def allowances(harmonics: Harmonics, states: States) -> dict[str, float]:
    """How far D qdd, h and c may be off.

    The harmonics themselves are as exact as `tolerances` argues. Writing them out leaves products below the
    noise away: at most 2^(runs - 1) per harmonic, a cosine or sine of every run but for its sign, none of
    them above 1. An element in absolute velocities is a sum of r^2 others, r the longest run, and one in the
    joints' velocities of r^2 of those; h_ijk is half of three slopes, each at most twice as steep.
    """
    n, known = harmonics.arm.n_joints, tolerances(harmonics)
    run, products = max(map(len, harmonics.velocities.runs)), 2 ** (len(harmonics.velocities.runs) - 1)
    functions = products * max(map(len, harmonics.inertia.values()))
    left_out = run**4 * functions * harmonics.noise[0]
    velocity, acceleration = np.abs(states.qd).max(), np.abs(states.qdd).max()
    # Two effects add up.
    return {
        "inertia": (2 * known["inertia"] + left_out) * n * acceleration,
        "coriolis_centrifugal": (2 * known["christoffel"] + 3 * left_out) * (n * velocity) ** 2,
        "gravity_loading": known["gravity_loading"]
        + 2 * products * len(harmonics.potential) * harmonics.noise[1],
    }


def assert_exact(arm: RobotArm, seed: int, count: int = 5) -> None:
    harmonics, states = harmonics_of(arm), states_of(arm, count, seed)
    drives = bool(arm.drives)
    numeric = decompose_states(arm, states, drives=drives)
    terms = energy_terms(harmonics, arm.drive_inertia if drives else None)
    found = values(arm, torques_of_energies(terms, harmonics.velocities), harmonics.velocities.matrix, states)
    inertia = numeric["inertia"].sum(axis=1) + (np.diag(arm.drive_inertia) if drives else 0.0)
    wanted = {
        "inertia": np.einsum("tij,tj->ti", inertia, states.qdd),
        "coriolis_centrifugal": numeric["coriolis_centrifugal"].sum(axis=1),
        "gravity_loading": numeric["gravity_loading"],
    }
    allowed = allowances(harmonics, states)
    for quantity in QUANTITIES:
        assert np.abs(found[quantity] - wanted[quantity]).max() <= allowed[quantity], quantity
    assert np.abs(sum(found.values()) - numeric["torque"]).max() <= sum(allowed.values())


@pytest.mark.parametrize("name", BUILT_IN)
def test_built_in_arms(name):
    assert_exact(load_arm(name), 1, 50)


@of_every_turn(seed=1, driven=True)
@examples(20)
@given(arms(max_joints=4) | arms_with_runs(max_joints=4), st.integers(0, 2**32 - 1), st.booleans())
def test_arms_of_every_make_with_parallel_axes_and_drives(arm, seed, driven):
    inertia = np.random.default_rng(seed).uniform(0.1, 2.0, arm.n_joints)
    drives = tuple(Drive(inertia=float(x)) for x in inertia) if driven else ()
    assert_exact(dataclasses.replace(arm, drives=drives), seed)


@examples(10)
@given(st.floats(0.2, 2.0), st.floats(0.5, 5.0), st.floats(0.5, 5.0))
def test_two_rods_as_everybody_writes_them(length, m1, m2):
    arm = two_link_of(length, m1, m2)
    found = {
        (t.i, t.j, tuple(map(tuple, t.monomial))): coefficient
        for t, coefficient in energy_terms(harmonics_of(arm)).items()
    }
    g = 9.8062
    wanted = {
        (0, 0, ()): (m1 / 3 + m2) * length**2,
        (0, 1, (("cos", (0, 1)),)): m2 * length**2 / 2,
        (1, 1, ()): m2 * length**2 / 3,
        (-1, -1, (("sin", (1, 0)),)): (m1 / 2 + m2) * g * length,
        (-1, -1, (("sin", (1, 1)),)): m2 / 2 * g * length,
    }
    assert found.keys() == wanted.keys()
    # Each is a sum of a few products of the arm's numbers: some eps of the largest.
    scale = max(wanted.values())
    for key, value in wanted.items():
        assert found[key] == pytest.approx(value, rel=0, abs=100 * np.finfo(float).eps * scale)


def test_a_scara_collapses_to_few_terms():
    """Angles of parallel axes add up across the slide; with the roll on its own there were 19 and 59."""
    assert_exact(scara(), 3, 50)
    harmonics = harmonics_of(scara())
    energies = energy_terms(harmonics)
    assert (len(energies), len(torques_of_energies(energies, harmonics.velocities))) == (10, 25)
    lines = {
        f"{term.i + 1}{term.j + 1}": Plain().right(term_formula(term, 1.0))
        for term in energies
        if term.i < term.j
    }
    # Of two links' angles only the difference counts, and nothing of how far the slide is out.
    assert lines.keys() == {"12", "14", "24"}
    assert lines["12"] == "C2"
    assert {f.multiples for t in energies for f in t.monomial if (t.i, t.j) == (0, 3)} == {(0, 1, 0, -1)}
