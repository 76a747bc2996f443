"""Links, drives and friction from measured motion and torque."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import reduce
from pathlib import Path

import numpy as np

from gd_analyze.arguments import strict
from gd_analyze.arrays import Array, FloatArray
from gd_analyze.diagnosis.answer import MUCH_TORQUE_SHARE, answer, faults_in_words, mentioned
from gd_analyze.diagnosis.diagnose import diagnose
from gd_analyze.diagnosis.faults import Fault, without_faults
from gd_analyze.diagnosis.hypothesis import Candidate
from gd_analyze.diagnosis.of_one_log import FrictionOfLogs
from gd_analyze.diagnosis.remedies import Remedy, another_column, reversed_torques
from gd_analyze.errors import GdAnalyzeWarning, UsageError, warn_caller
from gd_analyze.identification.consistent import bounded, consistent
from gd_analyze.identification.doubts import doubts_of, scale_error
from gd_analyze.identification.estimate import (
    SIGMAS,
    Estimate,
    change_by_friction,
    described,
    least_squares,
    plausible_sizes,
    solved_again,
    start_of,
)
from gd_analyze.identification.identification import Identification, Residuals
from gd_analyze.identification.identified_arm import (
    base_of,
    identified_arm,
    payload_of,
    sources_of,
    spread_of,
)
from gd_analyze.identification.rows import JointRows, Unknowns, identification_rows
from gd_analyze.motions.limits import require_trajectory_joints
from gd_analyze.motions.measured import fastest_of, require_torques
from gd_analyze.motions.pool import GivenMotions, motions_of
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.catalogue import arm_of
from gd_analyze.text import in_python, named_joints, percent, with_error
from gd_analyze.threads import one_thread

_HELD_OUT_SHARE = 1.0 / 3.0  # share at the end of every log that is predicted if no log is held out
_PAUSE_SHARE = 0.05  # gap between two logs in figures, as a share of the first
# A model with more than this share of the squared held-out torque as residual is useless.
_USELESS_SQUARE_SHARE = 0.5
_FAULTY_RMS_SHARE = 0.25  # share of the RMS beyond which model or log is faulty
_CLEAR_RATIO = 1.1  # ratio of two RMS that clearly differ
# Factor on torques beyond which no links explain it: files that state no drives are off by up to three,
# N mm, N cm and currents by ten and more.
_ANOTHER_UNIT_FACTOR = 10.0


@strict
@one_thread()
def identify(
    arm: RobotArm | str | Path,
    logs: GivenMotions,
    *,
    held_out: GivenMotions | None = None,
    loaded: GivenMotions | None = None,
    mass: float | None = None,
    physical: bool = True,
    anyway: bool = False,
) -> Identification:
    """Fit links, drives and friction to measured motions and torques by weighted least squares.

    Torque of every joint is linear in ten parameters of every link, the drives' inertia, Coulomb and viscous
    friction and an offset. Rows are means of both sides over short windows of time, weighted by their joint's
    residuals, the larger of fitted and held-out ones. Parameters that the logs do not tell keep the file's
    values, as do joints whose held-out torque is not predicted better than by the file with fitted friction.
    Faulty readings (`diagnose`) are left out.

    Parameters
    ----------
    arm
        The arm; or a shipped name, or the path of a file.
    logs
        Recordings with torques; or paths of files, or a folder of them.
    held_out
        Recordings that are predicted instead of fitted; by default the last third of each log.
    loaded
        Recordings with an unknown payload at the tip, whose mass and centre of mass are identified, too.
    mass
        The payload's mass, kg, if it is known: all torques are scaled so that it is met.
    physical
        Take the physically consistent parameters nearest to the least squares and, along unidentifiable
        directions, to the file, by a semidefinite program; otherwise only keep masses, drive inertias and
        friction non-negative.
    anyway
        Identify even where a cause other than the links' numbers explains the logs (`diagnose`), or a column
        is of no use.

    Returns
    -------
    Identification
        The arm, its parameters with standard errors, and the residuals of held-out torques.

    Raises
    ------
    UsageError
        If a log has no torques, constant or copied ones, is given twice, or has a wrong sign or column; if no
        joint moves, the logs do not determine the links, or no model of this arm predicts held-out torques;
        if `diagnose` finds a cause that other links do not explain.
    TrajectoryError
        If a log has another number of joints.

    Warns
    -----
    GdAnalyzeWarning
        If readings are faulty, joints do not move or are not predicted, or what is identified is implausible
        beside the file.
    """
    arm = arm_of(arm)
    fitted, carrying, held_out_motions = (
        [] if recordings is None else motions_of(recordings, arm) for recordings in (logs, loaded, held_out)
    )
    if not fitted:
        message, expected = "there are no logs", "one or several logs with torques"
        raise UsageError(message, where="logs", expected=expected, found=in_python(logs))
    _require_different([*fitted, *carrying, *held_out_motions])
    faults: list[Fault] = []
    fitted, carrying, held_out_motions = (
        [_without_faults(arm, motion, faults, anyway) for motion in motions]
        for motions in (fitted, carrying, held_out_motions)
    )
    doubts = _doubts_of_logs(arm, [*fitted, *held_out_motions], anyway)
    if mass is None:
        identification = _identified(arm, fitted, held_out_motions, carrying, physical, doubts)
        identification = replace(identification, faults=tuple(faults))
        if identification.payload is None:
            return identification
        scale_share = scale_error(arm, identification.arm, [*fitted, *held_out_motions])
        values, errors = identification.payload
        # The centre of mass is a ratio of torques, without an error of scale.
        errors = np.hypot(errors, [scale_share * values[0], 0.0, 0.0, 0.0])
        return replace(identification, payload=np.array([values, errors]))
    if not carrying or not 0.0 < mass < np.inf:
        raise UsageError(
            "a payload's mass calibrates torques by a log that carries it",
            where="mass",
            expected="a mass above 0 kg, and a log as `loaded`",
            found=f"{mass:g} kg" if carrying else "no log with the payload",
        )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", GdAnalyzeWarning)  # told of the scaled logs
        payload = _identified(arm, fitted, held_out_motions, carrying, physical, ()).payload
    assert payload is not None  # of a log with it
    weighed, error = payload[:, 0].tolist()
    if weighed <= SIGMAS * error:
        raise UsageError(
            "the logs do not determine the payload's mass, so it calibrates no torques",
            where=f"arm {arm.name}",
            expected="a heavier payload, or motions that lift it more",
            found=f"{with_error(weighed, error)} kg",
        )
    scale = mass / weighed
    fitted, held_out_motions, carrying = (
        [_with_torques(motion, scale) for motion in motions]
        for motions in (fitted, held_out_motions, carrying)
    )
    # The doubts are of torques that are not calibrated.
    identification = _identified(arm, fitted, held_out_motions, carrying, physical, ())
    return replace(identification, faults=tuple(faults), torque_scale=(scale, scale * error / weighed))


def _without_faults(arm: RobotArm, motion: Trajectory, faults: list[Fault], anyway: bool) -> Trajectory:
    """A recording without faulty readings, which are added to `faults`; refused if a column is useless."""
    require_trajectory_joints(motion, arm)
    require_torques(motion)
    (told, motion), where = without_faults(arm, motion), f"log {motion.name}"
    useless = [fault for fault in told if fault.is_of_column]
    is_anything_left = bool(np.isfinite(_torque_read(motion)).any())
    if useless and not (anyway and is_anything_left):
        further = "; anyway=True leaves it out" if is_anything_left else ""
        raise UsageError(
            "; ".join(fault.what[0].lower() + fault.what[1:] for fault in useless),
            where=where,
            expected="measured torques and positions of every joint",
            next_step=f"{useless[0].remedy}; `gd-analyze columns ROBOT LOG` lists the columns{further}",
        )
    by_name: dict[str, list[Fault]] = {}
    for fault in mentioned(told):
        by_name.setdefault(fault.name, []).append(fault)
    for group in by_name.values():
        warn_caller(f"{where}: {faults_in_words(group, arm.n_joints)}")
    faults += [replace(fault, what=f"{fault.what} ({where})") for fault in told]
    return motion


def _doubts_of_logs(arm: RobotArm, motions: Sequence[Trajectory], anyway: bool) -> tuple[str, ...]:
    """What a diagnosis doubts of logs and file; refuse logs with a cause that is none of the links'."""
    if not arm.mass.any():
        return ()
    try:
        diagnosis = diagnose(arm, motions)
    except UsageError:  # nothing moves, of which more is told below
        return ()
    causes = diagnosis.causes
    # Other links explain a payload, and torques of a scale that drives may have; friction is fitted anyway.
    of_friction = [cause for cause in causes if cause.name == FrictionOfLogs.name]
    others = [cause for cause in causes if not cause.unsure or _is_of_another_unit(cause)]
    others = [cause for cause in others if cause not in of_friction] + [cause for _, cause in diagnosis.apart]
    reason, _, _ = answer(diagnosis).partition(" Use ")
    if others and not anyway:
        raise UsageError(
            f"logs and file disagree for another reason than the links' numbers. {reason}",
            where=f"log {', '.join(diagnosis.logs)}",
            next_step=f"{reduce(Remedy.then, [cause.remedy for cause in others]).as_arguments}; "
            "anyway=True identifies all the same",
        )
    # A payload, which the last link may take up, is none: torques of another scale, and other arms, are.
    is_off = diagnosis.is_far_off or diagnosis.after.off > MUCH_TORQUE_SHARE
    is_doubtful = is_off or bool(others or of_friction)
    is_doubtful |= any(cause.correction.changes_torques or cause.correction.freedom > 1.0 for cause in causes)
    return (reason.removesuffix("."),) if is_doubtful else ()


