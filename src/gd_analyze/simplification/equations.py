"""The equations of an arm, exact, or of a model."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import overload

from gd_analyze.arguments import several
from gd_analyze.errors import UsageError
from gd_analyze.formulas.languages import Written
from gd_analyze.formulas.results import WrittenElements
from gd_analyze.harmonics.equations import each_equation, harmonics_for
from gd_analyze.harmonics.transform import Harmonics
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.catalogue import arm_with_masses
from gd_analyze.simplification.model import SimplifiedModel


@overload
def equations(
    dynamics: SimplifiedModel, elements: str | Sequence[str] = (), *, min_share: float = 0.0
) -> Written: ...
@overload
def equations(
    dynamics: Harmonics | RobotArm | str | Path,
    elements: str | Sequence[str] = (),
    *,
    min_share: float = 0.0,
) -> WrittenElements: ...
def equations(
    dynamics: SimplifiedModel | Harmonics | RobotArm | str | Path,
    elements: str | Sequence[str] = (),
    *,
    min_share: float = 0.0,
) -> Written | WrittenElements:
    """Find the equations of elements: of a model, or the exact ones of an arm.

    Parameters
    ----------
    dynamics
        A model: its D, J (drives), h and c, as `SimplifiedModel.equations`. Or an arm, the name of a built-in
        one, the path of its file, or its exact dynamics: its D, Christoffel symbols h_ijk and c.
    elements
        Labels: "D12", "h112", "c2"; "h1" for all nonzero h_1jk (j <= k), or for h_1 of a model; "D", "h", "c"
        for all nonzero elements of a kind. By default all. Commas separate indices of two digits: "D1,10".
    min_share
        Leave out terms below this share of the element's largest term; of exact equations.

    Returns
    -------
    Written, WrittenElements
        Equations in kg, m, s and rad, which print as text and, in a notebook, as mathematics. Exact ones are
        a tuple of `Equation` in the given order; a zero element named by all its indices has no terms.

    Raises
    ------
    UsageError
        If a label does not name an element of the arm, or that of a model which has no such term.
    ModelError
        If the model's level has no terms.

    Examples
    --------
    >>> import gd_analyze as gd
    >>> print(gd.equations("two_link", ["D12", "h1", "c1"]))
    D12 = 0.5 C2 + 0.333
    h112 = -0.5 S2
    h122 = -0.5 S2
    c1 = 19.6 C1 + 4.9 C12
    """
    elements = several(elements)
    if isinstance(dynamics, SimplifiedModel):
        if min_share:
            message = "a model has its terms already"
            raise UsageError(message, where="min_share", expected="an arm, or no share")
        return _of_model(dynamics, elements)
    if not isinstance(dynamics, Harmonics):
        dynamics = harmonics_for(arm_with_masses(dynamics), elements)
    return WrittenElements(each_equation(dynamics, elements, min_share=min_share))


def _of_model(model: SimplifiedModel, elements: Sequence[str]) -> Written:
    """Those elements of a model's equations that are asked for, and what its factors mean."""
    written = model.equations
    by_label = {f"{formula.left.letter}{formula.left.index}": formula for formula in written.formulas}
    chosen = []
    for name in elements:
        labels = [label for label in by_label if label == name or label[0] == name]
        if not labels:
            message, expected = "the model has no such element", ", ".join(by_label)
            raise UsageError(message, where="elements", expected=expected, found=name)
        chosen += [by_label[label] for label in labels]
    return Written(tuple(chosen), written.legend) if elements else written
