"""A bound on the torque error in a region of states, proven from the program that runs.

The proof is in docs/certificate.md: a grid over a box (`grid`, `motion`), Taylor's theorem along a tube
(`taylor`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arguments import strict
from gd_analyze.arrays import FloatArray
from gd_analyze.certification.box import Box
from gd_analyze.certification.error_field import ErrorField, harmonics_slack
from gd_analyze.certification.grid import Grid, Reached, shared_out
from gd_analyze.certification.taylor import Bounded, bound_along
from gd_analyze.certification.tube import Tube
from gd_analyze.errors import UsageError, require_type
from gd_analyze.harmonics.expansion import exact_row
from gd_analyze.harmonics.transform import Harmonics, harmonics_of
from gd_analyze.harmonics.trigonometric_polynomial import TrigonometricPolynomial
from gd_analyze.progress import NO_PROGRESS, Progress
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.parts import checked
from gd_analyze.simplification.accuracy import Proven
from gd_analyze.simplification.model import SimplifiedModel, require_model
from gd_analyze.text import in_python, number, rounded_up
from gd_analyze.threads import one_thread

# Positions per joint: about 22 per angle for an arm like the PUMA 560, whose error depends on four angles.
POSITIONS_PER_JOINT = 250_000

_USUAL_ANGLES = 4  # angles for which the effort is meant
_GROWTH_PER_ANGLE = 10  # factor by which positions grow with every further angle
_MOST_ANGLES = 7  # angles up to which they grow: beyond, a proof would take hours
# A written-out program of more terms gets `reduced_effort`, to be proven in seconds.
_MOST_TERMS_AT_FULL_EFFORT = 20_000
_REDUCED_EFFORT = 2_000  # effort for programs of more terms
_MOST_TERMS_IN_SECONDS = 150_000  # a program of more terms is not proven in seconds even so
# Positions per angle at which the size of the error is estimated before grids are chosen.
_POSITIONS_OF_ESTIMATE = 3
_GRIDS = 3  # groups of harmonics with a grid of their own
_ASCENTS_FROM_GRID = 8  # grid positions from which the search for the worst state climbs
_POSITIONS_PER_SMALL_BOX = 20  # positions that cost as much as one small box of a tube
_COEFFICIENTS_PER_SMALL_BOX = 4_000  # coefficients beyond which a small box costs more than that
_LOOSE_BOUND = 1.1  # ratio of a bound to the error found beyond which a grid is tried, too
# Positions whose quick bounds are computed together, so that all choices of velocities fit the cache.
_QUICK_BOUNDS_AT_ONCE = 512
_CLOSE_BOUNDS_AT_ONCE = 32  # positions whose close bounds are computed together, for the same reason
_TORQUE_POSITIONS = 512  # positions drawn in search of the largest torque
_TORQUE_ASCENTS = 4  # the best of these positions, from which the search climbs

# Effort for a bound that goes with an export.
EXPORT_EFFORT = 20_000


@dataclass(frozen=True, eq=False)
class Certificate:
    """Proven bounds and largest errors found per joint, N m (N for a prismatic joint), shape (n,)."""

    region: Box | Tube  # the states: a box, or a tube around a motion
    certified: FloatArray  # no state of the region has a larger torque error
    # Largest weighted torque error that a search found in the region; the truth lies between
    worst_found: FloatArray
    # Positions, velocities and accelerations of these errors, shape (n, n) each, row i for joint i
    worst_states: tuple[FloatArray, FloatArray, FloatArray]
    # For a tube: bound in every piece, shape (pieces, n); `certified` is its largest. None for a box
    along: FloatArray | None = None
    effort: int = POSITIONS_PER_JOINT

    @property
    def box(self) -> Box:
        """The box, or the smallest one around the tube."""
        return self.region.enclosing if isinstance(self.region, Tube) else self.region

    def __repr__(self) -> str:
        bounds = ", ".join(number(rounded_up(float(value))) for value in self.certified)
        return f"Certificate({len(self.certified)} joints, certified {bounds} N m)"

    @property
    def stated(self) -> Proven:
        """Form in which a model states it."""
        box, tube = self.box, self.region if isinstance(self.region, Tube) else None
        proven = Proven(
            self.certified,
            box.lower,
            box.upper,
            box.velocity,
            box.acceleration,
            self.effort,
            self.region.where,
            proven_here=True,
        )
        if tube is None or self.along is None:
            return proven
        worst = self.along.argmax(axis=0)
        pieces = np.stack([tube.lower[worst], tube.upper[worst]], axis=1)
        return replace(proven, margin=tube.margin, trajectory_fingerprint=tube.fingerprint, pieces=pieces)

    @property
    def where(self) -> str:
        """Name of the states, to follow "within"."""
        between = ", between its set points too" if isinstance(self.region, Tube) else ""
        return f"{self.region.where}{between}"

    @property
    def note(self) -> str:
        """Remark on the states, or ""."""
        return self.region.note if isinstance(self.region, Tube) else ""

    @property
    def ratio(self) -> FloatArray:
        """Certified over worst found, at least 1; infinite if only round-off is left."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where(self.certified == 0.0, 1.0, self.counting / self.worst_found)

    @property
    def found(self) -> FloatArray:
        """`worst_found` without the weights of a tube's pieces: torque errors at these states, shape (n,)."""
        if isinstance(self.region, Box):
            return self.worst_found
        return self.worst_found / self.region.counts_at(np.stack(self.worst_states)).diagonal()

    @property
    def counting(self) -> FloatArray:
        """`certified`, weighted in the pieces of a tube."""
        weights = self.region.weights if isinstance(self.region, Tube) else None
        return self.certified if weights is None or self.along is None else (self.along * weights).max(axis=0)

    def within(self, allowed: FloatArray) -> NDArray[np.bool_]:
        """Whether each joint is proven to keep an allowed error (n,) over the whole region."""
        return np.asarray(self.counting <= allowed)


