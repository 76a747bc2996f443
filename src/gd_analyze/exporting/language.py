"""Languages: comments, numbers, operators, files and templates."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import islice
from typing import Any, ClassVar, NamedTuple

from jinja2 import Environment, PackageLoader, StrictUndefined

from gd_analyze.exporting.export_input import ExportInput, Function
from gd_analyze.exporting.header import header
from gd_analyze.operations.trace import Expression
from gd_analyze.text import shortened

_LONGEST_LINE = 120


class Body(NamedTuple):
    """Body of a function."""

    statements: list[tuple[str, str]]  # assignments (name, value), in order
    outputs: dict[str, list[str]]  # expressions by output


@dataclass(frozen=True)
class Language:
    """A language, for numbers of one type; subclasses state the differences."""

    scalar: str = "double"  # type of all numbers, one of `scalars`

    # Templates (`exporting/templates`) by the suffix of the file made from each.
    files: ClassVar[Mapping[str, str]]
    # A comment of several lines: what precedes the first, the prefix of every line, and its end.
    comment: ClassVar[tuple[str, str, str]]
    # Characters that are replaced in a comment, which could end it, continue its line or be expanded.
    unfit: ClassVar[str] = r'[^\x20-\x7e]|[*\\?"`]'
    scalars: ClassVar[tuple[str, ...]] = ("double",)
    operators: ClassVar[Mapping[str, str]] = {"add": "+", "subtract": "-", "multiply": "*", "divide": "/"}
    separator: ClassVar[str] = ", "

    def number(self, value: float) -> str:
        """Write a number so that it reads back exactly; a negative one in brackets."""
        return repr(value) if value >= 0.0 else f"({value!r})"

    def listed(self, values: Sequence[float]) -> str:
        """Write the numbers of a constant."""
        return self.separator.join(map(repr, values))

    def function(self, name: str) -> str:
        """What sin or cos is called."""
        return name

    def sign(self, value: str) -> str:
        """Write the sign of a value, 1, 0 or -1."""
        return f"{self.function('sign')}({value})"

    def foreign(self, text: str) -> str:
        """Write a text from outside, such as an arm's title, for a comment."""
        return re.sub(self.unfit, lambda sign: f"<U+{ord(sign[0]):02X}>", shortened(text, _LONGEST_LINE))

    def block(self, text: str) -> str:
        """Write lines as a comment."""
        opening, prefix, closing = self.comment
        lines = [f"{prefix} {line}".rstrip() if prefix else line for line in text.strip("\n").split("\n")]
        return "\n".join([f"{opening}{lines[0]}", *lines[1:], closing])

    def body(self, function: Function) -> Body:
        """Write a program, one statement per step.

        Sines and cosines of inputs are named by their angles, all others t1, t2, ...
        """
        names: dict[int, str] = {}

        def written(x: Any) -> str:
            return names[x.order] if isinstance(x, Expression) else self.number(float(x))

        statements: list[tuple[str, str]] = []
        for step in function.program.steps:
            if step.operation == "input":
                names[step.order] = step.arguments[0]
                continue
            first, *operands = map(written, step.arguments)
            name = f"t{len(statements) + 1}"
            if step.operation in self.operators:
                value = f"{first} {self.operators[step.operation]} {operands[0]}"
            elif step.operation == "negative":
                value = f"-{first}"
            elif step.operation == "sign":
                value = self.sign(first)
            else:
                value = f"{self.function(step.operation)}({first})"
                if first.isidentifier():
                    name = f"{step.operation}_{first}"
            names[step.order] = name
            statements.append((name, value))
        expressions = map(written, function.program.outputs)
        outputs = {output.name: [*islice(expressions, output.size)] for output in function.outputs}
        return Body(statements, outputs)

    def notes(self, subject: ExportInput) -> Sequence[str]:
        """Lines for the end of the header."""
        return ()

    def values(self, subject: ExportInput) -> dict[str, Any]:
        """Further values for the templates of this language."""
        return {"functions": [(function, self.body(function)) for function in subject.functions]}

    def texts(self, subject: ExportInput) -> dict[str, str]:
        """Write the files: texts by suffix."""
        values = {
            "given": subject,
            "name": subject.name,
            "constants": subject.constants,
            "header": "\n".join([*header(subject, self.foreign), *self.notes(subject)]),
        } | self.values(subject)
        templates = environment(self).get_template
        return {suffix: templates(template).render(values) for suffix, template in self.files.items()}


@cache
def environment(language: Language) -> Environment:
    """Read templates. Nothing is escaped: their values are already safe."""
    environment = Environment(
        loader=PackageLoader("gd_analyze.exporting"),
        undefined=StrictUndefined,
        autoescape=False,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    environment.filters |= {"block": language.block, "listed": language.listed, "number": language.number}
    return environment


class Matlab(Language):
    """A function file for MATLAB, Octave and Simulink; states are columns."""

    files: ClassVar = {".m": "matlab.m.jinja"}
    comment = ("", "%", "")
    operators: ClassVar = {"add": "+", "subtract": "-", "multiply": ".*", "divide": "./"}
    separator = "; "


class Python(Language):
    """A Python module that needs only NumPy, or a module with the same functions."""

    files: ClassVar = {".py": "python.py.jinja"}
    comment = ('"""', "", '"""\n')
    # The module with sin, cos and arrays, and the name under which it is imported.
    module: ClassVar[str] = "numpy"
    short: ClassVar[str] = "np"

    def function(self, name: str) -> str:
        """What sin or cos is called."""
        return f"{self.short}.{name}"

    def values(self, subject: ExportInput) -> dict[str, Any]:
        """The module's names."""
        return super().values(subject) | {"module": self.module, "short": self.short}


class Jax(Python):
    """The module of NumPy, for JAX: functions to compile, differentiate and map."""

    files: ClassVar = {"_jax.py": "python.py.jinja"}
    module, short = "jax.numpy", "jnp"


class Casadi(Python):
    """A casadi.Function for each function, for derivatives and code generation."""

    files: ClassVar = {"_casadi.py": "casadi.py.jinja"}
    module = short = "casadi"


class Sympy(Python):
    """Functions of SymPy's symbols or numbers, for expressions to derive, simplify and print."""

    files: ClassVar = {"_sympy.py": "sympy.py.jinja"}
    module = short = "sympy"
