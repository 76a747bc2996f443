"""Several motions of one arm as one trajectory, and one of them again."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from os import PathLike
from pathlib import Path
from typing import TypeGuard

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import TrajectoryError
from gd_analyze.motions.csv_file import read_trajectory, shipped_trajectories
from gd_analyze.motions.folder import is_folder_of_motions, trajectory_files
from gd_analyze.motions.motions import Motion, in_words
from gd_analyze.motions.recording import Recording
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.robots.arm import RobotArm
from gd_analyze.text import in_python, number, visible

# One motion, by itself or by what it is read from; or several, or a folder of them.
GivenMotion = Trajectory | str | Path
GivenMotions = GivenMotion | Sequence[GivenMotion]

# Motions that the name of a pool spells out, and how long it may be: it is the name of a folder, too.
_SPELT_OUT, _LONGEST = 3, 80
# Between two motions, as a share of their mean duration; where none lasts, in s.
_PAUSE, _STILL = 0.1, 1.0


def trajectory_of(
    given: GivenMotions,
    arm: RobotArm,
    read: Callable[[str | Path, RobotArm], Trajectory] = read_trajectory,
) -> Trajectory:
    """Take a trajectory, or read what a shipped name, the path of a file or that of a folder stands for.

    Parameters
    ----------
    given
        A motion or a sequence of them. A folder stands for all trajectories in it, see `trajectory_files`.
    arm
        The arm that shall follow them.
    read
        Reads one file.

    Returns
    -------
    Trajectory
        One motion as it is; of several their pool, see `pool`.

    Raises
    ------
    TrajectoryError
        As `read_trajectory`, `trajectory_files` and `pool`.
    """
    if isinstance(given, Trajectory):
        return given
    several = _several(given)
    name = visible(Path(several[0]).resolve().name) if _is_only_folder(several) else None
    return pool(_each(several, arm, read), name)


def motions_of(
    given: GivenMotions,
    arm: RobotArm,
    read: Callable[[str | Path, RobotArm], Trajectory] = read_trajectory,
) -> list[Trajectory]:
    """Take the motions that `trajectory_of` makes one of, each by itself and no two of one name.

    Those of a pool come without readings.
    """
    return _apart(_each(_several(given), arm, read))


def _several(given: GivenMotions) -> list[GivenMotion]:
    return list(given) if isinstance(given, Sequence) and not isinstance(given, str) else [given]


def _each(
    several: Sequence[GivenMotion], arm: RobotArm, read: Callable[[str | Path, RobotArm], Trajectory]
) -> Iterator[Trajectory]:
    for one in several:
        if isinstance(one, Trajectory):
            yield one
        elif _is_folder(one):
            yield from (read(path, arm) for path in trajectory_files(Path(one)))
        else:
            yield read(one, arm)


def pool(motions: Iterable[Trajectory], name: str | None = None) -> Trajectory:
    """Put motions of one arm one after the other, with a pause between that nothing is known of.

    Parameters
    ----------
    motions
        Trajectories of as many joints; one alone is given back as it is.
    name
        Of the whole; "a+b" by default, or "a+7-more".

    Returns
    -------
    Trajectory
        Its `motions` tell which set points are whose, `gaps` where each begins. Time runs from 0, each motion
        by its own clock; the pause is a tenth of their mean duration. Motions of one name get different ones.
        Readings are those of all, where all have some.

    Raises
    ------
    TrajectoryError
        If there are none, or they are not of as many joints.

    Examples
    --------
    >>> rest = Trajectory([0.0], [[0.0]], [[0.0]], [[0.0]], name="rest")
    >>> pool([rest, rest]).name
    'rest+rest-2'
    """
    named = _apart(motions)
    if len(named) == 1:
        return named[0]
    pause = _pause(named)
    ends: list[int] = np.cumsum([one.n_set_points for one in named]).tolist()
    begins = [0, *ends[:-1]]
    told = in_words([one.name for one in named])
    rates = {one.rates_from for one in named}
    return Trajectory(
        _time(named, pause),
        np.concatenate([one.q for one in named]),
        np.concatenate([one.qd for one in named]),
        np.concatenate([one.qdd for one in named]),
        name=name or _name([one.name for one in named]),
        origin=f"{told}, one after the other with {number(pause)} s between",
        rates_from=rates.pop() if len(rates) == 1 else "as each motion states",
        gaps=_gaps(named, begins),
        recording=_recording(named),
        motions=tuple(
            Motion(
                one.name,
                first,
                end,
                float(one.time[0]),
                one.origin,
                one.rates_from,
                one.fingerprint,
            )
            for one, first, end in zip(named, begins, ends, strict=True)
        ),
    )


def _apart(motions: Iterable[Trajectory]) -> list[Trajectory]:
    """Motions of one arm by themselves, no two of one name; at least one."""
    given: list[Trajectory] = []
    for one in motions:
        if not isinstance(one, Trajectory):
            raise TrajectoryError(
                "this is no trajectory", where="motions", expected="a Trajectory", found=in_python(one)
            )
        given += taken_apart(one)
    if not given:
        raise TrajectoryError("there are no motions", where="motions", expected="at least one", found="none")
    _require_alike(given)
    names = _distinct(given)
    return [
        one if one.name == name else replace(one, name=name) for one, name in zip(given, names, strict=True)
    ]


def _is_folder(given: object) -> TypeGuard[str | Path]:
    return (
        isinstance(given, str | PathLike)
        and str(given) not in shipped_trajectories()
        and is_folder_of_motions(Path(given))
    )


def _is_only_folder(given: Sequence[GivenMotion]) -> TypeGuard[Sequence[str | Path]]:
    return len(given) == 1 and _is_folder(given[0])


def taken_apart(trajectory: Trajectory) -> tuple[Trajectory, ...]:
    """Take a pool apart again, without readings; any other trajectory is its only motion."""
    return tuple(_part(trajectory, motion) for motion in trajectory.motions) or (trajectory,)


def _part(whole: Trajectory, motion: Motion) -> Trajectory:
    rows = motion.rows
    return Trajectory(
        whole.time[rows] - whole.time[motion.first] + motion.start,
        whole.q[rows],
        whole.qd[rows],
        whole.qdd[rows],
        name=motion.name,
        origin=motion.origin,
        rates_from=motion.rates_from,
        gaps=tuple(row - motion.first for row in whole.gaps if motion.first < row < motion.end),
    )


def _require_alike(motions: Sequence[Trajectory]) -> None:
    first = motions[0]
    for one in motions:
        if one.n_joints != first.n_joints:
            raise TrajectoryError(
                f"trajectory {one.name} is not of the arm of the others",
                where=f"trajectory {one.name}",
                expected=f"{first.n_joints} joints, as {first.name} has",
                found=f"{one.n_joints} joints",
                next_step="analyse motions of different arms one by one",
            )


def _distinct(motions: Sequence[Trajectory]) -> list[str]:
    """Names of the motions; the second and later ones of a name get a number."""
    names: list[str] = []
    for one in motions:
        name, again = one.name, 1
        while name in names:
            again += 1
            name = f"{one.name}-{again}"
        names.append(name)
    return names


def _name(names: Sequence[str]) -> str:
    spelt = "+".join(names)
    if len(names) <= _SPELT_OUT and len(spelt) <= _LONGEST:
        return spelt
    return f"{names[0]}+{len(names) - 1}-more"


def _pause(motions: Sequence[Trajectory]) -> float:
    mean = float(np.mean([one.time[-1] - one.time[0] for one in motions]))
    return float(f"{_PAUSE * mean:.1g}") or _STILL


def _time(motions: Sequence[Trajectory], pause: float) -> FloatArray:
    clocks, now = [], 0.0
    for one in motions:
        clocks.append(one.time - one.time[0] + now)
        now = float(clocks[-1][-1]) + pause
    return np.concatenate(clocks)


def _gaps(motions: Sequence[Trajectory], begins: Sequence[int]) -> tuple[int, ...]:
    own = (first + row for first, one in zip(begins, motions, strict=True) for row in one.gaps)
    return tuple(sorted({*begins[1:], *own}))


def _recording(motions: Sequence[Trajectory]) -> Recording | None:
    """Readings of all motions, where all were measured; of filter and noise the joint's worst."""
    found = [one.recording for one in motions if one.recording is not None]
    if len(found) < len(motions):
        return None

    def joined(name: str) -> FloatArray | None:
        parts = [getattr(one, name) for one in found]
        return None if any(part is None for part in parts) else np.concatenate(parts)

    cutoffs = [one.cutoff for one in found if one.cutoff is not None]
    smoothed = np.array(cutoffs) if len(cutoffs) == len(found) else None
    return replace(
        found[0],
        q=np.concatenate([one.q for one in found]),
        torque=joined("torque"),
        torque_filtered=joined("torque_filtered"),
        cutoff=None if smoothed is None else np.min(smoothed, axis=0),
        noise_q=np.max([one.noise_q for one in found], axis=0),
        noise_qdd=np.max([one.noise_qdd for one in found], axis=0),
        treatment=(*_treatments(motions), _smoothing(smoothed)),
    )


def _treatments(motions: Sequence[Trajectory]) -> Iterator[str]:
    for motion in motions:
        for sentence in motion.recording.treatment if motion.recording else ():
            yield f"{motion.name}: {sentence}"


def _smoothing(cutoffs: FloatArray | None) -> str:
    """What the motions have in common; the last sentence tells what was done last."""
    if cutoffs is None:
        return "not all of the motions were smoothed"
    least, most = number(float(cutoffs.min())), number(float(cutoffs.max()))
    return f"each motion was smoothed by itself, cut-off {least} Hz" + (
        f" to {most} Hz" if most != least else ""
    )
