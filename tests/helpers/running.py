"""Runs what is printed: compiled with every warning an error, imported, or called by another interpreter."""

from __future__ import annotations

import importlib.util
import shutil
import subprocess
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

import gd_analyze as gd
from gd_analyze.arrays import FloatArray
from gd_analyze.exporting.export import written
from gd_analyze.exporting.export_input import ExportInput, Function
from rounded_programs import PAYLOAD, parameters_given

STRICT = ("-Wall", "-Wextra", "-Werror", "-pedantic")
COMPILERS = {"c": ("gcc", "-std=c99", "main.c"), "cpp": ("g++", "-std=c++11", "main.cpp")}


def needs(command: str) -> Any:
    return pytest.mark.skipif(shutil.which(command) is None, reason=f"{command} is not installed")


needs_gcc, needs_gpp = needs("gcc"), needs("g++")


def called(*words: str | Path, given: bytes = b"", folder: Path | None = None) -> bytes:
    """Run a command; what it prints."""
    done = subprocess.run([*map(str, words)], input=given, capture_output=True, check=False, cwd=folder)
    assert done.returncode == 0, (done.stderr + done.stdout[-2000:]).decode(errors="replace")[:4000]
    return done.stdout


@cache
def sanitizers(compiler: str) -> tuple[str, ...]:
    """What finds reads and writes out of place, where its library is installed."""
    words = ("-fsanitize=address,undefined", "-fno-sanitize-recover=all")
    command = [compiler, "-x", "c", "-", *words, "-o", "/dev/null"]
    done = subprocess.run(command, input=b"int main(void) { return 0; }", capture_output=True, check=False)
    return words if done.returncode == 0 else ()


def compiled(language: str, sources: Sequence[Path], out: Path, *flags: str) -> Path:
    """Compile and link."""
    compiler, standard, _ = COMPILERS[language]
    called(compiler, standard, *STRICT, *sanitizers(compiler), *flags, *sources, "-o", out, "-lm")
    return out


# A program, in C and C++ alike, that reads states and writes what every function gives, then torques of many.
MAIN = """
#include "{header}"
#include <stdio.h>
#include <stdlib.h>
#define NAME(word) {prefix}word
typedef {scalar} number;
int main(int some, char **words)
{{
    const size_t count = (size_t)atol(words[some - 1]);
    number *states = (number *)malloc(3 * {n} * count * sizeof(number) + 1);
    size_t s, i;
    if (fread(states, sizeof(number), 3 * {n} * count, stdin) != 3 * {n} * count)
        return 1;
{calls}
    free(states);
    return 0;
}}
"""
ONE = """
    for (s = 0; s < count; s++) {{
        number q[{n}], qd[{n}], qdd[{n}], results[{size}];
        for (i = 0; i < {n}; i++) {{
            q[i] = states[i * count + s];
            qd[i] = states[({n} + i) * count + s];
            qdd[i] = states[(2 * {n} + i) * count + s];
        }}
        const number *tau = qdd;
        const number payload[] = {{{payload}}}, parameters[] = {{{parameters}}};
        NAME({name})({arguments});
        (void)q; (void)qd; (void)qdd; (void)tau; (void)payload; (void)parameters;
        fwrite(results, sizeof(number), {size}, stdout);
    }}"""
# Memory of just the right size, so that a step too far is seen.
MANY = """
    {{
        const size_t many = {many};
        number *given = (number *)malloc(3 * {n} * many * sizeof(number) + 1);
        number *results = (number *)malloc({size} * many * sizeof(number) + 1);
        for (i = 0; i < 3 * {n}; i++)
            for (s = 0; s < many; s++)
                given[i * many + s] = states[i * count + s];
        NAME({name}_many)(many, {arguments});
        fwrite(results, sizeof(number), {size} * many, stdout);
        free(given);
        free(results);
    }}"""


def size_of(function: Function) -> int:
    return sum(output.size for output in function.outputs)


