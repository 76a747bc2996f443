"""The numbers of a comparison of formulations as plain values; terminal, JSON, HTML and PDF show these."""

from __future__ import annotations

import json
import warnings
from collections.abc import Collection
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from gd_analyze.comparison import METHODS, Comparison, Polynomial, text_costs
from gd_analyze.comparison.agreement import AUTHORITY
from gd_analyze.comparison.costs import exponent
from gd_analyze.errors import UsageError
from gd_analyze.files import replacing, write_text
from gd_analyze.formatting import number
from gd_analyze.operations import OperationCount
from gd_analyze.robots import fingerprint

FILES = {"html": "comparison.html", "pdf": "comparison.pdf", "json": "comparison.json"}
SHORT = {
    "lagrange_euler": "L-E",
    "recursive_lagrangian": "recursive L.",
    "newton_euler_base": "N-E base",
    "newton_euler_link": "N-E link",
    "generalized_dalembert": "G-D",
    "composite_moments": "G-D composite",
    AUTHORITY: "Pinocchio",
}


@dataclass(frozen=True)
class Count:
    """Multiplications, additions, and sines and cosines where they were counted."""

    multiplications: int
    additions: int
    sines_cosines: int | None = None

    @property
    def total(self) -> int:
        """Multiplications plus additions."""
        return self.multiplications + self.additions


@dataclass(frozen=True)
class MethodRow:
    """One formulation on the arm at hand; `text` is the text's polynomial at its number of joints.

    `seconds` is per set point; `difference` the largest of its torque from any other's, N m (N); the
    exponents are of total operations on the generic chain, `exponent_text` of the text's polynomial over
    the same sizes.
    """

    name: str
    title: str
    short: str
    source: str
    kinematics: str
    form: str
    order: str
    executed: Count
    folded: Count
    text: Count | None
    text_remark: str
    seconds: float
    difference: float
    exponent: float
    exponent_folded: float
    exponent_text: float | None
    explanation: str


@dataclass(frozen=True)
class Curve:
    """Total operations of one method over the number of joints; `text` where the text has a polynomial."""

    name: str
    short: str
    executed: tuple[Count, ...]
    folded: tuple[Count, ...]
    text: tuple[Count, ...]


@dataclass(frozen=True)
class ComparisonContext:
    """All numbers a report on a comparison shows.

    Parameters
    ----------
    title, subtitle
        Arm, and where torques were compared.
    headline
        The answer in one or two sentences.
    facts
        Headline figures as (value, caption).
    n_joints, all_turning
        Of the arm.
    methods
        One row per formulation.
    seconds_pinocchio
        Per set point, a Python loop over its `rnea`.
    timed_set_points, timed_repeats
        How the times were taken.
    sizes, curves
        Growth on the generic chain.
    names, torque_differences
        Largest torque difference of every pair, N m (N), "pinocchio" last.
    from_pinocchio
        (method, D, h, c, torque): largest difference from Pinocchio, SI units.
    bounds
        What round-off explains of D, h, c and torque.
    agrees
        Whether it explains all.
    polynomials
        (method, whose, multiplications, additions, remark): the text's, and ours as executed.
    text_source, text_remark
        Where they are from.
    warnings, provenance
        As in every report.
    """

    title: str
    subtitle: str
    headline: str
    facts: tuple[tuple[str, str], ...]
    n_joints: int
    all_turning: bool
    methods: tuple[MethodRow, ...]
    seconds_pinocchio: float
    timed_set_points: int
    timed_repeats: int
    sizes: tuple[int, ...]
    curves: tuple[Curve, ...]
    names: tuple[str, ...]
    torque_differences: tuple[tuple[float, ...], ...]
    from_pinocchio: tuple[tuple[str, float, float, float, float], ...]
    bounds: tuple[float, float, float, float]
    agrees: bool
    polynomials: tuple[tuple[str, str, str, str, str], ...]
    text_source: str
    text_remark: str
    warnings: tuple[str, ...]
    provenance: tuple[tuple[str, str], ...]


