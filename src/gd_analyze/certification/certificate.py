"""A bound on the torque error that no state of a box exceeds, proven from the program that runs.

The error of joint i is e_i = sum_r F_ir(q) r, r running over 1, the accelerations and the products of two
velocities, and F over polynomials in sines, cosines and prismatic variables whose coefficients are known.
For any
given velocities and accelerations it is such a polynomial itself, so its maximum over all positions of the
box
exceeds its maximum over a grid by no more than its curvature allows between the nodes (`grid`). That holds
for the worst velocities and accelerations too, whose error at a grid position has a closed bound
(`motion`). Waves in too many joints for a grid are bounded by their amplitudes.

The model's part of it is what its program computes, written out (`harmonics/expansion.py`): what is bounded
is what runs, whatever the terms beside it say. To this comes what the exact dynamics can be off by, being
read off numbers (`harmonics_slack`), what evaluating the error can (`ErrorField.round_off`), and what writing
the program out and running it in floating point can (`Expansion.round_off`).
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
from gd_analyze.text import html_of, in_python, number, rounded_up

# Positions per joint: about 22 per angle for an arm like the PUMA 560, whose error knows four of its angles;
# and how many times as many for every angle beyond these, but a few, as more would take hours.
EFFORT = 250_000
_ANGLES, _MOST_ANGLES, _FURTHER = 4, 7, 10
# Places per angle at which it is looked how large an error there is, before grids are chosen.
_FEW = 3
# Groups of waves with a grid of their own.
_GROUPS = 3
# Grid positions from which the search for the worst state climbs.
_STARTS = 8
# Positions that cost as much as the bound in one small box of a tube, and what is worth another look.
_PER_BOX, _LOOSE = 20, 1.1
# Coefficients beyond which a small box costs more than that.
_MANY = 4_000
# Positions whose velocities are looked at together, so that all choices fit the cache: first, and then
# closely.
_BATCH, _CLOSELY = 512, 32


@dataclass(frozen=True, eq=False)
class Certificate:
    """What is proven and what was found, per joint, N m (N for a prismatic joint), shape (n,).

    Parameters
    ----------
    region
        The states it is about: a box, or a tube around a motion.
    certified
        No state of the region has a larger torque error.
    worst_found
        Largest torque error that the search found in the region; the truth lies between.
    worst_states
        For every joint the state where it was found: positions, velocities and accelerations, shape (n, n)
        each, row i for joint i.
    along
        Of a tube: no state of a piece has a larger torque error, shape (pieces, n); `certified` is the
        largest of each joint. None for a box.
    """

    region: Box | Tube
    certified: FloatArray
    worst_found: FloatArray
    worst_states: tuple[FloatArray, FloatArray, FloatArray]
    along: FloatArray | None = None

    @property
    def box(self) -> Box:
        """The box; of a tube the smallest one around it."""
        return self.region.enclosing if isinstance(self.region, Tube) else self.region

    def __repr__(self) -> str:
        return f"Certificate({len(self.certified)} joints, certified {_told(self.certified)} N m)"

    def _repr_html_(self) -> str:
        """Bounds and what was found, for a notebook."""
        found = zip(self.certified, self.worst_found, self.ratio, strict=True)
        rows = [
            [str(i), number(rounded_up(float(bound))), number(float(error)), f"{ratio:.3g}"]
            for i, (bound, error, ratio) in enumerate(found, start=1)
        ]
        what = "a tube around a motion" if isinstance(self.region, Tube) else "a box of states"
        headings = ["joint", "no error above", "worst found", "ratio"]
        return html_of(f"Torque error within {what}", headings, rows, "In N m; in N where a joint slides.")

    @property
    def where(self) -> str:
        """Say which states it is about, as in "no state within the arm's limits has .."."""
        between = ", between its set points too," if isinstance(self.region, Tube) else ""
        return f"{self.region.where}{between}"

    @property
    def note(self) -> str:
        """What is to be known of them, in a sentence, or ""."""
        return self.region.note if isinstance(self.region, Tube) else ""

    @property
    def ratio(self) -> FloatArray:
        """Certified over worst found, at least 1; infinite where only round-off is left."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where(self.certified == 0.0, 1.0, self.certified / self.worst_found)

    def within(self, allowed: FloatArray) -> FloatArray:
        """Whether each joint is proven to stay within an allowed error (n,) over the whole region."""
        return np.asarray(self.certified <= allowed)


