"""Every formulation on one arm: operations, times, and agreement with each other and with Pinocchio."""

from __future__ import annotations

import itertools
import time
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass, replace
from functools import partial
from statistics import median
from typing import Any, Literal

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.dynamics.mass_matrix import require_positive_definite
from gd_analyze.dynamics.methods import METHODS, Method, torque_of_states
from gd_analyze.dynamics.pinocchio_check import pinocchio_dynamics, pinocchio_torques, round_off_bounds
from gd_analyze.figures.figure import Axis, Curve, Figure, Marker, Panel, decades_axis, ends_named
from gd_analyze.motions.limits import check_against_arm, require_joints
from gd_analyze.motions.states import States, states_in_box, states_of
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.operations.program import OperationCount
from gd_analyze.result import Column, Drawing, Fact, Result, Section, Table
from gd_analyze.results.findings import provenance_of_run
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.description import describe_in_full
from gd_analyze.robots.limits import box_limits
from gd_analyze.robots.plausibility import warn_of_implausible
from gd_analyze.simplification.exact import ExactForm
from gd_analyze.studies.comparison_costs import (
    SIZES,
    Cost,
    Counted,
    Growth,
    count_cost,
    explanation,
    growth,
    text_costs,
)
from gd_analyze.studies.study_files import inputs_stated
from gd_analyze.text import number

# States at which torques are compared, one by one in Pinocchio; states drawn, compared and timed; their seed.
_MOST_SET_POINTS, _N_RANDOM, _N_TIMED, _SEED = 5000, 500, 2000, 1987
PINOCCHIO = "pinocchio"
REPEATS = 7  # of timings
STEPS = len(SIZES) * len(METHODS) + len(METHODS) + REPEATS + 1 + 1  # that `compare` reports to its caller

# Products of 4x4 or 3x3 matrices take twice the roundings per joint of rotating a vector, and probing sums
# whole torques: each of two formulations may be off by twice what `round_off_bounds` allows.
_ROUNDINGS = 4

_NAMES = {name: method.short for name, method in METHODS.items()} | {PINOCCHIO: "Pinocchio"}
_COUNTED: dict[Counted, str] = {"executed": "as executed", "folded": "folded", "text": "FGL87"}
# Marks, filled or hollow, tell the curves apart as colours do, so that grey print does as well.
_MARKS: dict[str, tuple[Marker, bool]] = {
    "lagrange_euler": ("square", False),
    "recursive_lagrangian": ("triangle", False),
    "newton_euler_base": ("circle", True),
    "newton_euler_link": ("circle", False),
    "newton_euler_regrouped": ("down", False),
    "generalized_dalembert": ("diamond", False),
    "composite_moments": ("cross", False),
}


@dataclass(frozen=True, eq=False)
class Comparison:
    """Everything one comparison found."""

    arm: RobotArm
    trajectory: Trajectory | None
    compared_at: str  # the states where torques were compared, in words
    costs: Mapping[str, Cost]  # by method, of this arm
    exact: OperationCount  # of the exact torque that models are counted against
    growth: Growth  # of costs on the generic chain
    seconds: Mapping[str, float]  # per set point at random states, by method, and Pinocchio's
    agreement: Agreement
    warnings: tuple[str, ...]  # what is suspicious about the input
    provenance: Mapping[str, str]


def compare(
    arm: RobotArm,
    trajectory: Trajectory | None = None,
    *,
    command: str = "",
    warned: Iterable[str] = (),
    progress: Callable[[int], None] = lambda done: None,
) -> Comparison:
    """Count, time and compare every formulation on one arm; a disagreement does not raise.

    Torques are compared along the trajectory or, without one, at random states within the arm's limits. A
    `TrajectoryError` refuses one of another number of joints, an `ArmError` a D not positive definite.
    `progress` is called with the number of steps done since the last call, of `STEPS`.
    """
    # Two runs measure other times.
    source = provenance_of_run(command, names_of(arm, trajectory), describe_in_full(arm), repeats=False)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        warn_of_implausible(arm, stacklevel=2)
        if trajectory is None:
            states = states_in_box(arm, _N_RANDOM, _SEED)
            compared_at = f"{_N_RANDOM} random states within the arm's limits{box_limits(arm).remark}"
        else:
            check_against_arm(trajectory, arm)
            require_joints(trajectory, arm)
            every = states_of(trajectory)
            states, compared_at = every.evenly(_MOST_SET_POINTS), every.in_words
            if len(states) < len(every):
                compared_at = f"{len(states)} of the {every.in_words}"
        require_positive_definite(arm, states, arm.counts_drives())
        agreed = agreement(arm, states)
        progress(1)
        seconds = time_methods(arm, states_in_box(arm, _N_TIMED, _SEED), progress)
        costs = {name: count_cost(method, arm) for name, method in METHODS.items()}
        progress(len(costs))
        exact = ExactForm(arm).operations
        grown = growth(progress)
    said = tuple(dict.fromkeys([*warned, *(str(item.message) for item in caught)]))
    return Comparison(arm, trajectory, compared_at, costs, exact, grown, seconds, agreed, said, source)


