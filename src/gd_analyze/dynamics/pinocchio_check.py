"""Check every run against an independent implementation: Pinocchio on the same arm."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import GdAnalyzeError, require_type
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.parts import Placement
from gd_analyze.schema import quantity_units, require_table

if TYPE_CHECKING:
    import xarray as xr

# Enough to cover every region of a long trajectory, few enough to take milliseconds.
MOST_SET_POINTS = 500

COMPARED_QUANTITIES = ("inertia", "coriolis_centrifugal", "gravity_loading", "torque")


@dataclass(frozen=True)
class Residual:
    """Largest difference from Pinocchio, and the bound that round-off explains."""

    quantity: str
    largest: float
    bound: float
    unit: str


def cross_check(arm: RobotArm, dataset: xr.Dataset) -> tuple[Residual, ...]:
    """Compare D, h, c and torque with Pinocchio's crba, rnea and computeGeneralizedGravity.

    Beyond `MOST_SET_POINTS` set points, that many evenly spaced ones are compared.

    Parameters
    ----------
    arm, dataset
        The arm, and its `decompose`.

    Returns
    -------
    tuple of Residual
        One per quantity and, for joints of both kinds, per unit of its entries.

    Raises
    ------
    GdAnalyzeError
        If a difference exceeds the round-off bound: then one of the two programs is wrong.
    """
    require_type(arm, RobotArm, "arm", "a RobotArm, as `load_arm` returns it")
    require_table(dataset, "decomposition", "decompose")
    count = dataset.sizes["time"]
    chosen = np.unique(np.linspace(0, count - 1, min(count, MOST_SET_POINTS)).round().astype(int))
    part = dataset.isel(time=chosen)
    states = [part[name].values for name in ("q", "qd", "qdd")]
    computed = {
        "inertia": part.inertia.sum("effect").values,
        "coriolis_centrifugal": part.coriolis_centrifugal.sum("effect").values,
        "gravity_loading": part.gravity_loading.values,
        "torque": part.torque.values - (part.drive_torque.values if "drive_torque" in part else 0.0),
    }
    bounds = round_off_bounds(arm, *states)
    residuals = []
    for name, reference in pinocchio_dynamics(arm, *states).items():
        difference = np.abs(computed[name] - reference)
        units = quantity_units("inertia" if name == "inertia" else "effort", arm.is_revolute)
        for unit in dict.fromkeys(units.ravel().tolist()):
            largest = float(difference[..., units == unit].max())
            residuals.append(Residual(name, largest, bounds[name], unit))
    for residual in residuals:
        if not residual.largest <= residual.bound:
            raise GdAnalyzeError(
                f"{residual.quantity} disagrees with Pinocchio",
                where=f"arm {arm.name}",
                expected=f"a difference of at most {residual.bound:.1e} {residual.unit} (round-off)",
                found=f"{residual.largest:.1e} {residual.unit}",
                next_step="please report this with the arm file and the trajectory",
            )
    return tuple(residuals)


def round_off_bounds(arm: RobotArm, q: FloatArray, qd: FloatArray, qdd: FloatArray) -> dict[str, float]:
    """Largest difference of two correct programs in each quantity, over the given states.

    A coordinate of link s passes some 10 roundings per joint on its way to the base, and a moment of the
    composite consists of products of two such coordinates: 2 * 10 n roundings, and twice as many for two
    programs. With u = eps / 2 the difference is at most 40 n u = 20 n eps of the summed magnitudes of the
    summands, which are largest with the arm stretched out: sum_s m_s L^2 + |I_s| for D, the same times the
    squared sum of velocities for h (every h_i sums all j, k), sum_s m_s L |g| for c. A prismatic joint's rows
    have L once or not at all, hence max(L, 1).
    """
    travel = np.abs(np.where(arm.is_revolute, 0.0, q)).sum(axis=-1).max()
    com_reach = max(float(np.linalg.norm(com)) for com in arm.com)
    first = float(np.linalg.norm(arm.joints[0].placement.translation))
    reach = max(arm.reach + com_reach + travel + first, 1.0)
    inertia = float((arm.mass * reach**2 + np.abs(arm.inertia_com).sum(axis=(1, 2))).sum())
    velocities = float(np.abs(qd).sum(axis=-1).max())
    accelerations = float(np.abs(qdd).sum(axis=-1).max())
    gravity = float(arm.mass.sum() * reach * np.linalg.norm(arm.gravity_vector))
    unit = 20 * arm.n_joints * np.finfo(float).eps
    # Newton-Euler gives h as a difference of torques with gravity, so it contains gravity's round-off.
    h = inertia * velocities**2 + gravity
    return {
        "inertia": unit * inertia,
        "coriolis_centrifugal": unit * h,
        "gravity_loading": unit * gravity,
        "torque": unit * (inertia * accelerations + h),
    }


def pinocchio_dynamics(
    arm: RobotArm, q: FloatArray, qd: FloatArray, qdd: FloatArray
) -> dict[str, FloatArray]:
    """D, h, c and torque at states (N, n) by Pinocchio, not split by effect."""
    import pinocchio as pin

    model = pinocchio_model(arm)
    data = model.createData()
    quantities: dict[str, list[FloatArray]] = {name: [] for name in COMPARED_QUANTITIES}
    for position, velocity, acceleration in zip(*map(np.ascontiguousarray, (q, qd, qdd)), strict=True):
        upper = np.triu(pin.crba(model, data, position))
        gravity = pin.computeGeneralizedGravity(model, data, position).copy()
        steady = pin.rnea(model, data, position, velocity, np.zeros(arm.n_joints)).copy()
        torque = pin.rnea(model, data, position, velocity, acceleration).copy()
        state = (upper + np.triu(upper, 1).T, steady - gravity, gravity, torque)
        for name, value in zip(COMPARED_QUANTITIES, state, strict=True):
            quantities[name].append(value)
    return {name: np.array(values) for name, values in quantities.items()}


def pinocchio_model(arm: RobotArm) -> Any:
    """Build the arm as a `pinocchio.Model`, joint by joint."""
    import pinocchio as pin

    def placed(placement: Placement) -> Any:
        return pin.SE3(np.array(placement.rotation), np.array(placement.translation))

    model = pin.Model()
    model.name = arm.name
    model.gravity.linear = np.array(arm.gravity_vector)
    parent, behind = 0, pin.SE3.Identity()
    for i, (joint, link) in enumerate(zip(arm.joints, arm.links, strict=True)):
        unaligned = getattr(pin, f"JointModel{joint.kind.capitalize()}Unaligned")
        moving, placement = unaligned(np.array(joint.axis)), behind * placed(joint.placement)
        parent = model.addJoint(parent, moving, placement, f"joint_{i + 1}")
        behind = placed(link.frame)
        # Pinocchio refuses to construct a physically inconsistent inertia.
        body = pin.Inertia(link.mass, np.array(link.com), np.eye(3))
        body.inertia = np.array(link.inertia_com)
        model.appendBodyToJoint(parent, body, behind)
    return model
