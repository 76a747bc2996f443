"""What reports say of measured torques: rows of cells, and sentences; for the page and for paper."""

from __future__ import annotations

from typing import Any

from gd_analyze.results.findings import Findings
from gd_analyze.results.rows import Row
from gd_analyze.results.torque_words import (
    friction_cells,
    is_described,
    measured_rows,
    share_told,
    torque_sentence,
)
from gd_analyze.text import amount, figures, pretty, with_error

_UNKNOWN = "–"


def measured_document(findings: Findings) -> dict[str, Any] | None:
    """Describe measured torques beside the exact ones; None where none was measured.

    Returns
    -------
    dict
        `said` and whether the model is `described`; how many set points were `compared`; whether torques were
        `filtered`; whether friction was `fitted`; `rows` of text, one per joint.
    """
    rows = measured_rows(findings)
    if not any(row["verdict"] != "not measured" for row in rows):
        return None
    table = findings.tables["measured_torque"]
    fitted = "coulomb" in table
    return {
        "said": torque_sentence(table),
        "described": is_described(table),
        "compared": table.attrs["compared"],
        "filtered": bool(table.attrs["filter"]),
        "fitted": fitted,
        "rows": [_cells(row) | (_friction(row) if fitted else {}) for row in rows],
    }


def _cells(row: Row) -> dict[str, Any]:
    """One joint's comparison; torques with their units."""
    slope, error = row["slope_beside_friction"], row["slope_error"]
    torques = ("bias", "rms_difference", "peak_measured", "peak_model")
    return {
        "joint": row["joint"],
        "joint_name": row["joint_name"],
        "measured": row["verdict"] != "not measured",
        "told": row["told"],
        "explained": share_told(row["explained"]),
        "beside": _UNKNOWN if slope is None else _typeset(with_error(slope, error or 0.0)),
        "correlation": _UNKNOWN if row["correlation"] is None else _typeset(f"{row['correlation']:.3f}"),
        "slope": _UNKNOWN if row["slope"] is None else _typeset(figures(row["slope"])),
        **{
            name: _UNKNOWN if row[name] is None else _typeset(amount(row[name], row["effort_unit"]))
            for name in torques
        },
    }


def _friction(row: Row) -> dict[str, str]:
    """Friction fitted to one joint, every number with its unit."""
    cells = friction_cells(row)

    def with_unit(cell: str, unit: str) -> str:
        return cell if cell == _UNKNOWN else _typeset(f"{cell} {unit}")

    return {
        "coulomb": with_unit(cells.coulomb, cells.unit),
        "offset": with_unit(cells.offset, cells.unit),
        "viscous": with_unit(cells.viscous, cells.viscous_unit),
        "left": with_unit(cells.rms, cells.unit),
        "explained_beside_friction": cells.explained,
    }


def _typeset(cell: str) -> str:
    """Raise exponents, and make hyphens minus signs."""
    return pretty(cell).replace("-", "−")
