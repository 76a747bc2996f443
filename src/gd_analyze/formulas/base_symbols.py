"""Base parameters in symbols: which lengths, masses, centres and inertias make each.

A combination's coefficients are polynomials in the arm's lengths, of a degree that their units tell. They are
fitted to arms whose lengths differ by up to a tenth, of which there are more than a polynomial has terms, so
that a coefficient that is no polynomial is noticed.
"""

from __future__ import annotations

import itertools
import math
import warnings
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.dynamics.base_parameters import BaseParameters, base_parameters
from gd_analyze.errors import ArmError, argument
from gd_analyze.formulas.formula import NO_PIECES, Formula, Piece, Power, Product, Symbol
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.arm_numbers import with_numbers
from gd_analyze.robots.description import table_convention
from gd_analyze.robots.parts import entries_of

# Names of factors, sorted: () is 1, ("a2", "a2") the square of a2.
SymbolNames = tuple[str, ...]
SymbolPolynomial = Mapping[SymbolNames, float]

_LARGEST_CHANGE = 0.1
# Arms beyond those that the polynomial's terms need.
_MORE_ARMS = 8
# Share that fitted numbers are round-off below, and how near to a half they are one.
_ROUND_OFF = 1e-8
_MOST_LENGTHS = 20
_AXES = "xyz"


@dataclass(frozen=True)
class ArmLength:
    """A length of the arm: its symbol, and its name in arm files."""

    symbol: str  # "a2", "d4", "p3x"
    name: str  # "joint2.a", "joint3.xyz.x"
    number: float  # m


@dataclass(frozen=True)
class BaseSymbols:
    """Base parameters in symbols.

    Parameters
    ----------
    base
        The parameters with their numbers.
    combinations
        By parameter: polynomial in the lengths by kind and link (from 1) of each share.
    links
        Polynomials in masses, centres, inertias and lengths of the links' parameters that these name.
    values
        The arm's numbers by symbol, SI.
    """

    base: BaseParameters
    combinations: tuple[Mapping[tuple[str, int], SymbolPolynomial], ...]
    links: Mapping[tuple[str, int], SymbolPolynomial]
    values: Mapping[str, float]

    def formulas(self) -> Iterator[Formula]:
        """MX2 = mx2 + a2 m3..6, a line for each base parameter."""
        for parameter, shares in zip(self.base, self.combinations, strict=True):
            letters = parameter.symbol.removesuffix(str(parameter.link))
            pieces = list(_combined(shares))
            yield Formula(Symbol(letters, str(parameter.link)), tuple(pieces) or NO_PIECES)

    def definitions(self) -> Iterator[Formula]:
        """mx2 = m2 x2 + m2 a2, a line for each parameter of the links."""
        for (kind, link), polynomial in self.links.items():
            pieces = tuple(Piece(_product(weight, names)) for names, weight in polynomial.items())
            yield Formula(Symbol(kind, str(link)), pieces or NO_PIECES)


def base_symbols(base: BaseParameters) -> BaseSymbols:
    """Write base parameters in symbols; ArmError where they are no polynomials in a few lengths."""
    arm = base.arm
    lengths = _lengths(arm)
    factors, arms = _other_arms(base, lengths)
    combinations = []
    for i, parameter in enumerate(base):
        shares = {}
        for share in parameter.combination:
            degree = _degree(parameter.kind, arm, parameter.link) - _degree(share.kind, arm, share.link)
            values = [
                next((x.coefficient for x in other.parameters[i].combination if x[1:] == share[1:]), 0.0)
                for other in arms
            ]
            shares[share.kind, share.link] = _fitted(arm, factors, lengths, np.array(values), degree)
        combinations.append(shares)
    named = sorted({key for shares in combinations for key in shares}, key=lambda key: (key[1], key[0]))
    links: dict[tuple[str, int], SymbolPolynomial] = {}
    for link in range(1, arm.n_joints + 1):
        kinds = [kind for kind, of_link in named if of_link == link and kind not in ("m", "J")]
        if kinds:
            moments = _moments(base, link, factors, arms, lengths)
            links |= {(kind, link): moments[kind] for kind in kinds}
    symbols = {length.symbol: length.number for length in lengths} | _numbers(arm)
    polynomials = [*itertools.chain.from_iterable(x.values() for x in combinations), *links.values()]
    used = {name for polynomial in polynomials for names in polynomial for name in names}
    used |= {f"{kind}{link}" for kind, link in named if kind in ("m", "J")}
    numbers = {name: number for name, number in symbols.items() if name in used}
    return BaseSymbols(base, tuple(combinations), links, numbers)


