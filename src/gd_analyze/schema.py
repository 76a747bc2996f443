"""Every variable a result may hold: name, dimensions, unit, equation and meaning, said once.

The same declaration validates a Dataset, documents it and is stored with it as attributes.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from gd_analyze.errors import StoreError

if TYPE_CHECKING:
    import xarray as xr

SCHEMA_VERSION = 1


@dataclass(frozen=True)
class Variable:
    """Declaration of one variable; `unit` is that of an arm of revolute joints."""

    name: str
    dims: tuple[str, ...]
    unit: str
    symbol: str
    equation: str
    meaning: str

    def attributes(self, mixed_units: bool = False) -> dict[str, str]:
        """Attributes stored with the variable; a sliding joint's rows are in N, m and kg instead."""
        mixed = mixed_units and any(dim.startswith("joint") for dim in self.dims)
        return {
            "units": f"{self.unit} (m, N for rows of sliding joints)" if mixed else self.unit,
            "symbol": self.symbol,
            "equation": self.equation,
            "long_name": self.meaning,
        }


def _declare(*rows: tuple[str, str, str, str, str, str]) -> dict[str, Variable]:
    return {
        name: Variable(name, tuple(dims.split()), unit, symbol, equation, meaning)
        for name, dims, unit, symbol, equation, meaning in rows
    }


DECOMPOSITION = _declare(
    ("q", "time joint", "rad", "q_i", "[FGL87] 3.4", "joint variables"),
    ("qd", "time joint", "rad/s", "qd_i", "[FGL87] 3.4", "joint rates"),
    ("qdd", "time joint", "rad/s^2", "qdd_i", "[FGL87] 3.4", "joint accelerations"),
    (
        "inertia",
        "time effect joint joint_j",
        "kg m^2",
        "D_ij",
        "[FGL87] Eq. (3.4-25)",
        "acceleration-related (inertia) matrix, by effect",
    ),
    (
        "coriolis_centrifugal",
        "time effect joint",
        "N m",
        "h_i",
        "[FGL87] Eqs. (3.4-26), (3.4-27)",
        "Coriolis and centrifugal vector, by effect",
    ),
    (
        "centrifugal",
        "time effect joint",
        "N m",
        "sum_j h_ijj qd_j^2",
        "[FGL87] Eqs. (3.4-26), (3.4-27)",
        "centrifugal share of h, by effect",
    ),
    (
        "coriolis",
        "time effect joint",
        "N m",
        "sum_{j != k} h_ijk qd_j qd_k",
        "[FGL87] Eqs. (3.4-26), (3.4-27)",
        "Coriolis share of h, by effect",
    ),
    (
        "coupling",
        "time effect joint joint_j joint_k",
        "kg m^2",
        "h_ijk",
        "[FGL87] Eqs. (3.4-26), (3.4-27)",
        "coefficients of h, symmetric in j and k, by effect",
    ),
    ("gravity_loading", "time joint", "N m", "c_i", "[FGL87] Eq. (3.4-28)", "gravity loading vector"),
    (
        "torque",
        "time joint",
        "N m",
        "tau_i",
        "[FGL87] Eq. (3.4-24)",
        "generalized torque, drive_torque included where it is given",
    ),
    (
        "drive_torque",
        "time joint",
        "N m",
        "J_i qdd_i",
        "outside the text's D",
        "torque that accelerates the drives, a separate contribution",
    ),
    (
        "inertia_by_link",
        "time effect link joint joint_j",
        "kg m^2",
        "D_ij of link s",
        "[FGL87] Eq. (3.4-25), one s",
        "what each link adds to D, by effect",
    ),
    (
        "coriolis_centrifugal_by_link",
        "time effect link joint",
        "N m",
        "h_i of link s",
        "[FGL87] Eqs. (3.4-26), (3.4-27), one s",
        "what each link adds to h, by effect",
    ),
    (
        "gravity_loading_by_link",
        "time link joint",
        "N m",
        "c_i of link s",
        "[FGL87] Eq. (3.4-28), one s",
        "what each link adds to c",
    ),
    (
        "coriolis_centrifugal_terms",
        "time term joint",
        "N m",
        "T1..T4, R1, R2",
        "[FGL87] Eqs. (3.4-26), (3.4-27)",
        "the text's terms of h, kept apart",
    ),
)

REQUIRED = (
    "q",
    "qd",
    "qdd",
    "inertia",
    "coriolis_centrifugal",
    "centrifugal",
    "coriolis",
    "gravity_loading",
    "torque",
)


def validate(
    dataset: xr.Dataset,
    declared: Mapping[str, Variable] = DECOMPOSITION,
    required: tuple[str, ...] = REQUIRED,
) -> None:
    """Check that a Dataset holds what is declared.

    Raises
    ------
    StoreError
        If a required variable is missing, or a variable is unknown or has other dimensions.
    """
    for name in required:
        if name not in dataset:
            raise StoreError(f"the dataset lacks {name}", expected=", ".join(required), found=_names(dataset))
    for key, array in dataset.data_vars.items():
        name = str(key)
        variable = declared.get(name)
        if variable is None:
            raise StoreError(f"{name} is not a variable of this schema", expected=", ".join(declared))
        if tuple(array.dims) != variable.dims:
            raise StoreError(
                f"{name} has other dimensions than declared",
                expected=str(variable.dims),
                found=str(tuple(array.dims)),
            )


def _names(dataset: Any) -> str:
    return ", ".join(str(name) for name in dataset.data_vars) or "no variables"
