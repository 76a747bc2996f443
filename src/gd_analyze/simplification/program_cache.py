"""Programs that took long to write, kept between runs: each is a function of its key and of this code."""

from __future__ import annotations

import hashlib
import platform
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from functools import cache, lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.motions.states import States
from gd_analyze.operations.program import Program, read_back, written
from gd_analyze.simplification.cache import keep, kept, name_of

# What programs come from; a change there is another program.
_CODE = ("dynamics", "harmonics", "operations", "simplification", "robots")


_Writing = Callable[[], Iterable[Program]]
_Check = Callable[[Sequence[Program]], bool]


@dataclass(frozen=True)
class Task:
    """Programs to be written together, which takes long."""

    name: str  # of their entry in the cache
    n_joints: int = field(compare=False)
    write: _Writing = field(compare=False)
    are_right: _Check = field(compare=False)

    @classmethod
    def of(cls, key: Any, n_joints: int, write: _Writing, are_right: _Check) -> Task:
        """Name programs by everything they depend on; `key` is a JSON value."""
        return cls(name_of([_surroundings(), key]), n_joints, write, are_right)


@lru_cache(maxsize=256)
def kept_programs(wanted: Task) -> tuple[Program, ...]:
    """Give programs as they were written before, or write them; both are the same to the last bit."""
    found = _read(kept(wanted.name), wanted)
    if found is not None and wanted.are_right(found):
        return found
    values = [written(program) for program in wanted.write()]
    keep(wanted.name, values)
    again = _read(values, wanted)
    assert again is not None
    return again


def _read(values: Any, wanted: Task) -> tuple[Program, ...] | None:
    """Programs of plain values; None where they are none, whatever they are."""
    inputs = {f"{name}{joint + 1}" for name in ("q", "qd", "qdd") for joint in range(wanted.n_joints)}
    try:
        programs = tuple(read_back(steps, outputs, inputs) for steps, outputs in values)
    except (TypeError, ValueError, AttributeError, IndexError, OverflowError):
        return None
    return programs if all(len(program.outputs) == wanted.n_joints for program in programs) else None


def some_states(n_joints: int) -> States:
    """States at which a wrong program is found out, always the same."""
    return States(*np.random.default_rng(0).uniform(-3.0, 3.0, (3, 4, n_joints)))


def inputs_of(states: States) -> dict[str, FloatArray]:
    """What a program is given at states (N, n)."""
    named = zip(("q", "qd", "qdd"), states.last, strict=True)
    return {f"{name}{j + 1}": row for name, rows in named for j, row in enumerate(rows)}


@cache
def _surroundings() -> list[str]:
    """The code and what it runs on, as far as numbers may depend on it."""
    digest, root = hashlib.sha256(), Path(__file__).parents[1]
    for place in _CODE:
        for file in sorted((root / place).rglob("*.py")):
            digest.update(file.read_bytes())
    return [digest.hexdigest(), np.__version__, platform.python_version(), platform.machine()]
