"""Exact elements of D, h and c with the arm's numbers as symbols, compared with the numeric ones.

D comes from the array code of the composite moments, run on symbols; h and c by exact differentiation of D
and of the potential energy, as for `Harmonics`. D_ij, i <= j, depends on the joints behind i only, so that it
is found for the arm from joint i on.
"""

from __future__ import annotations

import itertools
import math
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from gd_analyze.arrays import FloatArray, falling
from gd_analyze.dynamics import composite_moments as composite
from gd_analyze.dynamics.arm_dynamics import ArmDynamics
from gd_analyze.dynamics.generalized_dalembert import EFFECTS
from gd_analyze.dynamics.kinematics import solve_kinematics
from gd_analyze.errors import ArmError, GdAnalyzeError, UsageError
from gd_analyze.harmonics.absolute_velocities import AbsoluteVelocities
from gd_analyze.harmonics.arm_symbols import ArmSymbol, ArmSymbols
from gd_analyze.harmonics.equations import ElementIndices, elements_named
from gd_analyze.harmonics.products import to_products
from gd_analyze.harmonics.symbolic_number import (
    MOST_SYMBOLIC_TERMS,
    SymbolicNumber,
    TooManySymbolsError,
    digits_of,
)
from gd_analyze.harmonics.terms import Monomial
from gd_analyze.harmonics.transform import round_off_cut
from gd_analyze.harmonics.trigonometric_polynomial import DEGREE, TrigonometricPolynomial
from gd_analyze.progress import NO_PROGRESS, Progress
from gd_analyze.robots.arm import RobotArm
from gd_analyze.text import joined, thousands

# Joints up to which all elements are written; D11 of five has more terms than a page has lines.
MOST_JOINTS = 4
# Random states at which every element is compared: equal functions agree at all, different ones at none.
_COMPARED_STATES = 8


@dataclass(frozen=True)
class SymbolicTerm:
    """A coefficient times powers of the arm's symbols and of sines, cosines and joint variables.

    Joints in the factors count from 0, the constant angles behind them, in the order of
    `SymbolicEquations.angles`.
    """

    coefficient: float  # a sum of fractions whose denominators are powers of 2; exact
    symbols: tuple[tuple[ArmSymbol, int], ...]  # with their exponents
    factors: Monomial

    @cached_property
    def number(self) -> float:
        """Coefficient and symbols multiplied, with the arm's numbers."""
        powers = (symbol.number**exponent for symbol, exponent in self.symbols)
        return math.prod(powers, start=self.coefficient)


@dataclass(frozen=True)
class SymbolicElement:
    """One effect of an element "D12" or "h112", or "c2"."""

    label: str
    effect: str  # "translation" or "rotation"; "" for gravity
    terms: tuple[SymbolicTerm, ...]  # grouped by factors, the largest group first


@dataclass(frozen=True)
class SymbolicEquations:
    """Elements in symbols, and all symbols that are in them."""

    arm: RobotArm
    elements: tuple[SymbolicElement, ...]
    symbols: tuple[ArmSymbol, ...]
    angles: tuple[ArmSymbol, ...]  # constant angles, which are among the symbols, too
    error: float  # largest difference from the numeric decomposition over what round-off explains

    @property
    def n_terms(self) -> int:
        """Number of terms."""
        return sum(len(element.terms) for element in self.elements)


class DifferentEquationsError(GdAnalyzeError):
    """Equations in symbols that differ from the numeric decomposition: a fault of gd-analyze."""


def symbolic_equations(
    arm: RobotArm, elements: Sequence[str] = (), *, progress: Progress = NO_PROGRESS
) -> SymbolicEquations:
    """Find elements of D, h_ijk and c with the arm's numbers as symbols.

    Parameters
    ----------
    arm
        A serial arm.
    elements
        Labels as for `equations`; by default all, of arms of up to `MOST_JOINTS` joints.
    progress
        Told the elements done.

    Returns
    -------
    SymbolicEquations
        Compared with the numeric decomposition at random states.

    Raises
    ------
    UsageError
        If a label names no element, or the arm is too long for all of them.
    ArmError
        If an element has too many terms.
    DifferentEquationsError
        If the result is wrong.
    """
    if not elements and arm.n_joints > MOST_JOINTS:
        raise UsageError(
            f"all equations of arm {arm.name} are too long to be written in symbols",
            where="symbolic",
            expected=f"at most {MOST_JOINTS} joints, or elements",
            found=f"{arm.n_joints} joints",
            next_step="name elements, such as `elements=['D12', 'c2']`",
        )
    source = _Source(arm)
    out: list[SymbolicElement] = []
    worst = 0.0
    named = elements_named(elements, arm.n_joints)
    progress.stage("deriving", len(named))
    for kind, indices, by_itself in named:
        label = kind + joined(indices)
        try:
            effects = source.element(kind, indices)
            written = [source.terms(number) for number in effects]
        except TooManySymbolsError:
            raise ArmError(
                f"{label} of arm {arm.name} is too long to be written in symbols",
                where=f"arm {arm.name}",
                expected=f"at most {thousands(MOST_SYMBOLIC_TERMS)} terms on the way",
                found=f"{label} of {arm.n_joints} joints",
                next_step=f"elements of outer joints are shorter, such as "
                f"D{joined((arm.n_joints - 1,) * 2)}, and so are all with numbers",
            ) from None
        worst = max(worst, source.compare(kind, indices, written))
        names = EFFECTS if len(written) > 1 else ("",)
        if by_itself or any(written):
            out += [
                SymbolicElement(label, effect, terms) for effect, terms in zip(names, written, strict=True)
            ]
        progress.advance()
    used = {symbol for element in out for term in element.terms for symbol, _ in term.symbols}
    used |= {
        source.used_angles[joint - arm.n_joints]
        for element in out
        for term in element.terms
        for factor in term.factors
        for joint in factor.joints
        if joint >= arm.n_joints
    }
    ordered = tuple(symbol for symbol in source.symbols.used if symbol in used)
    return SymbolicEquations(arm, tuple(out), ordered, source.used_angles, worst)


