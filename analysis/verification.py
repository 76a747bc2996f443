"""How exact is it? Measures every identity the numbers must satisfy and writes `verification.md` beside this file.

Run it again after any change of the mechanics: `python analysis/verification.py`.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import gd_analyze as gd
from gd_analyze.dynamics import generalized_dalembert as dalembert
from gd_analyze.dynamics.kinematics import solve_kinematics
from gd_analyze.dynamics.pinocchio_check import pinocchio_dynamics, round_off_bounds

N_STATES = 2000
SYMBOLS = {"inertia": "D", "coriolis_centrifugal": "h", "gravity_loading": "c"}
EPS = float(np.finfo(float).eps)
STEP = EPS ** (1 / 3)  # balances truncation (step^2) and round-off (eps / step) of a central difference


@dataclass(frozen=True)
class Measurement:
    """One identity on one arm: what was measured, and what round-off (or truncation) explains."""

    identity: str
    arm: str
    measured: float
    bound: float
    unit: str


def measure() -> Iterator[Measurement]:
    """Measure all identities on random states of the built-in arms."""
    random = np.random.default_rng(1987)
    for name in gd.builtin_arms():
        arm = gd.load_arm(name)
        lower, upper = arm.limits("lower"), arm.limits("upper")
        velocities, accelerations = arm.limits("velocity_limit"), arm.limits("acceleration_limit")
        n = arm.n_joints
        q = random.uniform(lower, upper, (N_STATES, n))
        qd = random.uniform(-velocities, velocities, (N_STATES, n))
        qdd = random.uniform(-accelerations, accelerations, (N_STATES, n))
        yield from _identities(arm, q, qd, qdd)
    yield _end_effector_pose()
    yield from _two_link_closed_forms()


def _identities(
    arm: gd.types.RobotArm, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray
) -> Iterator[Measurement]:
    ours = gd.tables.decompose_states(arm, gd.types.States(q, qd, qdd), drives=False)
    theirs = pinocchio_dynamics(arm, q, qd, qdd)
    bounds = round_off_bounds(arm, q, qd, qdd)
    units = {"inertia": "kg m^2"}
    inertia, christoffel = ours["inertia"], ours["christoffel"]
    for quantity, bound in bounds.items():
        whole = ours[quantity]
        if quantity in ("inertia", "coriolis_centrifugal"):
            whole = whole.sum(axis=1)
        yield Measurement(
            f"{SYMBOLS.get(quantity, quantity)}: equals Pinocchio's",
            arm.name,
            float(np.abs(whole - theirs[quantity]).max()),
            bound,
            units.get(quantity, "N m"),
        )
    for e, effect in enumerate(dalembert.EFFECTS):
        part = inertia[:, e]
        yield Measurement(
            f"D, {effect}: symmetric",
            arm.name,
            float(np.abs(part - np.swapaxes(part, 1, 2)).max()),
            0.0,
            "kg m^2",
        )
        yield Measurement(
            f"D, {effect}: positive semidefinite (most negative eigenvalue)",
            arm.name,
            max(0.0, -float(np.linalg.eigvalsh(part).min())),
            bounds["inertia"],
            "kg m^2",
        )
    kinematics = solve_kinematics(arm, np.ascontiguousarray(q.T))
    by_link = dalembert.inertia_by_link(arm, kinematics).sum(axis=1)
    yield Measurement(
        "D: equals [FGL87]'s sums over links",
        arm.name,
        float(np.abs(by_link - np.moveaxis(inertia, 0, -1)).max()),
        bounds["inertia"],
        "kg m^2",
    )
    velocities = np.ascontiguousarray(qd.T)
    itemised = dalembert.coriolis_centrifugal_by_link(arm, kinematics, velocities).sum(axis=1)
    effects = np.array([term.effect for term in dalembert.terms_of(arm)])
    literal = np.stack([itemised[effects == effect].sum(axis=0) for effect in dalembert.EFFECTS])
    h = np.moveaxis(ours["coriolis_centrifugal"], 0, -1)
    yield Measurement(
        "h: equals [FGL87]'s terms, summed over links",
        arm.name,
        float(np.abs(literal - h).max()),
        bounds["coriolis_centrifugal"],
        "N m",
    )
    contracted = np.einsum("Neijk,Nj,Nk->eiN", christoffel, qd, qd)
    yield Measurement(
        "h: equals the sum of h_ijk qd_j qd_k",
        arm.name,
        float(np.abs(contracted - h).max()),
        bounds["coriolis_centrifugal"],
        "N m",
    )
    # d D / d q_k by central differences; derivatives of trigonometric polynomials of degree 2 in n angles
    # are at most 2^3 times the amplitude, so truncation is some 8 / 6 step^2 of D and round-off eps / step.
    gradient = _gradient(arm, q)
    truncation = float(np.abs(inertia).max()) * (8 / 6 * STEP**2 + 8 * EPS / STEP)
    expected = 0.5 * (
        np.einsum("keNij->Neijk", gradient)
        + np.einsum("jeNik->Neijk", gradient)
        - np.einsum("ieNjk->Neijk", gradient)
    )
    for e, effect in enumerate(dalembert.EFFECTS):
        yield Measurement(
            f"h_ijk, {effect}: equals the Christoffel symbols of D, {effect} (central differences)",
            arm.name,
            float(np.abs(expected[:, e] - christoffel[:, e]).max()),
            truncation,
            "kg m^2",
        )
        coriolis_matrix = np.einsum("Nijk,Nk->Nij", christoffel[:, e], qd)
        rate_of_inertia = np.einsum("kNij,Nk->Nij", gradient[:, e], qd)
        skew = rate_of_inertia - 2.0 * coriolis_matrix
        yield Measurement(
            f"dD/dt - 2 C, {effect}: skew (central differences)",
            arm.name,
            float(np.abs(skew + np.swapaxes(skew, 1, 2)).max()),
            2.0 * truncation * float(np.abs(qd).sum(axis=1).max()),
            "kg m^2/s",
        )


def _gradient(arm: gd.types.RobotArm, q: np.ndarray) -> np.ndarray:
    """Slopes of D by q_k, by effect, shape (k, effect, N, n, n)."""
    slopes = []
    for k in range(arm.n_joints):
        ends = []
        for sign in (1.0, -1.0):
            moved = q.copy()
            moved[:, k] += sign * STEP
            still = np.zeros_like(moved)
            ends.append(
                gd.tables.decompose_states(arm, gd.types.States(moved, still, still), christoffel=False)[
                    "inertia"
                ]
            )
        slopes.append(np.moveaxis((ends[0] - ends[1]) / (2.0 * STEP), 1, 0))
    return np.array(slopes)


def _end_effector_pose() -> Measurement:
    """[FGL87] Fig. 2.11 prints the end effector's position to 0.01 mm."""
    arm = gd.load_arm("puma560")
    pose = solve_kinematics(arm, np.radians([[90.0, 0.0, 90.0, 0.0, 0.0, 0.0]]).T)
    printed = np.array([-0.14909, 0.92112, 0.02032])
    return Measurement(
        "end effector position at (90, 0, 90, 0, 0, 0) degrees, [FGL87] Fig. 2.11",
        arm.name,
        float(np.abs(pose.link_origins[-1, :, 0] - printed).max()),
        0.5e-5,
        "m",
    )


