"""A tube of states: all within margins of a motion, between its set points too."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, fields
from operator import itemgetter

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import FloatArray, chunks
from gd_analyze.certification.box import Box
from gd_analyze.errors import TrajectoryError, UsageError
from gd_analyze.motions.between import Between
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.robots.arm import RobotArm
from gd_analyze.text import LARGEST, UNSIGNED, named_joints

# Entries of a margin: field, and factor to its unit.
_UNITS = {
    "deg": ("revolute", math.pi / 180),
    "rad": ("revolute", 1.0),
    "mm": ("prismatic", 1e-3),
    "m": ("prismatic", 1.0),
    "qd%": ("velocity", 1e-2),
    "qdd%": ("acceleration", 1e-2),
}

# Most boxes, a second's work: intervals of a long recording share boxes.
MOST_PIECES = 2048
# Most pieces of one interval: more would only resolve an interval that the set points leave open.
_MOST_OF_ONE = 32
# Share of a margin below which differences count as rounding of the numbers in a file.
_ROUNDING = 1e-3
# Share of a joint's largest value that replaces a margin of zero where sizes are compared with margins.
_LEAST_SHARE = 0.02


@dataclass(frozen=True)
class Margin:
    """Largest distance of states from the motion; by default what a drive that follows it well keeps.

    A joint that is held still has a margin of position only, as its peak velocity is zero.

    Parameters
    ----------
    revolute, prismatic
        Positions of revolute joints, rad, and of prismatic joints, m.
    velocity, acceleration
        Velocities and accelerations, as shares of each joint's largest along the motion.

    Raises
    ------
    UsageError
        If one is negative, not finite or above 1e12.
    """

    revolute: float = math.radians(1.0)
    prismatic: float = 1e-3
    velocity: float = 0.02
    acceleration: float = 0.05

    def __post_init__(self) -> None:
        for entry in fields(self):
            value = getattr(self, entry.name)
            if not 0.0 <= value <= LARGEST:
                raise UsageError(
                    "a margin is out of range",
                    where=f"Margin, {entry.name}",
                    expected=f"0 or more, up to {LARGEST:g}",
                    found=f"{value:g}",
                )

    @classmethod
    def of(cls, given: Margin | str | None) -> Margin:
        """Margin from its text, itself, or the default."""
        return cls.parse(given) if isinstance(given, str) else given or cls()

    @classmethod
    def parse(cls, text: str) -> Margin:
        """Read "1deg,1mm,qd=2%,qdd=5%", or some of these entries; others are as by default.

        Raises
        ------
        UsageError
            If an entry is not understood, or a margin is given twice.

        Examples
        --------
        >>> Margin.parse("0.5deg,qd=1%").velocity
        0.01
        """
        given: dict[str, float] = {}
        for column, entry in enumerate(text.split(","), start=1):
            match = re.fullmatch(rf"(?:(qdd?)=)?({UNSIGNED}) ?(deg|rad|mm|m|%)", entry.strip())
            unit = match and (match[1] or "") + match[3]
            if match is None or unit not in _UNITS:
                raise UsageError(
                    "the margin is not understood",
                    where=f"--margin, entry {column}",
                    expected="entries such as 1deg or 1mm for positions, qd=2% for velocities and qdd=5% for "
                    "accelerations, comma-separated",
                    found=repr(entry.strip()),
                )
            name, factor = _UNITS[unit]
            if name in given:
                raise UsageError(
                    "a margin is given twice",
                    where=f"--margin, entry {column}",
                    expected="one entry each",
                    found=repr(text),
                )
            given[name] = float(match[2]) * factor
        return cls(**given)

    def __str__(self) -> str:
        """Text that `parse` reads."""
        return (
            f"{math.degrees(self.revolute):.12g}deg,{1e3 * self.prismatic:.12g}mm,"
            f"qd={100 * self.velocity:.12g}%,qdd={100 * self.acceleration:.12g}%"
        )

    def in_words(self, arm: RobotArm) -> str:
        """Text for the kinds of joints that an arm has.

        Examples
        --------
        >>> from gd_analyze.robots.catalogue import load_arm
        >>> Margin().in_words(load_arm("puma560"))
        '1°, 2 % of peak velocity and 5 % of peak acceleration'
        """
        kinds = {
            "revolute": f"{math.degrees(self.revolute):.6g}°",
            "prismatic": f"{1e3 * self.prismatic:.6g} mm",
        }
        present = {joint.kind for joint in arm.joints}
        positions = " or ".join(text for kind, text in kinds.items() if kind in present)
        velocity, acceleration = 100 * self.velocity, 100 * self.acceleration
        return f"{positions}, {velocity:.6g} % of peak velocity and {acceleration:.6g} % of peak acceleration"

    def along(self, arm: RobotArm, motion: Trajectory) -> FloatArray:
        """Margins of q, qd and qdd of every joint along a motion, SI, shape (3, n)."""
        position = np.where(np.array(arm.is_revolute), self.revolute, self.prismatic)
        peaks = [np.abs(values).max(axis=0) for values in (motion.qd, motion.qdd)]
        return np.stack([position, self.velocity * peaks[0], self.acceleration * peaks[1]])


@dataclass(frozen=True, eq=False)
class Tube:
    """A chain of boxes of states along a motion.

    Each box is about some time. It holds the states whose q, qd and qdd are within the margins of what the
    motion takes in that time; see `Between` for the motion between set points. If the possible motions
    between two set points differ by more than the margin, every box between them holds all that any of them
    takes there. Across a gap of the motion there is no box.

    Parameters
    ----------
    lower, upper
        Limits of q, qd and qdd, SI, shape (pieces, 3, n).
    begin, end
        Time that each box is about, s, shape (pieces,).
    margins
        Of q, qd and qdd, shape (3, n).
    where
        Name of these states.
    coarse
        Number of intervals between set points in which possible motions differ by more than the margins.
    note
        Remark on gaps and on these intervals, or "".
    """

    lower: FloatArray
    upper: FloatArray
    begin: FloatArray
    end: FloatArray
    margins: FloatArray
    where: str
    coarse: int = 0
    note: str = ""

    @property
    def n_joints(self) -> int:
        """Number of joints n."""
        return int(self.lower.shape[2])

    def __len__(self) -> int:
        return len(self.lower)

    @property
    def enclosing(self) -> Box:
        """The smallest box around all."""
        largest = np.maximum(np.abs(self.lower), np.abs(self.upper)).max(axis=0)
        return Box(self.lower[:, 0].min(axis=0), self.upper[:, 0].max(axis=0), largest[1], largest[2])

    @classmethod
    def along(
        cls, arm: RobotArm, motion: Trajectory, margin: Margin | str | None = None, *, most: int = MOST_PIECES
    ) -> Tube:
        """Enclose a motion.

        Parameters
        ----------
        arm, motion
            The arm and its motion.
        margin
            A margin or its text, see `Margin.parse`.
        most
            Most boxes; intervals of a longer motion share them.

        Raises
        ------
        UsageError
            If the motion is of another number of joints.
        TrajectoryError
            If two set points are so close in time that no motion leads from one to the next.
        """
        if motion.n_joints != arm.n_joints:
            raise UsageError(
                f"the trajectory does not fit arm {arm.name}",
                where=motion.name,
                expected=f"{arm.n_joints} joints",
                found=f"{motion.n_joints}",
            )
        around = Margin.of(margin)
        margins = around.along(arm, motion)
        where = f"{around.in_words(arm)} of {motion.name}"
        path = _Path(motion, margins)
        parts = path.boxes(most), _single(motion)
        lower, upper, begin, end = (np.concatenate(pair) for pair in zip(*parts, strict=True))
        order = np.argsort(begin, kind="stable")
        lower, upper, begin, end = lower[order], upper[order], begin[order], end[order]
        gaps = f"Gaps in the motion: {len(motion.gaps)}; nothing is proven across them." * bool(motion.gaps)
        note = " ".join(filter(None, (gaps, path.note())))
        coarse = int(path.unsure.any(axis=(1, 2)).sum())
        return cls(lower - margins, upper + margins, begin, end, margins, where, coarse, note)


def _single(motion: Trajectory) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Set points between two gaps, as boxes without extent."""
    at = [part.start for part in motion.stretches if part.stop - part.start == 1]
    state = np.stack([motion.q[at], motion.qd[at], motion.qdd[at]], axis=1)
    return state, state, motion.time[at], motion.time[at]


