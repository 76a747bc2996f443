"""Where our counts differ from the founding text's, and why."""

from __future__ import annotations

from gd_analyze.studies.costs import Growth
from gd_analyze.studies.text_costs import text_costs

# The sentences speak of so many joints of the generic chain.
N_JOINTS = 6

_WHY = {
    "lagrange_euler": (
        "FGL87's rows amount to four 4x4 products (256 multiplications) for each of its 392 traces. Ours "
        "forms every derivative of a transform once, going outwards, and weights it with the link's "
        "pseudo-inertia once, so a trace takes 16; it does not use the symmetry of D and of h's coefficients "
        "and takes 532 traces. The zeros and ones of the 4x4 matrices are multiplied out by both; folding "
        "strikes them."
    ),
    "recursive_lagrangian": (
        "Every link costs the same, but in eight whole 3x3 products, where Newton-Euler has vector products. "
        "A rotation matrix carries nine numbers for three freedoms."
    ),
    "newton_euler_base": (
        "Every inertia tensor is turned into the base frame, R I Rᵀ: what link frames save. Axes and points "
        "are placed in the base frame first."
    ),
    "newton_euler_link": (
        "Ours makes the rotation matrices from sines and cosines, a row FGL87's table does not have. The "
        "joint's axis may have any direction in the link's frame: multiplying by its zeros and ones is "
        "folded away where it is an axis of the frame."
    ),
    "newton_euler_regrouped": (
        "Frames stand on the joints' axes, and a link that turns keeps seven of its ten parameters, as the "
        "others act on the link before. Executed it multiplies whole matrices by zeros that are known "
        "beforehand; folding strikes them, and what is left is the least of all."
    ),
    "generalized_dalembert": (
        "The equations are followed term by term and link by link, D, h and c each on their own: what the "
        "joints do to the centres of mass is worked out anew in all three, which folding shares. D is summed "
        "in full, not its upper triangle."
    ),
    "composite_moments": (
        "FGL87 sums over links for every element; the moments of all links from joint m outwards are one "
        "suffix sum, used by every element of row m, and h comes from brackets of pairs of joints rather "
        "than from triples."
    ),
}


def explanation(method: str, grown: Growth) -> str:
    """Set a method's count beside FGL87's, and say why they differ; `grown` must have `N_JOINTS`."""
    cost = grown.costs[method][grown.sizes.index(N_JOINTS)]
    executed, folded = cost.executed.total, cost.folded.total
    stated = text_costs().of(method)
    if stated is None:
        counted = (
            f"Not counted in the founding text; at n = {N_JOINTS} ours carries out {executed} operations, "
            f"folded {folded}."
        )
    else:
        total = stated.at(N_JOINTS).total
        counted = (
            f"At n = {N_JOINTS} the founding text counts {total} operations, ours carries out {executed} "
            f"({100 * executed / total:.0f} % of that), folded {folded} ({100 * folded / total:.0f} %)."
        )
    return f"{counted} {_WHY[method]}"