def _is_of_another_unit(cause: Candidate) -> bool:
    """Whether torques differ by more than masses or unstated drives do: N mm, N cm and currents."""
    factors = np.abs(cause.correction.torque[cause.correction.torque != 0.0])
    return bool((np.abs(np.log(factors)) > np.log(_ANOTHER_UNIT_FACTOR)).any())


def _with_torques(motion: Trajectory, scale: float) -> Trajectory:
    """A recording whose torques are multiplied."""
    recording = motion.recording
    assert recording is not None  # checked before
    assert recording.torque is not None
    filtered = None if recording.torque_filtered is None else scale * recording.torque_filtered
    scaled = replace(recording, torque=scale * recording.torque, torque_filtered=filtered)
    return replace(motion, recording=scaled)


@dataclass(frozen=True, eq=False)
class _JointLogs:
    """Equations of one joint from all logs, and which are held out, or of an arm that carries the payload."""

    rows: JointRows
    held_out: Array  # (rows,)
    loaded: Array  # (rows,)

    @property
    def training(self) -> JointRows:
        """Rows that are fitted."""
        return self.rows.at(~self.held_out)

    @property
    def bare(self) -> JointRows:
        """Rows that are fitted, without the payload."""
        return self.rows.at(~self.held_out & ~self.loaded)

    def friction(self, start: FloatArray, unknowns: Unknowns, joint: int) -> FloatArray:
        """Friction fitted beside the file's links and drive, (3,)."""
        rows = self.bare
        columns = rows.columns[:, unknowns.friction_of(joint)]
        return np.asarray(np.linalg.lstsq(columns, rows.torque - rows.columns @ start, rcond=None)[0])

    def residuals(self, start: FloatArray, values: FloatArray, unknowns: Unknowns, joint: int) -> Residuals:
        """Torques by the file, by the file with friction, and as identified."""
        rows = self.rows
        file = rows.columns @ start
        friction = rows.columns[:, unknowns.friction_of(joint)] @ self.friction(start, unknowns, joint)
        identified = rows.columns @ values
        return Residuals(
            rows.time, rows.torque, file, file + friction, identified, self.held_out, self.loaded
        )


