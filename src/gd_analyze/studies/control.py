"""Whether a simplified model is good enough to control its arm along a motion, simulated."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.dynamics.torque_limits import warn_of_torque_limits
from gd_analyze.errors import ArmError, GdAnalyzeWarning, TrajectoryError, Warned, require_type
from gd_analyze.motions.limits import check_against_arm, require_trajectory_joints
from gd_analyze.motions.pool import trajectory_of
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.motions.velocities import FEWEST_SET_POINTS, completed
from gd_analyze.results.findings import provenance_of_run
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.catalogue import arm_with_masses
from gd_analyze.robots.description import describe_in_full
from gd_analyze.simplification.exact import ExactForm
from gd_analyze.simplification.exact_dynamics import ExactDynamics
from gd_analyze.simplification.model import SimplifiedModel, require_model
from gd_analyze.simplification.model_torque import require_arm
from gd_analyze.studies import control_bounds as bounds
from gd_analyze.studies.control_bounds import CertifiedTracking, FeedbackLeft
from gd_analyze.studies.control_law import CONTROLLERS, Controller, ControlSettings, Reference, World
from gd_analyze.studies.control_loop import Loop, TrackedLoop, follow
from gd_analyze.text import amount, html_of
from gd_analyze.threads import one_thread

# The polynomials' accelerations agree with the given ones if they are at most this many times as large.
_MOST_ACCELERATION_RATIO = 3.0
# Accelerations below this, rad/s^2 (m/s^2), agree whatever their ratio.
_SMALL_ACCELERATION = 1e-2


@dataclass(frozen=True, eq=False)
class ControlStudy:
    """A motion tracked by every controller at every rate and speed.

    Parameters
    ----------
    model
        The model that the simplified controllers use.
    arm
        The arm that moves: the model's own, or one that carries a payload.
    motion, settings
        The inputs.
    diagonal
        Mean of D's diagonal along the motion, kg m^2 (kg), shape (n,): M of controllers without D.
    limits
        Torque limits applied, N m (N), infinite where there are none, shape (n,).
    needed
        Largest torque that the motion needs at the usual speed, N m (N), shape (n,).
    loops
        Result of each loop.
    expected
        By controller and speed, the largest tracking error, rad (m), shape (n,), that the torque it lacks
        along the motion causes, to first order.
    certified
        By speed, the proven bounds for the simplified model; empty where nothing is proven.
    feedback
        Share of the feedback that computed torque with the simplified model leaves along the motion.
    torque_for_tolerance
        Torque errors with which a model with fixed gains keeps the tolerance, to first order, N m (N), shape
        (n,).
    fixed_excess
        Largest ratio of fixed gains to the intended ones, in any direction along the motion.
    at_rest
        Largest error of PD at rest, rad (m), shape (n,).
    warnings
        Warnings about the input.
    provenance
        Versions, time, command.
    """

    model: SimplifiedModel
    arm: RobotArm
    motion: Trajectory
    settings: ControlSettings
    diagonal: FloatArray
    limits: FloatArray
    needed: FloatArray
    loops: tuple[TrackedLoop, ...]
    expected: Mapping[tuple[Controller, float], FloatArray]
    certified: Mapping[float, CertifiedTracking]
    feedback: FeedbackLeft
    torque_for_tolerance: FloatArray
    fixed_excess: float
    at_rest: FloatArray
    warnings: tuple[str, ...] = ()
    provenance: Mapping[str, str] = field(default_factory=dict)

    def __repr__(self) -> str:
        return f"ControlStudy({self.arm.name!r}, {self.motion.name!r}, {len(self.loops)} loops)"

    def _repr_html_(self) -> str:
        """The largest tracking error of every controller at the usual rate and speed, for a notebook."""
        rate, speed = self.settings.usual_rate, self.settings.usual_speed
        loops = [loop for loop in self.loops if (loop.rate, loop.speed) == (rate, speed)]
        rows = [
            [
                loop.controller.title,
                *(amount(*pair) for pair in zip(loop.peak_error, self._units, strict=True)),
                "yes" if loop.within(self.tolerance) else "no",
            ]
            for loop in loops
        ]
        headings = ["controller", *(f"joint {i + 1}" for i in range(self.arm.n_joints)), "within tolerance"]
        title = f"{self.arm.title or self.arm.name} controlled along {self.motion.name}"
        at = "in continuous time" if math.isinf(rate) else f"at {rate:g} Hz"
        speed_text = "at the planned speed" if speed == 1.0 else f"{speed:g} times as fast as planned"
        return html_of(title, headings, rows, f"Largest tracking errors, {at}, {speed_text}.")

    @property
    def _units(self) -> list[str]:
        return [joint.unit for joint in self.arm.joints]

    @cached_property
    def tolerance(self) -> FloatArray:
        """Acceptable tracking error, rad (m), shape (n,)."""
        return self.settings.tolerance.of(self.arm)

    def loop(self, controller: Controller, rate: float, speed: float) -> TrackedLoop:
        """Find one loop."""
        return next(x for x in self.loops if (x.controller, x.rate, x.speed) == (controller, rate, speed))

    @property
    def too_slow_for_fixed_gains(self) -> tuple[float, ...]:
        """Rates at which fixed gains cannot be stable: a held e'' = -k e' grows where k is 2 per period."""
        damper = self.settings.gains.damper * self.fixed_excess
        return tuple(rate for rate in self.settings.rates if damper >= 2.0 * rate)

    @cached_property
    def fastest_within_limits(self) -> float:
        """Largest multiple of the planned speed within the arm's velocity and acceleration limits."""
        with np.errstate(divide="ignore", invalid="ignore"):
            velocity = self.arm.limits("velocity_limit") / np.abs(self.motion.qd).max(axis=0)
            acceleration = self.arm.limits("acceleration_limit") / np.abs(self.motion.qdd).max(axis=0)
        return float(np.nanmin([*velocity, *np.sqrt(acceleration), np.inf]))

    def shares(self, controller: Controller, rate: float) -> FloatArray:
        """Largest error of any joint over its tolerance, for all speeds from the lowest."""
        loops = [self.loop(controller, rate, speed) for speed in sorted(self.settings.speeds)]
        return np.array([(loop.peak_error / self.tolerance).max() for loop in loops])

    def tracks_up_to(self, controller: Controller, rate: float) -> float | None:
        """Speed up to which every joint stays within the tolerance.

        Errors between two speeds are assumed to grow with a power of the speed. Infinite where the tolerance
        holds at every speed tried, None where it holds at none.
        """
        speeds, shares = sorted(self.settings.speeds), self.shares(controller, rate)
        beyond = int((shares > 1.0).argmax())
        if not shares[beyond] > 1.0:
            return np.inf
        if not beyond:
            return None
        low, high = shares[beyond - 1 : beyond + 1]
        if not np.isfinite(high) or not low:
            return speeds[beyond - 1]
        power = np.log(high / low) / np.log(speeds[beyond] / speeds[beyond - 1])
        return float(speeds[beyond - 1] * low ** (-1.0 / power))