def _told(values: FloatArray) -> str:
    return ", ".join(number(rounded_up(float(value))) for value in values)


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
        Of a box: most positions per joint at which the error is evaluated (of each of at most 3 groups of
        waves), ten times as many for every angle beyond the fourth that it knows, up to the seventh. Of a
        tube: a twentieth as many small boxes, which cost as much, fewer where there are very many waves, each
        piece of the tube being one to begin with. More bring the bound closer to the truth; it is proven with
        any number.
    harmonics
        The arm's exact dynamics where they are at hand.
    progress
        Called with the hundredths of a joint that are done since it was called last.

    Returns
    -------
    Certificate
        Proven bound and worst error found.

    Raises
    ------
    ModelError
        If its program computes no torque of an arm, or is too long to be written out, see `expanded`.
    UsageError
        If the region is of another number of joints, `effort` is not positive, or no box is given and the arm
        does not state all its limits.
    """
    arm = model.arm
    tube = region if isinstance(region, Tube) else None
    box = box_of(region.enclosing if isinstance(region, Tube) else region, arm, effort)
    harmonics = harmonics or harmonics_of(arm)
    inertia = harmonics.whole_inertia(arm.drive_inertia if model.drives else None)
    runs = expansion_of(model)
    roundings = runs.round_off(box.farthest, box.velocity, box.acceleration)
    found = []
    for i, (row, rounding) in enumerate(zip(runs.rows, roundings, strict=True)):
        field, told = (
            ErrorField.of(exact_row(harmonics, inertia, i), row, float(rounding), box),
            _Told(progress),
        )
        found.append(_bounded_in(field, tube or box, box, effort, told))
        told(1.0)
    rows, errors, *states = (np.array(values) for values in zip(*found, strict=True))
    bounds = rows.T + harmonics_slack(harmonics, box)
    along = np.where(bounds <= 0.0, 0.0, np.nextafter(bounds, np.inf))
    worst = (states[0], states[1], states[2])
    return Certificate(region or box, along.max(axis=0), errors, worst, None if tube is None else along)


def expansion_of(model: SimplifiedModel) -> Expansion:
    """Write out what a model's program computes."""
    return expanded(model.program, [not turns for turns in model.arm.is_revolute])


def box_of(given: Box | None, arm: RobotArm, effort: int = 1) -> Box:
    """Box given, or the arm's own; a UsageError where it is of another arm or the effort is none."""
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
            "there is nothing to bound the error by", where="effort", expected="at least 1", found=str(effort)
        )
    return box


class _Told:
    """Tells whoever wants to know which share of a joint's work is done."""

    def __init__(self, progress: Callable[[int], None] | None) -> None:
        self._progress, self._done = progress, 0

    def __call__(self, share: float) -> None:
        more = int(100 * share) - self._done
        if self._progress is not None and more > 0:
            self._progress(more)
            self._done += more


