"""Several motions of one arm as one trajectory, and back."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from itertools import chain, count
from os import PathLike
from pathlib import Path

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.motions.logged import Recording
from gd_analyze.motions.read import files_in, read_trajectory, shipped_trajectories
from gd_analyze.motions.reading import refusal
from gd_analyze.motions.trajectory import Motion, Trajectory, in_words
from gd_analyze.robots.arm import RobotArm
from gd_analyze.text import in_python, number, visible

# One motion or its source; or several, or a folder of them.
GivenMotion = Trajectory | str | Path
GivenMotions = GivenMotion | Sequence[GivenMotion]
Read = Callable[[str | Path, RobotArm], Trajectory]

# Most motions spelt out in a pool's name, and its largest length, as it also names a folder.
_SPELT_OUT, _LONGEST = 3, 80
# Pause between two motions, as a share of their mean duration; in s if all are instants.
_PAUSE, _STILL = 0.1, 1.0


def trajectory_of(given: GivenMotions, arm: RobotArm, read: Read = read_trajectory) -> Trajectory:
    """Take a trajectory, or read those given by names, files and folders; several become a pool."""
    if isinstance(given, Trajectory):
        return given
    several, name = _several(given)
    return pool(_each(several, arm, read), name)


def motions_of(given: GivenMotions, arm: RobotArm, read: Read = read_trajectory) -> list[Trajectory]:
    """Take the same motions separately, without readings and with distinct names."""
    return _apart(_each(_several(given)[0], arm, read))


def _several(given: GivenMotions) -> tuple[list[GivenMotion], str | None]:
    """Motions, with folders replaced by their files; and the folder's name if only one is given."""
    entries = list(given) if isinstance(given, Sequence) and not isinstance(given, str) else [given]
    several, name = list[GivenMotion](), None
    for entry in entries:
        named = isinstance(entry, str | PathLike) and str(entry) not in shipped_trajectories()
        files = files_in(Path(str(entry))) if named else None
        if files is not None and len(entries) == 1:
            name = visible(Path(str(entry)).resolve().name)
        several += [entry] if files is None else files
    return several, name


def _each(several: Sequence[GivenMotion], arm: RobotArm, read: Read) -> Iterator[Trajectory]:
    return (one if isinstance(one, Trajectory) else read(one, arm) for one in several)


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
    parts = _apart(motions)
    if len(parts) == 1:
        return parts[0]
    names = [one.name for one in parts]
    mean = float(np.mean([one.time[-1] - one.time[0] for one in parts]))
    pause = float(f"{_PAUSE * mean:.1g}") or _STILL
    clocks: list[FloatArray] = []
    for one in parts:
        start = float(clocks[-1][-1]) + pause if clocks else 0.0
        clocks.append(one.time - one.time[0] + start)
    ends: list[int] = np.cumsum([one.n_set_points for one in parts]).tolist()
    begins = [0, *ends[:-1]]
    own_gaps = {first + row for first, one in zip(begins, parts, strict=True) for row in one.gaps}
    sources = {one.derivatives_from for one in parts}
    spelt = "+".join(names)
    if len(names) > _SPELT_OUT or len(spelt) > _LONGEST:
        spelt = f"{names[0]}+{len(names) - 1}-more"
    q, qd, qdd = (np.concatenate([getattr(one, what) for one in parts]) for what in ("q", "qd", "qdd"))
    return Trajectory(
        np.concatenate(clocks),
        q,
        qd,
        qdd,
        name=name or spelt,
        origin=f"{in_words(names)}, one after the other with {number(pause)} s between",
        derivatives_from=sources.pop() if len(sources) == 1 else "as each motion states",
        gaps=tuple(sorted({*begins[1:], *own_gaps})),
        recording=_recording(parts),
        motions=tuple(
            Motion(of.name, first, end, float(of.time[0]), of.origin, of.derivatives_from, of.fingerprint)
            for of, first, end in zip(parts, begins, ends, strict=True)
        ),
    )


def _apart(motions: Iterable[Trajectory]) -> list[Trajectory]:
    """Motions of one arm with distinct names; at least one."""
    found: list[Trajectory] = []
    for one in motions:
        if not isinstance(one, Trajectory):
            raise refusal("this is not a trajectory", "motions", "a Trajectory", in_python(one))
        found += taken_apart(one)
    if not found:
        raise refusal("there are no motions", "motions", "at least one", "none")
    first, taken = found[0], set[str]()
    for k, one in enumerate(found):
        if one.n_joints != first.n_joints:
            what, where = f"trajectory {one.name} is for a different arm", f"trajectory {one.name}"
            expected, step = f"{first.n_joints} joints, as {first.name} has", "analyse the arms one by one"
            raise refusal(what, where, expected, f"{one.n_joints} joints", step)
        others = (f"{one.name}-{number}" for number in count(2))
        name = next(name for name in chain([one.name], others) if name not in taken)
        taken.add(name)
        found[k] = one if name == one.name else replace(one, name=name)
    return found


def taken_apart(whole: Trajectory) -> tuple[Trajectory, ...]:
    """Split a pool into its motions, without readings; any other trajectory is its only motion."""
    parts = []
    for of in whole.motions:
        time = whole.time[of.rows] - whole.time[of.first] + of.start
        q, qd, qdd = (x[of.rows] for x in (whole.q, whole.qd, whole.qdd))
        gaps = tuple(row - of.first for row in whole.gaps if of.first < row < of.end)
        parts.append(Trajectory(time, q, qd, qdd, of.name, of.origin, of.derivatives_from, gaps))
    return tuple(parts) or (whole,)


def _recording(motions: Sequence[Trajectory]) -> Recording | None:
    """Readings of all motions, if all have some; filter and noise are each joint's worst."""
    found = [one.recording for one in motions if one.recording is not None]
    if len(found) < len(motions):
        return None

    def joined(parts: Sequence[FloatArray | None]) -> FloatArray | None:
        held = [part for part in parts if part is not None]
        return np.concatenate(held) if len(held) == len(parts) else None

    cutoffs = [one.cutoff for one in found if one.cutoff is not None]
    cutoff, common = None, "not all of the motions were smoothed"
    if len(cutoffs) == len(found):
        cutoff = np.min(cutoffs, axis=0)
        ends = dict.fromkeys(f"{number(float(of(cutoffs)))} Hz" for of in (np.min, np.max))
        common = f"each motion smoothed by itself, cut-off {' to '.join(ends)}"
    notes = (f"{of.name}: {note}" for of, one in zip(motions, found, strict=True) for note in one.treatment)
    return Recording(
        np.concatenate([one.q for one in found]),
        joined([one.torque for one in found]),
        joined([one.torque_filtered for one in found]),
        cutoff,
        np.max([one.noise_q for one in found], axis=0),
        np.max([one.noise_qdd for one in found], axis=0),
        found[0].columns,
        (*notes, common),
    )
