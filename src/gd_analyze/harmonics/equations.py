"""The elements of an arm's dynamics as equations, with the origin of every term."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from gd_analyze.arrays import falling, members
from gd_analyze.dynamics.generalized_dalembert import EFFECTS
from gd_analyze.errors import ArmError, UsageError, argument
from gd_analyze.harmonics.absolute_velocities import AbsoluteVelocities
from gd_analyze.harmonics.element_products import ElementProducts, Products
from gd_analyze.harmonics.terms import Monomial
from gd_analyze.harmonics.transform import Harmonics, harmonics_behind
from gd_analyze.harmonics.trigonometric_polynomial import DEGREE
from gd_analyze.progress import NO_PROGRESS, Progress
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.bodies import MOST_JOINTS_WITH_TERMS
from gd_analyze.schema import unit_of
from gd_analyze.text import in_python, joined, parted

ElementIndices = tuple[int, ...]


# Most terms of one element if all are asked for: with more, as of eight joints with axes askew, all elements
# together have millions. D12 of seven such joints has 9 400 terms.
_MOST_TERMS = 20_000
# Quantity that gives an element's unit, by its letter.
_QUANTITIES = {"D": "inertia", "h": "christoffel", "c": "effort"}


@dataclass(frozen=True, slots=True)
class EquationTerm:
    """One term of an element.

    Its `share` is its largest value over that of the element's largest term. Sines and cosines count as 1, a
    prismatic variable as its farther limit, or 1 m if the arm states none.
    """

    coefficient: float  # SI
    factors: Monomial
    effect: str  # "translation" (gravity, too), "rotation" or "both"
    translation: float  # parts of the coefficient by effect
    rotation: float
    links: tuple[int, ...]  # links whose mass or inertia contributes, from 1
    share: float


@dataclass(frozen=True)
class Equation:
    """One element: "D12", "h112" or "c2" ("D1,10" with two digits), its unit, its terms, largest first.

    The unit is that of the element, not of the coefficient of a prismatic variable.
    """

    symbol: str
    unit: str
    terms: tuple[EquationTerm, ...]


def harmonics_for(arm: RobotArm, elements: Sequence[str] = ()) -> Harmonics:
    """Find only the harmonics that these elements need; labels and errors as for `equations`."""
    n = arm.n_joints
    requested = elements_named(elements, n)
    if not members(elements) and len(AbsoluteVelocities.of(arm).runs) > MOST_JOINTS_WITH_TERMS:
        raise ArmError(
            f"all equations of arm {arm.name} are too long to be written out",
            where=f"arm {arm.name}",
            expected=f"at most {MOST_JOINTS_WITH_TERMS} joints with axes that are not parallel",
            found=f"{n} joints",
            next_step=f"name elements, such as {argument('elements', f'D{joined((n - 1, n - 1))}')}; "
            "`gd-analyze simplify ROBOT --level element` takes any number of joints",
        )
    rows = (min(indices) for kind, indices, _ in requested if kind != "c")
    return harmonics_behind(arm, min(rows, default=arm.n_joints))


def each_equation(
    harmonics: Harmonics,
    elements: Sequence[str] = (),
    *,
    min_share: float = 0.0,
    progress: Progress = NO_PROGRESS,
) -> Iterator[Equation]:
    """Yield `equations` one by one.

    ArmError if all are asked for, and one of them has so many terms that writing all takes many minutes.
    """
    if not isinstance(min_share, int | float) or not 0.0 <= min_share <= 1.0:
        message, expected = "min_share is out of range", "a number of 0 to 1, such as 0.01 for 1 %"
        raise UsageError(message, where="min_share", expected=expected, found=in_python(min_share))
    most = math.inf if members(elements) else _MOST_TERMS
    products = ElementProducts(harmonics)
    named = elements_named(elements, harmonics.arm.n_joints)
    progress.stage("writing out", len(named))
    for kind, indices, by_itself in named:
        equation = _equation(harmonics, products, kind, indices, min_share, most)
        if equation.terms or by_itself:
            yield equation
        progress.advance()


def elements_named(labels: Sequence[str], n: int) -> list[tuple[str, ElementIndices, bool]]:
    """Elements named by labels: letter, joints from 0, and whether named individually."""
    names = [labels] if isinstance(labels, str) else members(labels)
    return [element for label in names or ("D", "h", "c") for element in _resolve(str(label), n)]


def _resolve(label: str, n: int) -> Iterator[tuple[str, ElementIndices, bool]]:
    match = re.fullmatch(r"([Dhc])(\d*|\d+(?:,\d+)+)", label, re.ASCII)
    full = {"D": 2, "h": 3, "c": 1}
    kind, digits = match.groups() if match else ("", "")
    lengths = {full.get(kind, 0)} | ({1} if kind == "h" else set())
    indices = parted(digits, n, lengths) if digits else ()
    if match is None or indices is None:
        last = [joined((n - 1,) * count) for count in range(4)]
        raise UsageError(
            f"there is no element {label!r}",
            where="elements",
            expected=f"D, h, c, D11 to D{last[2]}, h1 to h{n}, h111 to h{last[3]} or c1 to c{n}"
            + ("; commas separate indices of two digits" if n > 9 else ""),
            found=label,
            next_step="`gd-analyze equations ROBOT` prints all of D, h and c",
        )
    if len(indices) == full[kind]:
        # D and h_i are symmetric: indices are sorted, except the first of h.
        first = indices[:1] if kind == "h" else ()
        yield kind, (*first, *sorted(indices[len(first) :])), True
        return
    for i in indices or range(n):
        if kind == "c":
            yield kind, (i,), False
        elif kind == "D":
            yield from ((kind, (i, j), False) for j in range(i, n))
        else:
            pairs = itertools.combinations_with_replacement(range(n), 2)
            yield from ((kind, (i, j, k), False) for j, k in pairs)


def _equation(
    harmonics: Harmonics,
    products: ElementProducts,
    kind: str,
    indices: ElementIndices,
    min_share: float,
    most: float,
) -> Equation:
    arm = harmonics.arm
    unit = unit_of(_QUANTITIES[kind], *(arm.is_revolute[joint] for joint in indices))
    noise = harmonics.noise[1] if kind == "c" else harmonics.noise[0] * (DEGREE if kind == "h" else 1)
    of_kind: dict[str, Callable[..., Products]]
    of_kind = {"D": products.inertia, "h": products.christoffel, "c": products.gravity_loading}
    weights = of_kind[kind](*indices)
    if len(weights) > most:
        raise ArmError(
            f"all equations of arm {arm.name} are too long to be written out",
            where=f"arm {arm.name}",
            expected=f"elements of at most {most} terms",
            found=f"{kind}{joined(indices)} alone has {len(weights)}",
            next_step="give a `min_share` to named elements, such as "
            f"{argument('elements', f'{kind}{joined(indices)}')}",
        )
    sizes = {factors: abs(float(row[0])) * _largest_value(arm, factors) for factors, row in weights.items()}
    largest = max(sizes.values(), default=0.0)
    shares = {factors: size / largest for factors, size in sizes.items()}
    terms = [
        _term(factors, weights[factors].tolist(), noise, share)
        for factors, share in shares.items()
        if share >= min_share
    ]
    terms.sort(key=lambda term: (falling(term.share), term.factors))
    return Equation(kind + joined(indices), unit, tuple(terms))


def _term(factors: Monomial, row: list[float], noise: float, share: float) -> EquationTerm:
    coefficient, translation, rotation, *links = row
    acts = (abs(translation) > noise, abs(rotation) > noise)
    effect = "both" if all(acts) else EFFECTS[acts[1]]
    acting = tuple(s for s, value in enumerate(links, start=1) if abs(value) > noise)
    return EquationTerm(coefficient, factors, effect, translation, rotation, acting, share)


def _largest_value(arm: RobotArm, factors: Monomial) -> float:
    prismatic = (arm.joints[factor.joints[0]] for factor in factors if factor.kind == "power")
    return math.prod(max(abs(joint.lower or 0.0), abs(joint.upper or 0.0)) or 1.0 for joint in prismatic)
