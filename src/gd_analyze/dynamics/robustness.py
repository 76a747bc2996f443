"""How sure verdicts are, given how well the arm's inertial parameters are known.

D and h are linear in every link's mass, first moment and inertia about its frame's origin. Of these the point
mass m at r, whose inertia is m (r.r 1 - r r^T), makes the translational parts; the rest of the inertia, that
about the centre of mass, makes the rotational parts. So sampled arms are one product of matrices.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from gd_analyze.arrays import Array, FloatArray
from gd_analyze.dynamics.base_parameters import inertial_parameters, parameters_of, regressor
from gd_analyze.dynamics.dominance import DOMINANCE_THRESHOLD, Element, elements
from gd_analyze.errors import ArmError
from gd_analyze.motions.limits import require_joints
from gd_analyze.motions.pool import GivenMotions, trajectory_of
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.catalogue import arm_of
from gd_analyze.robots.parts import Link, second_moment
from gd_analyze.robots.uncertainty import exactly_known, with_uncertainty
from gd_analyze.schema import table

if TYPE_CHECKING:
    import xarray as xr

VERDICTS = ("translation", "rotation", "both", "neither")

# Of a longer motion set points are taken evenly: verdicts cost time by samples times set points.
_MOST_SET_POINTS = 500
# Counts of a block fit into bytes, and its arrays into the cache.
_BLOCK = 255
# Samples of a link drawn in vain before its uncertainty is refused, per sample asked for.
_PATIENCE = 100


def robustness(
    arm: RobotArm | str | Path,
    trajectory: GivenMotions,
    uncertainty: str | None = None,
    *,
    threshold: float = DOMINANCE_THRESHOLD,
    samples: int = 10_000,
    seed: int = 0,
) -> xr.Dataset:
    """Probability of each verdict on each element of D and h, at each set point and over the motion.

    The uncertain parameters are drawn independently from normal distributions. A sampled link that is
    physically inconsistent is drawn again, unless the link as given is inconsistent or a limiting case, such
    as a point mass.

    Parameters
    ----------
    arm, trajectory
        The arm and its motion; or a shipped name, or the path of a file.
    uncertainty
        Standard uncertainties of all links instead of those the arm states: "mass=5%,com=2mm,inertia=10%".
    threshold
        As of `rank`.
    samples
        Arms that are drawn.
    seed
        Of the draws.

    Returns
    -------
    xarray.Dataset
        `probability` (element, time, verdict) and `over_motion` (element, verdict), each summing to one
        along `verdict`, and `redrawn` (link), how many samples were inconsistent. The attribute
        `exactly_known` names the parameters without uncertainty. Of a motion of more than 500 set points
        500 are taken evenly.

    Raises
    ------
    ArmError
        If no uncertainty is stated, or it is so large that hardly any sample is physically consistent.
    UsageError
        If the text for the uncertainty cannot be read.
    TrajectoryError
        If the trajectory is of another number of joints.
    """
    arm = arm_of(arm)
    trajectory = trajectory_of(trajectory, arm)
    require_joints(trajectory, arm)
    if uncertainty is not None:
        arm = with_uncertainty(arm, uncertainty)
    drawn = Drawn.from_arm(arm, samples, np.random.default_rng(seed))
    count = len(trajectory.time)
    taken = np.unique(np.linspace(0, count - 1, min(count, _MOST_SET_POINTS)).round().astype(int))
    per_unit = elements_per_unit(arm, trajectory.q[taken].T, trajectory.qd[taken].T)
    at_set_points, over_motion = _verdicts(arm, per_unit, drawn, threshold)
    return table(
        "robustness",
        {"probability": at_set_points, "over_motion": over_motion, "redrawn": drawn.redrawn},
        arm.is_revolute,
        {
            "element": [element.label for element in _judged(arm)],
            "time": ("time", trajectory.time[taken], {"units": "s"}),
            "verdict": list(VERDICTS),
            "link": np.arange(1, arm.n_joints + 1),
        },
        {
            "threshold": float(threshold),
            "samples": samples,
            "seed": seed,
            "exactly_known": exactly_known(arm),
            "arm": arm.name,
            "trajectory": trajectory.name,
        },
    )


def elements_per_unit(arm: RobotArm, q: Array, qd: Array) -> FloatArray:
    """Elements of D and h per unit of every link's `PARAMETERS`, shape (elements, N, n links, 10).

    Joint i's torque is D_ij where only joint j accelerates, and h_i where none does.
    """
    n, count = q.shape
    weightless = replace(arm, gravity=np.zeros(3))
    velocities = np.concatenate([np.zeros((n, n * count)), qd], axis=1)
    accelerations = np.concatenate([np.repeat(np.eye(n), count, axis=1), np.zeros((n, count))], axis=1)
    torques = regressor(weightless, np.tile(q, n + 1), velocities, accelerations)
    torques = torques.reshape(n, n, -1, n + 1, count)
    rows = [torques[e.i, :, :, n if e.j is None else e.j] for e in _judged(arm)]
    return np.moveaxis(np.array(rows), -1, 1)


@dataclass(frozen=True)
class Drawn:
    """Sampled parameters of every link, as `parameters_of` gives them for the effect's part of the matter."""

    by_effect: tuple[FloatArray, FloatArray]  # translation, rotation: (samples, n links, 10)
    redrawn: Array  # inconsistent samples of every link, (n links,)

    @classmethod
    def from_arm(cls, arm: RobotArm, samples: int, rng: np.random.Generator) -> Drawn:
        """Draw arms; ArmError where nothing is uncertain, or hardly a sample is consistent."""
        if all(link.uncertainty is None for link in arm.links):
            raise ArmError(
                f"arm {arm.name} states no uncertainty of its links",
                where=f"arm {arm.name}",
                next_step="give one, such as mass=5%,com=2mm,inertia=10%, or state it in the arm file",
            )
        links = [
            _drawn(link, nominal, samples, rng)
            for link, nominal in zip(arm.links, parameters_of(arm), strict=True)
        ]
        translation, rotation = (np.stack([link[e] for link in links], axis=1) for e in (0, 1))
        return cls((translation, rotation), np.array([link[2] for link in links]))