def _logs_by_joint(
    arm: RobotArm,
    unknowns: Unknowns,
    fitted: list[Trajectory],
    held_out_motions: list[Trajectory],
    carrying: list[Trajectory],
) -> list[_JointLogs]:
    """Equations of every joint, with the logs one after the other in time."""
    motions = [*fitted, *carrying, *held_out_motions]
    fastest = fastest_of(motions)
    parts: list[list[_JointLogs]] = [[] for _ in range(arm.n_joints)]
    begin = 0.0
    for k, motion in enumerate(motions):
        is_loaded = any(motion is loaded_motion for loaded_motion in carrying)
        end = begin + float(motion.time[-1] - motion.time[0])
        if k >= len(motions) - len(held_out_motions):
            held_out_from = -np.inf
        elif held_out_motions:
            held_out_from = np.inf
        else:
            held_out_from = end - _HELD_OUT_SHARE * (end - begin)
        for i, rows in enumerate(identification_rows(arm, motion, unknowns, fastest, loaded=is_loaded)):
            time = rows.time - motion.time[0] + begin
            loaded = np.full(len(time), is_loaded)
            parts[i].append(_JointLogs(replace(rows, time=time), time > held_out_from, loaded))
        begin = end + _PAUSE_SHARE * (end - begin)
    return [
        _JointLogs(
            JointRows.joined([log.rows for log in logs]),
            np.concatenate([log.held_out for log in logs]),
            np.concatenate([log.loaded for log in logs]),
        )
        for logs in parts
    ]


