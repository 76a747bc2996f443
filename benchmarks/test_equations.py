"""Exact equations of motion: seconds by arm and number of joints, and against SymPy's Lagrangian mechanics.

Run with `python -m pytest benchmarks/test_equations.py -s`.
"""

from __future__ import annotations

import itertools
import time
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import gd_analyze as gd
from gd_analyze.harmonics.transform import Harmonics
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.parts import Joint, Link, Placement

ROUNDS = 5
LENGTH, GRAVITY = 1.0, 9.8062


def seconds(work: Callable[[], object], rounds: int = ROUNDS) -> float:
    """Median, after one call that warms up."""
    work()
    took = []
    for _ in range(rounds):
        start = time.perf_counter()
        work()
        took.append(time.perf_counter() - start)
    return float(np.median(took))


def chain(n: int) -> RobotArm:
    """Revolute joints, no two axes parallel, no number round: nothing cancels."""
    rng = np.random.default_rng(n)
    links = []
    for i in range(n):
        rotation = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        rotation = rotation * np.linalg.det(rotation).round()
        root = rng.normal(scale=0.3, size=(3, 3))
        second = root @ root.T
        inertia = np.trace(second) * np.eye(3) - second
        frame = Placement(rotation, rng.uniform(-0.5, 0.5, 3))
        links.append(Link(f"{i + 1}", 1.0, rng.uniform(-0.05, 0.05, 3), 0.5 * (inertia + inertia.T), frame))
    return RobotArm("chain", tuple(Joint(f"{i + 1}") for i in range(n)), tuple(links))


def rods(n: int) -> RobotArm:
    """Uniform rods in a vertical plane, the text's two-link arm with n links."""
    across = LENGTH**2 / 12
    behind = Placement(np.eye(3), np.array([LENGTH, 0.0, 0.0]))
    com = np.array([-LENGTH / 2, 0.0, 0.0])
    link = [Link(f"{i + 1}", 1.0, com, np.diag([0.0, across, across]), behind) for i in range(n)]
    gravity = np.array([0.0, -GRAVITY, 0.0])
    return RobotArm("rods", tuple(Joint(f"{i + 1}") for i in range(n)), tuple(link), gravity)


def n_terms(harmonics: Harmonics) -> int:
    return sum(len(part) for parts in harmonics.inertia.values() for part in parts)


def test_built_in_arms(benchmark) -> None:
    puma = gd.load_arm("puma560")
    benchmark.pedantic(lambda: gd.tables.harmonics_of(puma), rounds=ROUNDS, warmup_rounds=1)
    for name in gd.builtin_arms():
        arm = gd.load_arm(name)
        identified = gd.tables.harmonics_of(arm)
        took, written = (
            seconds(lambda a=arm: gd.tables.harmonics_of(a)),
            seconds(lambda h=identified: gd.equations(h)),
        )
        benchmark.extra_info[name] = took
        print(
            f"\n{name}: identified in {took:.3f} s ({n_terms(identified)} terms of D), "
            f"D and c written out in {written:.3f} s"
        )


def test_growth_with_the_number_of_joints(benchmark) -> None:
    arms = {n: chain(n) for n in range(1, 9)}
    print("\nchain of n revolute joints, no parallel axes:")
    before = None
    for n, arm in arms.items():
        took = seconds(lambda a=arm: gd.tables.harmonics_of(a), rounds=1 if n == 8 else 3)
        benchmark.extra_info[f"n={n}"] = took
        times = f", {took / before:.1f} times" if before else ""
        print(f"  n = {n}: {took:.4f} s, {n_terms(gd.tables.harmonics_of(arm))} terms of D{times}")
        before = took
    print("rods in a plane (one run of n parallel axes):")
    for n in range(2, 9):
        arm = rods(n)
        took = seconds(lambda a=arm: gd.tables.harmonics_of(a), rounds=1)
        print(f"  n = {n}: {took:.4f} s, {n_terms(gd.tables.harmonics_of(arm))} terms of D")
    benchmark.pedantic(lambda: gd.tables.harmonics_of(arms[7]), rounds=3)


def test_one_element_against_the_whole(benchmark) -> None:
    """What it takes to read one element of a long arm, as a share of what all of its D and c take."""
    arm = chain(7)
    whole = seconds_of(lambda: gd.equations(arm, ("D", "c")))
    for label, share in itertools.product(("D12", "D45", "c2", "h112"), (0.0, 0.01)):
        one = seconds_of(lambda e=label, m=share: gd.equations(arm, [e], min_share=m))
        benchmark.extra_info[f"{label}, {share:g}"] = one / whole
        print(f"\n{label} from {share:.0%} on: {one:.3f} s, 1 / {whole / one:.0f} of D and c ({whole:.1f} s)")
    benchmark.pedantic(lambda: gd.equations(arm, ["D12"], min_share=0.01), rounds=3)


