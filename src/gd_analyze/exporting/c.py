"""C99, a header and a source that need only libm; C++, a header for any scalar, and Eigen."""

from __future__ import annotations

import re
from collections.abc import Sequence
from functools import partial
from typing import Any, ClassVar, NamedTuple

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import UsageError
from gd_analyze.exporting.export_input import ExportInput, Function, Output
from gd_analyze.exporting.language import Body, Language
from gd_analyze.motions.states import States, states_in_box
from gd_analyze.operations.program import UFUNCS, Program, program_inputs
from gd_analyze.operations.trace import Expression, Trace, reached
from gd_analyze.text import number, rounded_up

# Angles of one state processed at once: whole vectors of processors.
_ANGLES_AT_ONCE = 4
# States processed at once: whole vectors of processors, little memory.
_STATES_AT_ONCE = 8
# States at which single precision is compared with double.
_DRAWN_STATES = 1000
# Factor on the difference found there, as other compilers round differently.
_COMPILER_FACTOR = 2.0


class SineCosine(NamedTuple):
    """Constants of a sine and cosine that compilers vectorize.

    An angle is reduced to |r| <= pi/2 by subtracting half turns, which change the sign alone, in two parts
    (Cody and Waite 1980). Sine and cosine are then polynomials, r + r z (s0 + s1 z + ..) and
    1 - z/2 + z z (c0 + c1 z + ..) with z = r r, whose largest error there is the least (Remez).
    """

    # pi; the first part has few bits, so that its product with the number of half turns is exact
    parts: tuple[float, float]
    largest: float  # largest angle for which this holds, rad; beyond it the C library's functions are called
    # even number of half turns, more than the largest angle has: casts round down what it is added to
    shift: float
    sine: tuple[float, ...]
    cosine: tuple[float, ...]


# 33 bits of pi, 19 of the half turns. The polynomials are off by 4e-17 and 2e-17.
DOUBLE = SineCosine(
    (3.1415926534682512, 1.2154201013012384e-10),
    1e6,
    400000.0,
    (
        -0.16666666666666666,
        0.008333333333333115,
        -0.00019841269841185965,
        2.755731920778734e-06,
        -2.5052106606669523e-08,
        1.6058927837871089e-10,
        -7.642712960186641e-13,
        2.7184966738811603e-15,
    ),
    (
        0.04166666666666583,
        -0.001388888888883005,
        2.4801587285783927e-05,
        -2.7557317068508415e-07,
        2.0876592592219086e-09,
        -1.1463635426822e-11,
        4.61613491167436e-14,
    ),
)
# 12 bits of pi, 12 of the half turns. The polynomials are off by 5e-9 and 4e-10, up to 1.001 pi/2, as what is
# added to `shift` loses digits.
FLOAT = SineCosine(
    (3.1416015625, -8.908910206761538e-06),
    8e3,
    2560.0,
    (-0.16666657020640438, 0.008333015418659486, -0.00019806479009350805, 2.599751862300517e-06),
    (0.04166665568664429, -0.0013888567263326144, 2.47691770554558e-05, -2.619115295461136e-07),
)


class Inside(NamedTuple):
    """Body of a function in strides: angles (first number, function, body) and the rest."""

    angles: list[tuple[int, Function, Body]]
    rest: Function
    body: Body
    n_angles: int


