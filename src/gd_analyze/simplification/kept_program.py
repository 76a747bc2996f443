"""Exact programs that are kept between runs: shipped, in the user's cache, or newly written."""

from __future__ import annotations

import hashlib
import platform
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cache, lru_cache
from itertools import chain
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from gd_analyze.cache import keep, kept, name_of
from gd_analyze.operations.program import Program, plain_program, read_back

# Source folders that determine an exact program; a change there invalidates those written before.
_CODE = ("certification", "dynamics", "harmonics", "motions", "operations", "robots", "simplification")


# One or more programs of the same inputs: the torque, or D, h and c.
Programs: TypeAlias = tuple[Program, ...]


@dataclass(frozen=True)
class Task:
    """Exact programs of an arm, which are slow to write."""

    name: str  # of their entry in the cache
    n_joints: int = field(compare=False)
    write: Callable[[], Programs] = field(compare=False)
    is_right: Callable[[Programs], bool] = field(compare=False)  # compares them with the arm's recursion
    shipped: Any = field(default=None, compare=False)  # plain values of programs from a longer search


def program_name(key: Any) -> str:
    """Name programs by everything it depends on: `key`, see `name_of`, this code and its platform."""
    return name_of([_surroundings(), key])


@lru_cache(maxsize=256)
def kept_programs(task: Task) -> Programs:
    """Return programs as shipped, from the cache, or newly written; the last two are equal."""
    for stored in (task.shipped, kept(task.name)):
        with suppress(Exception):  # an entry may hold anything, and then the programs are written anew
            programs = _read(stored, task)
            if task.is_right(programs):
                return programs
    values = [plain_program(program) for program in task.write()]
    keep(task.name, values)
    return _read(values, task)


def _read(values: Any, task: Task) -> Programs:
    """Programs from plain values; an exception for any other values."""
    inputs = {f"{name}{joint + 1}" for name in ("q", "qd", "qdd") for joint in range(task.n_joints)}
    for steps, outputs in values:
        for cell in chain(outputs, *steps):
            if type(cell) not in (str, float, int):  # of JSON, true is not 1
                raise TypeError(f"{cell!r} is neither a name nor a number")
    return tuple(read_back(steps, outputs, inputs) for steps, outputs in values)


@cache
def _surroundings() -> list[str]:
    """The code and its platform, as far as numbers may depend on them."""
    digest, root = hashlib.sha256(), Path(__file__).parents[1]
    for place in _CODE:
        for file in sorted((root / place).rglob("*.py")):
            digest.update(file.read_bytes())
    return [digest.hexdigest(), np.__version__, platform.python_version(), platform.machine()]
