"""The main report as a page: the answer, the budget that can be moved, the model, and appendices."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

from markupsafe import Markup, escape

from gd_analyze.figures.arm import playable
from gd_analyze.figures.svg import panel_svg
from gd_analyze.report.budget import BudgetPath, budget_equations, budget_words, place
from gd_analyze.report.html import (
    drawing_html,
    frame,
    meanings_html,
    opening,
    paragraphs,
    parts_html,
    provenance_html,
    section_html,
    template,
    text,
)
from gd_analyze.report.main_report import MainReport, main_report
from gd_analyze.report.model_sections import made_of, model_parts
from gd_analyze.report.numbering import Numbers
from gd_analyze.result import Drawing, Part, Section
from gd_analyze.results.findings import Findings
from gd_analyze.results.rows import joint_rows
from gd_analyze.results.run_result import (
    provenance_lines,
    tube_bound,
)
from gd_analyze.text import amount, percent

_APPENDIX_NAMES = {
    "motion": "Motion",
    "recording": "Readings",
    "measured": "Measured",
    "effects": "Effects",
    "ranking": "Elements",
    "motions": "Motions",
    "terms": "Terms",
    "model": "Savings",
    "beyond": "Beyond",
    "elements": "By hand",
    "equations": "Equations",
    "data": "Data",
}


def render_html(findings: Findings, report: MainReport | None = None) -> str:
    """Write the interactive report of one run: one document with styles, drawings and scripts inside."""
    result, first, appendices, numbers = report or main_report(findings)
    path = BudgetPath.of(findings)
    letters = dict(zip((section.key for section in appendices), "ABCDEFGHIJKLM", strict=False))
    folded = "".join(_appendix(findings, section, letters[section.key], numbers) for section in appendices)
    body = (
        f'<section id="answer">\n{opening(result)}{_first_screen(findings, first, numbers)}</section>\n'
        f"{_budget(findings, path, first, numbers)}{_the_model(findings, path, numbers)}"
        '<section id="appendices" aria-labelledby="appendices-title">\n<div class="appendices-head">'
        '<h2 id="appendices-title">Appendices</h2> '
        '<button type="button" id="open-all">Unfold all</button></div>\n'
        f"{folded}</section>"
    )
    links = [("answer", "Answer"), ("budget", "Budget"), ("the-model", "Model")]
    links += [(key, f"{letter} {_APPENDIX_NAMES[key]}") for key, letter in letters.items()]
    data = {"arm": playable(findings), "budgets": path.data(findings) if path.moves else None}
    run = findings.provenance.get("run", "")
    return frame(f"{result.title} {result.subtitle}", links, body, data=_json(data), run=run)


_EMPTY_CELL = '<td class="value"></td>'


def _first_screen(findings: Findings, first: Sequence[Part], numbers: Numbers) -> str:
    """The arm that plays beside the stacked torques."""
    arm, contributions = first[:2]
    assert isinstance(arm, Drawing)
    assert isinstance(contributions, Drawing)
    rows = "".join(
        f'<tr><th scope="row">{k} {escape(joint.name)}</th>{2 * _EMPTY_CELL}</tr>\n'
        for k, joint in enumerate(findings.arm.joints, start=1)
    )
    (panel,) = arm.figure.panels
    drawn = f'<div id="scene">{panel_svg(panel, arm.figure)}</div>'
    caption = f"{numbers.of_figure('arm')}{text(arm.title)}"
    card = template("arm.html").format(drawn=drawn, rows=rows, caption=caption)
    return f'<div class="opening">\n{card}{drawing_html(contributions, numbers)}</div>\n'


def _budget(findings: Findings, path: BudgetPath, first: Sequence[Part], numbers: Numbers) -> str:
    """The slider, the joints' errors under it, and the trade-off."""
    model, ways = findings.model, {key: part for part in first[3:] if (key := _key(part))}
    if path.moves:
        kept = (
            ""
            if made_of(findings) in ("recursion", "formulas")
            else _result("kept", len(path.rows[path.asked]["kept"]), made_of(findings), "kept")
        )
        share = float(model.accuracy.shares.max(initial=0.0))
        head = template("budget.html").format(
            label=escape(budget_words(path.rows[path.asked]["budget"])),
            last=len(path.rows) - 1,
            asked=path.asked,
            count=_result("count", model.operations.total, "operations", f"of {model.operations_full.total}"),
            kept=kept,
            worst=_result(
                "worst", text(percent(share)), "largest error,", f"of {model.accuracy.asked.shares_of}"
            ),
            budget=escape(model.accuracy.budget),
            what="changes more steps"
            if made_of(findings) == "recursion"
            else "keeps nothing that a smaller one drops",
        )
    else:
        low, high = (budget_words(path.rows[k]["budget"]) for k in (0, -1))
        said = (
            "the model stays the same"
            if model.saves
            else "nothing can be dropped that would save an operation"
        )
        head = (
            f'<p class="note">No other model from {escape(low)} to {escape(high)}: {said}. '
            f"The exact torque takes <b>{model.operations_full.total}</b> operations.</p>\n"
        )
    drawing = ways.get("trade_off_figure")
    trade = (
        f'<div class="card">{drawing_html(drawing, numbers)}</div>' if isinstance(drawing, Drawing) else ""
    )
    table = ways.get("trade_off_table")
    numbers_table = parts_html((table,), numbers) if table else ""
    fold = f"<details><summary>The same in numbers</summary>\n{numbers_table}</details>\n" if table else ""
    return (
        '<section id="budget" aria-labelledby="budget-title">\n'
        '<h2 id="budget-title">What the budget buys</h2>\n'
        f'{head}<div class="buys{"" if trade else " alone"}">\n'
        f'<div class="card">{_errors(findings, numbers)}</div>\n'
        f"{trade}</div>\n{fold}</section>\n"
    )


