"""Elements of D, h and c: their labels, parts by effect, and the torque they make."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from gd_analyze.arrays import Array, FloatArray
from gd_analyze.text import joined


@dataclass(frozen=True)
class Element:
    """One element of D (i <= j), h or c; joints count from 0 here, from 1 in its label."""

    quantity: str
    i: int
    j: int | None = None

    @property
    def label(self) -> str:
        """D12, h3, c2."""
        symbol = {"inertia": "D", "coriolis_centrifugal": "h", "gravity_loading": "c"}[self.quantity]
        return symbol + joined((self.i,) if self.j is None else (self.i, self.j))

    def parts(self, quantities: Mapping[Any, Any]) -> FloatArray:
        """Translational and rotational part at every state, shape (2, N); gravity is translation.

        `quantities` is what `decompose` gave, or `decompose_states` for states of shape (N, n).
        """
        if self.quantity == "gravity_loading":
            values = np.asarray(quantities["gravity_loading"])[:, self.i]
            return np.stack([values, np.zeros_like(values)])
        index: Any = (self.i,) if self.j is None else (self.i, self.j)
        array: Array = np.asarray(quantities[self.quantity])[(slice(None), slice(None), *index)]
        return array.T

    def torque_factors(self, qdd: FloatArray) -> dict[int, FloatArray | float]:
        """Factors that turn the element into its torque at each joint it acts on."""
        if self.j is None:
            return {self.i: 1.0}
        return {self.i: qdd[:, self.j], self.j: qdd[:, self.i]}


def elements(n_joints: int) -> tuple[Element, ...]:
    """Upper triangle of D, then h, then c."""
    pairs = [Element("inertia", i, j) for i in range(n_joints) for j in range(i, n_joints)]
    vectors = [
        Element(name, i) for name in ("coriolis_centrifugal", "gravity_loading") for i in range(n_joints)
    ]
    return (*pairs, *vectors)