class _Path:
    """The motion between its set points, interval by interval.

    `lower` and `upper` are its limits in every interval, `differences` largest differences of the possible
    motions, `unsure` where these exceed the margin; shape (intervals, 3, n). An interval across a gap has nan
    for limits and joins no other.
    """

    def __init__(self, motion: Trajectory, margins: FloatArray) -> None:
        self.motion, self.margins = motion, margins
        count = motion.n_set_points - 1
        self.known = np.ones(count, dtype=bool)
        self.known[np.array(motion.gaps, dtype=int) - 1] = False
        # Number of each interval in its stretch.
        self.place = np.concatenate([np.arange(part.stop - part.start) for part in motion.stretches])[:-1]
        self.lower, self.upper, self.differences = (np.empty((count, *margins.shape)) for _ in range(3))
        self.unsure = np.empty(self.lower.shape, dtype=bool)
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            # There is no memory for all coefficients of a long recording at once.
            for part in chunks(count):
                self._fill(part)

    def _fill(self, part: slice) -> None:
        between, across = self._between(part), ~self.known[part]
        begin = np.zeros(len(between.coefficients))
        low, high = between.ranges(begin, begin + 1.0)
        differences = between.differences
        low[across] = high[across] = np.nan
        differences[across] = 0.0
        largest = np.maximum(np.abs(low), np.abs(high))
        self._require_possible(part.start, largest)
        noise = 64 * np.finfo(float).eps * np.nan_to_num(largest)
        self.lower[part], self.upper[part], self.differences[part] = low, high, differences
        self.unsure[part] = differences > np.maximum(self.margins, noise)

    def _between(self, chosen: slice | NDArray[np.intp]) -> Between:
        return Between.of(self.motion, _ROUNDING * self.margins[:2], chosen)

    def _require_possible(self, start: int, largest: FloatArray) -> None:
        wrong = ~(largest <= LARGEST).all(axis=(1, 2)) & self.known[start : start + len(largest)]
        if wrong.any():
            at = start + int(np.flatnonzero(wrong)[0])
            time = self.motion.time
            raise TrajectoryError(
                "no possible motion leads from one set point to the next",
                where=f"set points {at + 1} and {at + 2} of trajectory {self.motion.name}",
                expected=f"velocities and accelerations up to {LARGEST:g} in SI units",
                found=f"{time[at + 1] - time[at]:.3g} s between them",
                next_step="check that no two set points share almost the same instant",
            )

    def boxes(self, most: int) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Limits and times of at most `most` boxes, as small as the margins if possible."""
        if not self.known.any():
            nothing = np.empty((0, *self.margins.shape))
            return nothing, nothing, np.empty(0), np.empty(0)
        scale = 2 * np.maximum(self.margins, _LEAST_SHARE * self._reach())
        sizes, size = self._sizes(scale), 1.0
        while True:
            first, count = self._joined(size * scale)
            kept = self.known[first]
            first, count = first[kept], count[kept]
            pieces = np.clip(np.ceil(sizes[first] / size), 1, _MOST_OF_ONE)
            parts = np.where(count == 1, pieces, 1).astype(int)
            # Every stretch takes one box at least.
            if parts.sum() <= most or len(first) <= len(self.motion.gaps) + 1:
                return self._cut(first, count, np.minimum(parts, most))
            size *= 1.5

    def _sizes(self, scale: FloatArray) -> FloatArray:
        """Size of every interval in boxes of this scale, where the motion is known."""
        sizes = np.empty(len(self.lower))
        for part in chunks(len(sizes)):
            unknown = self.unsure[part] | ~self.known[part, None, None]
            widths = np.where(unknown, 0.0, self.upper[part] - self.lower[part])
            shares = np.divide(widths, scale, out=np.zeros_like(widths), where=scale > 0.0)
            sizes[part] = shares.max(axis=(1, 2))
        return sizes

    def _reach(self) -> FloatArray:
        """Half the range of positions, and the largest velocities and accelerations, shape (3, n)."""
        # These reductions ignore nan.
        low, high = np.fmin.reduce(self.lower), np.fmax.reduce(self.upper)
        largest = np.maximum(high, -low)
        largest[0] = (high[0] - low[0]) / 2
        return np.asarray(largest)

    def _joined(self, size: FloatArray) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """First interval and number of intervals of every group that fits a box of this size, shape (3, n).

        Neighbours of one stretch are joined in pairs, the pairs in pairs, and so on.
        """
        first, count = np.arange(len(self.lower)), np.ones(len(self.lower), dtype=np.intp)
        lower, upper = self.lower, self.upper
        span = 1
        while span < len(self.lower):
            left = np.flatnonzero((self.place[first] % (2 * span) == 0) & (count == span))
            left = left[left + 1 < len(first)]
            left = left[first[left + 1] == first[left] + span]
            low, high = np.minimum(lower[left], lower[left + 1]), np.maximum(upper[left], upper[left + 1])
            fits = (high - low <= size).all(axis=(1, 2))
            left, low, high = left[fits], low[fits], high[fits]
            if not len(left):
                break
            kept = np.ones(len(first), dtype=bool)
            kept[left + 1] = False
            place, both = np.cumsum(kept)[left] - 1, count[left] + count[left + 1]
            first, count, lower, upper = first[kept], count[kept], lower[kept], upper[kept]
            count[place], lower[place], upper[place] = both, low, high
            span *= 2
        return first, count

    def _cut(
        self, first: NDArray[np.intp], count: NDArray[np.intp], parts: NDArray[np.intp]
    ) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Limits and times of groups of intervals, single intervals cut into parts of equal length."""
        groups = np.repeat(np.arange(len(first)), parts)
        place = np.arange(len(groups)) - np.repeat(np.cumsum(parts) - parts, parts)
        # A group ends before the next begins, or before the interval across a gap behind it.
        edges = np.stack([first, first + count], axis=1).ravel()
        edges = edges[edges < len(self.lower)]
        lower = np.minimum.reduceat(self.lower, edges)[::2][groups]
        upper = np.maximum.reduceat(self.upper, edges)[::2][groups]
        time = self.motion.time
        width = (time[first + count] - time[first]) / parts
        begin = time[first][groups] + place * width[groups]
        cut = np.flatnonzero(parts[groups] > 1)
        if cut.size:
            among, each = place[cut], parts[groups[cut]]
            intervals = first[groups[cut]]
            low, high = self._between(intervals).ranges(among / each, (among + 1) / each)
            unsure = self.unsure[intervals]
            lower[cut] = np.where(unsure, lower[cut], low)
            upper[cut] = np.where(unsure, upper[cut], high)
        end = np.where(place + 1 < parts[groups], np.append(begin[1:], 0.0), time[first + count][groups])
        return lower, upper, begin, end

    def note(self) -> str:
        """Remark on intervals that the set points leave open by more than the margins, or ""."""
        if not self.unsure.any():
            return ""
        most, at, kind, joint = max(map(self._widest, chunks(len(self.unsure))), key=itemgetter(0))
        joints = [int(j) + 1 for j in np.flatnonzero(self.unsure.any(axis=(0, 1)))]
        by = f"{float(f'{most:.2g}'):g} times its margin" if np.isfinite(most) else "its margin being zero"
        time = self.motion.time
        count = self.unsure.any(axis=(1, 2)).sum()
        return (
            f"Set points too far apart in {count} of {self.known.sum()} intervals "
            f"({named_joints(joints, self.motion.n_joints)}): the tube is wider there. Largest ambiguity: "
            f"{('position', 'velocity', 'acceleration')[kind]} of joint {joint + 1}, {by}, from "
            f"{time[at]:.4g} to {time[at + 1]:.4g} s."
        )

    def _widest(self, part: slice) -> tuple[float, int, int, int]:
        """Largest difference over margin in some intervals: ratio, interval, kind and joint."""
        differences = np.where(self.unsure[part], self.differences[part], 0.0)
        none = np.where(self.unsure[part], np.inf, 0.0)
        times = np.divide(differences, self.margins, out=none, where=self.margins > 0)
        at, kind, joint = map(int, np.unravel_index(times.argmax(), times.shape))
        return float(times[at, kind, joint]), part.start + at, kind, joint
