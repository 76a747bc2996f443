"""A design swept: peak torque, verdicts and operations over numbers of an arm, and where verdicts change."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from gd_analyze.arguments import require_word, strict
from gd_analyze.arrays import ROUND_OFF_SHARE, Array, FloatArray
from gd_analyze.cache import without_cache
from gd_analyze.dynamics.dominance import DOMINANCE_THRESHOLD, elements
from gd_analyze.dynamics.many_arms import CONTRIBUTIONS, VERDICT_NAMES, peaks
from gd_analyze.errors import UsageError, require_type, require_whole
from gd_analyze.motions.pool import GivenMotions, trajectory_of
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.catalogue import arm_with_masses
from gd_analyze.robots.description import fingerprint
from gd_analyze.robots.varied import SPEED, Bodies, Parameter, VariedArm
from gd_analyze.simplification.budget import Budget, ReferenceTorques
from gd_analyze.simplification.candidates import TooManyTermsError, candidates_of
from gd_analyze.simplification.element import ELEMENT
from gd_analyze.simplification.exact import too_many_terms
from gd_analyze.simplification.exact_dynamics import ExactDynamics
from gd_analyze.simplification.harmonic import TERM
from gd_analyze.simplification.levels import LEVELS, level_named
from gd_analyze.simplification.search import SearchOptions
from gd_analyze.simplification.selection import descend
from gd_analyze.simplification.simplify import simplify_exact
from gd_analyze.simplification.torque_program import COUNTING
from gd_analyze.studies.many import each
from gd_analyze.text import LARGEST, UNSIGNED
from gd_analyze.threads import one_thread

if TYPE_CHECKING:
    import xarray as xr

# Default number of points of a range.
USUAL_POINTS = 21
# Most points of all ranges for which operations are counted.
MOST_COUNTED = 1000
# Largest number of points: some hundred MB.
_MOST_POINTS = 1_000_000
_RANGE = re.compile(rf"([^=\s]+)=([-+]?{UNSIGNED})\.\.([-+]?{UNSIGNED})(?::(\d+))?")
QUICK, NONE = "quick", "none"
# A torque beyond any, N m, at which a budget's shares outweigh its amounts.
_BOUNDLESS_TORQUE = 1e30


class Range(NamedTuple):
    """A parameter, the ends of its range, and its number of values; 0 if not given."""

    parameter: Parameter
    low: float
    high: float
    values: int

    @classmethod
    def parse(cls, text: str, varied: VariedArm) -> Range:
        """Read "link3.mass=1..5:9", or without the number of values."""
        match, where = _RANGE.fullmatch(text.strip()), f"--vary {text.strip()}"
        if match is None:
            expected = "NAME=LOW..HIGH[:COUNT], such as link3.mass=1..5:9 or speed=0.1..2"
            raise UsageError("this is not a range", where="--vary", expected=expected, found=repr(text))
        name, low, high, count = match.groups()
        parsed = cls(varied.parameter(name), float(low), float(high), int(count or 0))
        for is_wrong, expected in (
            (not parsed.low < parsed.high, "two numbers, the lower one first"),
            (max(-parsed.low, parsed.high) > LARGEST, f"numbers up to {LARGEST:g}"),
            (name == SPEED and parsed.low <= 0.0, "a speed above 0"),
            (count is not None and not 2 <= parsed.values <= _MOST_POINTS, "two values to a million"),
        ):
            if is_wrong:
                raise UsageError("the range is not valid", where=where, expected=expected)
        return parsed


@strict
@one_thread()
def sweep(
    arm: RobotArm | str | Path,
    trajectory: GivenMotions,
    vary: str | Sequence[str],
    *,
    samples: int | None = None,
    seed: int = 0,
    budget: Budget | str | None = None,
    threshold: float = DOMINANCE_THRESHOLD,
    drives: bool | None = None,
    precision: float = 2e-4,
    operations: str | None = None,
    jobs: int = 1,
    stage: Callable[[str, int | None], object] = lambda label, total: None,
    progress: Callable[[int], None] = lambda count: None,
) -> xr.Dataset:
    """Vary numbers of an arm, or the speed of its motion, and find the effect on torque and verdicts.

    Everything else is held, see `VariedArm`. Variations of masses, centres of mass, inertias and speed are
    evaluated by one product of matrices, each other geometry by itself.

    Parameters
    ----------
    arm, trajectory
        The arm and its motion, in the joint variables; or a shipped name, or the path of a file.
    vary
        Ranges "link3.mass=1..5:9", named as in arm files: joint2.a (or joint2.a_mm), link3.com.x,
        link3.inertia.xx, drive1.inertia, gravity.z; speed multiplies the velocity of the motion. Several
        ranges are combined to a grid. Without a number of values a range has 21.
    samples, seed
        Draw this many arms in place of the grid, each number uniformly over its range, and the draw's seed.
    budget, threshold, drives
        As for `simplify`, `rank` and `decompose`.
    precision
        Share of each range to which the changes of verdicts between points of the grid are bisected.
    operations
        "quick": estimated from the terms left at level term, within some 20 % of a search, 0.1 s per point;
        the name of a level: of the model that `simplify` finds, seconds per point; "none". By
        default quick for grids of up to 1000 points.
    jobs
        Number of processes that evaluate geometries and count operations.
    stage, progress
        Called with the name of a stage and its number of points, and with points done since the last call.

    Returns
    -------
    xarray.Dataset
        Over the grid, a dimension per parameter, or over `sample`: `verdict` (element; and of each joint
        whether its torque without h keeps the budget), `peak_torque` (joint), `contribution` (its peaks by
        contribution) and `operations`, nan where none were counted. Along `change` every change of a verdict
        between two points of the grid: `change_element`, `change_parameter`, `change_from`, `change_to`,
        `change_at` (values of all parameters, the middle of the bracket) and `change_seen` (the value of the
        grid's next point). Two changes between the same two points may cancel and remain unseen.

    Raises
    ------
    UsageError
        If a range or a parameter is not understood, or there are too many points.
    ArmError
        If a value makes the arm invalid or physically inconsistent.

    Examples
    --------
    >>> import gd_analyze as gd
    >>> found = gd.sweep("two_link", "two-link-swing", "link2.mass=0.5..2:4", operations="none")
    >>> found.peak_torque.sizes["link2.mass"]
    4
    """
    import xarray as xr

    if operations is not None:
        require_word(operations, (QUICK, NONE, *LEVELS), "operations")
    arm = arm_with_masses(arm)
    require_whole(seed, "seed", 0)
    varied = VariedArm(arm)
    ranges, budget = _ranges_of(vary, varied), _usable(budget)
    names = [span.parameter.name for span in ranges]
    shape = _shape_of(ranges, samples)
    if samples is None:
        grid = [np.linspace(span.low, span.high, count) for span, count in zip(ranges, shape, strict=True)]
        points = np.stack([x.ravel() for x in np.meshgrid(*grid, indexing="ij")], axis=-1)
        dims, coords = names, {name: (name, values) for name, values in zip(names, grid, strict=True)}
    else:
        low, high = ([getattr(span, end) for span in ranges] for end in ("low", "high"))
        points = np.random.default_rng(seed).uniform(low, high, (samples, len(ranges)))
        dims, coords = ["sample"], {name: ("sample", points[:, k]) for k, name in enumerate(names)}
    exact = ExactDynamics.of(arm, trajectory_of(trajectory, arm), drives)
    evaluator = _Sweep(
        varied, tuple(span.parameter for span in ranges), exact.thinned(), budget, threshold, jobs
    )
    stage("evaluating", len(points))
    verdict, torque, contribution = evaluator.at(points, progress)
    labels = [element.label for element in elements(arm.n_joints)]
    labels += [f"without h{i}" for i in range(1, arm.n_joints + 1)]
    counting = operations or (QUICK if samples is None and len(points) <= MOST_COUNTED else NONE)
    stage("counting operations", len(points))
    operation_counts = evaluator.operations(points, counting, progress)
    stage("bisecting", None)
    changes = [] if samples is not None else evaluator.changes(grid, verdict.reshape(-1, *shape), precision)
    element, axis, before, after, at, next_value = zip(*changes, strict=True) if changes else [()] * 6

    def over(values: Array, *names: str) -> tuple[tuple[str, ...], Array]:
        """Values (..., S) over the points; the leading dimensions come last, in order."""
        return (*dims, *names), np.moveaxis(values, -1, 0).reshape(*shape, *values.shape[:-1])

    return xr.Dataset(
        {
            "verdict": over(VERDICT_NAMES[verdict], "element"),
            "peak_torque": over(torque, "joint"),
            "contribution": over(contribution.swapaxes(0, 1), "joint", "of"),
            "operations": over(operation_counts),
            "change_element": ("change", np.array([labels[e] for e in element], dtype=str)),
            "change_parameter": ("change", np.array([names[k] for k in axis], dtype=str)),
            "change_from": ("change", VERDICT_NAMES[np.array(before, dtype=int)]),
            "change_to": ("change", VERDICT_NAMES[np.array(after, dtype=int)]),
            "change_at": (("change", "parameter"), np.array(at).reshape(-1, len(names))),
            "change_seen": ("change", np.array(next_value, dtype=float)),
        },
        coords
        | {
            "element": labels,
            "joint": np.arange(1, arm.n_joints + 1),
            "effort_unit": ("joint", [joint.effort_unit for joint in arm.joints]),
            "of": list(CONTRIBUTIONS),
            "parameter": names,
            "unit": ("parameter", [span.parameter.unit for span in ranges]),
            "precision": ("parameter", [precision * (span.high - span.low) for span in ranges]),
            "nominal": ("parameter", [varied.value(span.parameter) for span in ranges]),
        },
        {
            "arm": arm.name,
            "arm_fingerprint": fingerprint(arm),
            **{key: str(value) for key, value in exact.states.described.items()},
            "set_points_used": len(evaluator.exact.states),
            "drives": int(exact.form.drives),
            "threshold": float(threshold),
            "budget": str(budget),
            "operations_by": counting,
            **({} if samples is None else {"samples": samples, "seed": seed}),
        },
    )


def _ranges_of(vary: str | Sequence[str], varied: VariedArm) -> list[Range]:
    """Read the ranges; each parameter is varied once."""
    texts: list[Any] = [*vary] if isinstance(vary, list | tuple) else [vary]
    for text in texts:
        require_type(text, str, "vary", 'a range such as "link3.mass=1..5", or a list of ranges')
    ranges = [Range.parse(text, varied) for text in texts]
    names = [span.parameter.name for span in ranges]
    # A length in mm is the same parameter as in m.
    parameters = {(p.part, p.number, p.key, p.component) for p, *_ in ranges}
    if not names or len(parameters) < len(names):
        raise UsageError("parameters are varied once each", where="--vary", found=", ".join(names) or "none")
    return ranges


def _shape_of(ranges: Sequence[Range], samples: int | None) -> tuple[int, ...]:
    """Points of every range, or the number of samples; refuses too many."""
    if samples is not None and any(span.values for span in ranges):
        step = "leave out :COUNT"
        raise UsageError("samples take the place of a grid", where="--samples", next_step=step)
    counts = [span.values or USUAL_POINTS for span in ranges] if samples is None else [samples]
    if not 1 <= math.prod(counts) <= _MOST_POINTS:
        raise UsageError(
            "the number of points is out of range",
            where="--vary",
            expected=f"1 to {_MOST_POINTS}",
            found=str(math.prod(counts)),
        )
    return tuple(counts)


# A verdict that changes along one parameter: element, parameter, old and new verdict, values of all
# parameters at the change, and the parameter's value at the next grid point.
_Change = tuple[int, int, int, int, tuple[float, ...], float]


@dataclass(frozen=True, eq=False)
class _Sweep:
    """Arm, motion, varied parameters and criteria of a sweep."""

    varied: VariedArm
    parameters: tuple[Parameter, ...]
    exact: ExactDynamics
    budget: Budget
    threshold: float
    jobs: int

    @cached_property
    def _geometric(self) -> list[int]:
        """Indices of the parameters that are neither inertial nor the speed."""
        return [k for k, p in enumerate(self.parameters) if not p.is_inertial and p.key != SPEED]

    def at(
        self, points: FloatArray, progress: Callable[[int], None] = lambda count: None
    ) -> tuple[Array, FloatArray, FloatArray]:
        """Verdicts (E + n, S), peak torque (n, S) and its contributions (6, n, S) at points (S, P)."""
        count = len(points)
        values = dict(zip(self.parameters, points.T, strict=True))
        bodies = self.varied.bodies({p: x for p, x in values.items() if p.is_inertial}, count)
        if not self.exact.form.drives:
            bodies = replace(bodies, drive_inertia=np.zeros((count, 0)))
        speed = next((x for p, x in values.items() if p.key == SPEED), np.ones(count))
        geometries, geometry_of_point = np.unique(points[:, self._geometric], axis=0, return_inverse=True)
        groups = [np.flatnonzero(geometry_of_point.ravel() == k) for k in range(len(geometries))]
        changed = [self.parameters[k] for k in self._geometric]
        tasks = (
            (self, dict(zip(changed, values.tolist(), strict=True)), bodies.at(group), speed[group])
            for values, group in zip(geometries, groups, strict=True)
        )
        results: list[Array] = []
        for number, arrays in each(_Sweep.of_geometry, tasks, self.jobs if len(groups) > 1 else 1):
            if not results:
                results = [np.empty((*array.shape[:-1], count), array.dtype) for array in arrays]
            for result, array in zip(results, arrays, strict=True):
                result[..., groups[number]] = array
            progress(len(groups[number]))
        return results[0], results[1], results[2]

    def of_geometry(
        self, changed: Mapping[Parameter, float], bodies: Bodies, speed: FloatArray
    ) -> tuple[Array, FloatArray, FloatArray]:
        """Verdicts, peak torque and contributions, as in `at`, for arms of one geometry."""
        arm = self.varied.at(changed) if changed else self.varied.arm
        peak_values = peaks(arm, bodies, *self.exact.states.last, speed)
        parts, noise = peak_values.contributions, ROUND_OFF_SHARE * peak_values.torque.max(axis=0)
        verdicts = peak_values.verdicts(self.threshold, self._allowed(arm, peak_values.torque))
        return verdicts, peak_values.torque, np.where(parts > noise, parts, 0.0)

    def _allowed(self, arm: RobotArm, peak: FloatArray) -> FloatArray:
        """Allowed error, (n, S): the larger of shares of the peaks and amounts independent of them."""
        no_torque, vast_torque = np.zeros(arm.n_joints), np.full(arm.n_joints, _BOUNDLESS_TORQUE)
        least, share = (
            self.budget.allowed(ReferenceTorques(arm, x))[:, None] for x in (no_torque, vast_torque)
        )
        floor = np.maximum(ROUND_OFF_SHARE * peak.max(axis=0), np.finfo(float).tiny)
        return np.maximum(np.maximum(share / _BOUNDLESS_TORQUE * peak, least), floor)

    def changes(self, grid: Sequence[FloatArray], verdict: Array, precision: float) -> list[_Change]:
        """Bisect every change of a verdict (E + n, ...) between neighbours on the grid."""
        found_changes: list[_Change] = []
        for axis, values in enumerate(grid):
            resolution = max(precision * (values[-1] - values[0]), 4 * np.spacing(np.abs(values).max()))
            verdicts = np.moveaxis(verdict, axis + 1, -1)
            place = np.argwhere(verdicts[..., :-1] != verdicts[..., 1:])
            element, index = place[:, 0], np.insert(place[:, 1:-1], axis, place[:, -1], axis=1)
            base = np.stack([x[index[:, k]] for k, x in enumerate(grid)], axis=-1)
            low, high = base[:, axis].copy(), values[index[:, axis] + 1]
            before, after = verdicts[tuple(place.T)], verdicts[(*place.T[:-1], place[:, -1] + 1)]
            while len(element):
                at, end, verdict_at_end = low, high, after
                while (end - at > resolution).any():
                    base[:, axis] = (at + end) / 2
                    points, index_of_point = np.unique(base, axis=0, return_inverse=True)
                    verdict_at_middle = self.at(points)[0][element, index_of_point.ravel()]
                    is_unchanged = verdict_at_middle == before
                    at = np.where(is_unchanged, base[:, axis], at)
                    end = np.where(is_unchanged, end, base[:, axis])
                    verdict_at_end = np.where(is_unchanged, verdict_at_end, verdict_at_middle)
                base[:, axis] = (at + end) / 2
                columns = (x.tolist() for x in (element, before, verdict_at_end, base, high))
                found_changes += [
                    (e, axis, a, b, tuple(x), y) for e, a, b, x, y in zip(*columns, strict=True)
                ]
                # There is a third verdict between the two.
                has_third = verdict_at_end != after
                low, before = end[has_third], verdict_at_end[has_third]
                element, base = element[has_third], base[has_third]
                high, after = high[has_third], after[has_third]

        def position(change: _Change) -> tuple[int, float]:
            """The parameter along which a verdict changes, and its value there."""
            axis, values = change[1], change[4]
            return axis, values[axis]

        return sorted(found_changes, key=position)

    def operations(self, points: FloatArray, by: str, progress: Callable[[int], None]) -> FloatArray:
        """Operations of the simplified model at every point, (S,); nan where there are none."""
        counts = np.full(len(points), np.nan)
        if by != NONE and not (by == QUICK and too_many_terms(self.exact.form)):
            tasks = ((self, point, by) for point in points.tolist())
            for number, count in each(_Sweep.count, tasks, self.jobs):
                counts[number] = count
                progress(1)
        return counts

    def count(self, point: Sequence[float], by: str) -> float:
        """Operations at one point."""
        values, states = dict(zip(self.parameters, point, strict=True)), self.exact.states
        speed = next((value for parameter, value in values.items() if parameter.key == SPEED), 1.0)
        states = replace(states, qd=speed * states.qd, qdd=speed**2 * states.qdd)
        with without_cache():
            drives = self.exact.form.drives
            exact = ExactDynamics.of(self.varied.at(values), states, drives).under(self.budget)
            if by == QUICK:
                try:
                    return _quick_count(exact, exact.allowed(self.budget))
                except TooManyTermsError:
                    return np.nan
            level = level_named(by)
            budget = None if level is ELEMENT else self.budget
            return simplify_exact(exact, budget, SearchOptions(level)).operations.total


def _quick_count(exact: ExactDynamics, allowed: FloatArray) -> int:
    """Estimate operations of the torque from a descent alone."""
    candidates = candidates_of(exact, TERM, allowed)
    selection = candidates.selection()
    descend(selection, candidates.stays)
    return candidates.write(candidates.chosen(selection.selected), COUNTING).count.total


def _usable(budget: Budget | str | None) -> Budget:
    """A budget that can be evaluated from each arm's torque alone."""
    budget = Budget.of(budget)
    if "uncertainty" in budget.wholes:
        message, expected = "a sweep knows no uncertainty", "shares of peak, limit or friction, or N m"
        raise UsageError(message, where=budget.option, expected=expected, found=str(budget))
    return budget
