"""What is done to a valid file: changes in an order, each with the seed of its own choices; changes of text.

Hypothesis chooses the plan and shrinks it to the few changes that matter; the places and values inside come
from the seeds, which is several times as quick as letting it choose each of them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from random import Random
from typing import Any

from hostile_values import text
from hypothesis import strategies as st
from verdict import judge

# Takes the random choices and a value, gives a changed one; the value that was given is left as it is.
Change = Callable[[Random, Any], Any]


@dataclass(frozen=True)
class Stage:
    """A form in which a file is changed, and how it becomes that of the next stage."""

    changes: Mapping[str, Change]  # what may be done to it, by name
    finish: Callable[[Any], Any]  # makes the form of the next stage
    weight: int = 1  # how often its changes are chosen, compared with others


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


@dataclass(frozen=True)
class Format:
    """A format: its valid files, how they are changed, how one is written, and how one is judged."""

    bases: int
    stages: Sequence[Stage]
    write: Callable[[Plan, Path], None]
    judged: Callable[[Path], bool]  # whether a file was read; a BrokenError where the property does not hold

    @property
    def cases(self) -> st.SearchStrategy[Plan]:
        """Plans of changed files."""
        return plans(self.bases, self.stages)


def text_format(
    bases: Sequence[Any], stages: Sequence[Stage], read: Callable[[Path], Any], use: Callable[[Any], None]
) -> Format:
    """A format that ends as text and as bytes."""
    stages = (*stages, TEXT, BYTES)

    def write(plan: Plan, path: Path) -> None:
        path.write_bytes(carried_out(plan, bases[plan.base], stages))

    return Format(len(bases), stages, write, lambda path: judge(path, read, use))


ENDS = ["\r\n", "\r", "\n\n", "\x0b", "\u2028", "\x85", "\n\r"]
ENCODINGS = ["utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "utf-32", "latin-1", "cp1252", "utf-7"]
TAILS = [b"\0", b"\0" * 5000, b"\x1a", b"\xff", b"\n" * 5000, b" "]


def _insert(random: Random, old: str) -> str:
    place = random.randint(0, len(old))
    return old[:place] + text(random) + old[place:]


def _replace_span(random: Random, old: str) -> str:
    place, length = random.randint(0, len(old)), random.choice([1, 1, 2, 5, 40])
    return old[:place] + random.choice(["", text(random)]) + old[place + length :]


def _lines(random: Random, old: str) -> str:
    """A line removed, said twice, moved or put in place of another."""
    lines = old.split("\n")
    source, target = random.randrange(len(lines)), random.randrange(len(lines))
    kind = random.randrange(4)
    if kind == 0:
        del lines[source]
    elif kind == 1:
        lines.insert(target, lines[source])
    elif kind == 2:
        lines[source], lines[target] = lines[target], lines[source]
    else:
        lines[source] = lines[target]
    return "\n".join(lines)


def _ends(random: Random, old: str) -> str:
    return old.replace("\n", random.choice(ENDS), random.choice([-1, 1, 5]))


def _encode(random: Random, old: bytes) -> bytes:
    return old.decode(errors="replace").encode(random.choice(ENCODINGS), errors="replace")


def _noise(random: Random, old: bytes) -> bytes:
    place, length = random.randint(0, len(old)), random.choice([0, 1, 8])
    return old[:place] + random.randbytes(random.randint(1, 8)) + old[place + length :]


def _cut(random: Random, old: bytes) -> bytes:
    return old[: random.randint(0, len(old))]


def _tail(random: Random, old: bytes) -> bytes:
    return old + random.choice(TAILS)


TEXT = Stage(
    {"insert": _insert, "replace text": _replace_span, "lines": _lines, "ends": _ends},
    lambda changed: changed.encode(errors="surrogatepass"),
)
BYTES = Stage({"encode": _encode, "noise": _noise, "cut": _cut, "tail": _tail}, bytes)
