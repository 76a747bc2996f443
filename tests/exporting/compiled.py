"""Compiles what is printed for C and C++, with every warning an error, and runs it."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from gd_analyze.arrays import FloatArray
from gd_analyze.exporting.export_input import ExportInput
from gd_analyze.motions.states import States

needs_gcc = pytest.mark.skipif(shutil.which("gcc") is None, reason="gcc, which compiles it, is not installed")
needs_gpp = pytest.mark.skipif(shutil.which("g++") is None, reason="g++, which compiles it, is not installed")
STRICT = ("-Wall", "-Wextra", "-Werror", "-pedantic")


@cache
def sanitizers(compiler: str) -> tuple[str, ...]:
    """What finds reads and writes out of place, where its library is installed."""
    words = ("-fsanitize=address,undefined", "-fno-sanitize-recover=all")
    done = subprocess.run(
        [compiler, "-x", "c", "-", *words, "-o", "/dev/null"],
        input=b"int main(void) { return 0; }",
        capture_output=True,
        check=False,
    )
    return words if done.returncode == 0 else ()


def called(*words: str | Path, given: bytes = b"") -> bytes:
    """Run a command; what it prints."""
    done = subprocess.run([*map(str, words)], input=given, capture_output=True, check=False)
    assert done.returncode == 0, done.stderr.decode(errors="replace")[:2000]
    return done.stdout


def compiled(compiler: str, sources: Sequence[Path], out: Path, *flags: str) -> Path:
    """Compile and link."""
    standard = "-std=c99" if compiler == "gcc" else "-std=c++11"
    called(compiler, standard, *STRICT, *sanitizers(compiler), *flags, *sources, "-o", out, "-lm")
    return out


def main_text(subject: ExportInput, scalar: str, counts: Sequence[int]) -> str:
    """A program that reads states and writes what every function gives, then the torque of many."""
    name, n = subject.name, subject.n
    lines = [
        f'#include "{name}.h"',
        "#include <stdio.h>",
        "#include <stdlib.h>",
        f"typedef {scalar} number;",
        "int main(int some, char **words)",
        "{",
        "    const size_t count = (size_t)atol(words[some - 1]), joints = (size_t)NAME(joints);",
        "    number *states = malloc(3 * joints * count * sizeof(number));",
        "    size_t s, i;",
        "    if (fread(states, sizeof(number), 3 * joints * count, stdin) != 3 * joints * count)",
        "        return 1;",
    ]
    lines.insert(4, f"#define NAME(word) {name}_##word")
    for function in subject.functions:
        sizes = [result.size for result in function.outputs]
        results = [f"results + {sum(sizes[:k])}" for k in range(len(sizes))]
        lines += [
            "    for (s = 0; s < count; s++) {",
            f"        number q[{n}], qd[{n}], qdd[{n}], results[{sum(sizes)}];",
            f"        for (i = 0; i < {n}; i++) {{",
            "            q[i] = states[i * count + s];",
            "            qd[i] = states[(joints + i) * count + s];",
            "            qdd[i] = states[(2 * joints + i) * count + s];",
            "        }",
            f"        NAME({function.name})({', '.join([*function.arguments, *results])});",
            "        (void)q; (void)qd; (void)qdd;",
            f"        fwrite(results, sizeof(number), {sum(sizes)}, stdout);",
            "    }",
        ]
    for many in counts:
        lines += [
            "    {",
            f"        const size_t many = {many};",
            # Of just the right size, so that a step too far is seen.
            "        number *given = malloc(3 * joints * many * sizeof(number) + 1);",
            "        number *tau = malloc(joints * many * sizeof(number) + 1);",
            "        for (i = 0; i < 3 * joints; i++)",
            "            for (s = 0; s < many; s++)",
            "                given[i * many + s] = states[i * count + s];",
            "        NAME(torque_many)(many, given, given + joints * many, given + 2 * joints * many, tau);",
            "        fwrite(tau, sizeof(number), joints * many, stdout);",
            "        free(given);",
            "        free(tau);",
            "    }",
        ]
    return "\n".join([*lines, "    free(states);", "    return 0;", "}", ""])


def run_c(
    subject: ExportInput,
    files: Mapping[str, str],
    states: States,
    folder: Path,
    scalar: str = "double",
    counts: Sequence[int] = (),
) -> tuple[dict[str, FloatArray], list[FloatArray]]:
    """Every function's outputs (outputs, states), and of so many states the torque from all at once."""
    for file, text in files.items():
        (folder / file).write_text(text, encoding="ascii")
    (folder / "main.c").write_text(main_text(subject, scalar, counts), encoding="ascii")
    program = compiled("gcc", [folder / "main.c", folder / f"{subject.name}.c"], folder / "run")
    kind = np.float64 if scalar == "double" else np.float32
    rows = np.concatenate([x.T for x in states.arrays]).astype(kind)
    printed = np.frombuffer(called(program, str(len(states.q)), given=rows.tobytes()), dtype=kind)
    results: dict[str, FloatArray] = {}
    for function in subject.functions:
        size = sum(result.size for result in function.outputs) * len(states.q)
        results[function.name] = printed[:size].reshape(len(states.q), -1).T.astype(float)
        printed = printed[size:]
    bulk = []
    for many in counts:
        bulk.append(printed[: subject.n * many].reshape(subject.n, many).astype(float))
        printed = printed[subject.n * many :]
    assert not printed.size
    return results, bulk
