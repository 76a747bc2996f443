"""Search for a program of few operations whose outputs stay within allowed errors at a pool of states.

The search is local and random: a try makes one to three edits of the current program, adjusts its numbers,
and is accepted by simulated annealing. It never leaves what holds: at states where errors are large in every
try, and at the whole pool whenever operations are saved.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from copy import copy
from dataclasses import dataclass

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.program_search import kernels
from gd_analyze.program_search.layout import Layout, Nodes, copied, nodes_of_size


@dataclass(frozen=True)
class SearchSizes:
    """Numbers of states and tries."""

    active: int = 1000  # states at which every promising try is evaluated
    few: int = 128  # of the active states, those at which every try is evaluated
    watched: int = 6000  # states at which every accepted try is evaluated
    remembered: int = 2000  # of the watched states, those at which a program failed before
    batch: int = 2000  # tries between two looks at the whole pool
    unchecked: int = 20_000  # tries after which the current program is evaluated at the whole pool
    repairs: int = 5  # refits of a program that saves operations and fails at some states of the pool


USUAL_SIZES = SearchSizes()


@dataclass(frozen=True, kw_only=True)
class _RefitSettings:
    """Blocks of states, and the refit of numbers at the whole pool."""

    block_states: int = 256  # states of a block that fits the cache
    estimation_states: int = 48  # states at which the numbers of an edit are estimated
    rounds: int = 10  # rounds of a refit at the pool
    aimed_share: float = 0.99  # share of the limit that such a refit aims at


_REFIT = _RefitSettings()


class Pool:
    """States at which a program must hold: values of its leaves, exact outputs, and allowed errors."""

    def __init__(
        self, layout: Layout, inputs: Mapping[str, FloatArray], targets: FloatArray, scale: FloatArray
    ) -> None:
        self.leaves = layout.values(inputs)
        self.targets = np.ascontiguousarray(targets)
        self.scale = np.broadcast_to(scale, targets.shape).copy()

    def __len__(self) -> int:
        return self.targets.shape[1]

    def joined_by(
        self, layout: Layout, inputs: Mapping[str, FloatArray], targets: FloatArray, scale: FloatArray
    ) -> Pool:
        """The pool with further states."""
        further = Pool(layout, inputs, targets, scale)
        joined = copy(self)
        for name in ("leaves", "targets", "scale"):
            setattr(joined, name, np.hstack([getattr(self, name), getattr(further, name)]))
        return joined

    def sample(self, chosen: np.ndarray, room: int = 0) -> kernels.Sample:
        """Some states; with `room` for values of that many nodes, or for those of the leaves alone."""
        leaves = self.leaves[:, chosen]
        values = np.zeros((max(room, len(leaves)), len(chosen)))
        values[: len(leaves)] = leaves
        targets, scale = (np.ascontiguousarray(x[:, chosen]) for x in (self.targets, self.scale))
        return kernels.Sample(values, targets, scale, np.zeros(targets.shape))


class ProgramSearch:
    """A search over one pool from one layout."""

    def __init__(
        self,
        layout: Layout,
        pool: Pool,
        settings: kernels.SearchSettings,
        sizes: SearchSizes = USUAL_SIZES,
    ) -> None:
        self.layout, self.pool, self.settings, self.sizes = layout, pool, settings, sizes
        self.random = np.random.default_rng(0)
        self.statistics = np.zeros(6, dtype=np.int64)
        self._room = layout.exact.kind.size
        self._outputs = len(pool.targets)
        self._memory = self._memory_of(min(sizes.few, len(pool)))
        self._remembered = np.empty(0, dtype=np.int64)
        self._errors = np.zeros(pool.targets.shape)

    def _memory_of(self, screened: int) -> kernels.Memory:
        room, outputs, sizes = self._room, self._outputs, self.sizes
        numbers = room // 2

        def fit() -> kernels.NumberFit:
            return kernels.NumberFit(
                np.zeros(room, dtype=np.int32),
                np.zeros((outputs, numbers), dtype=np.int32),
                np.zeros(outputs, dtype=np.int64),
                np.zeros((outputs, screened, numbers)),
                np.zeros((room, max(screened, numbers))),
                np.zeros(room, dtype=np.int8),
                np.zeros((numbers, numbers)),
                np.zeros(numbers),
                np.zeros(1, dtype=np.int64),
                np.zeros((room, min(screened, _REFIT.estimation_states))),
            )

        def whole(*shape: int) -> FloatArray:
            return np.zeros(shape)

        table = 1 << int(4 * room).bit_length()
        return kernels.Memory(
            edited=nodes_of_size(room, outputs),
            trial=nodes_of_size(room, outputs),
            canon=kernels.Canon(
                np.zeros(table, dtype=np.int32),
                np.zeros(room, dtype=np.int32),
                np.zeros(room, dtype=np.int8),
                np.zeros(4 * room, dtype=np.int32),
                np.zeros(room, dtype=np.int8),
            ),
            used=np.zeros(room, dtype=np.int8),
            values=whole(room, screened),
            chord=fit(),
            fit=fit(),
            ones=np.ones((outputs, screened)),
            weights=whole(outputs, screened),
            numbers=whole(room),
            dense=whole(numbers, numbers),
            remainder=whole(min(screened, _REFIT.estimation_states)),
            gathered=kernels.Sample(
                whole(room, screened),
                whole(outputs, screened),
                whole(outputs, screened),
                whole(outputs, screened),
            ),
            column=whole(sizes.active),
            block=whole(room, _REFIT.block_states),
            block_errors=whole(outputs, _REFIT.block_states),
        )

    def cost(self, nodes: Nodes) -> float:
        """Operations, with sines and cosines at their price."""
        return float(kernels.cost(nodes, self.layout.about, self._memory.used))

    def errors(self, nodes: Nodes) -> FloatArray:
        """Errors over allowed ones at the pool, shape (outputs, N); overwritten by the next call."""
        memory, pool = self._memory, self.pool
        kernels.largest_errors(
            nodes, pool.leaves, pool.targets, pool.scale, memory.block, memory.block_errors, self._errors
        )
        return self._errors

    def _choose(self, nodes: Nodes) -> None:
        """Take active and watched states where errors of a program are largest, others at random."""
        errors, sizes, count = np.abs(self._errors), self.sizes, len(self.pool)

        def worst(most: int) -> np.ndarray:
            per_output = max(most // self._outputs, 1)
            if count <= per_output:
                return np.arange(count)
            top = np.argpartition(-errors, per_output - 1, axis=1)[:, :per_output]
            return np.unique(top)

        watched = [worst(sizes.watched // 2), self._remembered]
        watched.append(self.random.integers(0, count, sizes.watched // 4))
        self.watched = self.pool.sample(np.unique(np.concatenate(watched)))
        size = min(sizes.active, count)
        worst_ones = worst(size // 2)
        remembered = self._remembered[-size // 4 :]
        active = np.unique(np.concatenate([worst_ones, remembered]))[:size]
        drawn = np.setdiff1d(self.random.permutation(count)[: 4 * size], active, assume_unique=False)
        self.random.shuffle(drawn)
        active = np.concatenate([active, drawn[: size - len(active)]])
        if len(active) < size:
            active = np.concatenate([active, np.setdiff1d(np.arange(count), active)[: size - len(active)]])
        self.random.shuffle(active)
        # Half of the states at which every try is evaluated are the worst, half any of the active ones.
        screened = min(sizes.few, count)
        first = worst(screened // 2)
        active = (
            np.concatenate([first, np.setdiff1d(active, first)[: size - len(first)]])
            if len(first) < size
            else active
        )
        remaining = active[len(first) :]
        self.random.shuffle(remaining)
        self.active = self.pool.sample(active[:size], self._room)

    def _remember(self, limit: float) -> None:
        """Keep the worst states beyond the limit, of every output."""
        errors = np.abs(self._errors)
        worst = []
        for row in errors:
            exceeding = np.flatnonzero(row > limit)
            worst.append(exceeding[np.argsort(-row[exceeding], kind="stable")[:100]])
        self._remembered = np.unique(np.concatenate([self._remembered, *worst]))
        if len(self._remembered) > self.sizes.remembered:
            self._remembered = self.random.choice(self._remembered, self.sizes.remembered, replace=False)

    def _settled(self, nodes: Nodes) -> bool:
        """Adjust a program's numbers until it holds at the whole pool; False if they cannot."""
        limit, first = self.settings.limit, self.layout.about.degree.size
        for _ in range(self.sizes.repairs):
            if np.abs(self.errors(nodes)).max() <= limit:
                return True
            self._remember(limit)
            self._choose(nodes)
            kernels.refit(nodes, self.active, self._memory, first, _REFIT.rounds, _REFIT.aimed_share * limit)
        return bool(np.abs(self.errors(nodes)).max() <= limit)

    def run(
        self,
        start: Nodes,
        tries: int,
        seed: int,
        progress: Callable[[float, Nodes], bool] = lambda _, __: True,
    ) -> Nodes:
        """Search from a program; returns the cheapest found that holds at the whole pool.

        A start that does not hold, even with other numbers, is replaced by the exact program.
        `progress` is called with the least cost and its program after every batch; the search ends when it
        is false.
        """
        random = np.random.default_rng(seed)
        current = copied(start)
        if not self._settled(current):
            current = copied(self.layout.exact)
            self.errors(current)
        best, lowest_cost = copied(current), self.cost(current)
        self._choose(best)
        done = checked = 0
        while done < tries:
            before = int(self.statistics[0])
            batch = min(self.sizes.batch, tries - done)
            kernels.search(
                random,
                self.settings,
                current,
                batch,
                self.layout.about,
                self.active,
                self.watched,
                self._memory,
                self.statistics,
            )
            done += int(self.statistics[0]) - before
            if self.cost(current) < lowest_cost or done - checked >= self.sizes.unchecked:
                checked = done
                if self._settled(current):
                    if self.cost(current) <= lowest_cost:
                        best, lowest_cost = copied(current), self.cost(current)
                else:
                    current = copied(best)
                    self.errors(current)
                self._choose(current)
            if not progress(lowest_cost, best):
                break
        return best

    def add(self, inputs: Mapping[str, FloatArray], targets: FloatArray, scale: FloatArray) -> None:
        """Add states to the pool; a search remembers them."""
        count = len(self.pool)
        self.pool = self.pool.joined_by(self.layout, inputs, targets, scale)
        self._errors = np.zeros(self.pool.targets.shape)
        added = np.arange(count, len(self.pool))
        self._remembered = np.concatenate([self._remembered, added])[-self.sizes.remembered :]

    def allow(self, share: FloatArray) -> None:
        """Scale allowed errors by a factor per output, shape (outputs,)."""
        self.pool.scale /= share[:, None]