def names_of(arm: RobotArm, trajectory: Trajectory | None) -> tuple[str, str]:
    """Name arm and motion, which distinguish runs; "" without a motion."""
    return arm.name, "" if trajectory is None else trajectory.name


@dataclass(frozen=True, eq=False)
class Agreement:
    """Largest differences over all joints and set points, SI units."""

    names: tuple[str, ...]  # the m methods, and "pinocchio" last
    torque: FloatArray  # between any two of them, N m (N), (m + 1, m + 1)
    from_pinocchio: Mapping[str, Mapping[str, float]]  # by method and quantity: D, h, c and torque
    bounds: Mapping[str, float]  # what round-off explains, by quantity

    @property
    def largest(self) -> float:
        """Largest difference of torque between any two, N m (N)."""
        return float(self.torque.max())

    @property
    def holds(self) -> bool:
        """Whether round-off explains every difference."""
        rows, bounds = self.from_pinocchio.values(), self.bounds.items()
        beside_pinocchio = all(row[quantity] <= bound for row in rows for quantity, bound in bounds)
        return beside_pinocchio and self.largest <= self.bounds["torque"]


def agreement(arm: RobotArm, states: States, *, methods: Mapping[str, Method] = METHODS) -> Agreement:
    """Compare torque, D, h and c of methods at the same states; recursions are probed for D, h and c."""
    q_last, qd_last, _ = states.last
    theirs = pinocchio_dynamics(arm, *states.arrays)
    torques, from_pinocchio = [], {}
    for name, method in methods.items():
        torques.append(torque_of_states(method, arm, *states.arrays))
        given = method.dynamics(arm, q_last, qd_last)
        ours = {
            "inertia": np.moveaxis(given.inertia, -1, 0),
            "coriolis_centrifugal": given.coriolis_centrifugal.T,
            "gravity_loading": given.gravity_loading.T,
            "torque": torques[-1],
        }
        from_pinocchio[name] = {of: float(np.abs(ours[of] - value).max()) for of, value in theirs.items()}
    torques.append(theirs["torque"])
    differences = np.array([[np.abs(a - b).max() for b in torques] for a in torques])
    bounds = {name: _ROUNDINGS * float(b) for name, b in round_off_bounds(arm, *states.arrays).items()}
    return Agreement((*methods, PINOCCHIO), differences, from_pinocchio, bounds)


def time_methods(
    arm: RobotArm, states: States, progress: Callable[[int], None] = lambda done: None
) -> dict[str, float]:
    """Median seconds per set point of every method and, last, of a Python loop over Pinocchio's `rnea`.

    All run in turn on one thread, ours as one array call per operation and chunk of set points. A first round
    is not counted; `progress` is called with 1 after every round.
    """
    works: dict[str, Callable[[], object]] = {
        name: partial(torque_of_states, method, arm, *states.arrays) for name, method in METHODS.items()
    }
    works[PINOCCHIO] = pinocchio_torques(arm, *states.arrays)
    taken: dict[str, list[float]] = {name: [] for name in works}
    for _ in range(REPEATS + 1):
        # In turn, so that a machine whose speed drifts slows all alike.
        for name, work in works.items():
            start = time.perf_counter()
            work()
            taken[name].append(time.perf_counter() - start)
        progress(1)
    return {name: median(times[1:]) / len(states) for name, times in taken.items()}


