"""Search for a fast program of an arm's torque: several short searches, and the best of them continued."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.operations.program import Program
from gd_analyze.simplification.accuracy import SearchStep
from gd_analyze.simplification.effort import inputs_of
from gd_analyze.simplification.exact import ExactDynamics
from gd_analyze.simplification.fast import FAST, require_numba
from gd_analyze.simplification.levels import SearchOptions
from gd_analyze.simplification.model import SimplifiedModel, exactly, measured, no_dearer, with_gamma


@dataclass(frozen=True)
class FastSettings:
    """Lengths of a search, and how close to the budget it goes."""

    seeds: int = 3  # short searches from the start, of which the best is continued
    short: int = 100_000  # tries of each
    long: int = 100_000  # tries of the continued search
    again: int = 20_000  # tries after states were added
    limit: float = 0.995  # of allowed errors, at the states of the search


USUAL = FastSettings()


class FastSearch:
    """A search over states at which the budget holds; further states may be added."""

    def __init__(
        self,
        exact: ExactDynamics,
        allowed: FloatArray,
        how: SearchOptions,
        settings: FastSettings = USUAL,
        *,
        starts: tuple[Program, ...] = (),
        progress: Callable[[int], None] | None = None,
        stage: Callable[[str], object] = lambda _: None,
    ) -> None:
        require_numba()
        stage("loading the search: its first run compiles it, which takes about a minute")
        from gd_analyze.program_search import search
        from gd_analyze.program_search.kernels import Settings
        from gd_analyze.program_search.layout import Layout

        self.exact, self.allowed, self.how, self.settings = exact, allowed, how, settings
        self.stopped = ""  # why a search ended before all its tries: "after 20 s", "on request"
        self._progress = progress
        self._layout = Layout.of([exact.form.program, *starts], how.sine_price)
        pool = search.Pool(self._layout, *self._known(exact))
        self._search = search.ProgramSearch(self._layout, pool, Settings(limit=settings.limit))
        self._least = min(self._search.ladder)
        self._search.run(self._search.ladder[self._least], 1, 0)  # compiles
        self._begin = time.monotonic()
        stage(f"searching at level {FAST}")

    def _known(self, exact: ExactDynamics) -> tuple[dict[str, FloatArray], FloatArray, FloatArray]:
        """Inputs, torque, and the reciprocals of allowed errors at states."""
        inputs = inputs_of(exact.states)
        scale = np.broadcast_to(1.0 / self.allowed[:, None], (len(self.allowed), len(exact.states)))
        if exact.states.weights is not None:
            scale = scale * exact.states.weights.T
        return inputs, exact.form.program.run(inputs), scale

    def _goes_on(self, least: float) -> bool:
        if self._progress is not None and least < self._least:
            self._progress(round(self._least - least))
        self._least = min(self._least, least)
        if self.how.within is not None and time.monotonic() - self._begin > self.how.within:
            self.stopped = f"after {self.how.within:g} s"
        return not self.stopped

    def program(self) -> Program:
        """Search from the cheapest start; a program that holds at all states."""
        search, settings = self._search, self.settings
        start = best = search.ladder[min(search.ladder)]
        try:
            for seed in range(settings.seeds):
                found = search.run(start, self._tries(settings.short), seed, self._goes_on)
                best = min(best, found, key=search.cost)
            if not self.stopped:
                best = search.run(best, self._tries(settings.long), settings.seeds, self._goes_on)
        except KeyboardInterrupt:
            self.stopped = "on request"
            best = search.ladder[min(search.ladder)]
        return self._layout.program(best)

    def repaired(self, further: ExactDynamics, share: FloatArray, seed: int) -> Program:
        """Add states, allow a share of the errors, and search on from the cheapest that then holds."""
        search = self._search
        if len(further.states):
            search.add(*self._known(further))
        search.tighten(share)
        best = search.repaired()
        try:
            if not self.stopped:
                best = search.run(best, self._tries(self.settings.again), seed, self._goes_on)
        except KeyboardInterrupt:
            self.stopped = "on request"
        return self._layout.program(best)

    def _tries(self, usual: int) -> int:
        return max(round(usual * self.how.effort), 1)

    def model(self, program: Program, stated: str, exact: ExactDynamics) -> SimplifiedModel:
        """A program as a model, with its errors at some states, or the exact one if it saves nothing."""
        model = exactly(exact, FAST, self.allowed, stated)
        steps = (SearchStep("search", program.count.total),)
        model = replace(model, program=program).stating(replace(model.accuracy, steps=steps))
        return no_dearer(exact, with_gamma(exact, measured(exact, model)))


def fast_model(
    exact: ExactDynamics,
    allowed: FloatArray,
    stated: str,
    how: SearchOptions,
    *,
    progress: Callable[[int], None] | None = None,
    stage: Callable[[str], object] = lambda _: None,
) -> SimplifiedModel:
    """The shortest program found that keeps its budget at given states."""
    search = FastSearch(exact, allowed, how, progress=progress, stage=stage)
    return search.model(search.program(), stated, exact)
