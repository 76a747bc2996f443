"""Every formulation on one arm: operations, times, and agreement with each other and with Pinocchio."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any, Literal

import numpy as np

from gd_analyze.dynamics.mass_matrix import require_positive_definite
from gd_analyze.dynamics.methods import METHODS
from gd_analyze.dynamics.pinocchio_check import QUANTITIES
from gd_analyze.figures.figure import (
    Axis,
    Curve,
    Figure,
    Marker,
    Panel,
    decades_axis,
    ends_named,
)
from gd_analyze.motions.checks import check_against_arm, require_joints
from gd_analyze.motions.states import States, states_in_box, states_of
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.operations.program import OperationCount
from gd_analyze.result import Column, Drawing, Fact, Result, Section, Table
from gd_analyze.results.provenance import provenance_of_run
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.description import describe_in_full
from gd_analyze.robots.limits import box_limits
from gd_analyze.robots.plausibility import warn_of_implausible
from gd_analyze.simplification.exact_form import ExactForm
from gd_analyze.studies.comparison_agreement import (
    PINOCCHIO,
    REPEATS,
    Agreement,
    Timing,
    agreement,
    time_methods,
)
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

# States at which torques are compared, one by one in Pinocchio; states drawn, compared and timed.
MOST_SET_POINTS, N_RANDOM, N_TIMED = 5000, 500, 2000
# Steps that `compare` reports to its caller.
STEPS = len(SIZES) * len(METHODS) + len(METHODS) + REPEATS + 1 + 1

_NAMES = {name: method.short for name, method in METHODS.items()} | {PINOCCHIO: "Pinocchio"}
_COUNTED: dict[Counted, str] = {"executed": "as executed", "folded": "folded", "text": "FGL87"}
# Colour, dashes and marks tell the curves apart, so that grey print does as well.
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
    """Everything one comparison found.

    Parameters
    ----------
    arm, trajectory
        The arm and the trajectory, if one was given.
    compared_at
        The states where torques were compared, in words.
    costs
        By method, of this arm.
    exact
        Operations of the exact torque that models are counted against.
    growth
        Costs on the generic chain.
    timing
        Seconds per set point, at random states.
    agreement
        Largest differences.
    warnings
        What is suspicious about the input.
    provenance
        Versions, time, command.
    """

    arm: RobotArm
    trajectory: Trajectory | None
    compared_at: str
    costs: Mapping[str, Cost]
    exact: OperationCount
    growth: Growth
    timing: Timing
    agreement: Agreement
    warnings: tuple[str, ...]
    provenance: Mapping[str, str]


def compare(
    arm: RobotArm,
    trajectory: Trajectory | None = None,
    *,
    command: str = "",
    warned: Iterable[str] = (),
    progress: Callable[[int], None] = lambda done: None,
) -> Comparison:
    """Count, time and compare every formulation on one arm.

    Parameters
    ----------
    arm
        The arm.
    trajectory
        Where to compare torques; random states within the arm's limits where it is left out.
    command
        What the user typed, for provenance.
    warned
        Warnings given while the input was read; those given here are added.
    progress
        Called with the number of steps done since the last call, of `STEPS`.

    Returns
    -------
    Comparison
        A disagreement does not raise.

    Raises
    ------
    TrajectoryError
        If the trajectory is of another number of joints.
    ArmError
        If D is not positive definite somewhere.
    """
    # Two runs measure other times.
    source = provenance_of_run(command, names_of(arm, trajectory), describe_in_full(arm), repeats=False)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        warn_of_implausible(arm, stacklevel=2)
        if trajectory is not None:
            check_against_arm(trajectory, arm)
        states, compared_at = _states(arm, trajectory)
        require_positive_definite(arm, states, arm.counts_drives())
        agreed = agreement(arm, states)
        progress(1)
        timing = time_methods(arm, _drawn(arm, N_TIMED), progress=progress)
        costs = {name: count_cost(method, arm) for name, method in METHODS.items()}
        progress(len(costs))
        exact = ExactForm(arm).operations
        grown = growth(progress)
    every = tuple(dict.fromkeys([*warned, *(str(item.message) for item in caught)]))
    return Comparison(arm, trajectory, compared_at, costs, exact, grown, timing, agreed, every, source)


def names_of(arm: RobotArm, trajectory: Trajectory | None) -> tuple[str, str]:
    """Name arm and motion, which distinguish runs; "" without a motion."""
    return arm.name, "" if trajectory is None else trajectory.name


def _states(arm: RobotArm, trajectory: Trajectory | None) -> tuple[States, str]:
    if trajectory is None:
        return _drawn(
            arm, N_RANDOM
        ), f"{N_RANDOM} random states within the arm's limits{box_limits(arm).remark}"
    require_joints(trajectory, arm)
    every = states_of(trajectory)
    few = every.evenly(MOST_SET_POINTS)
    return few, f"{len(few)} of the {every.in_words}" if len(few) < len(every) else every.in_words


def _drawn(arm: RobotArm, count: int) -> States:
    """Random states within the arm's limits, the same ones every time."""
    return states_in_box(arm, count, 1987)