def comparison_result(found: Comparison) -> Result:
    """Facts, tables and drawings of a comparison."""
    arm, agreed, grown = found.arm, found.agreement, found.growth
    unit = "N m" if all(arm.is_revolute) else "N m or N"
    verdict = "agree" if agreed.holds else "DISAGREE"
    title, dashed = "Operations over the number of joints", "Dashed: the polynomials of FGL87."
    drawings = (
        Drawing("folded", f"{title}, folded", growth_figure(grown, "folded")),
        Drawing("executed", f"{title}, as executed", growth_figure(grown, "executed"), note=dashed),
    )
    why = tuple(Fact(name, method.short, explanation(name, grown)) for name, method in METHODS.items())
    explanations = Section("explanations", "Where the counts differ, and why", why)
    return Result(
        title=arm.title or arm.name,
        subtitle=f"formulations compared at {found.compared_at}",
        headline=(
            f"All formulations {verdict}. Largest torque difference {number(agreed.largest)} {unit}, "
            f"explained by round-off up to {number(agreed.bounds['torque'])} {unit}."
        ),
        facts=tuple(_facts(found)),
        parts=(
            Section("cost", "Cost", (_methods_table(found, unit), _growth_table(grown), _forms_table())),
            Section("drawings", "Growth", drawings),
            Section("agreement", "Agreement", (_differences_table(agreed, unit), _pinocchio_table(agreed))),
            Section("founding_text", "Counts beside FGL87", (_polynomials_table(grown), explanations)),
        ),
        notices=found.warnings,
        provenance=inputs_stated(arm, found.trajectory) | dict(found.provenance),
    )


def _facts(found: Comparison) -> Iterator[Fact]:
    agreed, grown = found.agreement, found.growth
    fewest, *_, most = sorted(METHODS, key=lambda name: found.costs[name].folded.total)
    for label, name in (("Fewest", fewest), ("Most", most)):
        total = found.costs[name].folded.total
        yield Fact("", f"{label} operations, folded", total, shown="count", note=METHODS[name].short)
    label, text = "Exact torque that simplified models are counted against", f"{found.exact.total} operations"
    yield Fact("operations_full", label, asdict(found.exact), text=text)
    fastest = min(METHODS, key=found.seconds.__getitem__)
    least, loop = found.seconds[fastest], found.seconds[PINOCCHIO]
    label, note = "Shortest time per set point", METHODS[fastest].short
    yield Fact("", label, least, text=f"{1e6 * least:.2f} µs", note=note)
    label = "Time per set point, Pinocchio in a loop"
    yield Fact("seconds_pinocchio", label, loop, text=f"{1e6 * loop:.2f} µs")
    slopes = {name: grown.slope(name, "executed") or 0.0 for name in METHODS}
    flattest, *_, steepest = sorted(slopes, key=slopes.__getitem__)
    note = f"{METHODS[flattest].short}, {METHODS[steepest].short}"
    text = f"n^{slopes[flattest]:.1f} to n^{slopes[steepest]:.1f}"
    yield Fact("", f"Growth from 6 to {SIZES[-1]} joints", "", text=text, note=note)
    values: dict[str, Any] = {
        "arm": found.arm.name,
        "n_joints": found.arm.n_joints,
        "compared_at": found.compared_at,
        "agrees": agreed.holds,
        "largest_difference": agreed.largest,
        "timed_set_points": _N_TIMED,
        "timed_repeats": REPEATS,
        "sizes": SIZES,
        "curves": {
            name: {which: [asdict(count) for count in grown.counts(name, which)] for which in _COUNTED}
            for name in METHODS
        },
        "text_source": text_costs().source,
    }
    for key, value in values.items():
        yield Fact(key, "", value)


def _names(names: Iterable[str]) -> list[Column]:
    """Columns that begin a table of formulations."""
    shown = [_NAMES.get(name, "explained by round-off") for name in names]
    return [Column("name", "", tuple(names)), Column("", "formulation", shown, shown="text")]


def _methods_table(found: Comparison, unit: str) -> Table:
    """Operations, time and difference by method, and Pinocchio's last."""
    n, texts, agreed = found.arm.n_joints, map(text_costs().of, METHODS), found.agreement
    counts: dict[Counted, list[OperationCount | None]] = {
        "executed": [found.costs[name].executed for name in METHODS],
        "folded": [found.costs[name].folded for name in METHODS],
        "text": [None if stated is None else stated.at(n) for stated in texts],
    }
    columns, seconds = _names(agreed.names), [found.seconds[name] for name in agreed.names]
    for which, label in _COUNTED.items():
        every = [*counts[which], None]
        pairs = [x and f"{x.multiplications} + {x.additions}" for x in every]
        columns.append(Column(which, "", [x and asdict(x) for x in every]))
        columns.append(Column("", label, pairs, meaning="multiplications + additions"))
    columns += [
        Column("seconds", "", seconds),
        Column("", "time", [f"{1e6 * x:.2f}" for x in seconds], "µs"),
        Column("difference", "difference", agreed.torque.max(axis=1), unit),
    ]
    note = f"Multiplications + additions of one torque; FGL87's polynomials at n = {n}."
    return Table("methods", "Operations, time per set point, largest torque difference", tuple(columns), note)