class C(Language):
    """C of double or single precision."""

    files: ClassVar = {".h": "c.h.jinja", ".c": "c.c.jinja"}
    comment = ("/*\n", " *", " */\n")
    scalars: ClassVar[tuple[str, ...]] = ("double", "float")

    @property
    def single(self) -> bool:
        """Whether numbers are of single precision."""
        return self.scalar == "float"

    def function(self, name: str) -> str:
        """Name of sin or cos."""
        return f"{name}f" if self.single else name

    def sign(self, value: str) -> str:
        """Write comparisons."""
        return f"({self.scalar})({value} > {self.number(0.0)} ? 1 : {value} < {self.number(0.0)} ? -1 : 0)"

    def number(self, value: float) -> str:
        """Write a number, in single precision with as few digits as possible; `UsageError` beyond it."""
        if not self.single:
            return super().number(value)
        if abs(value) > float(np.finfo(np.float32).max):
            raise UsageError(
                "a number of the model is too large for single precision",
                where="scalar",
                expected="magnitudes below 3.4e38",
                found=f"{value:g}",
                next_step="take double",
            )
        text = f"{float(str(np.float32(value)))!r}f"
        return text if value >= 0.0 else f"({text})"

    def listed(self, values: Sequence[float]) -> str:
        """Write the numbers of a constant."""
        return ", ".join(map(self.number, values))

    def notes(self, subject: ExportInput) -> Sequence[str]:
        """State the error of single precision, joint by joint."""
        if not self.single or subject.torque is None:
            return ()
        count = _DRAWN_STATES
        errors = single_precision_errors(subject.torque.program, states_in_box(subject.arm, count))
        most = ", ".join(number(rounded_up(_COMPILER_FACTOR * float(error))) for error in errors)
        return (
            f"Single precision: at {count} states drawn within the arm's limits it adds a torque error",
            f"of at most {most} (joint by joint) to the above.",
        )

    def values(self, subject: ExportInput) -> dict[str, Any]:
        """Functions in strides."""
        inside = [(function, self.one_by_one(function)) for function in subject.functions]
        constants, main = subject.constants, subject.functions[0]
        if self.single:
            constants = {key: constant.in_single for key, constant in constants.items()}
        many = self._inside(main.with_sums)
        return {
            "n": subject.n,
            "scalar": self.scalar,
            "to_scalar": f"({self.scalar})",
            "to_int": "(int)",
            "unused": "(void)",
            "restrict": "restrict",
            "within": "",
            "number": self.number,
            "zero": self.number(0.0),
            "constants": constants,
            "functions": inside,
            "trigonometric": many.n_angles or any(body.n_angles for _, body in inside),
            "block": _ANGLES_AT_ONCE,
            "lanes": _STATES_AT_ONCE,
            "main": main,
            "many": many,
            "declared": partial(self.declared, f"{subject.name}_"),
            "read": read,
            "sine_cosine": FLOAT if self.single else DOUBLE,
            "suffix": "f" if self.single else "",
        }

    def one_by_one(self, function: Function) -> Inside:
        """Body for one state: sums are used only if they save a whole block of angles."""
        candidates = map(self._inside, (function, function.with_sums))
        return min(candidates, key=lambda candidate: -(-candidate.n_angles // _ANGLES_AT_ONCE))

    def _inside(self, function: Function) -> Inside:
        groups, remainder = in_strides(function)
        angles, count = [], 0
        for group in groups:
            angles.append((count, group, self.body(group)))
            count += group.outputs[0].size
        return Inside(angles, remainder, self.body(remainder), count)

    def declared(self, prefix: str, function: Function, *, many: bool = False) -> str:
        """Declare a function of one state or, as pointers, of many."""
        inputs = [
            (f"const {self.scalar}", argument, function.width(argument)) for argument in function.arguments
        ]
        outputs = [(self.scalar, output.name, output.size) for output in function.outputs]
        words = [f"{kind} *{name}" if many else f"{kind} {name}[{n}]" for kind, name, n in inputs + outputs]
        if many:
            return f"void {prefix}{function.name}_many({', '.join(['size_t count', *words])})"
        return f"void {prefix}{function.name}({', '.join(words)})"


class Cpp(C):
    """C++11: templates on the scalar, so that types of automatic differentiation work, and Eigen."""

    files: ClassVar = {".hpp": "cpp.hpp.jinja"}
    scalars: ClassVar[tuple[str, ...]] = ("double",)

    def number(self, value: float) -> str:
        """Write a number of the scalar's type."""
        return f"T({value!r})"

    def sign(self, value: str) -> str:
        """Write comparisons."""
        return f"T({value} > T(0) ? 1 : {value} < T(0) ? -1 : 0)"

    def listed(self, values: Sequence[float]) -> str:
        """Write the numbers of a constant."""
        return ", ".join(map(repr, values))

    def values(self, subject: ExportInput) -> dict[str, Any]:
        """Names that differ in C++."""
        kits = [(kind, C(kind).number, kit) for kind, kit in (("double", DOUBLE), ("float", FLOAT))]
        words: dict[str, Any] = {
            "scalar": "T",
            "to_int": "int",
            "unused": "static_cast<void>",
            "restrict": "__restrict",
        }
        words |= {"own": kits, "within": "inside::", "declared": partial(self.declared, "")}
        return super().values(subject) | words

    def declared(self, prefix: str, function: Function, *, many: bool = False) -> str:
        """Declare a function of pointers to numbers of the scalar's type."""
        text = super().declared(prefix, function, many=many).replace(f"{self.scalar} ", "T ")
        return re.sub(r"(\w+)\[\d+\]", r"*\1", text)


def read(function: Function, *, many: bool) -> list[tuple[str, str]]:
    """Inputs, and the array elements that hold them; those of state l with `many`."""
    places = []
    for name, kind, index in function.inputs:
        array = {"sin": "sine", "cos": "cosine"}.get(kind)
        if array:
            places.append((name, f"{array}[{index} * lanes + l]" if many else f"{array}[{index}]"))
        else:
            places.append((name, f"{kind}[{index} * stride + l]" if many else f"{kind}[{index}]"))
    return places


def single_precision_errors(program: Program, states: States) -> FloatArray:
    """Largest difference of the torque between single and double precision, N m or N, shape (n,)."""
    inputs = program_inputs(states)
    single = {name: values.astype(np.float32) for name, values in inputs.items()}
    value = program.carried_out(single.__getitem__, lambda operation, *x: UFUNCS[operation](*x))
    exact = program.run(inputs)
    rough = np.array([np.broadcast_to(np.float32(value(x)), exact.shape[1:]) for x in program.outputs])
    return np.asarray(np.abs(rough - exact).max(axis=1))


def in_strides(function: Function) -> tuple[list[Function], Function]:
    """Split off a function's sines and cosines: angles, and the rest, given their sin1, cos1, ...

    Several angles are then processed at once, and each stride over many states is a loop without branches, so
    that compilers vectorize both. The angles are one function, unless there are sines of sines.
    """
    trace, values = Trace(), dict[int, Any]()
    pairs: dict[Expression, tuple[Any, Any]] = {}
    angles: list[Any] = []

    def of(x: Any) -> Any:
        return values[x.order] if isinstance(x, Expression) else x

    def pair(angle: Expression) -> tuple[Any, Any]:
        """Sine and cosine of an angle."""
        if angle not in pairs:
            angles.append(of(angle))
            sine, cosine = (trace.record("input", f"{name}{len(angles)}") for name in ("sin", "cos"))
            pairs[angle] = sine, cosine
        return pairs[angle]

    for step in function.program.steps:
        if step.operation in ("sin", "cos") and isinstance(step.arguments[0], Expression):
            values[step.order] = pair(step.arguments[0])[step.operation == "cos"]
        else:
            values[step.order] = trace.record(step.operation, *map(of, step.arguments))

    # Groups of angles: a new one begins if an angle depends on a sine of the current group.
    groups: list[list[Any]] = []
    before = 0
    for count, angle in enumerate(angles):
        needed = (trace.expressions[k] for k in reached([angle]))
        names = [step.arguments[0] for step in needed if step.operation == "input"]
        last = max((int(name[3:]) for name in names if name[:3] in ("sin", "cos")), default=0)
        if not groups or last > before:
            groups.append([])
            before = count
        groups[-1].append(angle)

    def part(name: str, outputs: tuple[Output, ...], values: list[Any]) -> Function:
        return Function(name, "", function.arguments, outputs, Program.of(trace, values))

    remainder = part(function.name, function.outputs, list(map(of, function.program.outputs)))
    return [part("angles", (Output("angles", (len(group),)),), group) for group in groups], remainder