@strict
@one_thread()
def certify(
    model: SimplifiedModel,
    region: Box | Tube | None = None,
    *,
    effort: int = POSITIONS_PER_JOINT,
    harmonics: Harmonics | None = None,
    limit: FloatArray | None = None,
    tighten: bool = True,
    progress: Progress = NO_PROGRESS,
) -> Certificate:
    """Bound a model's torque error over a box of states, or over a tube around a motion.

    The same model, region and effort give the same certificate on any machine and under any load.

    Parameters
    ----------
    model
        A model of any level.
    region
        The states; by default the arm's limits.
    effort
        For a box: most positions per joint at which the error is evaluated (for each of at most 3 groups of
        harmonics), ten times as many for every angle beyond the fourth that the error depends on, up to the
        seventh. For a tube: a twentieth as many small boxes, or fewer for very many harmonics; at first each
        piece of the tube is one. More effort gives a tighter bound; any number proves it.
    harmonics
        The arm's exact dynamics, if known.
    limit
        Along a tube, spend the effort on the question whether errors exceed these, N m (N), shape (n,).
    tighten
        With a limit, spend a twentieth of the effort on a tighter bound.
    progress
        Told the hundredths of joints done.

    Returns
    -------
    Certificate
        Proven bound and worst error found, N m (N), by joint.

    Raises
    ------
    ModelError
        If its program does not compute a torque of an arm, or is too long to be written out, see `expanded`.
    UsageError
        If the region has another number of joints, or `effort` is not positive.
    """
    require_model(model)
    tube = region if isinstance(region, Tube) else None
    box = box_of(region, model.arm, effort)
    require_type(harmonics, (Harmonics, type(None)), "harmonics", "what `harmonics_of` returns, or None")
    if limit is not None:
        limit = checked(limit, (box.n_joints,), "limit", "limit", nonnegative=True)
    progress.stage("certifying", 100 * box.n_joints)
    harmonics = harmonics or harmonics_of(model.arm)
    expansion = model.expansion
    roundings = expansion.round_off(box.farthest, box.velocity, box.acceleration).tolist()
    joint_bounds = []
    joint_weights = [None] * box.n_joints if tube is None or tube.weights is None else tube.weights.T
    limits = [None] * box.n_joints if limit is None else (limit - harmonics_slack(harmonics, box)).tolist()
    parts = zip(_exact_rows(model, harmonics), expansion.rows, roundings, joint_weights, limits, strict=True)
    for exact, row, rounding, counts, limit_of_joint in parts:
        step = _in_hundredths(progress)
        field = ErrorField.of(exact, row, rounding, box)
        joint_bounds.append(_bounded(field, tube, effort, step, counts, limit_of_joint, tighten))
        step(1.0)
    rows, errors, *states = (np.array(values) for values in zip(*joint_bounds, strict=True))
    bounds = rows.T + harmonics_slack(harmonics, box)
    along = np.where(bounds <= 0.0, 0.0, np.nextafter(bounds, np.inf))
    worst = (states[0], states[1], states[2])
    return Certificate(
        region or box, along.max(axis=0), errors, worst, None if tube is None else along, effort
    )


