"""What reports say of the readings behind a measured motion: words and cells, for the page and for paper."""

from __future__ import annotations

from typing import Any

from gd_analyze.results.findings import Findings
from gd_analyze.results.recording_words import is_recorded, noise_rows, recording_told
from gd_analyze.results.rows import Row
from gd_analyze.text import amount, figures, percent, pretty


def recording_document(findings: Findings) -> dict[str, Any] | None:
    """Describe the readings; None of a plan.

    Returns
    -------
    dict
        `said`: sentences; `treatment`: what was done, a sentence each; `rows`: cells, one per joint;
        `columns`: cells of how the log's columns were understood; `unused`: names of those left out, and why.
    """
    if not is_recorded(findings):
        return None
    table = findings.tables["recording"]
    names = ("column", "column_role", "column_joint", "column_unit", "column_why")
    columns = list(zip(*(table[name].values.tolist() for name in names), strict=True))
    return {
        "said": recording_told(findings),
        "treatment": [
            pretty(f"{line[:1].upper()}{line[1:]}.") for line in table.attrs["treatment"].split("\n") if line
        ],
        "rows": [_cells(row) for row in noise_rows(findings)],
        "columns": [column for column in columns if column[1] != "unused"],
        "unused": [[column[0], column[4]] for column in columns if column[1] == "unused"],
    }


def _cells(row: Row) -> dict[str, Any]:
    return {
        "joint": row["joint"],
        "joint_name": row["joint_name"],
        "cutoff": f"{figures(row['cutoff'])} Hz",
        "noise_q": pretty(f"{figures(row['noise_q'])} {row['unit']}"),
        "noise_qdd": pretty(f"{figures(row['noise_qdd'])} {row['unit']}/s^2"),
        "torque_noise": pretty(amount(row["torque_noise"], row["effort_unit"])),
        "of_allowed": percent(row["of_allowed"]),
    }