def comparison_result(found: Comparison) -> Result:
    """Facts, tables and drawings of a comparison."""
    arm, agreed, grown = found.arm, found.agreement, found.growth
    unit = "N m" if all(arm.is_revolute) else "N m or N"
    verdict = "agree" if agreed.holds else "DISAGREE"
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
            Section(
                "drawings",
                "Growth",
                (
                    Drawing(
                        "folded",
                        "Operations over the number of joints, folded",
                        growth_figure(grown, "folded"),
                    ),
                    Drawing(
                        "executed",
                        "Operations over the number of joints, as executed",
                        growth_figure(grown, "executed"),
                        note="Dashed: the polynomials of FGL87.",
                    ),
                ),
            ),
            Section("agreement", "Agreement", (_differences_table(agreed, unit), _pinocchio_table(agreed))),
            Section("founding_text", "Counts beside FGL87", (_polynomials_table(grown), _explained(grown))),
        ),
        notices=found.warnings,
        provenance=inputs_stated(arm, found.trajectory) | dict(found.provenance),
    )


def _facts(found: Comparison) -> Iterator[Fact]:
    agreed, timing, grown = found.agreement, found.timing, found.growth
    folded: dict[str, float] = {name: cost.folded.total for name, cost in found.costs.items()}
    slopes = {name: grown.slope(name, "executed") or 0.0 for name in METHODS}
    (fewest, most), (flattest, steepest) = (
        (min(x, key=x.__getitem__), max(x, key=x.__getitem__)) for x in (folded, slopes)
    )
    fastest = min(timing.seconds, key=timing.seconds.__getitem__)
    for label, name in (("Fewest", fewest), ("Most", most)):
        note = METHODS[name].short
        yield Fact("", f"{label} operations, folded", folded[name], shown="count", note=note)
    label, text = "Exact torque that simplified models are counted against", f"{found.exact.total} operations"
    yield Fact("operations_full", label, asdict(found.exact), text=text)
    for key, label, seconds, note in (
        ("", "Shortest time per set point", timing.seconds[fastest], METHODS[fastest].short),
        ("seconds_pinocchio", "Time per set point, Pinocchio in a loop", timing.pinocchio, ""),
    ):
        yield Fact(key, label, seconds, text=f"{1e6 * seconds:.2f} µs", note=note)
    note = f"{METHODS[flattest].short}, {METHODS[steepest].short}"
    text = f"n^{slopes[flattest]:.1f} to n^{slopes[steepest]:.1f}"
    yield Fact("", f"Growth from 6 to {SIZES[-1]} joints", "", text=text, note=note)
    curves = {
        name: {which: [asdict(count) for count in grown.counts(name, which)] for which in _COUNTED}
        for name in METHODS
    }
    values: dict[str, Any] = {
        "arm": found.arm.name,
        "n_joints": found.arm.n_joints,
        "compared_at": found.compared_at,
        "agrees": agreed.holds,
        "largest_difference": agreed.largest,
        "timed_set_points": timing.set_points,
        "timed_repeats": timing.repeats,
        "sizes": grown.sizes,
        "curves": curves,
        "text_source": text_costs().source,
    }
    for key, value in values.items():
        yield Fact(key, "", value)


