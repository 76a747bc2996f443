"""Progress that notes what it is told."""

from __future__ import annotations

import gd_analyze as gd


class Told(gd.types.Progress):
    """Stages in their order, each with its total and the steps done."""

    def __init__(self) -> None:
        self.stages: list[tuple[str, int | None]] = []
        self.steps: list[list[int]] = []  # of each stage
        self.counts: list[str] = []

    def stage(self, label: str, total: int | None = None) -> None:
        self.stages.append((label, total))
        self.steps.append([])

    def advance(self, steps: int = 1) -> None:
        self.steps[-1].append(steps)

    def counted(self, count: str) -> None:
        self.counts.append(count)