def usual_effort(model: SimplifiedModel, effort: int = POSITIONS_PER_JOINT) -> int | None:
    """Effort with which a proof takes seconds: small for very many terms, None for even more.

    Raises a ModelError as `certify` does.
    """
    terms = sum(np.count_nonzero(row.coefficients) for row in model.expansion.rows)
    if terms > _MOST_TERMS_IN_SECONDS:
        return None
    return min(effort, _REDUCED_EFFORT) if terms > _MOST_TERMS_AT_FULL_EFFORT else effort


def box_of(region: Box | Tube | None, arm: RobotArm, effort: int = 1) -> Box:
    """Box around a region, or of the arm's limits; `UsageError` for a box of another arm, or no effort."""
    if region is None:
        region = Box.of(arm)
    box = region.enclosing if isinstance(region, Tube) else region
    if not isinstance(box, Box):
        raise UsageError(
            "this is not a region of states",
            where="region",
            expected="a Box or a Tube",
            found=in_python(region),
            next_step="`gd.types.Tube.along(arm, gd.read_trajectory(FILE, arm))` is one around a motion",
        )
    if box.n_joints != arm.n_joints:
        expected, value = f"limits of {arm.n_joints} joints", f"{box.n_joints}"
        raise UsageError("the box does not fit the arm", where="box", expected=expected, found=value)
    require_type(effort, (int, np.integer), "effort", "a whole number, at least 1")
    if effort < 1:
        expected, value = "at least 1", str(effort)
        raise UsageError("the effort is not positive", where="effort", expected=expected, found=value)
    return box


def _exact_rows(
    model: SimplifiedModel, harmonics: Harmonics
) -> Iterator[tuple[TrigonometricPolynomial, list[int]]]:
    """Summands of every joint's exact torque, see `exact_row`."""
    inertia = harmonics.whole_inertia(model.arm.drive_inertia if model.drives else None)
    return (exact_row(harmonics, inertia, i) for i in range(model.arm.n_joints))


def _in_hundredths(progress: Progress) -> Callable[[float], None]:
    """Report a joint's progress, in hundredths since the last call."""
    reported = 0

    def step(share: float) -> None:
        nonlocal reported
        hundredths = int(100 * share) - reported
        if hundredths > 0:
            progress.advance(hundredths)
            reported += hundredths

    return step


def _bounded(
    field: ErrorField,
    tube: Tube | None,
    effort: int,
    step: Callable[[float], None],
    counts: FloatArray | None,
    limit: float | None,
    tighten: bool,
) -> Bounded:
    """Bound one joint without the slack of the exact dynamics."""
    if tube is None:
        angles = sum(degree > 0 for degree in field.polynomial.degrees)
        further_angles = min(max(angles, _USUAL_ANGLES), _MOST_ANGLES) - _USUAL_ANGLES
        bound, starts = _by_grids(field, effort * _GROWTH_PER_ANGLE**further_angles, step)
        return Bounded(np.array([bound]), *field.worst(starts))
    cost = 1 + int(np.count_nonzero(field.polynomial.coefficients)) // _COEFFICIENTS_PER_SMALL_BOX
    small_boxes = effort // (_POSITIONS_PER_SMALL_BOX * cost)
    along = bound_along(field, tube, small_boxes, counts, limit, tighten=tighten)
    error = along.found + field.omitted + field.round_off
    if limit is not None or along.bounds.max() <= _LOOSE_BOUND * error:
        return along
    # For wide boxes, between distant set points, a grid over all of them may give a smaller bound.
    return along._replace(bounds=np.minimum(along.bounds, _by_grids(field, effort, step)[0]))