def _identified(
    arm: RobotArm,
    fitted: list[Trajectory],
    held_out_motions: list[Trajectory],
    carrying: list[Trajectory],
    physical: bool,
    doubts_of_logs: tuple[str, ...],
) -> Identification:
    n = arm.n_joints
    unknowns = Unknowns(n, payload=bool(carrying))
    logs = _logs_by_joint(arm, unknowns, fitted, held_out_motions, carrying)
    training = [log.training for log in logs]
    _require_torque_that_tells(arm, training)
    start = np.zeros(unknowns.count)
    links = described(arm)
    start[unknowns.of_links] = links.ravel()
    if arm.drives:
        start[unknowns.of_drives] = arm.drive_inertia
    has_masses = bool(arm.mass.any())
    estimate = least_squares(training, start, plausible_sizes(arm, links, training, unknowns))
    # Friction that is not the model's bends the fit to its own rows, and they do not show how far it is off.
    judged = estimate.judged_by([log.rows for log in logs], [log.held_out for log in logs])
    estimate = solved_again(training, start, judged)

    def fitted_values() -> tuple[FloatArray, tuple[Residuals, ...]]:
        values = consistent(estimate, unknowns) if physical else bounded(estimate, unknowns)
        return values, tuple(log.residuals(start, values, unknowns, i) for i, log in enumerate(logs))

    values, residuals = fitted_values()
    if not has_masses:  # otherwise the diagnosis has tried signs
        _require_friction_that_brakes(arm, estimate, unknowns, residuals)
    _require_a_model(arm, residuals)
    # Joints that are not predicted better than by the file keep its torque.
    unimproved: list[int] = []
    fitted_estimate, fitted_rows = estimate, list(training)
    while has_masses:
        worse = [i for i in range(n) if i not in unimproved and not residuals[i].is_better]
        if not worse:
            break
        unimproved += worse
        file_values = start.copy()
        file_values[unknowns.of_payload] = values[unknowns.of_payload]
        for i in unimproved:
            file_values[unknowns.friction_of(i)] = logs[i].friction(start, unknowns, i)
            training[i] = replace(training[i], torque=training[i].columns @ file_values)
        estimate = solved_again(training, file_values, estimate)
        values, residuals = fitted_values()
    if unimproved:
        estimate = estimate.bent_by(estimate.values - fitted_estimate.values)
    estimate = estimate.bent_by(change_by_friction(fitted_estimate, fitted_rows, unknowns))
    parameters = base_of(arm, estimate, values, unknowns)
    if not any(parameter.identifiable for parameter in parameters):
        raise UsageError(
            "the logs do not determine the links",
            where=f"arm {arm.name}",
            expected="motions that excite them: `gd-analyze plan ROBOT --exciting --duration 20` plans one",
            found="parameters with standard errors as large as their values",
        )
    deviations, opened = estimate.deviations, estimate.open
    errors = np.sqrt(np.square(deviations).sum(axis=0))
    is_open = np.sqrt(np.square(opened).sum(axis=0)) > estimate.sizes / SIGMAS
    friction, drives = unknowns.of_friction, unknowns.of_drives
    payload = None
    if carrying:
        payload = payload_of(arm, values[unknowns.of_payload], deviations[:, unknowns.of_payload])
    of_log = sources_of(arm, fitted, carrying, held_out_motions, parameters)
    identified = identified_arm(arm, values, spread_of(arm, estimate, unknowns), unknowns, of_log)
    doubts = (*doubts_of_logs, *doubts_of(arm, identified, [*fitted, *held_out_motions], physical=physical))
    for text in doubts:
        warn_caller(text)
    return Identification(
        stated_arm=arm,
        arm=replace(identified, doubts=(*identified.doubts, *doubts)),
        logs=tuple(motion.name for motion in fitted),
        held_out=tuple(motion.name for motion in held_out_motions),
        loaded=tuple(motion.name for motion in carrying),
        physical=physical,
        parameters=parameters,
        friction=values[friction].reshape(n, 3),
        friction_error=np.where(is_open, np.nan, errors)[friction].reshape(n, 3),
        drive_inertia=values[drives],
        drive_error=np.where(is_open, np.nan, errors)[drives],
        residuals=residuals,
        estimate=estimate,
        kept=tuple(i + 1 for i in sorted(unimproved)),
        doubts=doubts,
        payload=payload,
    )


def _require_torque_that_tells(arm: RobotArm, rows: Sequence[JointRows]) -> None:
    """Refuse logs of an arm that stands still; warn of joints at rest."""
    still = [i + 1 for i, joint_rows in enumerate(rows) if not len(joint_rows.time)]
    if len(still) == arm.n_joints:
        raise UsageError(
            "no joint moves, so nothing can be identified",
            where=f"arm {arm.name}",
            expected="joints that move one way for a while, faster than creeping",
            next_step="record a motion that excites the arm: "
            "`gd-analyze plan ROBOT --exciting --duration 20` plans one",
        )
    if still:
        joints = named_joints(still, arm.n_joints)
        message = f"{joints} does not move, or has no usable torque: its torque is not informative"
        warn_caller(message)