def _methods_table(found: Comparison, unit: str) -> Table:
    """Operations, time and difference by method, and Pinocchio's last."""
    n, texts = found.arm.n_joints, [text_costs().of(name) for name in METHODS]
    counts: dict[Counted, list[OperationCount | None]] = {
        "executed": [found.costs[name].executed for name in METHODS],
        "folded": [found.costs[name].folded for name in METHODS],
        "text": [None if stated is None else stated.at(n) for stated in texts],
    }
    seconds = [*(found.timing.seconds[name] for name in METHODS), found.timing.pinocchio]
    differences = [found.agreement.worst_of(name) for name in (*METHODS, PINOCCHIO)]

    columns = [
        Column("name", "", (*METHODS, PINOCCHIO)),
        Column("", "formulation", list(_NAMES.values()), shown="text"),
    ]
    for which, label in _COUNTED.items():
        pairs = [
            None if count is None else f"{count.multiplications} + {count.additions}"
            for count in counts[which]
        ]
        columns += [
            Column(which, "", [*(count and asdict(count) for count in counts[which]), None]),
            Column("", label, [*pairs, None], meaning="multiplications + additions"),
        ]
    columns += [
        Column("seconds", "", seconds),
        Column("", "time", [f"{1e6 * x:.2f}" for x in seconds], "µs"),
        Column("difference", "difference", differences, unit),
    ]
    note = f"Multiplications + additions of one torque; FGL87's polynomials at n = {n}."
    return Table("methods", "Operations, time per set point, largest torque difference", tuple(columns), note)


def _forms_table() -> Table:
    methods = METHODS.values()
    columns = (
        Column("name", "", list(METHODS)),
        Column("title", "", [method.title for method in methods]),
        Column("", "formulation", [method.short for method in methods], shown="text"),
        Column("kinematics", "kinematics", [method.kinematics for method in methods], shown="text"),
        Column("form", "equations", [method.form for method in methods], shown="text"),
        Column("source", "", [method.source for method in methods]),
    )
    return Table("forms", "Kinematics and form of the equations", columns)


def _growth_table(grown: Growth) -> Table:
    slopes: dict[Counted, list[float | None]] = {
        which: [grown.slope(name, which) for name in METHODS] for which in _COUNTED
    }
    columns = [
        Column("name", "", list(METHODS)),
        Column("", "formulation", [method.short for method in METHODS.values()], shown="text"),
        Column("order", "order", [method.growth for method in METHODS.values()], shown="text"),
    ]
    for which, label in _COUNTED.items():
        texts = [None if slope is None else f"{slope:.2f}" for slope in slopes[which]]
        columns += [Column(f"exponent_{which}", "", slopes[which]), Column("", label, texts)]
    title = f"Growth: slope of log(operations) over log(n), n = 6 to {SIZES[-1]}, on a generic chain"
    return Table("growth", title, tuple(columns))


def _differences_table(agreed: Agreement, unit: str) -> Table:
    columns = [
        Column("name", "", agreed.names),
        Column("", "formulation", [_NAMES[name] for name in agreed.names], shown="text"),
        *(Column(name, _NAMES[name], row) for name, row in zip(agreed.names, agreed.torque, strict=True)),
    ]
    return Table("torque_differences", f"Largest torque difference of any two, {unit}", tuple(columns))


