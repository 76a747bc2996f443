"""Tests written with an export: states, values of every function, and programs that compare."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Collection, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from gd_analyze.errors import GdAnalyzeWarning
from gd_analyze.exporting.export_input import PAYLOAD_SIZE, ExportInput, Function
from gd_analyze.exporting.language import Language, environment
from gd_analyze.motions.states import states_in_box
from gd_analyze.operations.program import program_inputs

# Number of states within the arm's limits; tolerance as a share of a function's largest value: libraries
# round differently, but a change of any coefficient by a thousandth shows.
_TESTED_STATES = 12
_ALLOWED = {"double": 1e-9, "float": 3e-4}
# Template and file of the test of each language that has one.
_TESTS = {
    "c": ("test.c.jinja", "{}_test.c"),
    "cpp": ("test.c.jinja", "{}_test.cpp"),
    "matlab": ("test.m.jinja", "{}_test.m"),
    "python": ("test.py.jinja", "test_{}.py"),
}
# The build file, and the languages that it builds.
_CMAKE = "CMakeLists.txt"
_COMPILED = {"c", "cpp"}


def names_of_tests(name: str, languages: Collection[str]) -> list[str]:
    """Names of the files of `tests_of`."""
    tests = [_TESTS[word][1].format(name) for word in languages if word in _TESTS]
    return [*tests, _CMAKE] if _COMPILED & {*languages} else tests


def tests_of(subject: ExportInput, languages: Mapping[str, Language]) -> dict[str, str]:
    """Texts by file name: a test for each language that has one, and a CMake file for C and C++."""
    values = _values(subject)
    files = {}
    for word, language in languages.items():
        if word not in _TESTS:
            continue
        template, file = _TESTS[word]
        share, number = _ALLOWED[language.scalar], language.number if word == "c" else repr
        largest = {f.name: max(1e-3, *(max(map(abs, v[f.name])) for v in values)) for f in subject.functions}
        files[file.format(subject.name)] = (
            environment(language)
            .get_template(template)
            .render(
                given=subject,
                name=subject.name,
                vectors=values,
                scalar=language.scalar,
                cpp=word == "cpp",
                number=number,
                row=partial(_row, number),
                allowed={name: share * size for name, size in largest.items()},
                size=_size,
                begins=lambda f: np.cumsum([0, *(x.size for x in f.outputs)])[:-1].tolist(),
            )
        )
    compiled = [word for word in languages if word in _COMPILED]
    if compiled:
        text = environment(languages[compiled[0]]).get_template("CMakeLists.txt.jinja")
        files[_CMAKE] = text.render(name=subject.name, c="c" in compiled, cpp="cpp" in compiled)
    return files


def _row(number: Callable[[float], str], values: Sequence[float]) -> str:
    return ", ".join(map(number, values))


def _size(function: Function) -> int:
    return sum(output.size for output in function.outputs)


def _values(subject: ExportInput) -> list[dict[str, Any]]:
    """States and outputs by name, state by state; accelerations serve as input torques."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", GdAnalyzeWarning)  # of limits that are not stated
        states = states_in_box(subject.arm, _TESTED_STATES, seed=1)
    inputs = program_inputs(states)
    payloads = np.random.default_rng(1).uniform(0.0, 1.0, (_TESTED_STATES, PAYLOAD_SIZE))
    inputs |= {f"tau{i + 1}": row for i, row in enumerate(states.last[2])}
    inputs |= {f"payload{i + 1}": row for i, row in enumerate(payloads.T)}
    parameters = np.random.default_rng(2).uniform(-1.0, 1.0, (_TESTED_STATES, len(subject.base or ())))
    inputs |= {f"parameters{i + 1}": row for i, row in enumerate(parameters.T)}
    outputs = {function.name: function.program.run(inputs).T.tolist() for function in subject.functions}
    named = {"q": states.q.tolist(), "qd": states.qd.tolist(), "qdd": states.qdd.tolist()}
    named |= {"payload": payloads.tolist()} | outputs
    named |= {"parameters": parameters.tolist()} if subject.base else {}
    return [{name: rows[s] for name, rows in named.items()} for s in range(_TESTED_STATES)]
