"""Numbers by which figures, tables and appendices are cited: one list for the page and for paper."""

from __future__ import annotations

from string import ascii_uppercase

from gd_analyze.figures.torques import measured_joints
from gd_analyze.results import summary
from gd_analyze.results.findings import Findings
from gd_analyze.results.motion_words import changing
from gd_analyze.results.recording_words import is_recorded
from gd_analyze.results.rows import dropped_parts

# By the name that templates call them, in the order in which a reader meets them.
_FIGURES = {
    "arm": "the arm along the trajectory",
    "contributions": "torque by what makes it",
    "trade_off": "operations against error",
    "motion": "the motion of every joint",
    "errors": "torque and error over time",
    "recording": "readings beside the smoothed motion",
    "measured": "measured torque and the exact one",
    "inertia": "the inertia matrix by effect",
    "coriolis": "the Coriolis and centrifugal vector by effect",
    "gravity": "the gravity loading vector",
    # On the page only, hence last.
    "beyond": "errors beyond the trajectory",
}
_TABLES = {
    "errors": "error of every joint",
    "parameters": "links' parameters that the model keeps",
    "trade_off": "operations and error by budget",
    "torques": "torques and errors of every joint",
    "recording": "noise of readings, accelerations and torques",
    "columns": "columns of the log",
    "measured": "measured torque beside the exact one",
    "friction": "friction beside the exact torque",
    "ranking": "elements ranked by torque",
    "motions": "each motion by itself",
    "verdicts": "verdicts that depend on the motion",
    "terms": "single terms ranked by torque",
    "kept": "what the model keeps",
    "left_out": "what the model leaves out",
    "operations": "operations for one evaluation of all torques",
    "tube": "bounds near the motion",
    "beyond": "errors beyond the motion",
    "payload": "payload and uncertainty of the parameters",
    "dropped": "parts dropped by the founding text's own method",
    "cross_check": "differences from Pinocchio",
    "joints": "joints of the arm",
    "links": "links of the arm",
}
_APPENDICES = {
    "motion": "Motion, torque and error over time",
    "recording": "Readings behind the motion",
    "measured": "Measured torque beside the model's",
    "effects": "Inertia, velocity and gravity terms by effect",
    "ranking": "Elements ranked by torque",
    "motions": "Motion by motion",
    "terms": "Single terms ranked by torque",
    "model": "What the model keeps and what that saves",
    "beyond": "Near this motion, and beyond it",
    "elements": "By the founding text's own method",
    "equations": "Equations and cross-check",
    "data": "Data and provenance",
}


def numbering(findings: Findings) -> dict[str, dict[str, str]]:
    """Number what a report of these findings shows.

    Returns
    -------
    dict
        `figures` and `tables`: "Figure 1" and "Table 1" by name; `appendices`: "A" by name, `titles` theirs.
        What there is nothing to show of has no number.
    """
    figures, tables, appendices = map(list, (_FIGURES, _TABLES, _APPENDICES))
    for names, gone in zip((figures, tables, appendices), _absent(findings), strict=True):
        names[:] = [name for name in names if name not in gone]
    return {
        "figures": {name: f"Figure {k}" for k, name in enumerate(figures, start=1)},
        "tables": {name: f"Table {k}" for k, name in enumerate(tables, start=1)},
        "appendices": dict(zip(appendices, ascii_uppercase, strict=False)),
        "titles": {name: _APPENDICES[name] for name in appendices},
    }


def _absent(findings: Findings) -> tuple[set[str], set[str], set[str]]:
    """Figures, tables and appendices of which there is nothing to show."""
    flat = {"trade_off"} if summary.nothing_to_trade(findings) else set()
    measured = findings.tables.get("measured_torque")
    unmeasured = {"measured"} if not measured_joints(findings) else set()
    beyond = findings.tables["beyond"]
    of_elements = summary.made_of(findings) == "parts"
    of_recursion = summary.made_of(findings) == "recursion"
    one = not summary.has_motions(findings)
    tables = {
        "motions": one,
        "kept": of_recursion,
        "parameters": not of_recursion,
        "left_out": not of_recursion,
        "verdicts": one or not changing(findings),
        "terms": not findings.is_written_out,
        "tube": summary.tube_proven(findings) is None,
        "beyond": not (beyond.attrs["states_drawn"] or beyond.certified.notnull().all()),
        "operations": of_elements and not findings.model.saves,
        "friction": measured is None or "coulomb" not in measured or bool(unmeasured),
        "dropped": not dropped_parts(findings).costing,
    }
    gone = {name for name, absent in tables.items() if absent}
    unread = set() if is_recorded(findings) else {"recording"}
    if unread or not findings.tables["recording"].sizes["column"]:
        gone.add("columns")
    lacking = unmeasured | unread
    without = {"elements": of_elements, "motions": one}
    appendices = {name for name, absent in without.items() if absent}
    return flat | lacking, flat | lacking | gone, appendices | lacking