def _pinocchio_table(agreed: Agreement) -> Table:
    rows = {**agreed.from_pinocchio, "round_off": agreed.bounds}
    names = [_NAMES.get(name, "explained by round-off") for name in rows]
    symbols = dict(zip(QUANTITIES, ("D", "h", "c", "torque"), strict=True))
    columns = [Column("name", "", list(rows)), Column("", "formulation", names, shown="text")]
    columns += [Column(key, symbol, [row[key] for row in rows.values()]) for key, symbol in symbols.items()]
    return Table("from_pinocchio", "Largest difference from Pinocchio, SI units", tuple(columns))


def _polynomials_table(grown: Growth) -> Table:
    """Per method the polynomials of FGL87, then ours."""
    rows: list[tuple[str, str, str, str]] = []
    totals = text_costs().totals
    for name, method in METHODS.items():
        for cost in totals:
            if cost.name == name:
                table = f"FGL87 {cost.table}"
                rows.append((method.short, table, str(cost.multiplications), str(cost.additions)))
        if name in grown.polynomials:
            multiplications, additions = grown.polynomials[name]
            rows.append((method.short, "here", str(multiplications), str(additions)))
    keys = ("formulation", "counted", "multiplications", "additions")
    columns = tuple(
        Column(key, key, x, shown="text") for key, x in zip(keys, zip(*rows, strict=True), strict=True)
    )
    remarks = [f"{METHODS[x.name].short}, FGL87 {x.table}: {x.remark}." for x in totals if x.remark]
    note = "\n".join([*remarks, text_costs().remark])
    return Table(
        "polynomials", "Operations on a generic chain of n joints, by table and as executed", columns, note
    )


def _explained(grown: Growth) -> Section:
    facts = tuple(Fact(name, METHODS[name].short, explanation(name, grown)) for name in METHODS)
    return Section("explanations", "Where the counts differ, and why", facts)


def growth_figure(grown: Growth, which: Literal["executed", "folded"]) -> Figure:
    """Operations of every method over the number of joints, both axes logarithmic; FGL87's dashed."""
    totals: dict[Counted, dict[str, list[int]]] = {
        counted: {name: [count.total for count in grown.counts(name, counted)] for name in METHODS}
        for counted in _COUNTED
    }
    # Both figures of a report have one scale.
    every = [total for rows in totals.values() for row in rows.values() for total in row]
    y = decades_axis(min(every) / 1.3, max(every) * 1.3)
    y = replace(y, names=tuple(f"{tick:,.0f}".replace(",", "\u202f") for tick in y.ticks))
    named = tuple(float(n) for n in SIZES if n <= 6 or n % 2 == 0)
    x = Axis(SIZES[0] / 1.05, SIZES[-1] * 1.05, named, is_logarithmic=True)
    sizes = np.array(SIZES, dtype=float)
    items: list[Curve] = []
    ends = []
    for k, (name, (marker, hollow)) in enumerate(_MARKS.items(), start=1):
        colour, row = f"series-{k}", totals[which][name]
        if stated := totals["text"][name]:
            items.append(Curve(sizes, np.array(stated, dtype=float), colour, 0.9, (4.0, 2.8)))
        tips = tuple(
            f"{_NAMES[name]}, n = {n}\n{total} operations" for n, total in zip(SIZES, row, strict=True)
        )
        curve = np.array(row, dtype=float)
        items.append(
            Curve(sizes, curve, colour, 1.3, label=_NAMES[name], marker=marker, hollow=hollow, tips=tips)
        )
        ends.append((float(row[-1]), _NAMES[name], colour))
    margins = (40.0, 26.0, 110.0, 16.0)
    panel = Panel(which, f"operations, {_COUNTED[which]}", x, y, tuple(items), margins=margins)
    label = f"Operations {_COUNTED[which]} over the number of joints"
    return ends_named(label, panel, ends, "joints n", 250.0)