def lagranges_method(n: int) -> tuple[Any, Any]:
    """SymPy's own equations of motion of the same rods: inertia matrix and the rest, with numbers in."""
    from sympy import Matrix, Rational
    from sympy.physics.mechanics import (
        LagrangesMethod,
        Lagrangian,
        Point,
        ReferenceFrame,
        RigidBody,
        dynamicsymbols,
        inertia,
    )

    q, qd = dynamicsymbols(f"q1:{n + 1}"), dynamicsymbols(f"q1:{n + 1}", 1)
    base, tip = ReferenceFrame("N"), Point("O")
    tip.set_vel(base, 0)
    frame, bodies = base, []
    across = Rational(1, 12)
    height = 0
    for i in range(n):
        turned = frame.orientnew(f"A{i}", "Axis", [q[i], base.z])
        turned.set_ang_vel(frame, qd[i] * base.z)
        middle, end = tip.locatenew(f"C{i}", turned.x / 2), tip.locatenew(f"P{i}", turned.x)
        middle.v2pt_theory(tip, base, turned)
        end.v2pt_theory(tip, base, turned)
        body = RigidBody(f"B{i}", middle, turned, 1, (inertia(turned, 0, across, across), middle))
        height = height + turned.x.dot(base.y) / 2
        body.potential_energy = GRAVITY * height
        height = height + turned.x.dot(base.y) / 2
        bodies.append(body)
        frame, tip = turned, end
    method = LagrangesMethod(Lagrangian(base, *bodies), q)
    method.form_lagranges_equations()
    return Matrix(method.mass_matrix), method.forcing


@pytest.mark.parametrize("n", [2, 3])
def test_against_sympys_lagrangian_mechanics(benchmark, n: int) -> None:
    sympy = pytest.importorskip("sympy", reason="needs SymPy: pip install sympy")
    from sympy.core.cache import clear_cache
    from sympy.physics.mechanics import dynamicsymbols

    arm = rods(n)

    def theirs() -> tuple[Any, Any]:
        # What a second call finds in the cache is no work of the method.
        clear_cache()
        return lagranges_method(n)

    def ours() -> tuple[object, ...]:
        harmonics = gd.tables.harmonics_of(arm)
        return gd.equations(harmonics, ("D", "h", "c"))

    mass, forcing = theirs()
    ours()
    pairs = [(seconds_of(theirs), seconds_of(ours)) for _ in range(3)]
    benchmark.pedantic(ours, rounds=3)
    ratio = float(np.median([their / our for their, our in pairs]))
    benchmark.extra_info["times_faster"] = ratio
    print(
        f"\n{n} rods: LagrangesMethod {np.median([p[0] for p in pairs]):.3f} s, unsimplified; ours, readable "
        f"{np.median([p[1] for p in pairs]):.4f} s, {ratio:.0f} times faster"
    )
    simplified = seconds_of(lambda: mass.applyfunc(sympy.trigsimp))
    print(f"  to simplify its D alone (trigsimp) SymPy takes {simplified:.1f} s more")
    # The same equations: at one state, D and h + c agree.
    at, velocity = np.linspace(0.3, 0.9, n), np.linspace(-1.0, 1.5, n)
    q, qd = dynamicsymbols(f"q1:{n + 1}"), dynamicsymbols(f"q1:{n + 1}", 1)
    values = {**dict(zip(qd, velocity, strict=True)), **dict(zip(q, at, strict=True))}
    found = gd.tables.decompose_states(arm, gd.types.States(at, velocity, 0 * at))
    there = np.array(sympy.Matrix(mass).subs(values).evalf(), dtype=float)
    rest = -np.array(sympy.Matrix(forcing).subs(values).evalf(), dtype=float).ravel()
    np.testing.assert_allclose(found["inertia"].sum(axis=0), there, rtol=0, atol=1e-12 * there.max())
    np.testing.assert_allclose(found["torque"], rest, rtol=0, atol=1e-11 * np.abs(rest).max())


def seconds_of(work: Callable[[], object]) -> float:
    start = time.perf_counter()
    work()
    return time.perf_counter() - start
