"""The interactive report: one HTML file that opens offline and asks the network for nothing."""

from __future__ import annotations

import json
import math
import re
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from markupsafe import Markup, escape

from gd_analyze.dominance import text_verdicts
from gd_analyze.elements import Element, elements
from gd_analyze.findings import Findings
from gd_analyze.levels import parts_of
from gd_analyze.report import mathml
from gd_analyze.report.beyond_chart import beyond_chart
from gd_analyze.report.context import Context, DominanceRow, build_context, number, percent
from gd_analyze.report.equations import (
    inertia_matrix,
    model_equation,
    source_equations,
    torque_equations,
)
from gd_analyze.report.interactive import MOST_POINTS, page_data
from gd_analyze.report.stroboscope import stroboscope
from gd_analyze.report.terms import (
    exact_elements,
    exact_torques,
    shared_accelerations,
    tallies,
    term_rows,
    torque_legend,
    torque_views,
)
from gd_analyze.formatting import pretty

if TYPE_CHECKING:
    from jinja2 import Environment

TEMPLATES = Path(__file__).parent / "templates"
SCRIPTS = ("trade_off.js", "plots.js", "viewer.js", "table.js", "page.js")
LETTERS = {"translation": "T", "rotation": "R", "both": "T+R", "neither": "0"}
SYMBOLS = {"inertia": "D", "coriolis_centrifugal": "h", "gravity_loading": "c"}


def render_html(findings: Findings) -> str:
    """Write the interactive report of one run.

    Parameters
    ----------
    findings
        What the main job found.

    Returns
    -------
    str
        A complete document; styles, scripts, Plotly and data are inside it.

    Examples
    --------
    >>> import gd_analyze as gd
    >>> from gd_analyze.main_job import find
    >>> arm = gd.load_arm("two_link")
    >>> page = render_html(find(arm, gd.read_trajectory("two-link-swing", arm)))
    >>> page.startswith("<!doctype html>")
    True
    """
    context = build_context(findings)
    arm, model = findings.arm, findings.model
    source = text_verdicts(arm.name)
    exact = exact_torques(findings)
    return (
        environment()
        .get_template("report.html.j2")
        .render(
            c=context,
            arm=arm,
            trajectory=findings.trajectory,
            panels=_panels(findings, context),
            order={element.label: k for k, element in enumerate(elements(arm.n_joints))},
            mixed=not all(arm.is_revolute),
            dropped=_dropped(context),
            torque_equations=torque_equations(context, model.drives),
            inertia_matrix=inertia_matrix(context),
            model_equation=model_equation(),
            source_equations=source_equations(),
            still=stroboscope(arm, findings.decomposition.q.values),
            kinds=[k for k in ("revolute", "prismatic") if any(joint.kind == k for joint in arm.joints)],
            threshold=float(findings.dominance.attrs["threshold"]),
            drives=model.drives,
            text_remarks=source.remarks if source else {},
            thinned_to=MOST_POINTS if findings.trajectory.n_set_points > MOST_POINTS else None,
            data=_json(page_data(findings)),
            plotly=_plotly(),
            style=Markup(template_text("report.css")),
            scripts=Markup("\n".join(template_text(name) for name in SCRIPTS)),
            letters=LETTERS,
            symbols=SYMBOLS,
            torque_views=torque_views(findings),
            torque_legend=torque_legend(findings, exact),
            tallies=tallies(findings, exact),
            accelerations=[mathml.absolute_acceleration(i + 1) for i in range(arm.n_joints)],
            shared_accelerations=shared_accelerations(findings),
            term_rows=term_rows(findings, context),
            search_steps=_search_steps(context),
            exact_elements=exact_elements(findings),
            beyond_chart=beyond_chart(context.joint_errors, context.beyond),
            smallest_payload=min(context.beyond, key=lambda row: row.mass_within_budget),
            tightness=_tightness(context),
            uncertain=_above_allowed(context, "uncertainty"),
            outside=_above_allowed(context, "within_limits"),
        )
    )


@dataclass(frozen=True)
class Panel:
    """One element's small figure, and what the ranking says of it; row and column from 1."""

    element: str
    quantity: str
    row: int
    column: int
    ranked: DominanceRow


def _panels(findings: Findings, context: Context) -> dict[str, list[Panel]]:
    """All elements by quantity, in the order of the matrix."""
    ranked = {row.element: row for row in context.dominance}

    def panel(element: Element) -> Panel:
        return Panel(
            element.label,
            element.quantity,
            element.i + 1,
            (element.i if element.j is None else element.j) + 1,
            ranked[element.label],
        )

    grouped: dict[str, list[Panel]] = {}
    for element in elements(findings.arm.n_joints):
        grouped.setdefault(element.quantity, []).append(panel(element))
    return grouped


@dataclass(frozen=True)
class DroppedPart:
    """A part left out that would have made torque; `share_of_budget` of what its joint may be off."""

    label: str
    torque_peak: float
    torque_joint: int
    torque_share: float
    share_of_budget: float