def _forms_table() -> Table:
    title, *others = (
        Column(key, label, [getattr(method, key) for method in METHODS.values()], shown="text")
        for key, label in (("title", ""), ("kinematics",) * 2, ("form", "equations"), ("source", ""))
    )
    name, short = _names(METHODS)
    return Table("forms", "Kinematics and form of the equations", (name, title, short, *others))


def _growth_table(grown: Growth) -> Table:
    orders = [method.growth for method in METHODS.values()]
    columns = [*_names(METHODS), Column("order", "order", orders, shown="text")]
    for which, label in _COUNTED.items():
        slopes = [grown.slope(name, which) for name in METHODS]
        columns.append(Column(f"exponent_{which}", "", slopes))
        columns.append(Column("", label, [slope and f"{slope:.2f}" for slope in slopes]))
    title = f"Growth: slope of log(operations) over log(n), n = 6 to {SIZES[-1]}, on a generic chain"
    return Table("growth", title, tuple(columns))


def _differences_table(agreed: Agreement, unit: str) -> Table:
    rows = (Column(name, _NAMES[name], row) for name, row in zip(agreed.names, agreed.torque, strict=True))
    title = f"Largest torque difference of any two, {unit}"
    return Table("torque_differences", title, (*_names(agreed.names), *rows))


def _pinocchio_table(agreed: Agreement) -> Table:
    rows = {**agreed.from_pinocchio, "round_off": agreed.bounds}
    symbols = zip(agreed.bounds, ("D", "h", "c", "torque"), strict=True)
    columns = [Column(key, symbol, [row[key] for row in rows.values()]) for key, symbol in symbols]
    return Table("from_pinocchio", "Largest difference from Pinocchio, SI units", (*_names(rows), *columns))


def _polynomials_table(grown: Growth) -> Table:
    """Per method the polynomials of FGL87, then ours."""
    totals, rows = text_costs().totals, []
    for name, method in METHODS.items():
        stated = [(f"FGL87 {x.table}", x.multiplications, x.additions) for x in totals if x.name == name]
        ours = [("here", *grown.polynomials[name])] if name in grown.polynomials else []
        rows += [(method.short, *map(str, row)) for row in (*stated, *ours)]
    keys = ("formulation", "counted", "multiplications", "additions")
    columns = zip(keys, zip(*rows, strict=True), strict=True)
    remarks = [f"{METHODS[x.name].short}, FGL87 {x.table}: {x.remark}." for x in totals if x.remark]
    return Table(
        "polynomials",
        "Operations on a generic chain of n joints, by table and as executed",
        tuple(Column(key, key, values, shown="text") for key, values in columns),
        "\n".join([*remarks, text_costs().remark]),
    )


def growth_figure(grown: Growth, which: Literal["executed", "folded"]) -> Figure:
    """Operations of every method over the number of joints, both axes logarithmic; FGL87's dashed."""
    totals = {
        (name, counted): [float(count.total) for count in grown.counts(name, counted)]
        for name, counted in itertools.product(METHODS, _COUNTED)
    }
    # Both figures of a report have one scale.
    every = [total for row in totals.values() for total in row]
    y = decades_axis(min(every) / 1.3, max(every) * 1.3)
    y = replace(y, names=tuple(f"{tick:,.0f}".replace(",", "\u202f") for tick in y.ticks))
    named = tuple(float(n) for n in SIZES if n <= 6 or n % 2 == 0)
    x = Axis(SIZES[0] / 1.05, SIZES[-1] * 1.05, named, is_logarithmic=True)
    sizes, items, ends = np.array(SIZES, dtype=float), [], []
    for k, (name, (marker, hollow)) in enumerate(_MARKS.items(), start=1):
        colour, label, row = f"series-{k}", _NAMES[name], totals[name, which]
        if stated := totals[name, "text"]:
            items.append(Curve(sizes, np.array(stated), colour, 0.9, (4.0, 2.8)))
        tips = tuple(f"{label}, n = {n}\n{total:.0f} operations" for n, total in zip(SIZES, row, strict=True))
        curve = Curve(sizes, np.array(row), colour, 1.3, label=label, marker=marker, hollow=hollow, tips=tips)
        items.append(curve)
        ends.append((row[-1], label, colour))
    margins = (40.0, 26.0, 110.0, 16.0)
    panel = Panel(which, f"operations, {_COUNTED[which]}", x, y, tuple(items), margins=margins)
    label = f"Operations {_COUNTED[which]} over the number of joints"
    return ends_named(label, panel, ends, "joints n", 250.0)
