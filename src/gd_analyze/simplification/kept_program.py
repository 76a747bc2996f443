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
from typing import Any

import numpy as np

from gd_analyze.cache import keep, kept, name_of
from gd_analyze.operations.program import Program, plain_program, read_back

# Source folders that determine an exact program; a change there invalidates those written before.
_CODE = ("certification", "dynamics", "harmonics", "motions", "operations", "robots", "simplification")


@dataclass(frozen=True)
class Task:
    """The exact program of an arm, which is slow to write."""

    name: str  # of its entry in the cache
    n_joints: int = field(compare=False)
    write: Callable[[], Program] = field(compare=False)
    is_right: Callable[[Program], bool] = field(compare=False)  # compares it with the arm's recursion
    shipped: Any = field(default=None, compare=False)  # plain values of a program from a longer search


def program_name(key: Any) -> str:
    """Name a program by everything it depends on: `key`, see `name_of`, this code and its platform."""
    return name_of([_surroundings(), key])


@lru_cache(maxsize=256)
def kept_program(task: Task) -> Program:
    """Return a program as shipped, from the cache, or newly written; the last two are equal."""
    for stored in (task.shipped, kept(task.name)):
        with suppress(Exception):  # an entry may hold anything, and then the program is written anew
            program = _read(stored, task)
            if task.is_right(program):
                return program
    values = plain_program(task.write())
    keep(task.name, values)
    return _read(values, task)


def _read(values: Any, task: Task) -> Program:
    """A program from plain values; an exception for any other values."""
    inputs = {f"{name}{joint + 1}" for name in ("q", "qd", "qdd") for joint in range(task.n_joints)}
    steps, outputs = values
    for cell in chain(outputs, *steps):
        if type(cell) not in (str, float, int):  # of JSON, true is not 1
            raise TypeError(f"{cell!r} is neither a name nor a number")
    program = read_back(steps, outputs, inputs)
    if len(program.outputs) != task.n_joints:
        raise ValueError(f"{len(program.outputs)} outputs of {task.n_joints} joints")
    return program


@cache
def _surroundings() -> list[str]:
    """The code and its platform, as far as numbers may depend on them."""
    digest, root = hashlib.sha256(), Path(__file__).parents[1]
    for place in _CODE:
        for file in sorted((root / place).rglob("*.py")):
            digest.update(file.read_bytes())
    return [digest.hexdigest(), np.__version__, platform.python_version(), platform.machine()]
