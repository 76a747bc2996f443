"""Equations with the arm's numbers as symbols: closed forms, and the values of scripts that are executed."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import gd_analyze as gd
from gd_analyze.errors import ArmError, UsageError
from gd_analyze.formulas.symbolic import symbolic_text
from gd_analyze.harmonics import symbolic
from gd_analyze.harmonics.symbolic import DifferentEquationsError, symbolic_equations
from gd_analyze.studies.symbolic import text_closed_forms
from gd_analyze.types import ArmDynamics, Joint, Link, Placement, RobotArm
from long_cases import long_but
from strategies import arms, examples, random_inertia, random_rotation

sympy = pytest.importorskip("sympy", reason="needs SymPy: pip install sympy")

ELEMENTS = {
    "two_link": (),
    "scara": (),
    "stanford": ("D11", "D13", "h112", "h123", "D33", "c"),
    "puma560": ("D12", "h3", "D66", "c2", "D45"),
}


def executed(arm: RobotArm, elements: tuple[str, ...] = ()) -> dict[str, Any]:
    """Names that the script of an arm's equations defines."""
    scope: dict[str, Any] = {}
    exec(symbolic_text(symbolic_equations(arm, elements), "sympy", 80), scope)
    return scope


def assert_is_the_decomposition(arm: RobotArm, scope: dict[str, Any], rng: np.random.Generator) -> None:
    """Compare every element and effect of a script with the numeric decomposition."""
    q = rng.uniform(-3.0, 3.0, (7, arm.n_joints))
    variables = [scope[f"q{j + 1}"] for j in range(arm.n_joints)]
    symbols = [*scope["values"]]
    numbers = [*scope["values"].values()]
    dynamics = ArmDynamics(arm)
    inertia, christoffel = dynamics.inertia(q, by_effect=True), dynamics.christoffel(q, by_effect=True)
    gravity = dynamics.gravity_loading(q)
    # Both round terms that sum to at most the mass times the stretched arm's square, and its inertias, some
    # hundred times: 10 n in the decomposition, one per term and factor in the script.
    reach = arm.reach + np.linalg.norm(arm.com, axis=1).max() + 3.0 * arm.is_revolute.count(False)
    size = arm.mass.sum() * max(reach, 1.0) ** 2 + np.abs(arm.inertia_com).sum()
    labels = [name for name in scope if name[0] in "Dhc" and name[1:2].isdigit()]
    assert labels
    for label in labels:
        element, _, effect = label.partition("_")
        indices = tuple(int(digit) - 1 for digit in element[1:])
        expression = sympy.lambdify([*variables, *symbols], scope[label], "numpy")
        value = np.broadcast_to(expression(*q.T, *numbers), len(q))
        if element[0] == "c":
            expected, largest = gravity[:, indices[0]], size * np.linalg.norm(arm.gravity_vector)
        else:
            whole = inertia if element[0] == "D" else christoffel
            of_element, largest = whole[(slice(None), slice(None), *indices)], 6 * size
            parts = {"translation": of_element[:, 0], "rotation": of_element[:, 1]}
            expected = parts[effect] if effect else of_element.sum(axis=1)
        assert np.abs(value - expected).max() <= 200 * np.finfo(float).eps * largest, label


def test_two_links_give_the_closed_forms_of_the_text():
    """With both lengths l, centres at the rods' middles and inertias m l^2 / 12."""
    scope = executed(gd.load_arm("two_link"))
    text = text_closed_forms()
    m1, m2, length, g, theta1, theta2 = (
        next(s for matrix in text for s in matrix.free_symbols if s.name == name)
        for name in ("m1", "m2", "l", "g", "theta1", "theta2")
    )
    rods = {"m1": m1, "m2": m2, "a1": length, "a2": length, "g": g, "q1": theta1, "q2": theta2}
    rods |= {"x1": -length / 2, "x2": -length / 2}
    rods |= {f"I{k}zz": m * length**2 / 12 for k, m in ((1, m1), (2, m2))}
    inserted = {scope[name]: value for name, value in rods.items()}

    def same(name: str, expected: Any) -> bool:
        return sympy.simplify(scope[name].subs(inserted) - expected) == 0

    assert {symbol.name for symbol in scope["values"]} == {*rods} - {"q1", "q2"}
    for i, j in ((0, 0), (0, 1), (1, 1)):
        assert same(f"D{i + 1}{j + 1}", text.inertia[i, j])
    assert same("c1", text.gravity_loading[0])
    assert same("c2", text.gravity_loading[1])
    # h1 = 2 h112 qd1 qd2 + h122 qd2^2, h2 = h211 qd1^2.
    half = m2 * length**2 * sympy.sin(theta2) / 2
    assert same("h112", -half)
    assert same("h122", -half)
    assert same("h211", half)


