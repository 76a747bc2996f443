"""A study of control as files: a page that opens offline, a typeset PDF, and JSON."""

from __future__ import annotations

from collections.abc import Callable, Collection
from pathlib import Path
from typing import Any

from gd_analyze.figures.colours import ON_PAPER
from gd_analyze.report.canvas import Canvas
from gd_analyze.report.compiled_templates import TEMPLATES
from gd_analyze.report.inline_svg import inline_svg
from gd_analyze.report.main_pdf import typeset
from gd_analyze.report.page_environment import environment, style
from gd_analyze.studies.control_document import control_document, provenance_rows
from gd_analyze.studies.control_figures import LOOKS, error_figure, speed_figure
from gd_analyze.studies.controllers import CONTROLLERS
from gd_analyze.studies.study import ControlStudy
from gd_analyze.studies.study_files import as_json, write_study
from gd_analyze.text import pretty

FILES = {"html": "control.html", "pdf": "control.pdf", "json": "control.json"}

_FIGURES: dict[str, tuple[Callable[[ControlStudy], Canvas], str]] = {
    "errors": (error_figure, "Tracking error of every joint over time"),
    "speeds": (speed_figure, "Largest tracking error over the speed of the motion"),
}


def write_control(
    study: ControlStudy, folder: Path, formats: Collection[str], strangers: Collection[Path] = ()
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
        "html": lambda: render_control_html(study).encode(),
        "pdf": lambda: render_control_pdf(study),
        "json": lambda: as_json(control_document(study)),
    }
    write_study(make, FILES, folder, formats, strangers)


def render_control_html(study: ControlStudy) -> str:
    """Write the page of one study; style, figures and the theme switch are inside it."""
    figures = {name: inline_svg(make(study).svg(), name, label) for name, (make, label) in _FIGURES.items()}
    return (
        environment()
        .get_template("control.html.j2")
        .render(
            c=control_document(study),
            run=study.provenance["run"],
            provenance=provenance_rows(study),
            figures=figures,
            legend=_legend("var(--{})".format),
            style=style("report.css", "comparison.css", "control.css"),
        )
    )


def render_control_pdf(study: ControlStudy) -> bytes:
    """Typeset one study; the same study gives the same bytes.

    Raises
    ------
    GdAnalyzeError
        If the document cannot be typeset.
    """
    document = control_document(study)
    data: dict[str, Any] = {
        **{name: document[name] for name in ("title", "subtitle", "warnings")},
        "tables": {
            name: found | {"rows": [[pretty(cell) for cell in row] for row in found["rows"]]}
            for name, found in document["tables"].items()
        },
        "run": study.provenance["run"],
        "headline": pretty(document["headline"]),
        "sentences": [pretty(text) for text in document["sentences"]],
        "facts": [{"value": pretty(value), "caption": said} for value, said in document["facts"]],
        "legend": _legend(ON_PAPER.__getitem__),
        "provenance": [[label.replace("_", " "), value] for label, value in provenance_rows(study)],
    }
    figures = {name: make(study).svg() for name, (make, _) in _FIGURES.items()}
    return typeset(TEMPLATES / "control.typ", data, figures, study.provenance["created"])


def _legend(colour: Callable[[str], str]) -> list[dict[str, Any]]:
    """Name, colour and dashes of every controller."""
    looks = ((c, *LOOKS[c]) for c in CONTROLLERS)
    return [{"title": c.title, "colour": colour(name), "dashes": list(dashes)} for c, name, dashes in looks]