@one_thread()
def control(
    model: SimplifiedModel,
    trajectory: Trajectory | str,
    settings: ControlSettings | None = None,
    arm: RobotArm | str | Path | None = None,
    *,
    command: str = "",
    warned: Iterable[str] = (),
    progress: Callable[[int], None] = lambda percent: None,
) -> ControlStudy:
    """Simulate tracking on the exact arm with the simplified model, the exact one, and that without h.

    Parameters
    ----------
    model
        The simplified model; its drives act on the arm where they are part of it.
    trajectory
        The motion, a shipped name or a path.
    settings
        Gains, rates, speeds, limits and tolerance.
    arm
        The arm that moves, such as the model's with a payload unknown to controllers; by default the model's.
    command, warned
        What the user typed, and warnings given while the input was read.
    progress
        Called with the hundredths of all steps done since the last call.

    Returns
    -------
    ControlStudy
        Errors, torques and bounds of every loop.

    Raises
    ------
    TrajectoryError
        If the motion has another number of joints than the arm, or gaps.
    ModelError
        If the arm has another number of joints than the model.
    ArmError
        If D is not positive definite along the motion, or friction is asked for and the arm describes none.
    UsageError
        If the motion takes too many steps.

    Examples
    --------
    >>> import gd_analyze as gd
    >>> model = gd.simplify("two_link", "two-link-swing", "60%")
    >>> study = gd.control(model, "two-link-swing", gd.types.ControlSettings(rates=(500.0,), speeds=(1.0,)))
    >>> bool(study.loops[0].peak_error.max() < study.loops[2].peak_error.max())
    True
    """
    require_model(model)
    settings = ControlSettings() if settings is None else settings
    require_type(settings, ControlSettings, "settings", "a ControlSettings object, or None")
    moved = model.arm if arm is None else arm_with_masses(arm)
    require_arm(model, moved)
    motion = trajectory_of(trajectory, model.arm)
    require_trajectory_joints(motion, model.arm)
    warned_so_far = Warned(list(dict.fromkeys(warned)))
    with warned_so_far.collecting():
        check_against_arm(motion, moved)
        followed = followable(motion)
        world = _world(model, moved, followed, settings)
    loops = [Loop(c, r, s) for s in settings.speeds for r in settings.rates for c in CONTROLLERS]
    tracked = follow(world, loops, progress)
    is_known = arm is None and not settings.friction
    proven = bounds.certified(model, world, followed, settings.usual_speed) if is_known else None
    inputs = [describe_in_full(moved), motion.fingerprint, model.provenance.get("command", "")]
    return ControlStudy(
        model=model,
        arm=moved,
        motion=motion,
        settings=settings,
        diagonal=world.diagonal,
        limits=world.limits,
        needed=bounds.needed_torque(world, settings.usual_speed),
        loops=tracked,
        expected={(c, s): bounds.expected(world, c, s) for c in CONTROLLERS for s in settings.speeds},
        certified={} if proven is None else {settings.usual_speed: proven},
        feedback=bounds.feedback_left(model, world.reference),
        torque_for_tolerance=bounds.torque_for(
            world.plant.program, world.reference, settings.gains, lambda _: settings.tolerance.of(moved)
        ),
        fixed_excess=bounds.fixed_excess(world),
        at_rest=bounds.at_rest(world),
        warnings=tuple(warned_so_far.texts),
        provenance=provenance_of_run(command, names_of(moved, motion, settings), inputs, repeats=True),
    )