@dataclass(frozen=True)
class DroppedParts:
    """What was left out by reason: it costs something, is zero, or meets no acceleration."""

    costing: tuple[DroppedPart, ...]
    zero: tuple[str, ...]
    idle: tuple[str, ...]


def _dropped(context: Context) -> DroppedParts:
    ranked = {row.element: row for row in context.dominance}
    order = {part.label: k for k, part in enumerate(parts_of(len(context.joint_errors)))}
    costing, zero, idle = [], [], []
    for row in context.dropped:
        label, _, effect = row.part.partition(" ")
        ranking = ranked[label]
        peak = ranking.rotation_peak if effect == "rotation" else ranking.translation_peak
        if peak == 0.0:
            zero.append(row.part)
        elif row.torque_peak == 0.0:
            idle.append(row.part)
        else:
            allowed = context.joint_errors[row.torque_joint - 1].allowed
            share = row.torque_peak / allowed if allowed > 0 else float("inf")
            costing.append(DroppedPart(row.part, row.torque_peak, row.torque_joint, row.torque_share, share))
    return DroppedParts(
        tuple(costing), *(tuple(sorted(each, key=order.__getitem__)) for each in (zero, idle))
    )


@dataclass(frozen=True)
class SearchStep:
    """One step of the search and the operations after it; `fill` is that over the exact model's."""

    name: str
    operations: int
    fill: float


_STEPS = {
    "elimination": "terms dropped one by one",
    "dive": "integer program, one descent",
    "integer program": "integer program",
    "exchange": "terms exchanged",
    "refit": "coefficients refitted",
}


def _search_steps(context: Context) -> tuple[SearchStep, ...]:
    """The exact model, every step of the search, and the program that was made of its result."""
    full, left = sum(context.operations_full[:2]), sum(context.operations[:2])
    steps = [("exact model", full)]
    for step in context.search.split(", "):
        name, _, operations = step.rpartition(" ")
        if name in _STEPS:
            steps.append((_STEPS[name], int(operations)))
    steps.append(("final program, factored", left))
    return tuple(SearchStep(name, count, count / full if full else 0.0) for name, count in steps)


def _tightness(context: Context) -> float | None:
    """How far the certified bound lies above the worst error found, at most, as a share of that."""
    pairs = [(row.certified, row.worst_found) for row in context.beyond]
    shares = [certified / found - 1.0 for certified, found in pairs if certified is not None and found]
    return max(shares, default=None)


def _above_allowed(context: Context, what: Literal["uncertainty", "within_limits"]) -> list[str]:
    """Joints at which a torque of `BeyondRow` is known and above the allowed error."""
    rows = zip(context.beyond, context.joint_errors, strict=True)
    return [row.joint for row, error in rows if (getattr(row, what) or 0.0) > error.allowed]


@cache
def environment() -> Environment:
    """Jinja with the reports' templates and filters."""
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    environment = Environment(
        loader=FileSystemLoader(TEMPLATES),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {
        "number": lambda value: _typeset(number(float(value))),
        "percent": lambda share: _typeset(percent(float(share))),
        "typeset": _typeset,
        "powers": _powers,
        "unit": pretty,
        "symbol": mathml.part,
        "digits": lambda value: _typeset(f"{float(value):.6g}"),
        "joints": _joints,
        "mass": lambda kilograms: _typeset(_mass(float(kilograms))),
        "degrees": lambda angle: _typeset(f"{math.degrees(float(angle)):.4g}"),
    }
    return environment


def _joints(numbers: list[str], of: int) -> str:
    """Name joints: joint 3, joints 1, 4 and 5, or every joint."""
    if len(numbers) == of > 1:
        return "every joint"
    *first, last = numbers
    return f"joints {', '.join(first)} and {last}" if first else f"joint {last}"


def _mass(kilograms: float) -> str:
    """Kilograms, or grams below a tenth of one."""
    return f"{number(kilograms)} kg" if kilograms >= 0.1 else f"{number(1000 * kilograms)} g"


def _typeset(text: str) -> Markup:
    """Turn 1.42e-14 into a power of ten and a hyphen before digits into a minus sign."""
    escaped = str(escape(text))
    powers = re.sub(
        r"(\d)e([+-])0*(\d+)",
        lambda found: f"{found[1]}\u202f×\u202f10<sup>{'−' if found[2] == '-' else ''}{found[3]}</sup>",
        escaped,
    )
    return Markup(re.sub(r"(^|\s)-(?=\d)", r"\1−", powers))


def _powers(text: str) -> Markup:
    """Raise what follows a caret, and typeset the numbers."""
    typeset = str(_typeset(text)).replace(" - ", " − ")
    return Markup(re.sub(r"\^([\d.]+)", r"<sup>\1</sup>", typeset))


def _json(values: dict[str, Any]) -> Markup:
    """JSON that cannot end the script element it stands in."""
    text = json.dumps(values, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return Markup(text.replace("<", "\\u003c"))


def template_text(name: str) -> str:
    """Text of a file among the templates."""
    return (TEMPLATES / name).read_text(encoding="utf-8")


def _plotly() -> Markup:
    script = files("plotly").joinpath("package_data", "plotly.min.js").read_text(encoding="utf-8")
    return Markup(script)
