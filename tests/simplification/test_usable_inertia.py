"""D, h and c of a model: D is a usable one, all three sum to the torque, the budget holds near the motion.

Everything is compared with Pinocchio, which shares no code with the search.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest

import gd_analyze as gd
from gd_analyze.dynamics.pinocchio_check import pinocchio_dynamics, round_off_bounds
from gd_analyze.simplification.harmonic import ENERGY, TERM
from gd_analyze.simplification.search import SearchOptions
from gd_analyze.simplification.simplify import simplify_exact
from gd_analyze.types import Drive, Joint, Link, Placement, RobotArm, SimplifiedModel
from long_cases import long
from recordings import swinging
from strategies import random_inertia

EPS = float(np.finfo(float).eps)
# A torque of some hundred terms, each of some ten factors, is summed in another order: some thousand
# roundings of the largest one. A term that is missing or stands twice differs by 1e-6 and more.
ROUND_OFF = 1e4 * EPS


def seven_joints(drives: bool) -> RobotArm:
    """Axes turned a quarter against each other, as those of most such arms, and links of any inertia."""
    rng = np.random.default_rng(7)
    joints, links = [], []
    for i in range(7):
        turn = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
        shift = [[0.0, 0.0, 0.3], [0.08, 0.0, 0.0]][i % 2]
        joints.append(Joint(f"{i + 1}", "revolute", Placement(turn if i % 2 else turn.T, np.array(shift))))
        com, inertia = rng.uniform(-0.08, 0.08, 3), 0.05 * 0.6**i * random_inertia(rng)
        links.append(Link(f"{i + 1}", 4.0 * 0.7**i, com, inertia))
    arm = RobotArm("seven", tuple(joints), tuple(links), np.array([0.0, 0.0, -9.81]))
    sizes = (0.5, 0.5, 0.4, 0.3, 0.1, 0.1, 0.05)
    return replace(arm, drives=tuple(Drive(inertia) for inertia in sizes)) if drives else arm


@dataclass(frozen=True)
class Case:
    arm: RobotArm
    motion: gd.Trajectory
    drives: bool
    budget: str = "1%"

    def inertia(self, q: np.ndarray) -> np.ndarray:
        """Pinocchio's D, and the drives'."""
        d = pinocchio_dynamics(self.arm, q, 0.0 * q, 0.0 * q)["inertia"]
        return d + np.diag(self.arm.drive_inertia) if self.drives else d

    def torque(self, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray) -> np.ndarray:
        """Pinocchio's torque, and the drives'."""
        links = pinocchio_dynamics(self.arm, q, qd, qdd)["torque"]
        return links + self.arm.drive_inertia * qdd if self.drives else links


def case_of(name: str) -> Case:
    if name.startswith("seven"):
        arm = seven_joints("with" in name)
        # Its last joint carries next to nothing, of which a share would be next to no torque.
        return Case(arm, swinging(arm, 40), "with" in name, "5% or 0.4")
    robot, motion, *without = name.split()
    arm = gd.load_arm(robot)
    if motion == "planned":
        box = gd.types.Box.of(arm)
        half = (box.upper - box.lower) / 2
        ends = box.centre - 0.3 * half, box.centre + 0.2 * half
        return Case(arm, gd.plan(arm, *ends, 4.0), arm.counts_drives(None))
    return Case(arm, gd.read_trajectory(motion, arm), arm.counts_drives(None) and not without)


NAMES = [
    "puma560 pick-and-place",
    long("puma560 pick-and-place without"),
    long("puma560 large-slew"),
    long("puma560 wrist-move"),
    long("stanford planned"),
    "scara planned",
    "two_link two-link-swing",
    long("seven with drives"),
    long("seven"),
]


@pytest.fixture(scope="module", params=NAMES)
def case(request) -> Case:
    return case_of(request.param)


@pytest.fixture(scope="module")
def tube(case) -> gd.types.Tube:
    return gd.types.Tube.along(case.arm, case.motion)


@pytest.fixture(scope="module")
def model(case) -> SimplifiedModel:
    return gd.simplify(case.arm, case.motion, case.budget, drives=case.drives)


def drawn_in(tube: gd.types.Tube, count: int, corners: bool = False) -> np.ndarray:
    """States q, qd, qdd of a tube, at random or at the corners of its pieces, shape (3, count, n)."""
    rng = np.random.default_rng(5)
    lower, upper, _ = tube.pieces(count, rng)
    return np.where(rng.random(lower.shape) < 0.5, lower, upper) if corners else rng.uniform(lower, upper)


def gammas_of(inertia: np.ndarray, simplified: np.ndarray) -> np.ndarray:
    """|Eigenvalues of D^-1 Ds - I|, the largest at every position, by the symmetric problem of D = L L^T."""
    inverse = np.linalg.inv(np.linalg.cholesky(inertia))
    change = inverse @ simplified @ inverse.swapaxes(1, 2) - np.eye(inertia.shape[1])
    return np.abs(np.linalg.eigvalsh((change + change.swapaxes(1, 2)) / 2)).max(axis=1)


def test_its_inertia_is_symmetric_in_the_torque_itself(case, model, tube):
    """D as a function is so by its form; here it is what accelerations do in the program of the torque."""
    q, still = drawn_in(tube, 50)[0], np.zeros((50, case.arm.n_joints))
    at_rest = model.torque(q, still, still)
    columns = [model.torque(q, still, still + unit) - at_rest for unit in np.eye(case.arm.n_joints)]
    inertia = np.stack(columns, axis=2)
    # The difference of two torques has the roundings of gravity.
    slack = ROUND_OFF * max(np.abs(inertia).max(), np.abs(at_rest).max())
    assert np.abs(inertia - inertia.swapaxes(1, 2)).max() <= slack
    assert np.abs(inertia - model.inertia(q)).max() <= slack
    np.testing.assert_array_equal(model.inertia(q), model.inertia(q).swapaxes(1, 2))


def test_no_diagonal_element_is_zero(case, model, tube):
    q = drawn_in(tube, 2000)[0]
    simplified, exact = model.inertia(q), case.inertia(q)
    diagonal, whole = (np.einsum("nii->ni", each) for each in (simplified, exact))
    # As x^T Ds x is at least 1 - gamma times x^T D x, for every unit vector x, too.
    least = (1.0 - gammas_of(exact, simplified))[:, None] * whole
    assert (diagonal >= least - ROUND_OFF * whole.max()).all()
    assert (diagonal > 0.0).all()
    assert model.level is TERM


def test_it_is_positive_definite_against_pinocchio(case, model, tube):
    q = np.concatenate([drawn_in(tube, 1000)[0], drawn_in(tube, 1000, corners=True)[0], case.motion.q])
    gammas = gammas_of(case.inertia(q), model.inertia(q))
    assert gammas.max() < 1.0
    assert not model.is_torque_only
    # The stated one is the largest of the set points' and of 1000 positions drawn near them.
    assert gammas[2000:].max() <= model.accuracy.gamma * (1.0 + 1e-6) + ROUND_OFF
    shown = gd.certify_positive_definite(model, tube)
    values = np.linalg.eigvalsh(model.inertia(q))
    assert 0.0 < shown.proven <= values.min()


def test_d_h_and_c_sum_to_the_torque(case, model, tube):
    q, qd, qdd = drawn_in(tube, 500)
    parts = np.einsum("nij,nj->ni", model.inertia(q), qdd)
    parts = np.stack([parts, model.coriolis_centrifugal(q, qd), model.gravity_loading(q)])
    slack = ROUND_OFF * np.abs(parts).max()
    assert np.abs(parts.sum(axis=0) - model.torque(q, qd, qdd)).max() <= slack


def test_the_budget_holds_near_the_motion(case, model, tube):
    """By Pinocchio's torques at 20 000 states, half of them at corners, and at the set points."""
    states = np.concatenate([drawn_in(tube, 10_000), drawn_in(tube, 10_000, corners=True)], axis=1)
    set_points = np.stack([case.motion.q, case.motion.qd, case.motion.qdd])
    states = np.concatenate([states, set_points], axis=1)
    exact = case.torque(*states)
    error = np.abs(model.torque(*states) - exact).max(axis=0)
    share = float(case.budget.split("%")[0]) / 100
    amount = float(case.budget.split()[-1]) if "or" in case.budget else 0.0
    allowed = np.maximum(share * np.abs(exact[20_000:]).max(axis=0), amount)
    slack = round_off_bounds(case.arm, *states)["torque"]
    assert (error <= allowed + slack).all()
    np.testing.assert_allclose(model.accuracy.allowed, allowed, rtol=1e-9)
    # What saves operations makes an error, and what is exact none.
    assert model.saves == bool((error > slack).any())


