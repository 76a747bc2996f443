"""A bound on the torque error that no state of a region exceeds, proven from the program that runs.

The error of joint i is e_i = sum_r F_ir(q) r, with r over 1, the accelerations and the products of two
velocities, and F over polynomials in sines, cosines and prismatic variables whose coefficients are known. For
given velocities and accelerations it is such a polynomial itself, so its maximum over a box exceeds that over
a grid by no more than its curvature allows between the nodes (`grid`). That holds for the worst velocities
and accelerations too, whose error at a grid position has a closed bound (`motion`). Harmonics in too many
joints for a grid are bounded by their amplitudes. Along a tube many small boxes are bounded by Taylor's
theorem instead (`taylor`).

The model's part of the error is its program written out (`harmonics/expansion.py`): the bound is on what
runs, whatever terms stand beside it. Added are the error of the exact dynamics, found from numbers
(`harmonics_slack`), that of evaluating the error (`ErrorField.round_off`), and that of writing the program
out and running it in floating point (`Expansion.round_off`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import FloatArray
from gd_analyze.certification.box import Box
from gd_analyze.certification.error_field import ErrorField, harmonics_slack
from gd_analyze.certification.grid import Grid, Reached, shared_out
from gd_analyze.certification.taylor import Bounded, bound_along
from gd_analyze.certification.tube import Tube
from gd_analyze.errors import UsageError
from gd_analyze.harmonics.expansion import Expansion, exact_row, expanded, velocity_factors
from gd_analyze.harmonics.transform import Harmonics, harmonics_of
from gd_analyze.harmonics.trigonometric_polynomial import TrigonometricPolynomial
from gd_analyze.robots.arm import RobotArm
from gd_analyze.simplification.model import SimplifiedModel
from gd_analyze.text import in_python, number, rounded_up

# Positions per joint: about 22 per angle for an arm like the PUMA 560, whose error depends on four angles;
# that many times more for every further angle, up to a number beyond which it would take hours.
EFFORT = 250_000
_ANGLES, _MOST_ANGLES, _FURTHER = 4, 7, 10
# Places per angle at which the size of the error is estimated before grids are chosen.
_FEW = 3
# Groups of harmonics with a grid of their own.
_GROUPS = 3
# Grid positions from which the search for the worst state climbs.
_STARTS = 8
# Positions that cost as much as one small box of a tube, and the ratio to the error found worth another look.
_PER_BOX, _LOOSE = 20, 1.1
# Coefficients beyond which a small box costs more than that.
_MANY = 4_000
# Positions whose velocities are treated together, so that all choices fit the cache: at first, and closely.
_BATCH, _CLOSELY = 512, 32
# Positions drawn in search of the largest torque, and the best of them from which the search climbs.
_DRAWN, _CLIMBED = 512, 4


@dataclass(frozen=True, eq=False)
class Certificate:
    """Proven bounds and errors found per joint, N m (N for a prismatic joint), shape (n,)."""

    region: Box | Tube  # the states: a box, or a tube around a motion
    certified: FloatArray  # no state of the region has a larger torque error
    worst_found: FloatArray  # largest torque error that a search found in the region; the truth lies between
    # Positions, velocities and accelerations of these errors, shape (n, n) each, row i for joint i
    worst_states: tuple[FloatArray, FloatArray, FloatArray]
    # For a tube: bound in every piece, shape (pieces, n); `certified` is its largest. None for a box
    along: FloatArray | None = None

    @property
    def box(self) -> Box:
        """The box, or the smallest one around the tube."""
        return self.region.enclosing if isinstance(self.region, Tube) else self.region

    def __repr__(self) -> str:
        bounds = ", ".join(number(rounded_up(float(value))) for value in self.certified)
        return f"Certificate({len(self.certified)} joints, certified {bounds} N m)"

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
            return np.where(self.certified == 0.0, 1.0, self.certified / self.worst_found)

    def within(self, allowed: FloatArray) -> FloatArray:
        """Whether each joint is proven to keep an allowed error (n,) over the whole region."""
        return np.asarray(self.certified <= allowed)


def certify(
    model: SimplifiedModel,
    region: Box | Tube | None = None,
    *,
    effort: int = EFFORT,
    harmonics: Harmonics | None = None,
    progress: Callable[[int], None] | None = None,
) -> Certificate:
    """Bound a model's torque error over a box of states, or over a tube around a motion.

    The same model, region and effort give the same certificate on any machine and under any load.

    Parameters
    ----------
    model
        A model of any level.
    region
        The states; the arm's own limits by default.
    effort
        For a box: most positions per joint at which the error is evaluated (for each of at most 3 groups of
        harmonics), ten times as many for every angle beyond the fourth that the error depends on, up to the
        seventh. For a tube: a twentieth as many small boxes, which cost as much, or fewer if there are very
        many harmonics; each piece of the tube is one to begin with. More bring the bound closer to the truth;
        any number proves it.
    harmonics
        The arm's exact dynamics, if known.
    progress
        Called with the hundredths of a joint done since the last call.

    Returns
    -------
    Certificate
        Proven bound and worst error found.

    Raises
    ------
    ModelError
        If its program computes no torque of an arm, or is too long to be written out, see `expanded`.
    UsageError
        If the region is of another number of joints, or `effort` is not positive.
    """
    arm = model.arm
    tube = region if isinstance(region, Tube) else None
    box = box_of(region.enclosing if isinstance(region, Tube) else region, arm, effort)
    harmonics = harmonics or harmonics_of(arm)
    inertia = harmonics.whole_inertia(arm.drive_inertia if model.drives else None)
    expansion = expansion_of(model)
    roundings = expansion.round_off(box.farthest, box.velocity, box.acceleration)
    found = []
    for i, (row, rounding) in enumerate(zip(expansion.rows, roundings, strict=True)):
        field = ErrorField.of(exact_row(harmonics, inertia, i), row, float(rounding), box)
        step = _Progress(progress)
        found.append(
            _bounded_in_box(field, box, effort, step)
            if tube is None
            else _bounded_in_tube(field, tube, box, effort, step)
        )
        step(1.0)
    rows, errors, *states = (np.array(values) for values in zip(*found, strict=True))
    bounds = rows.T + harmonics_slack(harmonics, box)
    along = np.where(bounds <= 0.0, 0.0, np.nextafter(bounds, np.inf))
    worst = (states[0], states[1], states[2])
    return Certificate(region or box, along.max(axis=0), errors, worst, None if tube is None else along)


def expansion_of(model: SimplifiedModel) -> Expansion:
    """A model's program written out."""
    return expanded(model.program, [not revolute for revolute in model.arm.is_revolute])