def run_compiled(
    what: ExportInput,
    language: str,
    states: gd.types.States,
    folder: Path,
    scalar: str = "double",
    counts: Sequence[int] = (),
) -> tuple[dict[str, FloatArray], list[FloatArray]]:
    """Every function's outputs (outputs, states), and of so many states the first's from all at once."""
    n, calls = what.n, []
    for function in what.functions:
        begins = np.cumsum([0, *(output.size for output in function.outputs)])[:-1]
        arguments = ", ".join([*function.arguments, *(f"results + {begin}" for begin in begins)])
        given = ", ".join(f"(number){x!r}" for x in PAYLOAD)
        parameters = ", ".join(f"(number){x!r}" for x in parameters_given(function.n_parameters or 1))
        words = {"size": size_of(function), "name": function.name, "arguments": arguments, "payload": given}
        words |= {"parameters": parameters}
        calls.append(ONE.format(n=n, **words))
    main = what.functions[0]
    begins = np.cumsum([0, *(output.size for output in main.outputs)])[:-1]
    places = [f"given + {n * k} * many" for k in range(len(main.arguments))]
    arguments = ", ".join([*places, *(f"results + {begin} * many" for begin in begins)])
    calls += [
        MANY.format(n=n, many=many, size=size_of(main), name=main.name, arguments=arguments)
        for many in counts
    ]
    header, prefix = (".h", f"{what.name}_##") if language == "c" else (".hpp", f"{what.name}::")
    text = MAIN.format(header=what.name + header, prefix=prefix, scalar=scalar, n=n, calls="".join(calls))
    written(what, language, scalar if language == "c" else "double").save(folder)
    source = folder / COMPILERS[language][2]
    source.write_text(text, encoding="ascii")
    program = compiled(language, [source, *folder.glob(f"{what.name}.c")], folder / "run")
    kind = np.float64 if scalar == "double" else np.float32
    rows = np.concatenate([x.T for x in states.arrays]).astype(kind)
    printed = np.frombuffer(called(program, str(len(states)), given=rows.tobytes()), dtype=kind).astype(float)
    sizes = [size_of(function) * len(states) for function in what.functions] + [
        size_of(main) * many for many in counts
    ]
    assert len(printed) == sum(sizes)
    parts = np.split(printed, np.cumsum(sizes)[:-1])
    pairs = zip(what.functions, parts, strict=False)
    results = {function.name: part.reshape(len(states), -1).T for function, part in pairs}
    bulk = [part.reshape(size_of(main), -1) for part in parts[len(what.functions) :]]
    return results, bulk


def imported(what: ExportInput, language: str, folder: Path) -> ModuleType:
    """The module that was written."""
    pytest.importorskip({"python": "numpy"}.get(language, language))
    (path,) = written(what, language).save(folder)
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def of_each_state(call: Any, given: Sequence[FloatArray], n_outputs: int) -> Any:
    """What SymPy gives of one state after the other: an array per output, or the only one."""
    each = [call(*state) for state in zip(*given, strict=True)]
    parts = zip(*each, strict=True) if n_outputs > 1 else [each]
    arrays = [np.array([matrix.tolist() for matrix in part], dtype=float) for part in parts]
    return arrays if n_outputs > 1 else arrays[0]


def run_imported(
    what: ExportInput, language: str, states: gd.types.States, folder: Path
) -> dict[str, FloatArray]:
    """Every function's outputs (outputs, states)."""
    module, count, found = imported(what, language, folder), len(states), {}
    for function in what.functions:
        call = getattr(module, function.name)
        loads = np.broadcast_to(PAYLOAD, (count, len(PAYLOAD)))
        every = {"q": states.q, "qd": states.qd, "qdd": states.qdd, "tau": states.qdd, "payload": loads}
        every["parameters"] = np.tile(parameters_given(function.n_parameters), (count, 1))
        given = [every[name] for name in function.arguments]
        if language == "casadi":
            results = call.map(count)(*(x.T for x in given))
        elif language == "sympy":
            results = of_each_state(call, given, len(function.outputs))
        else:
            results = (pytest.importorskip("jax").jit(call) if language == "jax" else call)(*given)
        listed, rows = results if len(function.outputs) > 1 else [results], []
        for output, values in zip(function.outputs, listed, strict=True):
            if language == "sympy":
                values = values.reshape(count, *output.shape)
            elif language == "casadi":
                # Matrices of the states stand side by side.
                values = np.array(values).reshape(output.shape[0], count, -1).swapaxes(0, 1)
            else:
                assert values.shape == (count, *output.shape)
            rows.append(np.asarray(values).reshape(count, -1).T)
        found[function.name] = np.concatenate(rows)
    return found