def _lengths(arm: RobotArm) -> tuple[ArmLength, ...]:
    """Lengths that are not zero."""
    found = []
    if table_convention(arm) != "placement":
        for i, (row, joint) in enumerate(zip(arm.dh_table, arm.joints, strict=True), start=1):
            along = "d" if joint.kind == "revolute" else "l"
            found += [
                ArmLength(f"a{i}", f"joint{i}.a", row.a),
                ArmLength(f"{along}{i}", f"joint{i}.d", row.d),
            ]
    else:
        for i, (joint, link) in enumerate(zip(arm.joints, arm.links, strict=True), start=1):
            for axis, value in zip(_AXES, joint.placement.translation, strict=True):
                found.append(ArmLength(f"p{i}{axis}", f"joint{i}.xyz.{axis}", float(value)))
            for axis, value in zip(_AXES, link.frame.translation, strict=True):
                found.append(ArmLength(f"f{i}{axis}", f"link{i}.frame_xyz.{axis}", float(value)))
    if not arm.is_revolute[-1]:  # the frame of a last link that slides is at its centre of mass
        n, com = arm.n_joints, arm.links[-1].com.tolist()
        found += [
            ArmLength(f"{axis}{n}", f"link{n}.com.{axis}", x) for axis, x in zip(_AXES, com, strict=True)
        ]
    lengths = tuple(length for length in found if length.number)
    if len(lengths) > _MOST_LENGTHS:
        raise _unreadable(
            arm, f"{len(lengths)} lengths", f"at most {_MOST_LENGTHS} lengths that are not zero"
        )
    return lengths


def _other_arms(
    base: BaseParameters, lengths: Sequence[ArmLength]
) -> tuple[FloatArray, list[BaseParameters]]:
    """Arms with other lengths, (arms, lengths) in units of the arm's, and their base parameters."""
    count = math.comb(len(lengths) + 1, 2) + _MORE_ARMS
    rng = np.random.default_rng(0)
    factors = 1.0 + rng.uniform(-_LARGEST_CHANGE, _LARGEST_CHANGE, (count, len(lengths)))
    arms = []
    for row in factors:
        numbers = {x.name: x.number * factor for x, factor in zip(lengths, row.tolist(), strict=True)}
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of numbers that are in no file
            other = base_parameters(with_numbers(base.arm, numbers), base.drives)
        if [x.symbol for x in other] != [x.symbol for x in base]:
            raise _unreadable(base.arm, "other base parameters for other lengths")
        arms.append(other)
    return factors, arms


def _degree(kind: str, arm: RobotArm, link: int) -> int:
    """Power of lengths in a kind of parameter."""
    return (2 if arm.is_revolute[link - 1] else 0) if kind == "J" else len(kind) - 1


def _fitted(
    arm: RobotArm, factors: FloatArray, lengths: Sequence[ArmLength], values: FloatArray, degree: int
) -> SymbolPolynomial:
    """SymbolPolynomial in the lengths, all its terms of one degree, that has these values at all arms."""
    if degree < 0:
        raise _unreadable(arm, "a coefficient per length")
    terms = list(itertools.combinations_with_replacement(range(len(lengths)), degree))
    columns = np.array([np.prod(factors[:, list(term)], axis=1) for term in terms]).T.reshape(-1, len(terms))
    weights = np.linalg.lstsq(columns, values, rcond=None)[0]
    size = float(np.abs(values).max(initial=0.0))
    weights = np.where(np.abs(weights) > _ROUND_OFF * size, weights, 0.0)
    if np.abs(columns @ weights - values).max(initial=0.0) > _ROUND_OFF * size:
        raise _unreadable(arm, "a coefficient that is no sum of products of lengths")
    out = {}
    for term, weight in zip(terms, weights.tolist(), strict=True):
        if weight:
            number = weight / math.prod(lengths[k].number for k in term)
            near = round(2 * number) / 2
            number = near if abs(number - near) < _ROUND_OFF * max(abs(number), 1.0) else number
            out[tuple(sorted(lengths[k].symbol for k in term))] = number
    return out


def _moments(
    base: BaseParameters,
    link: int,
    factors: FloatArray,
    arms: Sequence[BaseParameters],
    lengths: Sequence[ArmLength],
) -> dict[str, SymbolPolynomial]:
    """First and second moments of a link in its frame of base parameters."""
    arm, s = base.arm, link - 1
    rotation = base.frames[s].rotation
    if any(np.abs(other.frames[s].rotation - rotation).max() > _ROUND_OFF for other in arms):
        raise _unreadable(arm, f"a frame of link {link} that turns with the lengths")
    places = np.array([other.frames[s].translation for other in arms])
    places = np.where(np.abs(places) > _ROUND_OFF * max(arm.reach, _ROUND_OFF), places, 0.0)
    source = arm.links[s]
    # Of the centre from that frame's origin, along the link's axes.
    centre = []
    for axis, (letter, number) in enumerate(zip(_AXES, source.com.tolist(), strict=True)):
        of_frame = _fitted(arm, factors, lengths, places[:, axis], 1)
        own: SymbolPolynomial = {(f"{letter}{link}",): 1.0} if number else {}
        centre.append(_sum([(1.0, own), (-1.0, of_frame)]))
    centre = [_sum(zip(rotation[:, a].tolist(), centre, strict=True)) for a in range(3)]
    second = _second_moments(link, source.inertia_com)
    mass: SymbolPolynomial = {(f"m{link}",): 1.0} if source.mass else {}
    out = {f"m{letter}": _times(mass, centre[a]) for a, letter in enumerate(_AXES)}
    for a, b in itertools.combinations_with_replacement(range(3), 2):
        turned = [(float(rotation[c, a] * rotation[d, b]), second[c][d]) for c, d in np.ndindex(3, 3)]
        steiner = _times(mass, _times(centre[a], centre[b]))
        out[f"P{_AXES[a]}{_AXES[b]}"] = _sum([*turned, (1.0, steiner)])
    return out


