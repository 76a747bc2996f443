"""What the main job found along each of several motions, as terminal and JSON show it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from gd_analyze.cli.terminal import line, sentence, table

if TYPE_CHECKING:
    from gd_analyze.results.findings import Findings

# Motions that have a column of verdicts each: as many as 80 columns hold.
_MOST_COLUMNS = 12


def motions_document(findings: Findings) -> dict[str, Any] | None:
    """Rows by motion and by element, as JSON has them; None of one motion."""
    from gd_analyze.results.motion_words import has_motions, motion_rows, verdict_rows

    if not has_motions(findings):
        return None
    verdicts = [{key: row[key] for key in row if key != "marks"} for row in verdict_rows(findings)]
    return {"each": motion_rows(findings), "verdicts": verdicts}


def show_motions(findings: Findings, top: int) -> None:
    """Print a row per motion, and the verdicts of up to `top` elements on which they depend."""
    from gd_analyze.results.motion_words import changing, has_motions, motion_rows
    from gd_analyze.results.summary import budget_sentence, changing_sentence, strict_sentence
    from gd_analyze.text import number, percent

    if not has_motions(findings):
        return
    rows = motion_rows(findings)
    table(
        "Largest error along each motion, of what the budget allows there, and its joint",
        ["", "motion", "set points", "duration", "error", "joint"],
        [
            [
                str(k),
                row["motion"],
                str(row["set_points"]),
                f"{number(row['duration'])} s",
                percent(row["worst"]),
                str(row["joint"]) if row["worst"] else "",
            ]
            for k, row in enumerate(rows, start=1)
        ],
        "rl",
    )
    line()
    for said in (budget_sentence(findings), strict_sentence(findings), changing_sentence(findings)):
        if said:
            sentence(said)
    elements = changing(findings)[:top]
    if elements and len(rows) <= _MOST_COLUMNS:
        table(
            "What dominates along each motion (T translation, R rotation, – negligible)",
            ["", *(str(k) for k in range(1, len(rows) + 1))],
            [[row["element"], *row["marks"]] for row in elements],
            "l" * (1 + len(rows)),
        )