def _drawn(
    link: Link, nominal: FloatArray, samples: int, rng: np.random.Generator
) -> tuple[FloatArray, FloatArray, int]:
    """Sampled parameters of a link by effect, each (samples, 10), and how many samples were drawn again."""
    moment = np.linalg.eigvalsh(second_moment(link.inertia_com))
    is_checked = link.mass > 0.0 and moment[0] > 1e-9 * moment[-1]
    of_points, of_matter = np.empty((2, samples, 10))
    missing, redrawn = np.arange(samples), 0
    while missing.size:
        drawn = _of_one(link, nominal, missing.size, rng)
        of_points[missing] = point_masses(drawn)
        of_matter[missing] = drawn - of_points[missing]
        of_matter[missing, :4] = 0.0
        good = _is_consistent(drawn, of_matter[missing]) if is_checked else np.full(missing.size, True)
        missing = missing[~good]
        redrawn += missing.size
        if redrawn > _PATIENCE * samples:
            raise ArmError(
                f"hardly a sample of link {link.name} is physically consistent",
                where=link.place,
                found=f"{redrawn} inconsistent samples",
                next_step="state a smaller uncertainty of its mass, centre of mass or inertia",
            )
    return of_points, of_matter, redrawn


def _of_one(link: Link, nominal: FloatArray, count: int, rng: np.random.Generator) -> FloatArray:
    """Draw parameters of a link, consistent or not, shape (count, 10)."""
    stated = link.uncertainty
    out = np.tile(nominal, (count, 1))
    if stated is None:
        return out
    mass = link.mass if stated.body_mass is None else stated.body_mass
    com = link.com if stated.body_com is None else stated.body_com
    body = np.concatenate([[mass], mass * com, np.zeros(6)])
    masses = rng.normal(mass, stated.mass or 0.0, count)
    coms = rng.normal(com, 0.0 if stated.com is None else stated.com, (count, 3))
    drawn = np.concatenate([masses[:, None], masses[:, None] * coms, np.zeros((count, 6))], axis=1)
    out[:, :4] += drawn[:, :4] - body[:4]
    if stated.inertia_about == "com":
        out[:, 4:] += point_masses(drawn)[:, 4:] - point_masses(body[None])[:, 4:]
    if stated.inertia is not None:
        spread = inertial_parameters(0.0, np.zeros(3), stated.inertia)[4:]
        out[:, 4:] += rng.normal(0.0, spread, (count, 6))
    return out