def _key(part: Part) -> str:
    return f"{part.key}_{'figure' if isinstance(part, Drawing) else 'table'}"


def _result(key: str, value: Any, first: str, second: str) -> str:
    return f'<p class="result"><b id="budget-{key}">{value}</b> <span>{first}<br>{second}</span></p>'


def _errors(findings: Findings, numbers: Numbers) -> str:
    """Every joint's error against the budget, on a logarithmic scale that the slider moves."""
    model, rows = findings.model, []
    proven = tube_bound(findings)
    for i, row in enumerate(joint_rows(findings, "simplified_model")):
        allowed, error, unit = row["allowed_error"], row["largest_error"], row["effort_unit"]
        mark = ""
        if proven is not None and allowed > 0:
            mark = f'<i class="proven-mark" style="left:{place(float(proven[i]) / allowed)}%"></i>'
        name = escape(row["joint_name"])
        at = place(error / allowed if allowed > 0 else float(error > 0))
        rows.append(
            f'<tr style="--error:{at};--budget:{place(1.0)}"><th scope="row"><b>{i + 1}</b> '
            f'<span class="name" title="{name}">{name}</span></th>\n<td class="bar-cell"><span class="log" '
            f'aria-hidden="true"><i class="fill"></i>{mark}<i class="allowed"></i></span></td>\n'
            f'<td class="said">{text(amount(error, unit))} of {text(amount(allowed, unit))}</td>\n'
            f'<td class="value">{text(percent(float(model.accuracy.shares[i])))}</td></tr>\n'
        )
    title = "Largest torque error of each joint on a logarithmic scale; the line is the budget"
    title += ", the diamond the error proven near the motion." if proven is not None else "."
    return template("errors.html").format(
        caption=f"{numbers.of_table('errors')}{title}",
        rows="".join(rows),
        shares_of=model.accuracy.asked.shares_of,
        budget=place(1.0),
    )


def _the_model(findings: Findings, path: BudgetPath, numbers: Numbers) -> str:
    """The model as equations; terms follow the slider."""
    model = findings.model
    head = '<section id="the-model" aria-labelledby="model-title">\n<h2 id="model-title">The model</h2>\n'
    if made_of(findings) == "terms":
        inside = (
            '<p class="lead">All of the model: a line each for <i>D</i> inertia, <i>h</i> Coriolis and '
            "centrifugal, and <i>c</i> gravity. SI units; three digits shown, all of them in "
            "<code>model.json</code>.</p>\n"
            f'<div class="torques">\n{budget_equations(findings, path)}</div>\n{meanings_html(model.legend)}'
        )
        if model.refitted or model.level.is_mechanical:
            inside += '<p class="small only-other">Coefficients are those of this report\'s model.</p>\n'
    elif made_of(findings) == "recursion":
        inside = (
            '<p class="lead">The recursion of Newton and Euler with the constants of this arm: outward for '
            "velocities and accelerations, inward for forces and moments. A simplified step is dropped, "
            'lacks a summand, or has another number. <a href="#model">The appendix</a> has all equations and '
            "what was left out.</p>\n"
        ) + parts_html(model_parts(findings), numbers)
    else:
        inside = parts_html(model_parts(findings), numbers)
    return head + inside + template("reading.html") + "</section>\n"


def _appendix(findings: Findings, section: Section, letter: str, numbers: Numbers) -> str:
    more = ""
    if section.key == "effects":
        more = template("effects.html")
    elif section.key == "equations":
        more = template("equations.html")
    inside = "".join(
        section_html(part, numbers, 3) if isinstance(part, Section) else parts_html((part,), numbers)
        for part in section.parts
    )
    if section.key == "data":
        inside += provenance_html(dict(provenance_lines(findings)))
    return (
        f'<details class="appendix" id="{section.key}">\n<summary><h2><span class="letter">{letter}</span> '
        f"{text(section.title)}</h2></summary>\n{paragraphs(section.note)}{more}{inside}</details>\n"
    )


def _json(values: dict[str, Any]) -> Markup:
    """JSON that cannot end the script element it stands in."""
    written = json.dumps(values, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return Markup(written.replace("<", "\\u003c"))
