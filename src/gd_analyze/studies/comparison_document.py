"""A comparison of formulations as plain values: what terminal, JSON, HTML and PDF show."""

from __future__ import annotations

import warnings
from dataclasses import asdict
from typing import Any

from gd_analyze.dynamics.methods import METHODS
from gd_analyze.dynamics.pinocchio_check import QUANTITIES
from gd_analyze.operations.program import OperationCount
from gd_analyze.robots.description import fingerprint
from gd_analyze.studies.compare import Comparison
from gd_analyze.studies.cost_explanations import explanation
from gd_analyze.studies.text_costs import text_costs
from gd_analyze.text import number


def comparison_document(comparison: Comparison) -> dict[str, Any]:
    """Lay a comparison out as JSON values, full precision.

    Parameters
    ----------
    comparison
        What was found.

    Returns
    -------
    dict
        Operations by method are those of one torque of this arm, `text` FGL87's polynomials at its number
        of joints; `exponent` and the curves are of the generic chain. Times are seconds per set point,
        differences of torque N m (N), `from_pinocchio` rows of D, h, c and torque, SI units, as `bounds` are.
    """
    arm, agreed, grown = comparison.arm, comparison.agreement, comparison.growth
    text = text_costs()
    return {
        "title": arm.title or arm.name,
        "subtitle": f"formulations compared at {comparison.compared_at}",
        "headline": _headline(comparison),
        "facts": _facts(comparison),
        "n_joints": arm.n_joints,
        "all_turning": all(arm.is_revolute),
        "methods": [_method(comparison, name) for name in METHODS],
        "operations_full": asdict(comparison.exact),
        "seconds_pinocchio": comparison.timing.pinocchio,
        "timed_set_points": comparison.timing.set_points,
        "timed_repeats": comparison.timing.repeats,
        "sizes": list(grown.sizes),
        "curves": [
            {
                "name": name,
                "short": METHODS[name].short,
                "executed": [asdict(count) for count in grown.counts(name, "executed")],
                "folded": [asdict(count) for count in grown.counts(name, "folded")],
                "text": [_of_text(count) for count in grown.counts(name, "text")],
            }
            for name in METHODS
        ],
        "names": list(agreed.names),
        "torque_differences": agreed.torque.tolist(),
        "from_pinocchio": [
            [name, *(row[quantity] for quantity in QUANTITIES)] for name, row in agreed.from_pinocchio.items()
        ],
        "bounds": [agreed.bounds[quantity] for quantity in QUANTITIES],
        "agrees": agreed.holds,
        "polynomials": _polynomials(comparison),
        "text_source": text.source,
        "text_remark": text.remark,
        "warnings": list(comparison.warnings),
        "provenance": dict(provenance_rows(comparison)),
    }


def _method(comparison: Comparison, name: str) -> dict[str, Any]:
    method, cost, grown = METHODS[name], comparison.costs[name], comparison.growth
    stated = text_costs().of(name)
    return {
        "name": name,
        "title": method.title,
        "short": method.short,
        "source": method.source,
        "kinematics": method.kinematics,
        "form": method.form,
        "order": method.growth,
        "executed": asdict(cost.executed),
        "folded": asdict(cost.folded),
        "text": _of_text(stated.at(comparison.arm.n_joints)) if stated else None,
        "text_remark": stated.remark if stated else "",
        "seconds": comparison.timing.seconds[name],
        "difference": comparison.agreement.worst_of(name),
        "exponent": grown.slope(name, "executed"),
        "exponent_folded": grown.slope(name, "folded"),
        "exponent_text": grown.slope(name, "text"),
        "explanation": explanation(name, grown),
    }


def _of_text(count: OperationCount) -> dict[str, Any]:
    return asdict(count) | {"sines_cosines": None}


def _polynomials(comparison: Comparison) -> list[list[str]]:
    """Per method FGL87's polynomials, then ours: title, whose, multiplications, additions, remark."""
    rows = []
    for name, method in METHODS.items():
        stated: dict[tuple[str, str, str], list[str]] = {}
        for cost in text_costs().totals:
            if cost.name == name:
                key = (str(cost.multiplications), str(cost.additions), cost.remark)
                stated.setdefault(key, []).append(cost.table)
        rows += [[method.title, f"Table {' and '.join(tables)}", *key] for key, tables in stated.items()]
        if name in comparison.growth.polynomials:
            multiplications, additions = comparison.growth.polynomials[name]
            rows.append([method.title, "ours", str(multiplications), str(additions), ""])
    return rows


def _headline(comparison: Comparison) -> str:
    agreed, folded = comparison.agreement, _folded(comparison)
    fewest, most = (choose(folded, key=folded.__getitem__) for choose in (min, max))
    difference = f"{number(agreed.largest)} {comparison.unit}"
    # An arm without mass needs none at all.
    more = f"{folded[most] / folded[fewest]:.2g} times as many" if folded[fewest] else str(folded[most])
    told = (
        f"All formulations agree: their torques differ by at most {difference}"
        if agreed.holds
        else f"The formulations disagree: torques differ by {difference}, more than round-off explains"
    )
    return (
        f"{told}. {METHODS[fewest].title} needs the fewest operations, {folded[fewest]} once folded; "
        f"{METHODS[most].title} needs {more}. Rewritten, the exact torque takes "
        f"{comparison.exact.total}: what simplified models are counted against."
    )


def _facts(comparison: Comparison) -> list[list[str]]:
    """Headline figures and their captions."""
    folded, timing, agreed = _folded(comparison), comparison.timing, comparison.agreement
    fewest = min(folded, key=folded.__getitem__)
    fastest = min(timing.seconds, key=timing.seconds.__getitem__)
    slopes = {name: comparison.growth.slope(name, "executed") or 0.0 for name in METHODS}
    flattest, steepest = (choose(slopes, key=slopes.__getitem__) for choose in (min, max))
    return [
        [str(folded[fewest]), f"operations at the fewest, folded ({METHODS[fewest].short})"],
        [
            f"{1e6 * timing.seconds[fastest]:.2f} µs",
            f"per set point at the fastest ({METHODS[fastest].short}); Pinocchio in a loop "
            f"{1e6 * timing.pinocchio:.2f} µs",
        ],
        [
            f"n^{slopes[flattest]:.1f} … n^{slopes[steepest]:.1f}",
            f"growth from 6 to 12 joints, {METHODS[flattest].short} to {METHODS[steepest].short}",
        ],
        [
            number(agreed.largest),
            f"largest difference of any two torques, {comparison.unit}; "
            f"round-off allows {number(agreed.bounds['torque'])}",
        ],
    ]


def _folded(comparison: Comparison) -> dict[str, int]:
    return {name: cost.folded.total for name, cost in comparison.costs.items()}


def provenance_rows(comparison: Comparison) -> list[tuple[str, str]]:
    """Say where the result comes from, as (label, value)."""
    trajectory = comparison.trajectory
    motion = f"{trajectory.name}, SHA-256 {trajectory.fingerprint[:16]}" if trajectory else "none given"
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # already told when the arm was read
        arm = f"{comparison.arm.name}, SHA-256 {fingerprint(comparison.arm)[:16]}"
    return [
        ("arm", arm),
        *(("payload", note) for note in comparison.arm.assumptions if "payload" in note),
        ("trajectory", motion),
        *comparison.provenance.items(),
    ]