def comparison_context(comparison: Comparison) -> ComparisonContext:
    """Collect the numbers of one comparison."""
    arm, agreed, grown = comparison.arm, comparison.agreement, comparison.growth
    text = text_costs()
    why = {told.method: told.sentence for told in comparison.explanations}
    rows = []
    for name, method in METHODS.items():
        stated = text.of(name)
        large = [n for n in grown.sizes if n >= 6]
        cost = comparison.costs[name]
        rows.append(
            MethodRow(
                name=name,
                title=method.title,
                short=SHORT[name],
                source=method.source,
                kinematics=method.kinematics,
                form=method.form,
                order=method.growth,
                executed=_count(cost.executed),
                folded=_count(cost.folded),
                text=_text(stated.multiplications, stated.additions, arm.n_joints) if stated else None,
                text_remark=stated.remark if stated else "",
                seconds=comparison.timing.seconds[name],
                difference=agreed.worst_of(name),
                exponent=grown.exponents[name],
                exponent_folded=grown.exponents_folded[name],
                exponent_text=exponent(large, [stated.total(n) for n in large]) if stated else None,
                explanation=why[name],
            )
        )
    bounds = agreed.bounds
    return ComparisonContext(
        title=arm.title or arm.name,
        subtitle=f"formulations compared at {comparison.states}",
        headline=_headline(comparison, rows),
        facts=_facts(comparison, rows),
        n_joints=arm.n_joints,
        all_turning=all(arm.is_revolute),
        methods=tuple(rows),
        seconds_pinocchio=comparison.timing.pinocchio,
        timed_set_points=comparison.timing.set_points,
        timed_repeats=comparison.timing.repeats,
        sizes=grown.sizes,
        curves=tuple(
            Curve(
                name,
                SHORT[name],
                tuple(_count(cost.executed) for cost in costs),
                tuple(_count(cost.folded) for cost in costs),
                tuple(_text(stated.multiplications, stated.additions, n) for n in grown.sizes)
                if (stated := text.of(name))
                else (),
            )
            for name, costs in grown.costs.items()
        ),
        names=agreed.names,
        torque_differences=tuple(tuple(float(x) for x in row) for row in agreed.torque),
        from_pinocchio=tuple(
            (name, row["inertia"], row["coriolis_centrifugal"], row["gravity_loading"], row["torque"])
            for name, row in agreed.from_authority.items()
        ),
        bounds=(
            float(bounds["inertia"]),
            float(bounds["coriolis_centrifugal"]),
            float(bounds["gravity_loading"]),
            float(bounds["torque"]),
        ),
        agrees=agreed.holds,
        polynomials=_polynomials(comparison),
        text_source=text.source,
        text_remark=text.remark,
        warnings=comparison.warnings,
        provenance=_provenance(comparison),
    )


def _polynomials(comparison: Comparison) -> tuple[tuple[str, str, str, str, str], ...]:
    """Per method the text's polynomials, then ours."""
    rows = []
    for name, method in METHODS.items():
        stated: dict[tuple[str, str, str], list[str]] = {}
        for cost in text_costs().totals:
            if cost.name == name:
                key = (str(cost.multiplications), str(cost.additions), cost.remark)
                stated.setdefault(key, []).append(cost.table)
        for (multiplications, additions, remark), tables in stated.items():
            whose = f"Table {' and '.join(tables)}"
            rows.append((method.title, whose, multiplications, additions, remark))
        if name in comparison.growth.polynomials:
            ours = comparison.growth.polynomials[name]
            rows.append((method.title, "ours", str(ours[0]), str(ours[1]), ""))
    return tuple(rows)