def _by_grids(field: ErrorField, effort: int, step: Callable[[float], None]) -> tuple[float, FloatArray]:
    """Bound over the field's box, and positions to climb from."""
    reached = _expected(field) if len(field.polynomial) else None
    shares, remainder = shared_out(field.polynomial, field.box, effort, _GRIDS, reached)
    farthest = field.box.farthest
    bound = field.omitted + float(remainder.sizes(farthest).sum())
    starts = [field.box.centre]
    for part, grid in shares:
        largest, positions = _over_grid(field, part, grid, step)
        starts += list(grid.positions(positions).T)
        amplitudes = float(part.sizes(farthest).sum())
        bound += min(grid.over_box(part, field.box, largest + field.round_off), amplitudes)
    # Rounding of these sums.
    return bound * (1.0 + 64 * float(np.finfo(float).eps)) + field.round_off, np.array(starts).T


def _expected(field: ErrorField) -> Reached:
    """Error at a few positions, in the box and around the circle."""
    rng, box, polynomial = np.random.default_rng(0), field.box, field.polynomial
    shares = [rng.random(_POSITIONS_OF_ESTIMATE if degree else 1) for degree in polynomial.degrees]
    width = box.upper - box.lower
    largest = []
    for widths in (width, np.where(polynomial.revolute & (width > 0.0), 2 * np.pi, width)):
        nodes = [low + share * extent for low, share, extent in zip(box.lower, shares, widths, strict=True)]
        largest.append(max(float(field.motion.quick_bound(v).max()) for v in polynomial.on_grid(nodes)))
    return Reached(*largest)


def _over_grid(
    field: ErrorField, part: TrigonometricPolynomial, grid: Grid, step: Callable[[float], None]
) -> tuple[float, NDArray[np.int64]]:
    """Largest value over a grid, and indices of the best positions of some of its pieces."""
    largest, before = 0.0, 0
    tops: list[tuple[float, int]] = []
    for values in part.on_grid(grid.nodes):
        sum_of_sizes = np.abs(values).sum(axis=0)
        top = int(sum_of_sizes.argmax())
        tops.append((float(field.motion.bound(values[:, [top]])[0]), before + top))
        largest = max(largest, tops[-1][0])
        # Most positions are excluded before signs of velocities are tried; most of the remaining ones before
        # the close bound.
        candidates = np.flatnonzero(sum_of_sizes > largest)
        at_once, closely = _QUICK_BOUNDS_AT_ONCE, _CLOSE_BOUNDS_AT_ONCE
        batches = np.split(candidates, range(at_once, len(candidates), at_once))
        quick = np.concatenate([field.motion.quick_bound(values[:, batch]) for batch in batches])
        order = np.argsort(-quick)
        candidates, quick = candidates[order], quick[order]
        while candidates.size and quick[0] > largest:
            bounds = field.motion.bound(values[:, candidates[:closely]])
            if bounds.max() > largest:
                largest = float(bounds.max())
                tops.append((largest, before + int(candidates[bounds.argmax()])))
            candidates, quick = candidates[closely:], quick[closely:]
        before += values.shape[1]
        # The first grid is the largest.
        step(0.95 * before / grid.size)
    tops.sort(reverse=True)
    return largest, np.array([index for _, index in tops[:_ASCENTS_FROM_GRID]])


def largest_torque(
    model: SimplifiedModel, region: Box | Tube | None = None, *, harmonics: Harmonics | None = None
) -> FloatArray:
    """Largest exact torque of every joint that a search finds in a region, N m (N), shape (n,).

    There may be larger ones, so that shares of it may be too large, not too small. It follows from the arm
    and the states alone; of the model it uses only whether drives are included.
    """
    box, out = box_of(region, model.arm), np.zeros(model.arm.n_joints)
    drawn = np.random.default_rng(0).uniform(box.lower, box.upper, (_TORQUE_POSITIONS, len(out))).T
    for i, row in enumerate(_exact_rows(model, harmonics or harmonics_of(model.arm))):
        field = ErrorField.of(row, None, 0.0, box)
        if isinstance(region, Tube):
            out[i] = bound_along(field, region, 0).found
        elif len(field.polynomial):
            order = np.argsort(-field.motion.reached(field.polynomial(drawn)), kind="stable")
            out[i] = field.worst(drawn[:, order[:_TORQUE_ASCENTS]])[0]
    return out
