"""Whether a simplified model is good enough to control its arm along a motion."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.dynamics.energy import kinetic_energy, potential_energy
from gd_analyze.errors import ArmError, GdAnalyzeWarning
from gd_analyze.motions.checks import check_against_arm, require_joints
from gd_analyze.motions.pool import trajectory_of
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.results.provenance import provenance_of_run
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.description import describe_in_full
from gd_analyze.simplification.evaluation import require_arm
from gd_analyze.simplification.exact import ExactDynamics
from gd_analyze.simplification.exact_form import ExactForm
from gd_analyze.simplification.model import SimplifiedModel
from gd_analyze.studies.bounds import (
    CertifiedTracking,
    at_rest,
    certified,
    expected,
    feedback_left,
    fixed_excess,
    mean_diagonal,
)
from gd_analyze.studies.controllers import CONTROLLERS, Knowledge
from gd_analyze.studies.loop import Course, Loop, World, follow
from gd_analyze.studies.reference import Reference, followable
from gd_analyze.studies.settings import ControlSettings
from gd_analyze.studies.study import ControlStudy, TrackedLoop


def control(
    model: SimplifiedModel,
    trajectory: Trajectory | str,
    settings: ControlSettings | None = None,
    arm: RobotArm | None = None,
    *,
    command: str = "",
    warned: Iterable[str] = (),
    progress: Callable[[int], None] = lambda percent: None,
) -> ControlStudy:
    """Track a motion on the exact arm by controllers that know nothing, gravity, all but h, the model, all.

    Parameters
    ----------
    model
        The simplified model; its drives act on the arm where they are part of it.
    trajectory
        The motion, a shipped name or a path.
    settings
        Gains, rates, speeds, limits and tolerance.
    arm
        The arm that moves, such as the model's own carrying a payload that no controller knows of; the
        model's own by default.
    command, warned
        What the user typed, and warnings given while the input was read.
    progress
        Called with the hundredths of all steps that are done since it was called last.

    Returns
    -------
    ControlStudy
        Errors, torques and bounds of every loop.

    Raises
    ------
    TrajectoryError
        If the motion is of another number of joints, or has gaps.
    ModelError
        If the arm is of another number of joints than the model.
    ArmError
        If D is not positive definite along the motion, or drives act and the arm describes none.
    UsageError
        If the motion takes too many steps.

    Examples
    --------
    >>> import gd_analyze as gd
    >>> model = gd.simplify("two_link", "two-link-swing", "20%")
    >>> study = gd.control(model, "two-link-swing", gd.ControlSettings(rates=(500.0,), speeds=(1.0,)))
    >>> bool(study.loops[0].peak_error.max() < study.loops[2].peak_error.max())
    True
    """
    settings = settings or ControlSettings()
    moved = model.arm if arm is None else arm
    require_arm(model, moved)
    motion = trajectory_of(trajectory, model.arm)
    require_joints(motion, model.arm)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", GdAnalyzeWarning)
        check_against_arm(motion, moved)
        followed = followable(motion)
        world = _world(model, moved, followed, settings)
    loops = [Loop(c, r, s) for s in settings.speeds for r in settings.rates for c in CONTROLLERS]
    course = follow(world, loops, progress)
    lacking = {(c, s): expected(world, c, s) for c in CONTROLLERS for s in settings.speeds}
    proven: dict[float, CertifiedTracking] = {}
    if arm is None and not settings.friction:
        bound = certified(model, world, followed, settings.usual_speed)
        proven = {} if bound is None else {settings.usual_speed: bound}
    inputs = [describe_in_full(moved), motion.fingerprint, model.provenance.get("command", "")]
    return ControlStudy(
        model=model,
        arm=moved,
        motion=motion,
        settings=settings,
        diagonal=world.knowledge.diagonal,
        limits=world.limits,
        loops=tuple(
            _tracked(world, loop, course, k, lacking[loop.controller, loop.speed])
            for k, loop in enumerate(loops)
        ),
        certified=proven,
        feedback=feedback_left(model, world.reference),
        fixed_excess=fixed_excess(world),
        at_rest={c: at_rest(world, c) for c in CONTROLLERS if c.law == "pd"},
        warnings=tuple(dict.fromkeys([*warned, *(str(item.message) for item in caught)])),
        provenance=provenance_of_run(command, names_of(moved, motion, settings), inputs, repeats=True),
    )


def names_of(arm: RobotArm, motion: Trajectory, settings: ControlSettings) -> list[str]:
    """Name arm, motion and settings: what a study was asked for."""
    return [arm.name, motion.name, str(settings)]


def _world(model: SimplifiedModel, arm: RobotArm, motion: Trajectory, settings: ControlSettings) -> World:
    """What the loops share; an arm that cannot be simulated is refused."""
    reference = Reference.of(motion)
    form = model.form if arm is model.arm else ExactForm(arm, model.drives)
    ExactDynamics.of(arm, motion, model.drives)  # which refuses a D that is not positive definite
    diagonal = mean_diagonal(model.form, reference)
    limits = np.full(arm.n_joints, np.inf)
    if settings.limits is not None and arm.drives:
        stated = [np.inf if drive.torque_limit is None else drive.torque_limit for drive in arm.drives]
        limits = settings.limits * np.array(stated)
    if settings.friction and not arm.drives:
        raise ArmError(
            f"arm {arm.name} describes no friction",
            where=f"arm {arm.name}",
            expected="drives with their friction",
            next_step="leave friction out, or add [[drives]] to the arm file",
        )
    knowledge = Knowledge.of(model, diagonal)
    return World(form, knowledge, settings.gains, reference, limits, settings.friction)


def _tracked(world: World, loop: Loop, course: Course, k: int, lacking: FloatArray) -> TrackedLoop:
    """What came of one loop."""
    arm, drives = world.plant.arm, world.plant.drives

    def energy(state: FloatArray) -> float:
        q, qd = state
        return float(kinetic_energy(arm, q, qd, drives=drives) + potential_energy(arm, q))

    is_lost = bool(np.isfinite(course.lost_at[k]))
    gained = energy(course.end[..., k]) - energy(course.start[..., k])
    work, dissipated = float(course.work[k]), float(course.dissipated[k])
    time, error = course.histories[k]
    return TrackedLoop(
        controller=loop.controller,
        rate=loop.rate,
        speed=loop.speed,
        peak_error=np.full(arm.n_joints, np.inf) if is_lost else course.peak_error[:, k],
        rms_error=np.full(arm.n_joints, np.inf) if is_lost else np.sqrt(course.squared_error[:, k]),
        peak_torque=course.peak_torque[:, k],
        rms_torque=np.sqrt(course.squared_torque[:, k]),
        saturated=course.saturated[:, k],
        expected=lacking,
        lost_at=float(course.lost_at[k]) if is_lost else None,
        work=work,
        dissipated=dissipated,
        energy_residual=gained - work + dissipated,
        time=time,
        error=error,
    )
