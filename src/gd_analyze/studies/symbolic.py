"""[FGL87]'s two-link arm with symbols for numbers, through the formulations' own code.

The array code runs on SymPy expressions as it runs on numbers. Its own constants (0.5, 1, 2) are floats, but
they, their products and their sums are exact in binary, so they convert to rationals without loss; the rods'
m l^2 / 12, which is not exact, is inserted afterwards.
"""

from __future__ import annotations

from dataclasses import dataclass
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from gd_analyze.dynamics.methods import METHODS, known_method
from gd_analyze.errors import UsageError
from gd_analyze.result import Equations, Result, Section, Value
from gd_analyze.robots.parts import Joint

if TYPE_CHECKING:
    import sympy


class ClosedForms(NamedTuple):
    """D (2, 2), h (2, 1) and c (2, 1) in the symbols m1, m2, l, g, theta1, theta2, thetad1, thetad2."""

    inertia: sympy.Matrix
    coriolis_centrifugal: sympy.Matrix
    gravity_loading: sympy.Matrix

    def entries(self) -> dict[str, str]:
        """Entries as text by their names: D12, h1, c2."""
        labels = ("D11", "D12", "D21", "D22", "h1", "h2", "c1", "c2")
        return dict(zip(labels, (str(entry) for matrix in self for entry in matrix), strict=True))


def two_link_closed_forms(method: str) -> ClosedForms:
    """Run one formulation on [FGL87]'s two rods, with masses, length and angles as symbols."""
    formulation = known_method(method)
    sp, s = _sympy(), _symbols()
    q = np.array([[_Angle(s[name])] for name in ("theta1", "theta2")], dtype=object)
    qd = np.array([[s["thetad1"]], [s["thetad2"]]], dtype=object)
    dynamics = formulation.dynamics(_symbolic_arm(s), q, qd)

    def exact(expression: Any) -> Any:
        rational = sp.sympify(expression).replace(lambda x: x.is_Float, lambda x: sp.Rational(float(x)))
        rods = {s[f"I{k}"]: s[f"m{k}"] * s["l"] ** 2 / 12 for k in (1, 2)}
        # Sums of angles stay in [FGL87]'s form: cos(theta1 + theta2), not its expansion.
        return sp.trigsimp(sp.expand(rational.subs(rods)))

    parts = (dynamics.inertia, dynamics.coriolis_centrifugal, dynamics.gravity_loading)
    matrices = (np.vectorize(exact, otypes=[object])(part).reshape(2, -1).tolist() for part in parts)
    return ClosedForms(*map(sp.Matrix, matrices))


def text_closed_forms() -> ClosedForms:
    """Closed forms derived by hand in [FGL87] sections 3.2.6, 3.3.7 and 3.4.2."""
    sp, symbols = _sympy(), _symbols()
    d12 = "m2*l**2/3 + m2*l**2*cos(theta2)/2"
    second = "m2*g*l*cos(theta1 + theta2)/2"
    parts = (
        [["m1*l**2/3 + 4*m2*l**2/3 + m2*cos(theta2)*l**2", d12], [d12, "m2*l**2/3"]],
        [
            ["-m2*sin(theta2)*l**2*thetad2**2/2 - m2*sin(theta2)*l**2*thetad1*thetad2"],
            ["m2*sin(theta2)*l**2*thetad1**2/2"],
        ],
        [[f"m1*g*l*cos(theta1)/2 + {second} + m2*g*l*cos(theta1)"], [second]],
    )
    return ClosedForms(
        *(sp.Matrix([[sp.sympify(x, locals=symbols) for x in row] for row in part]) for part in parts)
    )


def symbolic_result(robot: str) -> Result:
    """D, h and c of the two-link arm by every formulation, compared with [FGL87]."""
    if robot != "two_link":
        message = "only [FGL87]'s two-link arm has closed forms here"
        raise UsageError(message, where="symbolic", expected="two_link", found=robot)
    text = text_closed_forms()
    forms = {name: two_link_closed_forms(name) for name in METHODS}
    methods = {name: form.entries() | {"is_the_text's": same(form, text)} for name, form in forms.items()}
    # Formulations that end in the same expressions are listed together.
    titles_by_entries: dict[tuple[tuple[str, object], ...], list[str]] = {}
    for name, entries in methods.items():
        titles_by_entries.setdefault(tuple(entries.items()), []).append(METHODS[name].title)
    sections = []
    for (*labelled_entries, (_, is_text)), titles in titles_by_entries.items():
        equations = Equations(None, "", tuple(f"{label:3} = {entry}" for label, entry in labelled_entries))
        note = "As in FGL87." if is_text else "NOT as in FGL87."
        sections.append(Section(None, "; ".join(titles), (equations,), note=note))
    facts = (Value("text", text.entries()), Value("methods", methods))
    subtitle = "in symbols, by every formulation"
    return Result("Two-link planar arm", subtitle, facts=facts, parts=tuple(sections))


def same(first: ClosedForms, second: ClosedForms) -> bool:
    """Whether D, h and c are equal, whatever their form."""
    return all(_sympy().simplify(a - b).is_zero_matrix for a, b in zip(first, second, strict=True))


@dataclass(frozen=True)
class _Angle:
    """An angle: the formulations take only cosine and sine of angles and of their sums."""

    symbol: Any

    def __add__(self, other: _Angle) -> _Angle:
        return _Angle(self.symbol + other.symbol)

    def cos(self) -> Any:
        """Cosine, as `numpy.cos` takes it of objects."""
        return _sympy().cos(self.symbol)

    def sin(self) -> Any:
        """Sine, as `numpy.sin` takes it of objects."""
        return _sympy().sin(self.symbol)


class _SymbolicArm:
    """An arm of plain fields, hashable by identity so that its kinematics are cached."""

    def __init__(self, **fields: Any) -> None:
        self.__dict__.update(fields)


def _symbolic_arm(s: dict[str, Any]) -> Any:
    """The attributes of a `RobotArm` that formulations read; `RobotArm` itself requires numbers."""
    length = s["l"]
    com = np.array([-0.5 * length, 0.0, 0.0], dtype=object)
    frame = SimpleNamespace(rotation=np.eye(3), translation=np.array([length, 0.0, 0.0], dtype=object))
    across = [np.diag(np.array([0.0, s[f"I{k}"], s[f"I{k}"]], dtype=object)) for k in (1, 2)]
    return _SymbolicArm(
        mass=np.array([s["m1"], s["m2"]], dtype=object),
        com=np.array([com, com]),
        inertia_com=np.array(across),
        gravity_vector=np.array([0.0, -s["g"], 0.0], dtype=object),
        links=(SimpleNamespace(com=com, frame=frame),) * 2,
        joints=(Joint("1"), Joint("2")),
        is_revolute=(True, True),
        n_joints=2,
    )


def _symbols() -> dict[str, Any]:
    sp = _sympy()
    positive = {name: sp.Symbol(name, positive=True) for name in ("m1", "m2", "l", "g", "I1", "I2")}
    real = ("theta1", "theta2", "thetad1", "thetad2")
    return positive | {name: sp.Symbol(name, real=True) for name in real}


def _sympy() -> Any:
    try:
        import sympy
    except ImportError:
        message, step = "this needs SymPy, which is not installed", "pip install sympy"
        raise UsageError(message, next_step=step) from None
    return sympy