def _bounded_in(field: ErrorField, region: Box | Tube, box: Box, effort: int, told: _Told) -> Bounded:
    """One joint's error in a box, or in a tube in that box."""
    if isinstance(region, Box):
        angles = sum(degree > 0 for degree in field.waves.degrees)
        further = _FURTHER ** (min(max(angles, _ANGLES), _MOST_ANGLES) - _ANGLES)
        bound, starts = _bounded(field, box, effort * further, told)
        return Bounded(np.array([bound]), *field.worst(box, starts))
    many = 1 + int(np.count_nonzero(field.waves.coefficients)) // _MANY
    along = bound_along(field, region, effort // (_PER_BOX * many))
    known = along.found + field.rest + field.round_off
    if along.bounds.max() <= _LOOSE * known:
        return along
    # Of wide boxes, between set points far apart, a grid over all of them may tell more.
    return along._replace(bounds=np.minimum(along.bounds, _bounded(field, box, effort, told)[0]))


def _bounded(field: ErrorField, box: Box, effort: int, told: _Told) -> tuple[float, FloatArray]:
    """Proven bound of one joint without the slack of the exact dynamics, and positions to climb from."""
    reached = _expected(field, box) if len(field.waves) else None
    shares, rest = shared_out(field.waves, box, effort, _GROUPS, reached)
    bound = field.rest + float(rest.sizes(box.farthest).sum())
    starts = [box.centre]
    for waves, grid in shares:
        amplitudes = float(waves.sizes(box.farthest).sum())
        # The first grid is the largest.
        largest, positions = _over_grid(field, waves, grid, told)
        starts += list(grid.positions(positions).T)
        bound += min(grid.over_box(waves, box, largest + field.round_off), amplitudes)
    # Some roundings of these sums.
    bound = bound * (1.0 + 64 * float(np.finfo(float).eps)) + field.round_off
    return bound, np.array(starts).T


def _expected(field: ErrorField, box: Box) -> Reached:
    """What the error reaches at a few positions, in the box and around the circle."""
    rng, revolute = np.random.default_rng(0), ~np.array(field.waves.prismatic)
    shares = [rng.random(_FEW if degree else 1) for degree in field.waves.degrees]
    lower, width = box.lower, box.upper - box.lower
    found = []
    for widths in (width, np.where(revolute & (width > 0.0), 2 * np.pi, width)):
        nodes = [low + share * wide for low, share, wide in zip(lower, shares, widths, strict=True)]
        found.append(max(float(field.motion.quick_bound(v).max()) for v in field.waves.on_grid(nodes)))
    return Reached(*found)


def _over_grid(
    field: ErrorField, waves: TrigonometricPolynomial, grid: Grid, told: _Told
) -> tuple[float, NDArray[np.int64]]:
    """Largest value over a grid, and the numbers of the best positions of a few of its pieces."""
    largest, before = 0.0, 0
    tops: list[tuple[float, int]] = []
    for values in waves.on_grid(grid.nodes):
        rough = np.abs(values).sum(axis=0)
        top = int(rough.argmax())
        tops.append((float(field.motion.bound(values[:, [top]])[0]), before + top))
        largest = max(largest, tops[-1][0])
        # Most positions are out of the question without a look at the signs of the velocities, and most
        # others without a close one.
        near = np.flatnonzero(rough > largest)
        quick = np.concatenate(
            [
                field.motion.quick_bound(values[:, part])
                for part in np.split(near, range(_BATCH, len(near), _BATCH))
            ]
        )
        order = np.argsort(-quick)
        near, quick = near[order], quick[order]
        while near.size and quick[0] > largest:
            bounds = field.motion.bound(values[:, near[:_CLOSELY]])
            if bounds.max() > largest:
                largest = float(bounds.max())
                tops.append((largest, before + int(near[bounds.argmax()])))
            near, quick = near[_CLOSELY:], quick[_CLOSELY:]
        before += values.shape[1]
        told(0.95 * before / grid.size)
    tops.sort(reverse=True)
    return largest, np.array([index for _, index in tops[:_STARTS]])


# Positions looked at, and the best of them from which the search climbs.
_DRAWN, _CLIMBED = 512, 4


def largest_torque(
    model: SimplifiedModel, region: Box | Tube | None = None, *, harmonics: Harmonics | None = None
) -> FloatArray:
    """Largest exact torque of every joint that a search finds among some states, N m (N), shape (n,).

    There may be larger ones: a share of it is rather too large than too small. It follows from the arm and
    these states alone, not from anything that the model states.

    Parameters
    ----------
    model
        Whose arm it is, and whether drives act.
    region
        The states; the arm's own limits by default.
    harmonics
        The arm's exact dynamics where they are at hand.
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
        elif len(field.waves):
            order = np.argsort(-field.motion.reached(field.waves(drawn)), kind="stable")
            out[i] = field.worst(box, drawn[:, order[:_CLIMBED]])[0]
    return out