def _require_friction_that_brakes(
    arm: RobotArm, estimate: Estimate, unknowns: Unknowns, residuals: Sequence[Residuals]
) -> None:
    """Refuse unpredictable torques with which friction would drive the joint: their sign is wrong."""
    of, n = unknowns.of_friction, arm.n_joints
    values = estimate.values[of].reshape(n, 3)[:, :2]
    errors = np.sqrt(np.square(estimate.deviations[:, of]).sum(axis=0)).reshape(n, 3)[:, :2]
    poor = np.array([residual.share("identified") > _FAULTY_RMS_SHARE for residual in residuals])
    clear = (values < 0.0).all(axis=1) & (values < -SIGMAS * errors).any(axis=1)
    driven = np.flatnonzero(poor & clear).tolist()
    if driven:
        signs = [-1.0 if i in driven else 1.0 for i in range(n)]
        raise UsageError(
            f"friction would drive {named_joints([i + 1 for i in driven], n)} instead of braking",
            where=f"arm {arm.name}",
            expected="torques positive towards growing positions",
            next_step=f"{reversed_torques(signs)} reverses their torques; "
            f"{another_column('torque', driven[0])} names another column",
        )


def _require_a_model(arm: RobotArm, residuals: Sequence[Residuals]) -> None:
    """Refuse logs whose held-out rows no parameters predict; warn of single joints of this kind."""
    n, shares = arm.n_joints, [residual.share("identified") for residual in residuals]
    judged = [i for i, share in enumerate(shares) if np.isfinite(share)]
    unseen = [i + 1 for i in range(n) if i not in judged and len(residuals[i].time)]
    if not judged:
        raise UsageError(
            "no joint moves in the held-out rows, so the result cannot be judged",
            where=f"arm {arm.name}",
            next_step="hold out a log with moving joints, or none (then the last third of each)",
        )
    if unseen:
        message = f"{named_joints(unseen, n)} does not move in the held-out rows: its torque is not judged"
        warn_caller(message)
    poor = [i for i in judged if shares[i] > _FAULTY_RMS_SHARE]
    nothing = [i for i in poor if shares[i] ** 2 > _USELESS_SQUARE_SHARE]
    worse = [
        i for i in judged if residuals[i].rms("identified") > _CLEAR_RATIO * residuals[i].rms("friction")
    ]
    if not poor and len(worse) < len(judged):
        return
    missed = ", ".join(percent(shares[i]) for i in poor or worse)
    joints = named_joints([i + 1 for i in poor or worse], n)
    message = f"the identified model misses {missed} of the RMS of held-out torque at {joints}"
    if 2 * len(nothing) > len(judged) or len(judged) in (len(poor), len(worse)):
        better = (
            f"; the {start_of(arm)} with friction misses less at every joint"
            if len(worse) == len(judged)
            else ""
        )
        raise UsageError(
            f"no model of this arm predicts the logs: {message}{better}",
            where=f"arm {arm.name}",
            next_step=f"{_search_of_cause(arm)}; a log that is short, or ends differently from its "
            "beginning, cannot predict: `gd-analyze plan ROBOT --exciting --duration 20` plans one that can",
        )
    message += f": {_search_of_cause(arm)}"
    warn_caller(message)


def _search_of_cause(arm: RobotArm) -> str:
    """What tells more of a log that does not fit; a diagnosis compares it with the file's masses."""
    if arm.mass.any():
        return "`gd-analyze diagnose ROBOT LOG` looks for the cause"
    return "`gd-analyze columns ROBOT LOG` shows what is read: check units, signs and order"


def _require_different(motions: Sequence[Trajectory]) -> None:
    """Refuse a log given twice: it would count twice, or be predicted from itself."""
    by_fingerprint: dict[str, list[Trajectory]] = {}
    for motion in motions:
        # A commanded motion may be repeated; its torques are measured anew.
        for earlier in by_fingerprint.setdefault(motion.fingerprint, []):
            if np.array_equal(_torque_read(motion), _torque_read(earlier), equal_nan=True):
                raise UsageError(
                    "a log is given twice",
                    where=f"{earlier.name} and {motion.name}",
                    expected="every log once: fitted, held out or loaded",
                    next_step="leave one of them out",
                )
        by_fingerprint[motion.fingerprint].append(motion)


def _torque_read(motion: Trajectory) -> FloatArray:
    recording = motion.recording
    return np.zeros(0) if recording is None or recording.torque is None else recording.torque