def box_of(given: Box | None, arm: RobotArm, effort: int = 1) -> Box:
    """Box given, or the arm's own; a UsageError if it is of another arm or the effort is not positive."""
    if given is not None and not isinstance(given, Box):
        raise UsageError(
            "this is no region of states", where="region", expected="a Box or a Tube", found=in_python(given)
        )
    box = given or Box.of(arm)
    if box.n_joints != arm.n_joints:
        raise UsageError(
            "the box does not fit the arm",
            where="box",
            expected=f"limits of {arm.n_joints} joints",
            found=f"{box.n_joints}",
        )
    if effort < 1:
        raise UsageError(
            "the effort is not positive", where="effort", expected="at least 1", found=str(effort)
        )
    return box


class _Progress:
    """Passes the share of a joint's work on, in hundredths."""

    def __init__(self, progress: Callable[[int], None] | None) -> None:
        self._progress, self._done = progress, 0

    def __call__(self, share: float) -> None:
        more = int(100 * share) - self._done
        if self._progress is not None and more > 0:
            self._progress(more)
            self._done += more


def _bounded_in_box(field: ErrorField, box: Box, effort: int, step: _Progress) -> Bounded:
    angles = sum(degree > 0 for degree in field.polynomial.degrees)
    further = _FURTHER ** (min(max(angles, _ANGLES), _MOST_ANGLES) - _ANGLES)
    bound, starts = _bounded(field, box, effort * further, step)
    return Bounded(np.array([bound]), *field.worst(box, starts))


