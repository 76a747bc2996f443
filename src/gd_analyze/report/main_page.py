"""The main report as a page: the answer, the model and its budget, effects, and appendices."""

from __future__ import annotations

import json
from typing import Any

from markupsafe import escape

from gd_analyze.figures import structure
from gd_analyze.figures.arm import playable
from gd_analyze.figures.svg import panel_svg
from gd_analyze.formulas.writing import part_symbol
from gd_analyze.operations.program import OperationCount
from gd_analyze.report.answer import VerdictList, element_details
from gd_analyze.report.budget import BudgetPath, budget_equations, budget_words, place
from gd_analyze.report.html import (
    caption_html,
    drawing_html,
    frame,
    legend_html,
    maths,
    meanings_html,
    notice_list,
    opening,
    paragraphs,
    parts_html,
    provenance_html,
    template,
    text,
)
from gd_analyze.report.main_report import MainReport, main_report
from gd_analyze.report.model_sections import made_of, model_parts
from gd_analyze.report.numbering import PartNumbers
from gd_analyze.result import Drawing, Section
from gd_analyze.results.findings import Findings
from gd_analyze.results.model_facts import structure_note
from gd_analyze.results.near_motion import tube_bound
from gd_analyze.results.rows import joint_rows
from gd_analyze.results.run_result import is_unreadable, provenance_lines, stop_rows
from gd_analyze.simplification.harmonic import ENERGY
from gd_analyze.text import amount, percent, short_names, thousands

