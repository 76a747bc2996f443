"""Search for a fast program of an arm's torque: several searches, begun from the exact program or the best.

After each search states may be added, and allowed errors may be changed.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.operations.program import Program, program_inputs
from gd_analyze.simplification.accuracy import SearchStep
from gd_analyze.simplification.exact_dynamics import ExactDynamics
from gd_analyze.simplification.fast import FAST, require_numba
from gd_analyze.simplification.levels import SearchOptions
from gd_analyze.simplification.model import SimplifiedModel, exactly, measured, no_dearer, with_gamma

if TYPE_CHECKING:
    from gd_analyze.program_search.layout import Nodes


@dataclass(frozen=True)
class FastSettings:
    """Lengths of the searches, and how close to the budget they go."""

    scouts: int = 0  # short searches at first
    fresh: int = 3  # searches from the exact program, of which the best is continued; scouts included
    searches: int = 4  # in all
    tries: int = 100_000  # of each
    few: int = 20_000  # tries of a scout, and of a search after the time is over
    limit: float = 0.995  # of allowed errors, at the states of the search


USUAL_FAST = FastSettings()


class FastSearch:
    """A search over states at which the budget holds; further states may be added."""

    def __init__(
        self,
        exact: ExactDynamics,
        allowed: FloatArray,
        options: SearchOptions,
        settings: FastSettings = USUAL_FAST,
        *,
        progress: Callable[[int], None] | None = None,
        stage: Callable[[str], object] = lambda _: None,
    ) -> None:
        require_numba()
        stage("loading the search: its first run compiles it, which takes about a minute")
        from gd_analyze.program_search import search
        from gd_analyze.program_search.kernels import SearchSettings
        from gd_analyze.program_search.layout import Layout

        self.exact, self.allowed, self.options, self.settings = exact, allowed, options, settings
        self.stopped = ""  # why the searches ended early: "after 20 s", "on request"
        self._progress = progress
        self._layout = Layout.of(exact.form.program, options.sine_price)
        pool = search.Pool(self._layout, *self._known(exact))
        self._search = search.ProgramSearch(self._layout, pool, SearchSettings(limit=settings.limit))
        self._share = np.ones(len(allowed))
        self._best = self._layout.exact
        self._least = self._search.cost(self._best)
        self._search.run(self._best, 1, 0)  # compiles
        self._begin = time.monotonic()
        stage(f"searching at level {FAST}")

    def _known(self, exact: ExactDynamics) -> tuple[dict[str, FloatArray], FloatArray, FloatArray]:
        """Inputs, torque, and the reciprocals of allowed errors at states."""
        inputs = program_inputs(exact.states)
        scale = np.broadcast_to(1.0 / self.allowed[:, None], (len(self.allowed), len(exact.states)))
        if exact.states.weights is not None:
            scale = scale * exact.states.weights.T
        return inputs, exact.form.program.run(inputs), scale

    def program(self, turn: int) -> Program:
        """The shortest program of one search that holds at all states so far."""
        begins = turn < self.settings.fresh
        start = self._layout.exact if begins else self._best
        is_short = bool(self.stopped) or turn < self.settings.scouts
        usual = self.settings.few if is_short else self.settings.tries
        tries = max(round(usual * self.options.effort), 1)
        self._last = start
        try:
            self._last = self._search.run(start, tries, turn, self._goes_on)
        except KeyboardInterrupt:
            if self.stopped:
                raise
            self.stopped = "on request"
        return self._layout.program(self._last)

    def _goes_on(self, lowest_cost: float, program: Nodes) -> bool:
        self._last = program
        if self._progress is not None and lowest_cost < self._least:
            self._progress(round(self._least - lowest_cost))
            self._least = lowest_cost
        seconds = self.options.within
        if not self.stopped and seconds is not None and time.monotonic() - self._begin > seconds:
            self.stopped = f"after {seconds:g} s"
            return False
        return True

    def is_best(self) -> bool:
        """Whether the last program is the cheapest so far; later searches continue from that one."""
        is_best = self._search.cost(self._last) <= self._search.cost(self._best)
        if is_best:
            self._best = self._last
        return is_best

    def learn(self, further: ExactDynamics, share: FloatArray) -> None:
        """Add states, and allow a share of the budget, shape (n,), at all."""
        if len(further.states):
            inputs, torque, scale = self._known(further)
            self._search.add(inputs, torque, scale / self._share[:, None])
        self._search.allow(share / self._share)
        self._share = share

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
    options: SearchOptions,
    *,
    progress: Callable[[int], None] | None = None,
    stage: Callable[[str], object] = lambda _: None,
) -> SimplifiedModel:
    """The shortest program found that keeps its budget at given states."""
    search = FastSearch(exact, allowed, options, progress=progress, stage=stage)
    best = exact.form.program
    for turn in range(search.settings.searches):
        program = search.program(turn)
        if search.is_best():
            best = program
        if search.stopped:
            break
    return search.model(best, stated, exact)
