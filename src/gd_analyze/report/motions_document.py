"""What page and PDF say of several motions: a row for each, and the elements whose verdict changes."""

from __future__ import annotations

from typing import Any

from gd_analyze.results import summary
from gd_analyze.results.findings import Findings
from gd_analyze.results.motion_words import Row, changing, mark_of, motion_rows
from gd_analyze.results.words import VERDICTS
from gd_analyze.text import amount, number, percent, pretty

# Motions that have a column each; of more it is counted how many are of which verdict.
MOST_COLUMNS = 12


def motions_told(findings: Findings) -> dict[str, Any] | None:
    """Give rows, marks and sentences of several motions; None of one."""
    if not summary.has_motions(findings):
        return None
    rows = motion_rows(findings)
    return {
        "rows": [_row(findings, k, row) for k, row in enumerate(rows, start=1)],
        "budget": summary.budget_sentence(findings),
        "strict": summary.strict_sentence(findings),
        "changes": summary.changing_sentence(findings),
        **_matrix(findings, len(rows)),
    }


def _row(findings: Findings, place: int, row: Row) -> Row:
    """One motion: of every joint its peak torque, and its largest error over what it is allowed."""
    return {
        "number": place,
        "name": row["motion"],
        "origin": row["origin"],
        "set_points": row["set_points"],
        "duration": f"{number(row['duration'])} s",
        "joints": [
            {
                "used": percent(used) if peak else "–",
                "peak": pretty(amount(peak, joint.effort_unit)),
                "is_worst": i == row["joint"] and used > 0.0,
            }
            for i, (joint, used, peak) in enumerate(
                zip(findings.arm.joints, row["used"], row["peak_torque"], strict=True), start=1
            )
        ],
    }


def _matrix(findings: Findings, count: int) -> dict[str, Any]:
    """Elements whose verdict changes: a mark per motion, or how many motions are of each verdict."""
    rows, by_motion = changing(findings), count <= MOST_COLUMNS
    met = {verdict for row in rows for verdict in row["verdicts"]}
    verdicts = [verdict for verdict in VERDICTS if verdict in met]
    heads = [str(k) for k in range(1, count + 1)] if by_motion else [VERDICTS[v] for v in verdicts]
    return {
        "by_motion": by_motion,
        "heads": heads,
        "key": [[mark_of(verdict), verdict, VERDICTS[verdict]] for verdict in verdicts],
        "changing": [
            {
                "element": row["element"],
                "cells": [
                    {"mark": mark, "verdict": _kept(verdict), "told": VERDICTS[verdict]}
                    for mark, verdict in zip(row["marks"], row["verdicts"], strict=True)
                ]
                if by_motion
                else [_counted(row, verdict) for verdict in verdicts],
            }
            for row in rows
        ],
    }


def _counted(row: Row, verdict: str) -> dict[str, str]:
    """Along how many motions an element is of a verdict."""
    count = row["verdicts"].count(verdict)
    look = _kept(verdict) if count else "neither"
    return {"mark": str(count or ""), "verdict": look, "told": VERDICTS[verdict]}


def _kept(verdict: str) -> str:
    """The look of a mark: what does not matter has none."""
    return "neither" if verdict == "negligible" else verdict
