"""The comparison of formulations as files: a page that opens offline, a typeset PDF, and JSON."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection
from pathlib import Path
from typing import Any, Literal

from markupsafe import Markup

from gd_analyze.dynamics.methods import METHODS
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.report.compiled_templates import TEMPLATES
from gd_analyze.report.main_pdf import typeset
from gd_analyze.report.page_environment import environment, style
from gd_analyze.robots.arm import RobotArm
from gd_analyze.studies.agreement import PINOCCHIO
from gd_analyze.studies.compare import Comparison, names_of
from gd_analyze.studies.comparison_chart import PAPER, SCREEN, Palette, growth_chart
from gd_analyze.studies.comparison_document import comparison_document, provenance_rows
from gd_analyze.studies.study_files import as_json, write_study
from gd_analyze.text import figures, pretty

FILES = {"html": "comparison.html", "pdf": "comparison.pdf", "json": "comparison.json"}

_SHORT = {name: method.short for name, method in METHODS.items()} | {PINOCCHIO: "Pinocchio"}


def default_folder(arm: RobotArm, trajectory: Trajectory | None) -> Path:
    """Folder the results go to when none is named."""
    return Path("reports") / "-".join(["compare", *filter(None, names_of(arm, trajectory))])


def write_comparison(
    comparison: Comparison, folder: Path, formats: Collection[str], strangers: Collection[Path] = ()
) -> None:
    """Write the chosen files of `FILES`, all together when the last is made, and remove those of another run.

    Raises
    ------
    UsageError
        If there is no such format.
    OutputError
        If the folder cannot be written to.
    """
    make: dict[str, Callable[[], bytes]] = {
        "html": lambda: render_comparison_html(comparison).encode(),
        "pdf": lambda: render_comparison_pdf(comparison),
        "json": lambda: as_json(comparison_document(comparison)),
    }
    write_study(make, FILES, folder, formats, strangers)


def render_comparison_html(comparison: Comparison) -> str:
    """Write the page of one comparison; styles, charts and the theme switch are inside it."""
    template = environment().get_template("comparison.html.j2")
    return template.render(
        c=comparison_document(comparison),
        run=comparison.provenance["run"],
        provenance=provenance_rows(comparison),
        names=[_SHORT[name] for name in comparison.agreement.names],
        charts=_charts(comparison, SCREEN),
        slowest=max(comparison.timing.pinocchio, *comparison.timing.seconds.values()),
        style=style("report.css", "comparison.css"),
    )


def render_comparison_pdf(comparison: Comparison) -> bytes:
    """Typeset one comparison; the same comparison gives the same bytes.

    Raises
    ------
    GdAnalyzeError
        If the document cannot be typeset.
    """
    data, charts = _typeset_numbers(comparison), _charts(comparison, PAPER)
    return typeset(TEMPLATES / "comparison.typ", data, charts, comparison.provenance["created"])


def _charts(comparison: Comparison, palette: Palette) -> dict[str, Markup]:
    kinds: tuple[Literal["executed", "folded"], ...] = ("executed", "folded")
    return {which: Markup(growth_chart(comparison.growth, which, palette)) for which in kinds}


def _typeset_numbers(comparison: Comparison) -> dict[str, Any]:
    """Take the document, its numbers and names as they are printed."""
    document = comparison_document(comparison)

    def microseconds(seconds: float) -> str:
        return f"{1e6 * seconds:.2f}"

    def slope(value: float | None) -> str:
        return "–" if value is None else f"{value:.2f}"

    return document | {
        "run": comparison.provenance["run"],
        "headline": pretty(document["headline"]),
        "unit": comparison.unit,
        "facts": [{"value": _powers(value), "caption": pretty(said)} for value, said in document["facts"]],
        "methods": [
            row
            | {
                "order": _powers(row["order"]),
                "time": microseconds(row["seconds"]),
                "difference": figures(row["difference"]),
                "slopes": [slope(row[f"exponent{which}"]) for which in ("", "_folded", "_text")],
            }
            for row in document["methods"]
        ],
        "pinocchio": {
            "time": microseconds(comparison.timing.pinocchio),
            "difference": figures(comparison.agreement.worst_of(PINOCCHIO)),
        },
        "names": [_SHORT[name] for name in document["names"]],
        "torque_differences": [
            ["–" if i == j else figures(value) for j, value in enumerate(row)]
            for i, row in enumerate(document["torque_differences"])
        ],
        "from_pinocchio": [
            [_SHORT[name], *map(figures, values)] for name, *values in document["from_pinocchio"]
        ],
        "bounds": [figures(value) for value in document["bounds"]],
        "polynomials": [
            [title, whose, _powers(multiplications), _powers(additions), remark]
            for title, whose, multiplications, additions, remark in document["polynomials"]
        ],
        "provenance": [[label.replace("_", " "), value] for label, value in provenance_rows(comparison)],
    }


def _powers(formula: str) -> list[dict[str, Any]] | str:
    """Cut a formula with carets into pieces, raised or not; leave one without as it is."""
    formula = formula.replace(" - ", " − ")
    if "^" not in formula:
        return pretty(formula)
    pieces: list[dict[str, Any]] = []
    for k, part in enumerate(formula.split("^")):
        raised = re.match(r"[\d.]*\d", part) if k else None
        cut = raised.end() if raised else 0
        if cut:
            pieces.append({"text": part[:cut], "raised": True})
        pieces.append({"text": part[cut:], "raised": False})
    return pieces