@pytest.mark.parametrize("name", long_but(("two_link", "scara", "stanford"), ELEMENTS))
def test_a_script_is_the_decomposition(name, rng):
    arm = gd.load_arm(name)
    scope = executed(arm, ELEMENTS[name])
    assert_is_the_decomposition(arm, scope, rng)
    # Every symbol has the value of the arm, which its name tells.
    values = {symbol.name: value for symbol, value in scope["values"].items()}
    for s, link in enumerate(arm.links):
        expected = {"m": link.mass, **dict(zip("xyz", link.com, strict=True))}
        expected |= {"a": arm.dh_table[s].a}
        for letter, value in expected.items():
            assert values.get(f"{letter}{s + 1}", value) == value


@examples(3)
@given(arms(max_joints=2, massive=True), st.integers(0, 2**32 - 1))
def test_two_joints_placed_anyhow(arm, seed):
    assert_is_the_decomposition(arm, executed(arm), np.random.default_rng(seed))


@st.composite
def tables(draw: st.DrawFn) -> RobotArm:
    """Arms of three joints from right or general angles, sliding or turning, with full inertias."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    joints, links = [], []
    for i in range(3):
        quarter = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
        angle = rng.uniform(0.1, 1.4)
        cosine, sine = np.cos(angle), np.sin(angle)
        askew = np.array([[1.0, 0.0, 0.0], [0.0, cosine, -sine], [0.0, sine, cosine]])
        rotation = draw(st.sampled_from([np.eye(3), quarter, askew]))
        lengths = rng.normal(size=3) * draw(st.lists(st.booleans(), min_size=3, max_size=3))
        kind = draw(st.sampled_from(["revolute", "prismatic"]))
        joints.append(Joint(str(i + 1), kind, Placement(rotation, lengths)))
        links.append(Link(str(i + 1), rng.uniform(0.1, 5.0), rng.normal(size=3), random_inertia(rng)))
    return RobotArm("drawn", tuple(joints), tuple(links))


@pytest.mark.slow
@examples(4)
@given(tables(), st.integers(0, 2**32 - 1))
def test_three_joints_with_full_inertias(arm, seed):
    assert_is_the_decomposition(arm, executed(arm), np.random.default_rng(seed))


def test_three_joints_placed_askew(rng):
    joints = tuple(
        Joint(str(i), placement=Placement(random_rotation(rng), rng.normal(size=3))) for i in range(3)
    )
    links = tuple(Link(str(i), 1.0 + i, rng.normal(size=3), random_inertia(rng)) for i in range(3))
    arm = RobotArm("askew", joints, links)
    assert_is_the_decomposition(arm, executed(arm, ("D23", "c3", "h233")), rng)


def test_wrong_equations_are_an_internal_error(monkeypatch):
    arm = gd.load_arm("two_link")
    heavier = replace(arm, links=(arm.links[0], replace(arm.links[1], mass=1.0 + 1e-9)))
    of_arm = symbolic.ArmSymbols
    monkeypatch.setattr(symbolic, "ArmSymbols", lambda _: of_arm(heavier))
    with pytest.raises(DifferentEquationsError, match="internal error: D11"):
        symbolic_equations(arm)


def test_what_is_too_long_is_refused(monkeypatch):
    arm = gd.load_arm("puma560")
    with pytest.raises(UsageError, match=r"elements=.'D12'"):
        symbolic_equations(arm)
    monkeypatch.setattr("gd_analyze.harmonics.symbolic_number.MOST_SYMBOLIC_TERMS", 20)
    with pytest.raises(ArmError, match="D11 of arm puma560 is too long"):
        symbolic_equations(arm, ("D11",))


def test_parts_that_are_zero():
    text = symbolic_text(symbolic_equations(gd.load_arm("puma560"), ("D66", "D56")), "text", 80)
    assert "\nD66^rot = I6zz\nD56 = 0\n" in text
    assert "\nI6zz = 4e-5 kg m^2\n" in text