def _second_moments(link: int, inertia: FloatArray) -> list[list[SymbolPolynomial]]:
    """Second moments about the centre in terms of the inertia: Pxx = (Iyy + Izz - Ixx) / 2, Pxy = -Ixy."""
    known = {name: bool(value) for name, value in entries_of(inertia).items()}

    def symbol(a: int, b: int) -> SymbolPolynomial:
        name = "".join(sorted(_AXES[a] + _AXES[b]))
        return {(f"I{link}{name}",): 1.0} if known[name] else {}

    half_trace = _sum([(0.5, symbol(a, a)) for a in range(3)])
    return [[_sum([(float(a == b), half_trace), (-1.0, symbol(a, b))]) for b in range(3)] for a in range(3)]


def _numbers(arm: RobotArm) -> dict[str, float]:
    """Masses, centres, inertias and drives by symbol."""
    out = {}
    for i, link in enumerate(arm.links, start=1):
        out[f"m{i}"] = link.mass
        out |= {f"{axis}{i}": x for axis, x in zip(_AXES, link.com.tolist(), strict=True)}
        out |= {f"I{i}{name}": x for name, x in entries_of(link.inertia_com).items()}
        if arm.drives:
            out[f"J{i}"] = float(arm.drive_inertia[i - 1])
    return out


def _sum(terms: Iterable[tuple[float, SymbolPolynomial]]) -> SymbolPolynomial:
    """Sum of multiples of polynomials, without what cancels."""
    out: defaultdict[SymbolNames, float] = defaultdict(float)
    sizes: defaultdict[SymbolNames, float] = defaultdict(float)
    for factor, polynomial in terms:
        for names, weight in polynomial.items():
            out[names] += factor * weight
            sizes[names] += abs(factor * weight)
    return {names: weight for names, weight in out.items() if abs(weight) > _ROUND_OFF * sizes[names]}


def _times(first: SymbolPolynomial, second: SymbolPolynomial) -> SymbolPolynomial:
    pairs = itertools.product(first.items(), second.items())
    return _sum((1.0, {tuple(sorted(a + b)): x * y}) for (a, x), (b, y) in pairs)


def _combined(shares: Mapping[tuple[str, int], SymbolPolynomial]) -> Iterator[Piece]:
    """A combination's summands; masses with the same factor are written together, m3..6."""
    runs: list[tuple[SymbolNames, float, str, int, int]] = []
    ordered = sorted(shares.items(), key=lambda share: share[0][0] == "m")
    for (kind, link), polynomial in ordered:
        for names, weight in polynomial.items():
            before = next(
                (k for k, run in enumerate(runs) if run[:3] == (names, weight, kind) and run[4] == link - 1),
                None,
            )
            if kind == "m" and before is not None:
                runs[before] = (*runs[before][:4], link)
            else:
                runs.append((names, weight, kind, link, link))
    for names, weight, kind, start, end in runs:
        index = str(start) if start == end else f"{start}..{end}"
        factors = _product(weight, names)
        yield Piece(Product(weight, (*factors.powers, Power(Symbol(kind, index)))))


def _product(weight: float, names: SymbolNames) -> Product:
    """A product of symbols: masses and inertias first."""
    counted = sorted(Counter(names).items(), key=lambda entry: ("mI".find(entry[0][0]) % 3, entry[0]))
    return Product(weight, tuple(Power(Symbol(*parted_name(name)), exponent) for name, exponent in counted))


def parted_name(name: str) -> tuple[str, str]:
    """Letter and index of a symbol's name: I and 2xx."""
    return name[0], name[1:]


def _unreadable(arm: RobotArm, found: str, expected: str | None = None) -> ArmError:
    return ArmError(
        f"the base parameters of arm {arm.name} cannot be written in symbols",
        where=f"arm {arm.name}",
        expected=expected or "sums of products of lengths, as right angles between the joints give them",
        found=found,
        next_step=f"without {argument('symbolic')} they are written with numbers",
    )
