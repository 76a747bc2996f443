"""What is done to a valid file: which changes in which order, each with the seed of its own choices.

Hypothesis chooses the plan and shrinks it to the few changes that matter; the places and values inside come
from the seeds, which is several times as quick as letting it choose each of them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from random import Random
from typing import Any

from hypothesis import strategies as st

# Takes the random choices and a value, gives a changed one; the value that was given is left as it is.
Change = Callable[[Random, Any], Any]


@dataclass(frozen=True)
class Stage:
    """A form in which a file is changed.

    Parameters
    ----------
    changes
        What may be done to it, by name.
    finish
        Makes the form of the next stage.
    weight
        How often its changes are chosen, compared with others.
    """

    changes: Mapping[str, Change]
    finish: Callable[[Any], Any]
    weight: int = 1


@dataclass(frozen=True)
class Plan:
    """The number of a valid file, and changes to it by name and seed."""

    base: int
    steps: tuple[tuple[str, int], ...]


def plans(bases: int, stages: Sequence[Stage], most: int = 4) -> st.SearchStrategy[Plan]:
    """Plans of up to `most` changes to one of so many valid files."""
    names = [name for stage in stages for name in stage.changes for _ in range(stage.weight)]
    step = st.tuples(st.sampled_from(names), st.integers(0, 2**32 - 1))
    return st.builds(Plan, st.integers(0, bases - 1), st.lists(step, max_size=most).map(tuple))


def carried_out(plan: Plan, base: Any, stages: Sequence[Stage]) -> Any:
    """Change a valid file, stage by stage."""
    for stage in stages:
        for name, seed in plan.steps:
            if name in stage.changes:
                base = stage.changes[name](Random(seed), base)
        base = stage.finish(base)
    return base
