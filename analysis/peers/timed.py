"""C compiled and timed: many states per call, the least of many rounds, everybody in turn."""

from __future__ import annotations

import ctypes
import subprocess
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.motions.states import States

# Nanoseconds that a way's turn takes in a round: long against reading the clock, short against others' use of it.
_TURN = 1_000_000


@dataclass(frozen=True, eq=False)
class Way:
    """One way to the torque at some states.

    Parameters
    ----------
    name
        What it is.
    run
        Evaluates it at all states, as many times as it is told.
    torque
        Where that leaves what it found, shape (states, joints).
    """

    name: str
    run: Callable[[int], object]
    torque: FloatArray


def library(folder: Path, sources: Mapping[str, str], *command: str) -> ctypes.CDLL:
    """Compile files, of which headers are read by others, and load what comes of it.

    Raises
    ------
    subprocess.CalledProcessError
        If it does not compile; what the compiler says is its `stderr`.
    """
    folder.mkdir(parents=True)
    for name, text in sources.items():
        (folder / name).write_text(text, encoding="utf-8")
    files = [name for name in sources if not name.endswith((".h", ".hpp"))]
    arguments = [*command, "-shared", "-fPIC", *files, "-o", "made.so", "-lm"]
    subprocess.run(arguments, check=True, cwd=folder, capture_output=True, text=True)
    return ctypes.CDLL(str(folder / "made.so"))


def way(name: str, function: Callable[..., object], states: States, *, by_joint: bool = False) -> Way:
    """Call `function(passes, count, q, qd, qdd, tau)`, in arrays state by state, or joint by joint."""
    arrays = [np.ascontiguousarray(x.T if by_joint else x) for x in states.arrays]
    torque = np.full_like(arrays[0], np.nan)
    pointers = [ctypes.c_void_p(x.ctypes.data) for x in (*arrays, torque)]
    count = ctypes.c_long(len(states.q))

    def run(passes: int, _kept: object = arrays) -> None:
        function(ctypes.c_long(passes), count, *pointers)

    return Way(name, run, torque.T if by_joint else torque)


def nanoseconds(ways: Sequence[Way], rounds: int) -> dict[str, float]:
    """Time per state of every way, the least of some rounds, in which each has its turn."""
    # The least of a few, as one pass in which others had the processor would make all turns short.
    passes = [max(1, int(_TURN / min(_took(each, 1) for _ in range(5)))) for each in ways]
    least = [np.inf] * len(ways)
    for _ in range(rounds):
        least = [min(t, _took(each, n) / n) for t, each, n in zip(least, ways, passes, strict=True)]
    return {each.name: t / len(each.torque) for each, t in zip(ways, least, strict=True)}


def _took(way: Way, passes: int) -> int:
    start = time.perf_counter_ns()
    way.run(passes)
    return time.perf_counter_ns() - start