def names_of(arm: RobotArm, motion: Trajectory, settings: ControlSettings) -> list[str]:
    """Names of arm, motion and settings, which identify a study."""
    return [arm.name, motion.name, str(settings)]


def _world(model: SimplifiedModel, arm: RobotArm, motion: Trajectory, settings: ControlSettings) -> World:
    """Inputs that all loops share; refuses an arm that cannot be simulated."""
    if settings.friction and not arm.drives:
        where, step = f"arm {arm.name}", "leave friction out, or add [[drives]] to the arm file"
        message, expected = f"{where} describes no friction", "drives with their friction"
        raise ArmError(message, where=where, expected=expected, next_step=step)
    along = ExactDynamics.of(arm, motion, model.drives)  # which refuses a D that is not positive definite
    reference, exact = Reference.of(motion), model.form.program
    limits = np.full(arm.n_joints, np.inf)
    if settings.limits is not None and arm.drives:
        stated = [np.inf if drive.torque_limit is None else drive.torque_limit for drive in arm.drives]
        limits = settings.limits * np.array(stated)
        warn_of_torque_limits(arm, along.states, along.torque)
    return World(
        plant=model.form if arm is model.arm else ExactForm(arm, model.drives),
        exact=exact,
        simplified=model.program,
        diagonal=bounds.mean_diagonal(exact, reference),
        gains=settings.gains,
        reference=reference,
        limits=limits,
        friction=settings.friction,
    )


def followable(motion: Trajectory) -> Trajectory:
    """Prepare a trajectory for tracking; derivatives that contradict its positions are recomputed."""
    if motion.gaps:
        begin, end = motion.time[motion.gaps[0] - 1], motion.time[motion.gaps[0]]
        raise TrajectoryError(
            "a motion with gaps cannot be tracked",
            where=f"trajectory {motion.name}, between {begin:g} and {end:g} s",
            expected="one motion without gaps",
            found=f"{len(motion.gaps)} gap{'s' if len(motion.gaps) > 1 else ''}",
            next_step="give one of its parts as a trajectory of its own",
        )
    if motion.n_set_points < 2:
        message, where = "there is no motion to track", f"trajectory {motion.name}"
        raise TrajectoryError(message, where=where, expected="two set points or more", found="1 set point")
    reference = Reference.of(motion)
    middles = reference.time[:-1] + np.diff(reference.time) * np.array([[0.25], [0.5], [0.75]])
    largest = np.abs(reference.at(middles)[2]).max(axis=(1, 2))
    most = np.maximum(_MOST_ACCELERATION_RATIO * np.abs(motion.qdd).max(axis=0), _SMALL_ACCELERATION)
    contradicts = largest > most
    if not contradicts.any() or motion.n_set_points < FEWEST_SET_POINTS:
        return motion
    qd, qdd, _ = completed(motion.time, motion.q, None, None)
    joint = int(largest.argmax())
    warnings.warn(
        f"velocities and accelerations of {motion.name} disagree with its positions, which need up to "
        f"{largest[joint]:.3g} rad/s^2 (m/s^2) of joint {joint + 1}, the motion states "
        f"{np.abs(motion.qdd[:, joint]).max():.3g}; a quintic spline through the positions is followed",
        GdAnalyzeWarning,
        stacklevel=2,
    )
    return replace(motion, qd=qd, qdd=qdd)