def _bounded_in_tube(field: ErrorField, tube: Tube, box: Box, effort: int, step: _Progress) -> Bounded:
    many = 1 + int(np.count_nonzero(field.polynomial.coefficients)) // _MANY
    along = bound_along(field, tube, effort // (_PER_BOX * many))
    known = along.found + field.rest + field.round_off
    if along.bounds.max() <= _LOOSE * known:
        return along
    # For wide boxes, between set points far apart, a grid over all of them may give a smaller bound.
    return along._replace(bounds=np.minimum(along.bounds, _bounded(field, box, effort, step)[0]))


def _bounded(field: ErrorField, box: Box, effort: int, step: _Progress) -> tuple[float, FloatArray]:
    """Proven bound of one joint without the slack of the exact dynamics, and positions to climb from."""
    reached = _expected(field, box) if len(field.polynomial) else None
    shares, rest = shared_out(field.polynomial, box, effort, _GROUPS, reached)
    bound = field.rest + float(rest.sizes(box.farthest).sum())
    starts = [box.centre]
    for part, grid in shares:
        amplitudes = float(part.sizes(box.farthest).sum())
        largest, positions = _over_grid(field, part, grid, step)
        starts += list(grid.positions(positions).T)
        bound += min(grid.over_box(part, box, largest + field.round_off), amplitudes)
    # Some roundings of these sums.
    bound = bound * (1.0 + 64 * float(np.finfo(float).eps)) + field.round_off
    return bound, np.array(starts).T


def _expected(field: ErrorField, box: Box) -> Reached:
    """Error at a few positions, in the box and around the circle."""
    rng = np.random.default_rng(0)
    shares = [rng.random(_FEW if degree else 1) for degree in field.polynomial.degrees]
    lower, width = box.lower, box.upper - box.lower
    around = np.where(field.polynomial.revolute & (width > 0.0), 2 * np.pi, width)
    found = []
    for widths in (width, around):
        nodes = [low + share * wide for low, share, wide in zip(lower, shares, widths, strict=True)]
        found.append(max(float(field.motion.quick_bound(v).max()) for v in field.polynomial.on_grid(nodes)))
    return Reached(*found)


def _over_grid(
    field: ErrorField, part: TrigonometricPolynomial, grid: Grid, step: _Progress
) -> tuple[float, NDArray[np.int64]]:
    """Largest value over a grid, and the numbers of the best positions of a few of its pieces."""
    largest, before = 0.0, 0
    tops: list[tuple[float, int]] = []
    for values in part.on_grid(grid.nodes):
        rough = np.abs(values).sum(axis=0)
        top = int(rough.argmax())
        tops.append((float(field.motion.bound(values[:, [top]])[0]), before + top))
        largest = max(largest, tops[-1][0])
        # Most positions drop out before the signs of the velocities are tried, most others before a close
        # look.
        near = np.flatnonzero(rough > largest)
        batches = np.split(near, range(_BATCH, len(near), _BATCH))
        quick = np.concatenate([field.motion.quick_bound(values[:, batch]) for batch in batches])
        order = np.argsort(-quick)
        near, quick = near[order], quick[order]
        while near.size and quick[0] > largest:
            bounds = field.motion.bound(values[:, near[:_CLOSELY]])
            if bounds.max() > largest:
                largest = float(bounds.max())
                tops.append((largest, before + int(near[bounds.argmax()])))
            near, quick = near[_CLOSELY:], quick[_CLOSELY:]
        before += values.shape[1]
        # The first grid is the largest.
        step(0.95 * before / grid.size)
    tops.sort(reverse=True)
    return largest, np.array([index for _, index in tops[:_STARTS]])


def largest_torque(
    model: SimplifiedModel, region: Box | Tube | None = None, *, harmonics: Harmonics | None = None
) -> FloatArray:
    """Largest exact torque of every joint that a search finds in a region, N m (N), shape (n,).

    There may be larger ones, so that a share of it is rather too large than too small. It follows from the
    arm and the states alone, not from anything that the model states.

    Parameters
    ----------
    model
        Its arm, and whether drives are included, matter.
    region
        The states; the arm's own limits by default.
    harmonics
        The arm's exact dynamics, if known.
    """
    arm = model.arm
    box = box_of(region.enclosing if isinstance(region, Tube) else region, arm)
    harmonics = harmonics or harmonics_of(arm)
    inertia = harmonics.whole_inertia(arm.drive_inertia if model.drives else None)
    nothing = TrigonometricPolynomial.constant(harmonics.potential.prismatic, 0.0)[
        [0] * len(velocity_factors(arm.n_joints))
    ]
    drawn = np.random.default_rng(0).uniform(box.lower, box.upper, (_DRAWN, arm.n_joints)).T
    out = np.zeros(arm.n_joints)
    for i in range(arm.n_joints):
        field = ErrorField.of(exact_row(harmonics, inertia, i), nothing, 0.0, box)
        if isinstance(region, Tube):
            out[i] = bound_along(field, region, 0).found
        elif len(field.polynomial):
            order = np.argsort(-field.motion.reached(field.polynomial(drawn)), kind="stable")
            out[i] = field.worst(box, drawn[:, order[:_CLIMBED]])[0]
    return out
