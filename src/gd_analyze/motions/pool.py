"""Several motions of one arm as one trajectory, and back."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from itertools import chain, count
from os import PathLike
from pathlib import Path

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import require_type
from gd_analyze.motions.formats import files_in, shipped_trajectories
from gd_analyze.motions.read import read_trajectory
from gd_analyze.motions.reading import refusal
from gd_analyze.motions.smoothing import Recording
from gd_analyze.motions.trajectory import Motion, Trajectory, counted_motions
from gd_analyze.robots.arm import RobotArm
from gd_analyze.text import number, visible

# One motion or its source; or several, or a folder of them.
GivenMotion = Trajectory | str | Path
GivenMotions = GivenMotion | Sequence[GivenMotion]
Read = Callable[[str | Path, RobotArm], Trajectory]

# Most motions spelt out in a pool's name.
_MOST_NAMED_MOTIONS = 3
# Characters of a pool's name, which also names a folder.
_LONGEST_NAME = 80
# What is each motion's own of a recording, beside its rows.
_TREATMENT = ("cutoff", "noise_q", "noise_qdd", "columns", "treatment")
# Pause between two motions, as a share of their mean duration.
_PAUSE_SHARE = 0.1
# Pause between two motions that are single instants.
_PAUSE_OF_INSTANTS_SECONDS = 1.0


def trajectory_of(sources: GivenMotions, arm: RobotArm, read: Read = read_trajectory) -> Trajectory:
    """Take a trajectory, or read those given by names, files and folders; several become a pool."""
    if isinstance(sources, Trajectory):
        return sources
    return pool(*_given_motions(sources, arm, read))


def motions_of(sources: GivenMotions, arm: RobotArm, read: Read = read_trajectory) -> list[Trajectory]:
    """Take the same motions separately, with distinct names."""
    return _distinct(_given_motions(sources, arm, read)[0])


def _given_motions(
    sources: GivenMotions, arm: RobotArm, read: Read
) -> tuple[Iterator[Trajectory], str | None]:
    """Motions, of a folder those of its files, read one by one; and its name if only a folder is given."""
    entries = list(sources) if isinstance(sources, Sequence) and not isinstance(sources, str) else [sources]
    motions, name = list[GivenMotion](), None
    for entry in entries:
        named = isinstance(entry, str | PathLike) and str(entry) not in shipped_trajectories()
        files = files_in(Path(str(entry))) if named else None
        if files is not None and len(entries) == 1:
            name = visible(Path(str(entry)).resolve().name)
        motions += [entry] if files is None else files
    return (motion if isinstance(motion, Trajectory) else read(motion, arm) for motion in motions), name


def pool(motions: Iterable[Trajectory], name: str | None = None) -> Trajectory:
    """Join motions of one arm to one trajectory, with gaps between them.

    Parameters
    ----------
    motions
        Trajectories with the same number of joints; a single one is returned unchanged.
    name
        Name of the pool; by default "a+b" or "a+7-more".

    Returns
    -------
    Trajectory
        Its `motions` assign set points to motions, and `gaps` state where each begins. Time starts at 0; the
        pause between motions is a tenth of their mean duration. Equal names are made distinct. Readings are
        joined if all motions have some.

    Raises
    ------
    TrajectoryError
        If there are no motions, or their numbers of joints differ.

    Examples
    --------
    >>> rest = Trajectory([0.0], [[0.0]], [[0.0]], [[0.0]], name="rest")
    >>> pool([rest, rest]).name
    'rest+rest-2'
    """
    require_type(motions, Iterable, "motions", "a list of trajectories")
    motions = list(motions)
    for motion in motions:
        require_type(motion, Trajectory, "motions", "a list of trajectories")
    parts = _distinct(motions)
    if len(parts) == 1:
        return parts[0]
    names = [motion.name for motion in parts]
    mean = float(np.mean([motion.time[-1] - motion.time[0] for motion in parts]))
    pause = float(f"{_PAUSE_SHARE * mean:.1g}") or _PAUSE_OF_INSTANTS_SECONDS
    clocks: list[FloatArray] = []
    motions_of_pool: list[Motion] = []
    gaps: list[int] = []
    first, start = 0, 0.0
    for motion in parts:
        clocks.append(motion.time - motion.time[0] + start)
        about = float(motion.time[0]), motion.origin, motion.derivatives_from, motion.fingerprint
        treated = None if motion.recording is None else motion.recording.at(slice(0))
        motions_of_pool.append(Motion(motion.name, first, first + motion.n_set_points, *about, treated))
        gaps += [first, *(first + row for row in motion.gaps)]
        first, start = first + motion.n_set_points, float(clocks[-1][-1]) + pause
    sources = {motion.derivatives_from for motion in parts}
    joined_names = "+".join(names)
    if len(names) > _MOST_NAMED_MOTIONS or len(joined_names) > _LONGEST_NAME:
        joined_names = f"{names[0]}+{len(names) - 1}-more"
    q, qd, qdd = (
        np.concatenate([getattr(motion, quantity) for motion in parts]) for quantity in ("q", "qd", "qdd")
    )
    return Trajectory(
        np.concatenate(clocks),
        q,
        qd,
        qdd,
        name=name or joined_names,
        origin=f"{counted_motions(names)}, one after the other with {number(pause)} s between",
        derivatives_from=sources.pop() if len(sources) == 1 else "as each motion states",
        gaps=tuple(gaps[1:]),
        recording=_recording(parts),
        motions=tuple(motions_of_pool),
    )


def _distinct(motions: Iterable[Trajectory]) -> list[Trajectory]:
    """Motions of one arm with distinct names; at least one."""
    trajectories: list[Trajectory] = []
    for motion in motions:
        trajectories += taken_apart(motion)
    if not trajectories:
        raise refusal("there are no motions", "motions", "at least one", "none")
    first, used_names = trajectories[0], set[str]()
    for k, motion in enumerate(trajectories):
        if motion.n_joints != first.n_joints:
            message, where = f"trajectory {motion.name} is for a different arm", f"trajectory {motion.name}"
            expected, step = f"{first.n_joints} joints, as {first.name} has", "analyse the arms one by one"
            raise refusal(message, where, expected, f"{motion.n_joints} joints", step)
        numbered_names = (f"{motion.name}-{number}" for number in count(2))
        name = next(name for name in chain([motion.name], numbered_names) if name not in used_names)
        used_names.add(name)
        trajectories[k] = motion if name == motion.name else replace(motion, name=name)
    return trajectories


def taken_apart(whole: Trajectory) -> tuple[Trajectory, ...]:
    """Split a pool into its motions; any other trajectory is its only motion."""
    parts = []
    for motion in whole.motions:
        time = whole.time[motion.rows] - whole.time[motion.first] + motion.start
        q, qd, qdd = (x[motion.rows] for x in (whole.q, whole.qd, whole.qdd))
        gaps = tuple(row - motion.first for row in whole.gaps if motion.first < row < motion.end)
        recording = whole.recording
        if recording is not None:
            recording = recording.at(motion.rows)
            own = motion.treated or recording
            treatment = {name: getattr(own, name) for name in _TREATMENT}
            recording = replace(recording, **treatment)
        about = motion.name, motion.origin, motion.derivatives_from
        parts.append(Trajectory(time, q, qd, qdd, *about, gaps, recording))
    return tuple(parts) or (whole,)


def _recording(motions: Sequence[Trajectory]) -> Recording | None:
    """Readings of all motions, if all have some; filter and noise are each joint's worst."""
    recordings = [motion.recording for motion in motions if motion.recording is not None]
    if len(recordings) < len(motions):
        return None

    def joined(parts: Sequence[FloatArray | None]) -> FloatArray | None:
        arrays = [part for part in parts if part is not None]
        return np.concatenate(arrays) if len(arrays) == len(parts) else None

    cutoffs = joined([None if each.cutoff is None else each.cutoff[None] for each in recordings])
    common = "not all of the motions were smoothed"
    if cutoffs is not None:
        ends = dict.fromkeys(f"{number(float(cutoff))} Hz" for cutoff in (cutoffs.min(), cutoffs.max()))
        common = f"each motion smoothed by itself, cut-off {' to '.join(ends)}"
    notes = (
        f"{motion.name}: {note}"
        for motion, recording in zip(motions, recordings, strict=True)
        for note in recording.treatment
    )
    return Recording(
        np.concatenate([recording.q for recording in recordings]),
        joined([recording.torque for recording in recordings]),
        joined([recording.torque_filtered for recording in recordings]),
        None if cutoffs is None else cutoffs.min(axis=0),
        np.max([recording.noise_q for recording in recordings], axis=0),
        np.max([recording.noise_qdd for recording in recordings], axis=0),
        recordings[0].columns,
        (*notes, common),
        joined([recording.qd for recording in recordings]),
    )
