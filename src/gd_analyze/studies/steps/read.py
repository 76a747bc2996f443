"""The first step of the main job: read an arm and a motion, and refuse those that do not fit together."""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from gd_analyze.certification.tube import Tube
from gd_analyze.diagnosis.answer import is_identified
from gd_analyze.dynamics.decomposition import MOST_KEPT
from gd_analyze.errors import TrajectoryError, warn_caller
from gd_analyze.motions.limits import check_against_arm
from gd_analyze.motions.margin import Margin
from gd_analyze.motions.measured import has_torques, require_torques
from gd_analyze.motions.pool import GivenMotions, taken_apart, trajectory_of
from gd_analyze.motions.read import read_trajectory
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.progress import Progress
from gd_analyze.results.findings import provenance_of_run
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.catalogue import arm_with_masses
from gd_analyze.robots.description import describe
from gd_analyze.robots.plausibility import warn_of_implausible
from gd_analyze.robots.uncertainty import StatedUncertainty, with_uncertainty
from gd_analyze.simplification.budget import ReferenceTorques
from gd_analyze.studies.settings import Settings


@dataclass(frozen=True, eq=False)
class RunInputs:
    """What the main job works on: an arm, a motion and settings."""

    arm: RobotArm
    trajectory: Trajectory
    settings: Settings
    source: dict[str, str]  # origin of the results
    tube: Tube  # states near the motion
    has_tube: bool  # whether these are known

    @property
    def stored_parts(self) -> dict[str, Any]:
        """Options of a decomposition that is stored."""
        settings, christoffel = self.settings, self.settings.christoffel
        if christoffel is None:
            christoffel = self.trajectory.n_set_points <= MOST_KEPT
        return {
            "by_link": settings.by_link,
            "terms": settings.terms,
            "drives": settings.drives,
            "christoffel": christoffel,
        }


def read_step(
    arm: RobotArm | str | Path,
    trajectory: GivenMotions,
    settings: Settings,
    command: str,
    progress: Progress,
) -> RunInputs:
    """Read the inputs, and refuse those that do not fit together."""
    arm = arm_with_masses(arm)
    if isinstance(settings.uncertainty, StatedUncertainty):
        arm = with_uncertainty(arm, settings.uncertainty)
    motion = trajectory_of(trajectory, arm, partial(read_trajectory, progress=progress))
    if settings.fit_friction:
        require_torques(motion)
    no_torque = np.zeros(arm.n_joints)
    of_log = no_torque if has_torques(motion) else None
    # A budget that does not fit fails.
    settings.asked.allowed(ReferenceTorques(arm, no_torque, no_torque, of_log))
    tube, has_tube = _tube_along(arm, motion, Margin.of(settings.margin))
    return RunInputs(arm, motion, settings, source_of(arm, motion, settings, command), tube, has_tube)


def warn_of_inputs(inputs: RunInputs) -> None:
    """Warn of an arm that is not plausible, and of a motion that the arm cannot follow."""
    warn_of_implausible(inputs.arm)
    for motion in taken_apart(inputs.trajectory):
        check_against_arm(motion, inputs.arm)
    if inputs.trajectory.n_stated == 1:
        warn_caller(
            f"trajectory {inputs.trajectory.name} is one set point: verdicts, ranking and model are of this "
            "state and its surroundings; what other states need, or anything over time, takes a motion"
        )


_FILE = re.compile(r"\S+\.\w+")


def source_of(arm: RobotArm, trajectory: Trajectory, settings: Settings, command: str = "") -> dict[str, str]:
    """Origin of the results; the inputs and what the results state of the motion mark the run."""
    motions = [motion.name for motion in trajectory.motions]
    # Two files may describe robots of one name: a source begins with its file's.
    files = [name for name in (text.partition(":")[0] for text in arm.sources) if _FILE.fullmatch(name)]
    robot = [arm.name, *files, *(["identified"] if is_identified(arm) else [])]
    inputs = [*robot, trajectory.name, settings.described, *motions]
    motion = [trajectory.fingerprint, trajectory.origin, trajectory.derivatives_from]
    return provenance_of_run(command, inputs, [describe(arm), motion], repeats=True)


def _tube_along(arm: RobotArm, motion: Trajectory, margin: Margin) -> tuple[Tube, bool]:
    """Enclose a motion in a tube; if that fails, return a tube without known states, and False."""
    try:
        return Tube.along(arm, motion, margin), True
    except TrajectoryError as error:
        # Statements about the set points themselves remain true.
        unknown = np.full((1, 3, arm.n_joints), np.nan)
        margins, note = margin.along(arm, motion), f"Not certified: {error.what} ({error.details['where']})."
        return Tube(unknown, unknown, motion.time[:1], motion.time[-1:], margins, motion.name, 0, note), False
