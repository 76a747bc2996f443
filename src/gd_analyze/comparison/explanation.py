"""Where our counts differ from the text's, and why: sentences made from the numbers."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from gd_analyze.comparison.breakdown import Place, count_by_place
from gd_analyze.comparison.chain import generic_chain
from gd_analyze.comparison.costs import Cost, Growth
from gd_analyze.comparison.methods import METHODS
from gd_analyze.comparison.text_costs import text_costs
from gd_analyze.operations import OperationCount

Parts = Mapping[Place, OperationCount]


@dataclass(frozen=True)
class Explanation:
    """One method's count against the text's, at `n` joints of the generic chain."""

    method: str
    n: int
    sentence: str


def explanations(grown: Growth, n: int = 6) -> tuple[Explanation, ...]:
    """Explain every method's count at n joints.

    Parameters
    ----------
    grown
        Counts on the generic chain; `n` must be among its sizes.
    n
        Number of joints.
    """
    at = grown.sizes.index(n)
    told = []
    for name, costs in grown.costs.items():
        parts = count_by_place(METHODS[name], generic_chain(n))
        why = _WHY[name](parts, costs[at], grown, n)
        told.append(Explanation(name, n, f"{_against_text(name, costs[at], n)} {why}"))
    return tuple(told)


def multiplications(parts: Parts, **wanted: str) -> int:
    """Multiplications booked to the places whose attributes are as wanted."""
    return sum(count.multiplications for place, count in parts.items() if _is(place, wanted))


def operations(parts: Parts, **wanted: str) -> int:
    """Multiplications and additions booked to the places whose attributes are as wanted."""
    return sum(count.total for place, count in parts.items() if _is(place, wanted))


def _is(place: Place, wanted: Mapping[str, str]) -> bool:
    return all(getattr(place, name) == value for name, value in wanted.items())


def _against_text(name: str, cost: Cost, n: int) -> str:
    text = text_costs().of(name)
    executed, folded = cost.executed.total, cost.folded.total
    if text is None:
        return f"Not counted in the text; at n = {n} ours carries out {executed} operations, folded {folded}."
    stated = text.total(n)
    return (
        f"At n = {n} the text counts {stated} operations, ours carries out {executed} "
        f"({_percent(executed / stated)} of that), folded {folded} ({_percent(folded / stated)})."
    )


def _lagrange_euler(parts: Parts, cost: Cost, grown: Growth, n: int) -> str:
    traces = operations(parts, helper="_trace_of_product")
    traced = multiplications(parts, helper="_trace_of_product") // 16
    return (
        "The text's rows amount to four 4x4 products (256 multiplications) for each of its "
        f"{n * (n + 1) ** 2 * (n + 2) // 6} traces. Ours forms every derivative of a transform once, going "
        "outwards, and weights it with the link's pseudo-inertia once, so a trace takes 16; it does not use "
        f"the symmetry of D and of h's coefficients and takes {traced} traces, "
        f"{_percent(traces / cost.executed.total)} of its work. The zeros and ones of the 4x4 matrices are "
        "multiplied out by both; folding strikes them."
    )


def _recursive_lagrangian(parts: Parts, cost: Cost, grown: Growth, n: int) -> str:
    share = multiplications(parts, helper="_product") / cost.executed.multiplications
    return (
        f"Every link costs the same, but in whole 3x3 products: they are {_percent(share)} of its "
        "multiplications, where Newton-Euler has vector products. A rotation matrix carries nine numbers for "
        "three freedoms."
    )


def _newton_euler_base(parts: Parts, cost: Cost, grown: Growth, n: int) -> str:
    tensor = operations(parts, helper="_base_tensor")
    there = operations(parts, module="kinematics")
    return (
        f"Turning every inertia tensor into the base frame, R I Rᵀ, takes {tensor} of its operations "
        f"({_percent(tensor / cost.executed.total)}): what link frames save. Another {there} place axes and "
        "points in the base frame."
    )


def _newton_euler_link(parts: Parts, cost: Cost, grown: Growth, n: int) -> str:
    matrices = operations(parts, helper="_step")
    axes = operations(parts, target="out[i]")
    return (
        f"Making the rotation matrices from sines and cosines takes {matrices}, a row the text's table does "
        "not have. The joint's axis may have any direction in the link's frame: multiplying by its zeros and "
        f"ones, {axes} operations for the torques alone, is folded away where it is an axis of the frame."
    )


def _generalized_dalembert(parts: Parts, cost: Cost, grown: Growth, n: int) -> str:
    levers = operations(parts, target="velocity")
    return (
        "The equations are followed term by term and link by link, D, h and c each on their own: what the "
        f"joints do to the centres of mass is worked out anew in all three, {levers} operations "
        f"({_percent(levers / cost.executed.total)}), which folding shares. D is summed in full, not its "
        "upper triangle."
    )


def _composite_moments(parts: Parts, cost: Cost, grown: Growth, n: int) -> str:
    last = len(grown.sizes) - 1
    whole = grown.costs["generalized_dalembert"][last].executed.total
    mine = grown.costs["composite_moments"][last].executed.total
    return (
        "The text sums over links for every element; the moments of all links from joint m outwards are one "
        f"suffix sum, used by every element of row m. At n = {grown.sizes[last]} that takes "
        f"{_percent(mine / whole)} of the operations of the equations as written, and h comes from brackets "
        "of pairs of joints rather than from triples."
    )


_WHY: dict[str, Callable[[Parts, Cost, Growth, int], str]] = {
    "lagrange_euler": _lagrange_euler,
    "recursive_lagrangian": _recursive_lagrangian,
    "newton_euler_base": _newton_euler_base,
    "newton_euler_link": _newton_euler_link,
    "generalized_dalembert": _generalized_dalembert,
    "composite_moments": _composite_moments,
}


def _percent(share: float) -> str:
    return f"{100 * share:.0f} %"