class _Source:
    """Numbers, terms and comparisons of one arm's elements."""

    def __init__(self, arm: RobotArm) -> None:
        self.arm, self.n = arm, arm.n_joints
        self.symbols = ArmSymbols(arm)
        numbered = [(k, angle) for k, angle in enumerate(self.symbols.angles) if angle is not None]
        self.used_angles = tuple(angle for _, angle in numbered)
        # The joints, then the constant angles that the arm has.
        self._columns = [*range(self.n), *(self.n + k for k, _ in numbered)]
        self._is_revolute = np.array([*arm.is_revolute, *(True for _ in numbered)])
        of_joints = AbsoluteVelocities.of(arm)
        runs = (*of_joints.runs, *((self.n + k,) for k in range(len(numbered))))
        self._velocities = AbsoluteVelocities(runs, (*of_joints.signs, *(1 for _ in numbered)))
        self._rows: dict[int, Any] = {}
        rng = np.random.default_rng(0)
        self._q = rng.uniform(-np.pi, np.pi, (_COMPARED_STATES, self.n))
        # The expected values: D, h_ijk and c by effect.
        dynamics = ArmDynamics(arm)
        self._numeric = {
            "D": dynamics.inertia(self._q, by_effect=True, drives=False),
            "h": dynamics.christoffel(self._q, by_effect=True),
            "c": dynamics.gravity_loading(self._q)[:, None],
        }

    def element(self, kind: str, indices: ElementIndices) -> list[SymbolicNumber]:
        """An element by effect; gravity has one."""
        if kind == "c":
            return [self._derivative(self._potential, indices[0])]
        if kind == "D":
            return list(self._inertia(*indices))
        i, j, k = indices
        slopes = [
            [self._derivative(part, by) for part in self._inertia(a, b)]
            for a, b, by in ((i, j, k), (i, k, j), (j, k, i))
        ]
        return [0.5 * (first + second - third) for first, second, third in zip(*slopes, strict=True)]

    def _inertia(self, i: int, j: int) -> tuple[SymbolicNumber, SymbolicNumber]:
        first, last = sorted((i, j))
        if first not in self._rows:
            arm, q = self.symbols.behind(first)
            moments = composite.composite_moments(arm, solve_kinematics(arm, q))
            self._rows[first] = composite.inertia(moments)[:, 0, :, 0]
        translation, rotation = self._rows[first][:, last - first]
        return _number(translation), _number(rotation)

    @cached_property
    def _potential(self) -> SymbolicNumber:
        arm, q = self.symbols.whole()
        positions = solve_kinematics(arm, q).com_positions
        return _number(-np.einsum("s,a,san->n", arm.mass, self.symbols.gravity, positions)[0])

    def _derivative(self, number: SymbolicNumber, joint: int) -> SymbolicNumber:
        return number.derivative(joint, self.arm.is_revolute[joint])

    def terms(self, number: SymbolicNumber) -> tuple[SymbolicTerm, ...]:
        """Write a number as products of sines and cosines, symbols grouped by these."""
        # Harmonics by the powers of symbols before them.
        harmonics: dict[int, dict[tuple[int, ...], complex]] = defaultdict(dict)
        for key, coefficient in number.terms.items():
            multiples, of_symbols = digits_of(key, self.n + len(self.symbols.angles))
            harmonics[of_symbols][tuple(multiples[column] for column in self._columns)] = coefficient
        groups: dict[Monomial, list[SymbolicTerm]] = defaultdict(list)
        for of_symbols, polynomial in harmonics.items():
            digits, _ = digits_of(of_symbols, len(self.symbols.lengths_and_masses))
            pairs = zip(self.symbols.lengths_and_masses, digits, strict=True)
            powers = tuple((symbol, exponent) for symbol, exponent in pairs if exponent)
            for factors, (weight,) in to_products(self._polynomial(polynomial), self._velocities).items():
                if weight:
                    groups[factors].append(SymbolicTerm(float(weight), powers, factors))
        for terms in groups.values():
            terms.sort(key=lambda term: falling(term.number))
        # The largest group first, as the arm's numbers have it.
        ordered = sorted(groups.values(), key=lambda terms: falling(sum(abs(term.number) for term in terms)))
        return tuple(itertools.chain.from_iterable(ordered))

    def _polynomial(self, harmonics: dict[tuple[int, ...], complex]) -> TrigonometricPolynomial:
        """One polynomial, of each pair m and -m the lexically larger, with both coefficients."""
        terms: dict[tuple[int, ...], complex] = {}
        for multiples, coefficient in harmonics.items():
            angles = [m for m, revolute in zip(multiples, self._is_revolute, strict=True) if revolute]
            leading = next(filter(None, angles), 0)
            if leading >= 0:
                terms[multiples] = 2 * coefficient if leading else coefficient
        return TrigonometricPolynomial(
            tuple(map(bool, ~self._is_revolute)),
            np.array([*terms], dtype=np.int64).reshape(len(terms), len(self._columns)),
            np.array([[*terms.values()]], dtype=complex),
        )

    def compare(
        self, kind: str, indices: ElementIndices, effects: Sequence[tuple[SymbolicTerm, ...]]
    ) -> float:
        """Largest difference from the decomposition over what round-off explains, at random states."""
        of_angles = np.array([angle.number for angle in self.used_angles])
        variables = np.concatenate(
            [self._q.T, np.broadcast_to(of_angles[:, None], (len(of_angles), _COMPARED_STATES))]
        )
        worst = 0.0
        for effect, terms in enumerate(effects):
            values, sizes = np.zeros(_COMPARED_STATES), np.zeros(_COMPARED_STATES)
            for term in terms:
                value = term.number * _product(term.factors, variables)
                values, sizes = values + value, sizes + np.abs(value)
            place: tuple[Any, ...] = (slice(None), effect, *indices)
            expected = self._numeric[kind][place]
            allowed = self._allowed(kind, len(terms), sizes)
            worst = max(worst, float((np.abs(values - expected) / allowed).max()))
        if not worst <= 1.0:
            label = kind + joined(indices)
            raise DifferentEquationsError(
                f"internal error: {label} in symbols differs from the numeric decomposition",
                where=f"arm {self.arm.name}",
                found=f"{worst:.3g} times what round-off explains",
                next_step="nothing was written; please report it with the arm's file",
            )
        return worst

    def _allowed(self, kind: str, n_terms: int, sizes: FloatArray) -> FloatArray:
        """What round-off explains of a difference, with a factor of 4.

        A term has some 20 roundings (its powers and factors, and arguments of up to some 10 rad), their
        sum one each. The decomposition is as exact as for `Harmonics`; for h it adds three slopes. A
        rotation that is orthonormal up to a deviation changes D and the energy by that share.
        """
        eps = float(np.finfo(float).eps)
        of_inertia, of_potential = round_off_cut(self.arm)
        of_numeric = {"D": of_inertia, "h": 2 * DEGREE * of_inertia, "c": of_potential}[kind]
        tiny = float(np.finfo(float).tiny)
        rotations = [joint.placement.rotation for joint in self.arm.joints]
        rotations += [link.frame.rotation for link in self.arm.links]
        deviation = sum(float(np.abs(rotation.T @ rotation - np.eye(3)).sum()) for rotation in rotations)
        of_rotations = of_numeric * deviation / eps
        return 4 * ((20 + n_terms) * eps * sizes + of_numeric + of_rotations) + tiny


def _product(factors: Monomial, variables: FloatArray) -> FloatArray:
    """Product of sines, cosines and distances at variables (n, K)."""
    out = np.ones(variables.shape[1])
    for factor in factors:
        argument = np.array(factor.multiples, dtype=float) @ variables
        out *= {"cos": np.cos, "sin": np.sin, "power": np.positive}[factor.kind](argument)
    return out


def _number(value: Any) -> SymbolicNumber:
    """A result of the array code; plain numbers are its zeros."""
    return (
        value if isinstance(value, SymbolicNumber) else SymbolicNumber({0: complex(value)} if value else {})
    )


def each_group(element: SymbolicElement) -> Iterator[tuple[Monomial, tuple[SymbolicTerm, ...]]]:
    """Terms with the same factors."""
    for factors, terms in itertools.groupby(element.terms, key=lambda term: term.factors):
        yield factors, tuple(terms)