def _two_link_closed_forms() -> Iterator[Measurement]:
    """[FGL87] section 3.4.2, with the masses and the length of the built-in arm."""
    arm = gd.load_arm("two_link")
    (m1, m2), length, g = arm.mass, arm.dh_table[0].a, float(np.linalg.norm(arm.gravity_vector))
    random = np.random.default_rng(1987)
    q, qd, qdd = random.uniform(-3.0, 3.0, (3, N_STATES, 2))
    ours = gd.tables.decompose_states(arm, gd.types.States(q, qd, qdd), drives=False)
    c1, c2, s2, c12 = np.cos(q[:, 0]), np.cos(q[:, 1]), np.sin(q[:, 1]), np.cos(q.sum(axis=1))
    d22 = np.full_like(c2, m2 * length**2 / 3)
    d12 = d22 + m2 * length**2 * c2 / 2
    d11 = (m1 + 4 * m2) * length**2 / 3 + m2 * length**2 * c2
    inertia = np.moveaxis(np.array([[d11, d12], [d12, d22]]), -1, 0)
    factor = m2 * s2 * length**2
    h = np.stack([-factor * (qd[:, 1] ** 2 / 2 + qd[:, 0] * qd[:, 1]), factor * qd[:, 0] ** 2 / 2], axis=1)
    c = g * length * np.stack([m1 * c1 / 2 + m2 * (c12 / 2 + c1), m2 * c12 / 2], axis=1)
    bounds = round_off_bounds(arm, q, qd, qdd)
    for quantity, closed, unit in (
        ("inertia", inertia, "kg m^2"),
        ("coriolis_centrifugal", h, "N m"),
        ("gravity_loading", c, "N m"),
    ):
        whole = ours[quantity] if quantity == "gravity_loading" else ours[quantity].sum(axis=1)
        yield Measurement(
            f"{SYMBOLS[quantity]}: equals the closed form of [FGL87] section 3.4.2",
            arm.name,
            float(np.abs(whole - closed).max()),
            bounds[quantity],
            unit,
        )
    yield Measurement(
        "h, rotation: identically zero, [FGL87] section 3.4.2",
        arm.name,
        float(np.abs(ours["coriolis_centrifugal"][:, 1]).max()),
        0.0,
        "N m",
    )


def report() -> str:
    """Write the measurements as Markdown: a row per identity, measured and bound per arm."""
    by_identity: dict[tuple[str, str], dict[str, Measurement]] = {}
    for row in measure():
        by_identity.setdefault((row.identity, row.unit), {})[row.arm] = row
    arms = gd.builtin_arms()
    lines = [
        "# Verification",
        "",
        "How exact D, h and c are: every identity that they must satisfy, measured on the built-in arms. Each run of the main",
        "job also compares its own trajectory with Pinocchio, prints the largest difference, and fails if it exceeds round-off.",
        "",
        f"In each cell: the largest difference over {N_STATES} random states within the arm's limits, and what round-off, or the",
        "truncation of a central difference, explains. Pinocchio and the closed forms give the sum of both effects. Entries of",
        "the Stanford arm's prismatic joint are in N, kg m and kg. `python analysis/verification.py` writes this page, and the",
        "tests measure the same. The digits measured vary with the machine.",
        "",
        f"| identity | unit | {' | '.join(arms)} |",
        f"|---|---|{'---|' * len(arms)}",
    ]
    for (identity, unit), rows in by_identity.items():
        cells = [f"{rows[arm].measured:.1e} ≤ {rows[arm].bound:.1e}" if arm in rows else "" for arm in arms]
        lines.append(f"| {identity} | {unit} | {' | '.join(cells)} |")
    lines.append("")
    return "\n".join(lines)


if __name__ == "__main__":
    Path(__file__).with_suffix(".md").write_text(report(), encoding="utf-8")
