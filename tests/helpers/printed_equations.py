"""Terms of printed equations: by element, velocities or acceleration, and product of sines and cosines."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Mapping

import numpy as np

import gd_analyze as gd
from gd_analyze.arrays import FloatArray
from gd_analyze.formulas.formula import CircularFunction, Formula, Power
from gd_analyze.formulas.writing import powers
from gd_analyze.harmonics.terms import Factor, Monomial
from gd_analyze.report.budget import summands
from gd_analyze.types import RobotArm, States

# Element such as "D12" or "h2", velocities with their exponents, and factors.
Printed = tuple[str, frozenset[tuple[str, int]], tuple[Power, ...]]


def terms_of_model(formulas: Iterable[Formula]) -> dict[Printed, float]:
    """Coefficients of a model's printed terms; the drives stand apart, and are left out."""
    out = {}
    for formula in formulas:
        element = f"{formula.left.letter}{formula.left.index}"
        for factors, velocities, weight in summands(formula):
            moving = frozenset((power.base.index, power.exponent) for power in velocities)
            if formula.left.letter != "J":
                out[element, moving, factors] = weight
    return out


def terms_of_equations(arm: RobotArm) -> dict[Printed, float]:
    """The same of an arm's exact equations, h_ijk and h_ikj as one term of h_i."""
    out = {}
    for equation in gd.equations(arm):
        kind, index = equation.symbol[0], equation.symbol[1:]
        i, *pair = index.split(",") if "," in index else index
        moving = Counter(pair) if kind == "h" else Counter()
        element = f"h{i}" if kind == "h" else equation.symbol
        for term in equation.terms:
            place = element, frozenset(moving.items()), powers(term.factors)
            out[place] = len(moving) * term.coefficient if len(moving) == 2 else term.coefficient
    return out


def without_form(products: Collection[Monomial]) -> list[Monomial]:
    """Products of an element that one form of squares has not: of 1, C^2, S^2, cos 2a only 1 and C^2 meet."""
    out = []
    for product in products:
        for factor in dict.fromkeys(product):
            doubled = tuple(2 * multiple for multiple in factor.multiples)
            is_double = factor.kind != "power" and not any(multiple % 2 for multiple in factor.multiples)
            angle = tuple(multiple // 2 for multiple in factor.multiples) if is_double else factor.multiples
            own = (factor,) * product.count(factor)
            beside = tuple(other for other in product if other != factor)
            cosine, sine = Factor("cos", angle), Factor("sin", angle)
            alike = [(), (cosine, cosine), (sine, sine), (Factor("cos", doubled),)]
            if is_double:
                alike[3] = own
            if is_double and factor.kind == "sin":
                out.append(product)
            elif own in alike[2:]:
                others = (tuple(sorted(beside + other)) for other in alike if other != own)
                out += [other for other in others if other in products]
    return out


def torque_of(terms: Mapping[Printed, float], drives: FloatArray, states: States) -> tuple[FloatArray, float]:
    """Torque (N, n) that printed terms and the drives' inertia give, and the largest magnitude of a summand.

    D is symmetric where D21 is not printed; joints have one digit.
    """
    q, qd, qdd = (array.T for array in states.arrays)
    out, largest = np.array(drives)[:, None] * qdd, 0.0
    for (element, moving, factors), weight in terms.items():
        rows = [int(digit) - 1 for digit in element[1:]]
        value = weight * np.prod([_value(power, q) for power in factors], axis=0)
        for joint, exponent in moving:
            value = value * qd[int(joint) - 1] ** exponent
        pairs = [(rows[0], None)] if element[0] in "hc" else [(rows[0], rows[1])]
        if element[0] == "D" and rows[0] != rows[1]:
            assert rows[0] < rows[1], "a symmetric D prints its upper triangle"
            pairs.append((rows[1], rows[0]))
        for row, accelerated in pairs:
            summand = value if accelerated is None else value * qdd[accelerated]
            out[row] += summand
            largest = max(largest, float(np.abs(summand).max(initial=0.0)))
    return out.T, largest


def _value(power: Power, q: FloatArray) -> FloatArray:
    base, exponent = power
    if isinstance(base, CircularFunction):
        argument = sum(weight * q[int(powers[0].base.index) - 1] for weight, powers in base.argument)
        return {"cos": np.cos, "sin": np.sin}[base.name](argument) ** exponent
    argument = sum(q[int(digit) - 1] for digit in base.index)
    return {"C": np.cos, "S": np.sin, "d": lambda x: x}[base.letter](argument) ** exponent
