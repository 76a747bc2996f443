"""An estimate as an arm: its base parameters, their covariance, links, drives and friction, and a payload."""

from __future__ import annotations

import datetime
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.diagnosis.answer import IDENTIFIED
from gd_analyze.dynamics.base_parameters import base_parameters
from gd_analyze.dynamics.drivetrain import rubbing
from gd_analyze.identification.estimate import SIGMAS, Estimate, start_of
from gd_analyze.identification.identification import IdentifiedParameter
from gd_analyze.identification.rows import Unknowns
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.parts import Drive, of_point_mass, symmetric_tensor
from gd_analyze.text import with_error


def base_matrix(arm: RobotArm) -> tuple[list[tuple[str, str, int]], FloatArray]:
    """Symbol, unit and link of every base parameter, drives included, and its coefficients.

    The coefficients are for `parameters_of` and the drives' inertia, in the order of `Unknowns`: (k, 11 n).
    """
    base = base_parameters(arm, drives=True)
    of_drives = np.zeros((len(base), arm.n_joints))
    for k, parameter in enumerate(base):
        for share in parameter.combination:
            if share.kind == "J":
                of_drives[k, share.link - 1] += share.coefficient
    names = [(parameter.symbol, parameter.unit, parameter.link) for parameter in base]
    return names, np.hstack([base.matrix.reshape(len(base), -1), of_drives])


def base_of(
    arm: RobotArm, estimate: Estimate, values: FloatArray, unknowns: Unknowns
) -> tuple[IdentifiedParameter, ...]:
    """Base parameters: of the file, by least squares, identified, with errors, and whether identifiable."""
    names, matrix = base_matrix(arm)
    inertial = slice(0, unknowns.of_drives.stop)
    file, plain, identified = (matrix @ x[inertial] for x in (estimate.start, estimate.values, values))
    spreads = estimate.deviations[:, inertial], estimate.open[:, inertial]
    variance, open_variance = (np.square(spread @ matrix.T).sum(axis=0) for spread in spreads)
    size = np.sqrt(np.square(matrix * estimate.sizes[inertial]).sum(axis=1))
    shows = SIGMAS * np.sqrt(open_variance) <= size
    errors = np.sqrt(np.where(shows, variance, variance + open_variance))
    # Less than its error may be nothing at all.
    identifiable = shows & (np.abs(identified) >= errors)
    return tuple(
        IdentifiedParameter(
            *name,
            float(file[k]),
            float(plain[k]),
            float(identified[k]),
            float(errors[k]),
            float(size[k]),
            bool(identifiable[k]),
        )
        for k, name in enumerate(names)
    )


def spread_of(arm: RobotArm, estimate: Estimate, unknowns: Unknowns) -> FloatArray:
    """Rows whose squares add up to the covariance of links and drives, (k, n, 11).

    Directions on which no torque depends are not uncertain: the split of sums among links is the file's.
    """
    matrix = base_matrix(arm)[1]
    sizes = estimate.sizes[: matrix.shape[1]]
    acting = np.linalg.svd(matrix * sizes, full_matrices=False)[2]
    rows = np.vstack([estimate.deviations, estimate.open])[:, : matrix.shape[1]] / sizes
    strength, directions = np.linalg.svd(rows @ acting.T, full_matrices=False)[1:]
    spread = strength[:, None] * (directions @ acting) * sizes
    n = arm.n_joints
    return np.concatenate([spread[:, : 10 * n].reshape(-1, n, 10), spread[:, 10 * n :, None]], axis=2)


def identified_arm(
    arm: RobotArm, values: FloatArray, spread: FloatArray, unknowns: Unknowns, sources: str
) -> RobotArm:
    """The arm with identified numbers."""
    links, drives = [], []
    bodies, inertias = values[unknowns.of_links].reshape(-1, 10), values[unknowns.of_drives]
    for link, (mass, *moments) in zip(arm.links, bodies, strict=True):
        com = np.array(moments[:3]) / (mass or 1.0)
        xx, xy, yy, xz, yz, zz = moments[3:]
        about_com = symmetric_tensor(xx, yy, zz, xy, xz, yz) - of_point_mass(mass, com)
        links.append(
            replace(
                link,
                mass=float(mass),
                com=com,
                inertia_com=about_com,
                uncertainty=None,
                as_measured=False,
                axial_only=False,
                bare=None,
            )
        )
    friction = values[unknowns.of_friction].reshape(-1, 3)
    for drive, inertia, (coulomb, viscous, offset) in zip(
        arm.drives or (Drive(),) * arm.n_joints, inertias, friction, strict=True
    ):
        driven = replace(drive, inertia=float(inertia), inertia_uncertainty=None)
        drives.append(rubbing(driven, float(coulomb), float(viscous), float(offset)))
    return replace(
        arm,
        links=tuple(links),
        drives=tuple(drives),
        spread=spread,
        sources=(*arm.sources, sources),
        assumptions=(*arm.assumptions, _ASSUMED.format(start_of(arm))),
        # Doubts about the links are obsolete.
        doubts=tuple(text for text in arm.doubts if "mass" not in text and "inertia" not in text),
    )


_ASSUMED = (
    "Only the base parameters follow from torque: their split into masses, centres of mass and inertias, "
    "and parameters without effect on torque, are as near to those of the {} as physical consistency allows."
)


def sources_of(
    arm: RobotArm,
    fitted: Sequence[Trajectory],
    loaded: Sequence[Trajectory],
    held_out: Sequence[Trajectory],
    parameters: Sequence[IdentifiedParameter],
) -> str:
    """State day, logs with fingerprints, standard errors, and parameters that the logs do not tell."""
    roles = (("", fitted), (", with a payload", loaded), (", held out", held_out))
    logs = [
        f"{log.name}{role} (SHA-256 {log.fingerprint[:16]})" for role, motions in roles for log in motions
    ]
    unidentifiable = ", ".join(parameter.symbol for parameter in parameters if not parameter.identifiable)
    note = (
        f" Not identifiable, kept near the values of the {start_of(arm)}: {unidentifiable}."
        if unidentifiable
        else ""
    )
    identifiable = (parameter for parameter in parameters if parameter.identifiable)
    errors = ", ".join(f"{x.symbol} {with_error(x.value, x.error)} {x.unit}" for x in identifiable)
    day = datetime.date.today().isoformat()
    return f"{IDENTIFIED} on {day} from {'; '.join(logs)}. Standard errors: {errors}.{note}"


def payload_of(arm: RobotArm, body: FloatArray, deviations: FloatArray) -> FloatArray:
    """Mass and centre of mass in the frame of the tip, and their standard errors, (2, 4)."""
    mass, com = body[0], body[1:4] / body[0]
    turn, shift = arm.tip_frame.rotation, arm.tip_frame.translation
    moved = (deviations[:, 1:4] - deviations[:, :1] * com) / mass @ turn
    errors = np.sqrt(np.square(np.hstack([deviations[:, :1], moved])).sum(axis=0))
    return np.array([[mass, *(turn.T @ (com - shift))], errors])