def point_masses(parameters: FloatArray) -> FloatArray:
    """Parameters of the point masses with the mass and the first moment of these, shape (..., 10)."""
    out = parameters.copy()
    mass, first = parameters[..., :1], parameters[..., 1:4]
    x, y, z = np.moveaxis(first / np.sqrt(np.where(mass > 0.0, mass, np.inf)), -1, 0)
    out[..., 4:] = np.stack([y * y + z * z, -x * y, x * x + z * z, -x * z, -y * z, x * x + y * y], axis=-1)
    return out


def _is_consistent(parameters: FloatArray, of_matter: FloatArray) -> Array:
    """Whether mass and second moment about the centre of mass are positive definite, shape (count,)."""
    xx, xy, yy, xz, yz, zz = of_matter[:, 4:].T
    half = 0.5 * (xx + yy + zz)
    a, b, c = half - xx, half - yy, half - zz
    # Leading minors of the second moment tr(I)/2 - I (Sylvester).
    determinant = a * b * c - 2 * xy * xz * yz - a * yz**2 - b * xz**2 - c * xy**2
    return (parameters[:, 0] > 0.0) & (a > 0.0) & (a * b > xy**2) & (determinant > 0.0)


def _verdicts(
    arm: RobotArm, per_unit: FloatArray, drawn: Drawn, threshold: float
) -> tuple[FloatArray, FloatArray]:
    """Probabilities of `VERDICTS` at every set point (elements, N, 4), and over the motion (elements, 4)."""
    n_elements, count = per_unit.shape[:2]
    flat = per_unit.reshape(n_elements * count, -1)
    fixed, changes, columns = [], [], []
    for parameters in drawn.by_effect:
        sampled = parameters.reshape(len(parameters), -1)
        nominal = sampled.mean(axis=0)
        varies = np.ptp(sampled, axis=0) > 0.0
        fixed.append((flat @ np.where(varies, nominal, sampled[0])).reshape(n_elements, count, 1))
        changes.append((sampled - nominal)[:, varies].T.copy())
        columns.append(flat[:, varies].copy())
    # As in `rank`: round-off must not make an element that is zero look like one of both effects.
    largest = np.abs(fixed[0] + fixed[1]).max(axis=(1, 2))
    is_inertia = np.array([element.quantity == "inertia" for element in _judged(arm)])
    noise = (
        64
        * np.finfo(float).eps
        * np.where(is_inertia, *(largest[k].max() for k in (is_inertia, ~is_inertia)))
    )
    at_set_points = np.zeros((n_elements, count, 3))
    over_motion = np.zeros((n_elements, 3))
    samples = len(drawn.by_effect[0])
    for start in range(0, samples, _BLOCK):
        block = slice(start, start + _BLOCK)
        parts = [
            (column @ change[:, block]).reshape(n_elements, count, -1) + mean
            for column, change, mean in zip(columns, changes, fixed, strict=True)
        ]
        whole = np.abs(parts[0] + parts[1]).max(axis=1)
        least = np.maximum(threshold * whole, noise[:, None])[:, None]
        needed = [np.abs(part) > least for part in parts]
        for out, flags in ((at_set_points, needed), (over_motion, [flag.any(axis=1) for flag in needed])):
            for k, flag in enumerate((*flags, flags[0] & flags[1])):
                out[..., k] += np.add.reduce(flag.view(np.uint8), axis=-1, dtype=np.uint8)
    return _by_verdict(at_set_points, samples) / samples, _by_verdict(over_motion, samples) / samples


def _by_verdict(needed: FloatArray, samples: int) -> FloatArray:
    """Samples of each of `VERDICTS` from those in which translation, rotation and both are needed."""
    translation, rotation, both = np.moveaxis(needed, -1, 0)
    return np.stack([translation - both, rotation - both, both, samples - translation - rotation + both], -1)


def _judged(arm: RobotArm) -> list[Element]:
    """Elements of D and h; gravity loading has one part only."""
    return [element for element in elements(arm.n_joints) if element.quantity != "gravity_loading"]
