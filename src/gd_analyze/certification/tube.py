"""A tube of states: all states within margins of a motion, between its set points too."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import CHUNK, FloatArray
from gd_analyze.certification.between import Between
from gd_analyze.certification.box import Box
from gd_analyze.errors import TrajectoryError, UsageError, require_type
from gd_analyze.motions.margin import Margin
from gd_analyze.motions.pool import taken_apart
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.robots.arm import RobotArm
from gd_analyze.text import LARGEST, named_joints, number

IndexArray = NDArray[np.intp]

# Most boxes, a second's work: intervals of a long recording share boxes.
MOST_PIECES = 2048

# Most pieces of one interval: more would only resolve an interval that the set points leave ambiguous.
_MOST_PER_INTERVAL = 32
# Share of a margin below which differences count as rounding of the numbers in a file.
_ROUNDING_SHARE = 1e-3
# Share of a joint's largest value that replaces a margin of zero when sizes are compared with margins.
_LEAST_SIZE = 0.02
# Most intervals, or groups of them, treated separately: several times the number of boxes.
_MOST_GROUPS = 8 * MOST_PIECES


@dataclass(frozen=True, eq=False)
class Tube:
    """A chain of boxes of states along a motion.

    Each box belongs to a time interval. It holds the states whose q, qd and qdd are within the margins of the
    motion's values in that interval; see `Between` for the motion between set points. If the possible motions
    between two set points differ by more than the margin, the boxes between them contain all of these. There
    is no box across a gap of the motion. Each of several motions has its own boxes and margins.

    Parameters
    ----------
    lower, upper
        Limits of q, qd and qdd, SI, shape (pieces, 3, n).
    begin, end
        Time interval of each box, s, shape (pieces,).
    margins
        Margins of q, qd and qdd, SI, shape (3, n); the smallest of several motions.
    where
        Name of these states.
    coarse
        Number of intervals between set points in which possible motions differ by more than the margins.
    note
        Remark on gaps and on these intervals, or "".
    margin, fingerprint
        Text of the margin, and the motion's fingerprint.
    motion
        Motion of each box, from 0, if there are several, shape (pieces,).
    weights
        Weight of a torque error in each box, shape (pieces, n), see `States.weights`; None if equal.
    """

    lower: FloatArray
    upper: FloatArray
    begin: FloatArray
    end: FloatArray
    margins: FloatArray
    where: str
    coarse: int = 0
    note: str = ""
    margin: str = ""
    fingerprint: str = ""
    motion: NDArray[np.intp] | None = None
    weights: FloatArray | None = None

    @property
    def n_joints(self) -> int:
        """Number of joints n."""
        return int(self.lower.shape[2])

    def __len__(self) -> int:
        return len(self.lower)

    def pieces(self, count: int, rng: np.random.Generator) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Limits of q, qd, qdd (3, count, n) to draw states from; what errors count there (count, n)."""
        chosen = rng.integers(len(self), size=count)
        counts = np.ones((count, self.n_joints)) if self.weights is None else self.weights[chosen]
        return self.lower[chosen].swapaxes(0, 1), self.upper[chosen].swapaxes(0, 1), counts

    def contains(self, q: FloatArray, qd: FloatArray, qdd: FloatArray) -> NDArray[np.bool_]:
        """Whether each state, shape (N, n) each, lies in a box, shape (N,)."""
        states = np.stack([q, qd, qdd], axis=1).reshape(len(q), -1)
        lower, upper = self.lower.reshape(len(self), -1), self.upper.reshape(len(self), -1)
        inside = np.zeros(len(states), dtype=bool)
        # Most boxes are left after a joint or two, and most states are in one of the first boxes that fit.
        order = np.argsort(states[:, 0], kind="stable")
        sorted_values = states[order, 0]
        for low, high in zip(lower, upper, strict=True):
            first, last = (
                np.searchsorted(sorted_values, low[0]),
                np.searchsorted(sorted_values, high[0], "right"),
            )
            rows = order[first:last]
            rows = rows[~inside[rows]]
            inside[rows] = ((low <= states[rows]) & (states[rows] <= high)).all(axis=1)
        return inside

    def counts_at(self, states: FloatArray) -> FloatArray:
        """Weights of errors at states of the tube (3, M, n), the largest where boxes meet, shape (M, n)."""
        if self.weights is None:
            return np.ones(states.shape[1:])
        insides = (
            ((self.lower <= state) & (state <= self.upper)).all(axis=(1, 2))
            for state in states.swapaxes(0, 1)
        )
        return np.array([self.weights[inside].max(axis=0, initial=1.0) for inside in insides])

    @property
    def enclosing(self) -> Box:
        """The smallest box around all boxes."""
        largest = np.maximum(np.abs(self.lower), np.abs(self.upper)).max(axis=0)
        return Box(self.lower[:, 0].min(axis=0), self.upper[:, 0].max(axis=0), largest[1], largest[2])

    @classmethod
    def along(
        cls, arm: RobotArm, motion: Trajectory, margin: Margin | str | None = None, *, most: int = MOST_PIECES
    ) -> Tube:
        """Enclose a motion in a tube.

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
            If the motion has another number of joints.
        TrajectoryError
            If two set points are so close in time that no motion leads from one to the next.
        """
        require_type(motion, Trajectory, "motion", "a Trajectory")
        if motion.n_joints != arm.n_joints:
            message, expected = f"the trajectory does not fit arm {arm.name}", f"{arm.n_joints} joints"
            raise UsageError(message, where=motion.name, expected=expected, found=f"{motion.n_joints}")
        margin = Margin.of(margin)
        if motion.motions:
            return cls._around(arm, motion, margin, most)
        margins = margin.along(arm, motion)
        path = _Path(motion, margins)
        # Set points between two gaps are boxes without extent.
        single = [part.start for part in motion.stretches if part.stop - part.start == 1]
        state = np.stack([motion.q[single], motion.qd[single], motion.qdd[single]], axis=1)
        pairs = zip(path.boxes(most), (state, state, motion.time[single], motion.time[single]), strict=True)
        lower, upper, begin, end = map(np.concatenate, pairs)
        order = np.argsort(begin, kind="stable")
        return cls(
            lower[order] - margins,
            upper[order] + margins,
            begin[order],
            end[order],
            margins,
            f"{margin.in_words(arm)} of {motion.name}",
            int(path.coarse.sum()),
            path.note(),
            str(margin),
            motion.fingerprint,
        )

    @classmethod
    def _around(cls, arm: RobotArm, several: Trajectory, margin: Margin, most: int) -> Tube:
        parts = taken_apart(several)
        tubes = [cls.along(arm, part, margin, most=max(1, most // len(parts))) for part in parts]
        # On the clock of the whole.
        later = [float(several.time[motion.first]) - motion.start for motion in several.motions]
        notes = (f"{part.name}: {tube.note}" for part, tube in zip(parts, tubes, strict=True) if tube.note)
        pairs = zip(tubes, later, strict=True)
        boxes = ((tube.lower, tube.upper, tube.begin + t, tube.end + t) for tube, t in pairs)
        lower, upper, begin, end = map(np.concatenate, zip(*boxes, strict=True))
        return cls(
            *(lower, upper, begin, end),
            np.min([tube.margins for tube in tubes], axis=0),
            f"{margin.in_words(arm)} of {several.name}",
            sum(tube.coarse for tube in tubes),
            " ".join(notes),
            str(margin),
            several.fingerprint,
            np.repeat(np.arange(len(tubes)), [len(tube) for tube in tubes]),
        )


class _Path:
    """The motion between set points, interval by interval; an interval across a gap has nan for limits.

    For a long motion, groups of consecutive intervals replace intervals.
    """

    def __init__(self, motion: Trajectory, margins: FloatArray) -> None:
        self.motion, self.margins = motion, margins
        length = 1
        while (motion.n_set_points - 1) / length > _MOST_GROUPS:
            length *= 2
        # First intervals of the groups; index of each in its stretch; whether it is not across a gap.
        firsts, places, are_known = list[IndexArray](), list[IndexArray](), list[NDArray[np.bool_]]()
        for part in motion.stretches:
            inside = np.arange(part.start, part.stop - 1, length)
            gap = [part.stop - 1] if part.stop < motion.n_set_points else []
            firsts += [inside, np.array(gap, dtype=np.intp)]
            places += [np.arange(len(inside) + len(gap))]
            are_known += [np.ones(len(inside), dtype=bool), np.zeros(len(gap), dtype=bool)]
        self.edges = np.append(np.concatenate(firsts), motion.n_set_points - 1)
        self.place, self.is_separate = np.concatenate(places), length == 1
        self.is_known = np.concatenate(are_known)
        count = len(self.edges) - 1
        # Limits, largest differences of the possible motions, shape (groups, 3, n), and number of intervals
        # in which these exceed the margins.
        self.lower, self.upper, self.differences = (np.empty((count, *margins.shape)) for _ in range(3))
        self.coarse = np.zeros(count, dtype=np.intp)
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            # The coefficients of a long recording do not fit into memory at once.
            step = max(1, CHUNK // length)
            for first in range(0, count, step):
                self._reduce(first, min(first + step, count))
        across = ~self.is_known
        self.lower[across] = self.upper[across] = np.nan
        self.differences[across], self.coarse[across] = 0.0, 0
        largest = np.maximum(np.abs(self.lower), np.abs(self.upper))
        wrong = np.flatnonzero(~(largest <= LARGEST).all(axis=(1, 2)) & self.is_known)
        if wrong.size:
            at, time = int(self.edges[wrong[0]]), motion.time
            at += int(np.diff(time[at : self.edges[wrong[0] + 1] + 1]).argmin())
            raise TrajectoryError(
                "no possible motion leads from one set point to the next",
                where=f"set points {at + 1} and {at + 2} of trajectory {motion.name}",
                expected=f"velocities and accelerations up to {LARGEST:g} in SI units",
                found=f"{time[at + 1] - time[at]:.3g} s between them",
                next_step="check that no two set points share almost the same instant",
            )
        self.unsure = self.differences > self._sure(np.nan_to_num(largest))

    def _sure(self, largest: FloatArray) -> FloatArray:
        """Difference that is treated as zero."""
        return np.maximum(self.margins, 64 * np.finfo(float).eps * largest)

    def _reduce(self, first: int, last: int) -> None:
        """Enclose the motion in some groups."""
        edges = self.edges[first : last + 1]
        part = slice(int(edges[0]), int(edges[-1]))
        groups, rounding = slice(first, last), _ROUNDING_SHARE * self.margins[:2]
        exact = self.is_separate
        if not exact:
            lower, upper, differences = Between.along_lines(self.motion, rounding, part)
            exact = not (differences <= self.margins).all()
        if exact:
            between = Between.of(self.motion, rounding, part)
            begin = np.zeros(len(between.coefficients))
            lower, upper = between.ranges(begin, begin + 1.0)
            differences = between.differences
        starts = edges[:-1] - edges[0]
        largest = np.nan_to_num(np.maximum(np.abs(lower), np.abs(upper)))
        coarse = (differences > self._sure(largest)).any(axis=(1, 2))
        self.lower[groups] = np.minimum.reduceat(lower, starts)
        self.upper[groups] = np.maximum.reduceat(upper, starts)
        self.differences[groups] = np.maximum.reduceat(differences, starts)
        self.coarse[groups] = np.add.reduceat(coarse.astype(np.intp), starts)

    def boxes(self, most: int) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Limits and times of at most `most` boxes, as small as the margins if possible."""
        if not self.is_known.any():
            nothing = np.empty((0, *self.margins.shape))
            return nothing, nothing, np.empty(0), np.empty(0)
        # Half the range of positions, largest velocities and accelerations; these reductions ignore nan.
        low, high = np.fmin.reduce(self.lower), np.fmax.reduce(self.upper)
        reach = np.maximum(high, -low)
        reach[0] = (high[0] - low[0]) / 2
        scale = 2 * np.maximum(self.margins, _LEAST_SIZE * reach)
        widths = np.where(self.unsure | ~self.is_known[:, None, None], 0.0, self.upper - self.lower)
        shares = np.divide(widths, scale, out=np.zeros_like(widths), where=scale > 0.0).max(axis=(1, 2))
        size = 1.0
        while True:
            first, count = self._joined(size * scale)
            is_known = self.is_known[first]
            first, count = first[is_known], count[is_known]
            pieces = np.clip(np.ceil(shares[first] / size), 1, _MOST_PER_INTERVAL)
            parts = np.where((count == 1) & self.is_separate, pieces, 1).astype(int)
            # Every stretch takes at least one box.
            if parts.sum() <= most or len(first) <= len(self.motion.gaps) + 1:
                return self._cut(first, count, np.minimum(parts, most))
            size *= 1.5

    def _joined(self, size: FloatArray) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """First interval and number of intervals of every group that fits a box of this size, shape (3, n).

        Neighbours of one stretch are joined in pairs, the pairs in pairs, and so on.
        """
        place = self.place
        first, count = np.arange(len(self.lower)), np.ones(len(self.lower), dtype=np.intp)
        lower, upper = self.lower.copy(), self.upper.copy()
        span = 1
        while span < len(self.lower):
            pairs = np.flatnonzero((place[first] % (2 * span) == 0) & (count == span))
            pairs = pairs[pairs + 1 < len(first)]
            pairs = pairs[first[pairs + 1] == first[pairs] + span]
            low, high = np.minimum(lower[pairs], lower[pairs + 1]), np.maximum(upper[pairs], upper[pairs + 1])
            fits = (high - low <= size).all(axis=(1, 2))
            pairs, low, high = pairs[fits], low[fits], high[fits]
            if not len(pairs):
                break
            count[pairs] += count[pairs + 1]
            lower[pairs], upper[pairs] = low, high
            first, count, lower, upper = (np.delete(x, pairs + 1, 0) for x in (first, count, lower, upper))
            span *= 2
        return first, count

    def _cut(
        self, first: NDArray[np.intp], count: NDArray[np.intp], parts: NDArray[np.intp]
    ) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Limits and times of groups of intervals; single intervals are cut into parts of equal length."""
        groups = np.repeat(np.arange(len(first)), parts)
        place = np.arange(len(groups)) - np.repeat(np.cumsum(parts) - parts, parts)
        # A group ends where the next begins, or before the interval across a gap after it.
        edges = np.stack([first, first + count], axis=1).ravel()
        edges = edges[edges < len(self.lower)]
        lower = np.minimum.reduceat(self.lower, edges)[::2][groups]
        upper = np.maximum.reduceat(self.upper, edges)[::2][groups]
        starts, ends = self.motion.time[self.edges[first]], self.motion.time[self.edges[first + count]]
        begin = starts[groups] + place * ((ends - starts) / parts)[groups]
        end = np.where(place + 1 < parts[groups], np.append(begin[1:], 0.0), ends[groups])
        cut = np.flatnonzero(parts[groups] > 1)
        if cut.size:
            part, part_counts, intervals = place[cut], parts[groups[cut]], first[groups[cut]]
            between = Between.of(self.motion, _ROUNDING_SHARE * self.margins[:2], intervals)
            low, high = between.ranges(part / part_counts, (part + 1) / part_counts)
            lower[cut] = np.where(self.unsure[intervals], lower[cut], low)
            upper[cut] = np.where(self.unsure[intervals], upper[cut], high)
        return lower, upper, begin, end

    def note(self) -> str:
        """Remark on gaps, and on intervals that are ambiguous by more than the margins, or ""."""
        notes = []
        if self.motion.gaps:
            notes.append(f"Gaps in the motion: {len(self.motion.gaps)}; nothing is proven across them.")
        if self.unsure.any():
            intervals, kinds, joints = np.nonzero(self.unsure)
            with np.errstate(divide="ignore"):
                times = self.differences[self.unsure] / self.margins[kinds, joints]
            widest = int(times.argmax())
            quantity = ("position", "velocity", "acceleration")[kinds[widest]]
            by = f"{number(times[widest], 2)} times its margin"
            by = by if np.isfinite(times[widest]) else "its margin being zero"
            begin, end = self.motion.time[self.edges[intervals[widest] : intervals[widest] + 2]]
            numbers = [int(joint) + 1 for joint in np.unique(joints)]
            count = int(np.diff(self.edges)[self.is_known].sum())
            notes.append(
                f"Set points too far apart in {self.coarse.sum()} of {count} intervals "
                f"({named_joints(numbers, self.motion.n_joints)}): the tube is wider there. "
                f"Largest ambiguity: {quantity} of joint {joints[widest] + 1}, {by}, "
                f"from {begin:.4g} to {end:.4g} s."
            )
        return " ".join(notes)
