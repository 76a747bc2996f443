"""What measured torques say of the model, for people."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from gd_analyze.cli.terminal import line, sentence, table

if TYPE_CHECKING:
    from gd_analyze.results.findings import Findings
    from gd_analyze.results.rows import Row


def show_measured_torque(findings: Findings) -> None:
    """Print measurement beside model, and the friction fitted; nothing where no torque was measured."""
    from gd_analyze.results.torque_words import measured_rows, torque_sentence
    from gd_analyze.text import fitting, joint_name, number

    if not (rows := measured_rows(findings)):
        return
    cells = []
    for row in rows:
        known = {name: row[name] for name in ("bias", "rms_difference") if row[name] is not None}
        factor, unit = fitting(known.values(), row["effort_unit"])
        torques = (
            number(known[name] / factor) if name in known else "–" for name in ("bias", "rms_difference")
        )
        ratios = (
            "–" if row[name] is None else format(row[name], digits)
            for name, digits in (("correlation", ".3f"), ("slope", ".3g"))
        )
        cells.append([joint_name(row["joint"], row["joint_name"]), *ratios, *torques, unit, row["told"]])
    table(
        "Measured torque beside the exact one: correlation, slope of measured over exact, mean and RMS of "
        "measured minus exact",
        ["joint", "corr", "slope", "bias", "RMS", "", "verdict"],
        cells,
        "lrrrrll",
    )
    if "coulomb" in findings.tables["measured_torque"]:
        show_friction(rows)
    line()
    sentence(torque_sentence(findings.tables["measured_torque"]))


def show_friction(rows: Sequence[Row], beside: str = "") -> None:
    """Print the friction fitted to each joint, of rows as `measured_rows` gives; beside which model."""
    from gd_analyze.results.torque_words import friction_cells
    from gd_analyze.text import joint_name

    cells = []
    for row in rows:
        *told, _ = friction_cells(row, digits=1)
        tight = (cell.replace(" ± ", "±") for cell in told)
        cells.append([joint_name(row["joint"], row["joint_name"]), *tight])
    table(
        f"Friction and offset fitted to the difference{beside}, standard errors, and RMS of what is left",
        ["joint", "Coulomb", "offset", "RMS", "", "viscous", ""],
        cells,
        "lrrrlrl",
    )