@pytest.mark.parametrize("level", [TERM, ENERGY], ids=str)
@pytest.mark.parametrize(
    ("drives", "budget"), [(True, "1%"), long(False, "10%"), long(True, "10%"), long(False, "1%")]
)
def test_gamma_at_the_states_of_a_search_is_what_it_is(puma, pick_and_place, level, drives, budget):
    """Where no states but those are drawn, it is a number that can be recomputed."""
    exact = gd.types.ExactDynamics.of(puma, pick_and_place, drives)
    model = simplify_exact(exact, budget, SearchOptions(level, effort=0.2))
    case = Case(puma, pick_and_place, drives)
    gamma = gammas_of(case.inertia(pick_and_place.q), model.inertia(pick_and_place.q)).max()
    # Without drives D is divided by 1e-5 of its largest element.
    assert model.accuracy.gamma == pytest.approx(gamma, rel=1e-6, abs=1e-9)
    assert gamma < 1.0


@pytest.mark.slow
def test_an_arm_of_seven_joints_without_drives_has_a_usable_inertia():
    """Chosen by torque alone, its D would not be: light directions are differences of large terms."""
    case = case_of("seven")
    model = simplify_exact(
        gd.types.ExactDynamics.of(case.arm, case.motion), "5% or 0.5", SearchOptions(effort=0.1)
    )
    assert gammas_of(case.inertia(case.motion.q), model.inertia(case.motion.q)).max() < 1.0
    assert not model.is_torque_only