_EMPTY_CELL = '<td class="value"></td>'
_APPENDIX_NAMES = {
    "motion": "Motion",
    "recording": "Readings",
    "measured": "Measured",
    "torque": "Torque",
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
    report, path = report or main_report(findings), BudgetPath.of(findings)
    numbers = report.numbers
    letters = dict(zip((section.key or "" for section in report.appendices), "ABCDEFGHIJKLMN", strict=False))
    appendices = (
        _appendix(findings, report, section, letters[section.key or ""]) for section in report.appendices
    )
    effects = "".join(drawing_html(drawing, numbers) for drawing in report.effects)
    body = template("main.html").format(
        opening=opening(report.opening, "notes" if report.notes else ""),
        answer=_answer(findings, report),
        effects=template("effects.html") + effects,
        slider=_slider(findings, path),
        errors=f'<div class="card">{_errors(findings, numbers)}</div>\n' if report.errors else "",
        model=_model(findings, path, numbers),
        notes=notice_list(report.notes),
        appendices="".join(appendices),
    )
    links = [("answer", "Answer"), ("the-model", "Model"), ("budget", "Budget")]
    links += [("elements-by-effect", "Effects"), ("notes", "Notes")]
    links += [(key, f"{letter} {_APPENDIX_NAMES[key]}") for key, letter in letters.items()]
    data = {
        "arm": playable(findings),
        "budgets": path.data(findings) if path.moves else None,
        "elements": element_details(findings),
    }
    written = json.dumps(data, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return frame(
        f"{report.opening.title} {report.opening.subtitle}",
        links,
        body,
        data=written.replace("<", "\\u003c"),  # which could end the script element
        run=findings.provenance.get("run", ""),
    )


def _answer(findings: Findings, report: MainReport) -> str:
    """What the answer is valid for, verdict lists, and the matrix with the joints' bars beside it."""
    n, numbers = findings.arm.n_joints, report.numbers
    lists = "".join(
        f'<div class="{group.verdict}"><dt>{group.heading}</dt><dd>{_elements(group)}</dd></div>\n'
        for group in report.verdicts
    )
    cells_by_label, matrix, bars = structure.cells(findings), report.structure.figure, report.shares.figure
    drawn = []
    for r, c, panel in matrix.places:
        column = c + 1 + (c >= n) + (c > n)  # gaps before h and before c
        cell = cells_by_label[panel.key]
        label = f"{panel.key}, {cell.verdict}, {percent(cell.share)} of peak torque of joint {cell.joint}"
        drawn.append(
            f'<button type="button" class="cell" data-element="{panel.key}" tabindex="-1" '
            f'aria-label="{label}" style="grid-area:{r + 2}/{column}">{panel_svg(panel, matrix)}</button>\n'
        )
    last, gap, side = n + 6, 6, f"{matrix.height:g}"
    rows = "".join(
        f'<div class="bar-of-joint" style="grid-area:{r + 2}/{last}">{panel_svg(panel, bars)}</div>\n'
        for r, _, panel in bars.places
    )
    return template("answer.html").format(
        validity=text(report.validity),
        verdicts=lists,
        legend=legend_html(matrix.legend),
        joints=n,
        columns=f"repeat({n},{side}fr) {gap}fr {side}fr {gap}fr {side}fr {2 * gap}fr {bars.width:g}fr",
        h=n + 2,
        c=n + 4,
        last=last,
        cells="".join(drawn),
        bars=rows,
        structure=caption_html(report.structure, numbers),
        shares=caption_html(report.shares, numbers),
    )


def _elements(group: VerdictList) -> str:
    symbols = [maths(part_symbol(label)) for label in group.elements]
    listed = [f"<span>{symbol},</span>" for symbol in symbols[:-1]] + symbols[-1:]
    return " ".join([*listed, text(group.words)]).strip()


def _stops(findings: Findings) -> str:
    """Named budgets above the slider, with what is known of their models."""
    buttons = "".join(
        f'<button type="button" data-stop="{row["position"]}" aria-pressed="{str(row["own"]).lower()}"'
        f"{' disabled' if row['position'] < 0 else ''}><b>{text(budget_words(row['budget']))}</b> "
        f"{text(row['words'])}</button>\n"
        for row in stop_rows(findings)
    )
    return f'<div class="stops" role="group" aria-label="Budgets">\n{buttons}</div>\n' if buttons else ""


def _arm(findings: Findings, drawing: Drawing) -> str:
    """The animated arm."""
    rows = "".join(
        f'<tr><th scope="row">{k} {escape(name)}</th>{2 * _EMPTY_CELL}</tr>\n'
        for k, name in enumerate(short_names([joint.name for joint in findings.arm.joints]), start=1)
    )
    (panel,) = drawing.figure.panels
    return template("arm.html").format(
        drawn=f'<div id="scene">{panel_svg(panel, drawing.figure)}</div>',
        rows=rows,
        caption=text(drawing.title),
    )


def _slider(findings: Findings, path: BudgetPath) -> str:
    """The budget slider, or a note that no other budget gives another model."""
    model, kind, rows = findings.model, made_of(findings), path.rows
    full, row = model.operations_full, rows[path.asked]
    if not path.moves:
        low, high = (escape(budget_words(rows[k]["budget"])) for k in (0, -1))
        nothing = "dropping terms would not save an operation"
        reason = f"No other model from {low} to {high}: "
        reason += f"{'the model stays the same' if model.saves else nothing}. "
        reason = "" if len(rows) == 1 or is_unreadable(findings) else reason
        note = f"{reason}The exact torque takes <b>{full.total}</b> operations "
        note += f"and {full.sines_cosines} sines and cosines."
        return f'{_stops(findings)}<p class="note">{note}</p>\n'
    share, reference = float(model.accuracy.shares.max(initial=0.0)), model.accuracy.asked.shares_of
    figures = ""
    if kind in ("terms", "parts"):
        figures += _figure("kept", len(row["kept"]), kind, f"of {thousands(model.size[1])}")
    if kind == "terms":
        figures += _counts(
            "apart",
            row["operations_apart"],
            row["sines_cosines_apart"],
            "D, h, c",
            model.form.functions.operations,
        )
    figures += _counts("count", row["operations"], row["sines_cosines"], "torque", full)
    figures += _figure("worst", text(f"up to {percent(share)}"), f"of {reference}", "at the set points")
    between = " Those between the named budgets follow from this report's model."
    return template("budget.html").format(
        stops=_stops(findings),
        low=escape(budget_words(rows[0]["budget"])),
        high=escape(budget_words(rows[-1]["budget"])),
        label=escape(budget_words(row["budget"])),
        last=len(rows) - 1,
        asked=path.asked,
        figures=figures,
        between=between if stop_rows(findings) else "",
        proof=text(path.proofs(findings)[path.asked]),
    )


def _counts(key: str, operations: int, angles: int, what: str, full: OperationCount) -> str:
    """Operations, and sines and cosines, of those of the exact ones."""
    second = f'{what}, and <span id="budget-{key}-angles">{angles}</span> of {full.sines_cosines} sin, cos'
    return _figure(key, operations, f"of {full.total} operations", second)


def _figure(key: str, value: Any, first: str, second: str) -> str:
    return f'<p class="result"><b id="budget-{key}">{value}</b> <span>{first}<br>{second}</span></p>'


def _errors(findings: Findings, numbers: PartNumbers) -> str:
    """Every joint's error against the budget, on a logarithmic scale; the slider updates it."""
    accuracy, proven, rows = findings.model.accuracy, tube_bound(findings), []
    for i, row in enumerate(joint_rows(findings, "simplified_model")):
        allowed, error, unit = row["allowed_error"], row["largest_error"], row["effort_unit"]
        mark, name = "", escape(row["joint_name"])
        if proven is not None and allowed > 0:
            mark = f'<i class="proven-mark" style="left:{place(float(proven[i]) / allowed)}%"></i>'
        at = place(error / allowed if allowed > 0 else float(error > 0))
        rows.append(
            f'<tr style="--error:{at};--budget:{place(1.0)}"><th scope="row"><b>{i + 1}</b> {name}</th>\n'
            '<td class="bar-cell"><span class="log" aria-hidden="true"><i class="fill"></i>'
            f'{mark}<i class="allowed"></i></span></td>\n'
            f'<td class="said">{text(amount(error, unit))} of {text(amount(allowed, unit))}</td>\n'
            f'<td class="value">{text(percent(float(accuracy.shares[i])))}</td></tr>\n'
        )
    title = "Torque error of each joint, up to this at the set points; the line is the budget"
    if proven is not None:
        title += f'<span class="only-this">, the diamond the bound near the motion ({findings.proof})</span>'
    return template("errors.html").format(
        caption=f"{numbers.of_table('errors')}{title}.",
        rows="".join(rows),
        shares_of=accuracy.asked.shares_of,
        budget=place(1.0),
    )


def _model(findings: Findings, path: BudgetPath, numbers: PartNumbers) -> str:
    """The model as equations; terms follow the slider."""
    model, kind = findings.model, made_of(findings)
    if kind != "terms":
        return parts_html(model_parts(findings), numbers)
    structure_text, _, gamma = structure_note(model).partition("\n")
    inside = template("terms.html").format(
        h=text(structure_text),
        gamma=text(gamma),
        equations=budget_equations(findings, path),
        meanings=meanings_html(model.equations.legend),
    )
    if model.level is ENERGY:
        inside += '<p class="small only-other">Coefficients are those of this report\'s model.</p>\n'
    return inside


def _appendix(findings: Findings, report: MainReport, section: Section, letter: str) -> str:
    more = template("equations.html") if section.key == "equations" else ""
    if section.key == "motion":
        more = _arm(findings, report.arm)
    inside = parts_html(section.parts, report.numbers, level=3)
    if section.key == "data":
        inside += provenance_html(dict(provenance_lines(findings)))
    return (
        f'<details class="appendix" id="{section.key}">\n<summary><h2><span class="letter">{letter}</span> '
        f"{text(section.title)}</h2></summary>\n{paragraphs(section.note)}{more}{inside}</details>\n"
    )