def write_comparison(
    comparison: Comparison, context: ComparisonContext, folder: Path, formats: Collection[str]
) -> None:
    """Write the chosen files of `FILES`; all are made before the first is written.

    Raises
    ------
    UsageError
        If there is no such format.
    OutputError
        If the folder cannot be written to.
    """
    unknown = sorted(set(formats) - set(FILES))
    if unknown:
        raise UsageError(
            f"there is no format {unknown[0]!r}", where="formats", expected=", ".join(FILES), found=unknown[0]
        )
    html, pdf = "", b""
    if "html" in formats:
        from gd_analyze.report.comparison_html import render_comparison_html

        html = render_comparison_html(context)
    if "pdf" in formats:
        from gd_analyze.report.comparison_pdf import render_comparison_pdf

        pdf = render_comparison_pdf(context, comparison.provenance["created"])
    if "json" in formats:
        write_text(folder / FILES["json"], json.dumps(as_document(context), indent=2, allow_nan=False) + "\n")
    if html:
        write_text(folder / FILES["html"], html)
    if pdf:
        with replacing(folder / FILES["pdf"]) as temporary:
            temporary.write_bytes(pdf)


def as_document(context: ComparisonContext) -> dict[str, Any]:
    """Lay the context out as JSON values, full precision."""
    return asdict(context) | {"provenance": dict(context.provenance)}


def default_folder(arm_name: str) -> Path:
    """Folder the results go to when none is named."""
    return Path("reports") / f"compare-{arm_name}"


def _headline(comparison: Comparison, rows: list[MethodRow]) -> str:
    agreed, unit = comparison.agreement, _unit(comparison)
    fewest = min(rows, key=lambda row: row.folded.total)
    most = max(rows, key=lambda row: row.folded.total)
    difference = (
        f"differ by at most {number(agreed.largest)} {unit}"
        if agreed.holds
        else f"differ by {number(agreed.largest)} {unit}, more than round-off explains"
    )
    agree = "All formulations agree: their torques" if agreed.holds else "The formulations disagree: torques"
    return (
        f"{agree} {difference}. {fewest.title} needs the fewest operations, {fewest.folded.total} once "
        f"folded; {most.title} needs {most.folded.total / fewest.folded.total:.2g} times as many."
    )


def _facts(comparison: Comparison, rows: list[MethodRow]) -> tuple[tuple[str, str], ...]:
    fewest = min(rows, key=lambda row: row.folded.total)
    fastest = min(rows, key=lambda row: row.seconds)
    steepest = max(rows, key=lambda row: row.exponent)
    flattest = min(rows, key=lambda row: row.exponent)
    return (
        (str(fewest.folded.total), f"operations at the fewest, folded ({fewest.short})"),
        (
            f"{1e6 * fastest.seconds:.2f} µs",
            f"per set point at the fastest ({fastest.short}); Pinocchio in a loop "
            f"{1e6 * comparison.timing.pinocchio:.2f} µs",
        ),
        (
            f"n^{flattest.exponent:.1f} … n^{steepest.exponent:.1f}",
            f"growth from 6 to 12 joints, {flattest.short} to {steepest.short}",
        ),
        (
            number(comparison.agreement.largest),
            f"largest difference of any two torques, {_unit(comparison)}; "
            f"round-off allows {number(comparison.agreement.bounds['torque'])}",
        ),
    )


def _unit(comparison: Comparison) -> str:
    return "N m" if all(comparison.arm.is_revolute) else "N m or N"


def _count(count: OperationCount) -> Count:
    return Count(count.multiplications, count.additions, count.sines_cosines)


def _text(multiplications: Polynomial, additions: Polynomial, n: int) -> Count:
    return Count(multiplications(n), additions(n))


def _provenance(comparison: Comparison) -> tuple[tuple[str, str], ...]:
    trajectory = comparison.trajectory
    motion = f"{trajectory.name}, SHA-256 {trajectory.fingerprint[:16]}" if trajectory else "none given"
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # already told when the arm was read
        arm = f"{comparison.arm.name}, SHA-256 {fingerprint(comparison.arm)[:16]}"
    return (
        ("arm", arm),
        *(("payload", note) for note in comparison.arm.assumptions if "payload" in note),
        ("trajectory", motion),
        *comparison.provenance.items(),
    )
