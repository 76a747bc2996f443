"""Results in one HDF5 file, a group per concept, readable by plain xarray and plain h5py."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from gd_analyze.errors import Location, StoreError
from gd_analyze.files import replacing
from gd_analyze.findings import Findings
from gd_analyze.schema import SCHEMA_VERSION, validate

if TYPE_CHECKING:
    import xarray as xr

FORMAT = "gd-analyze results"
GROUPS = (
    "trajectory",
    "decomposition",
    "dominance",
    "simplified_model",
    "terms",
    "trade_off",
    "beyond",
)
_MOTION = ("q", "qd", "qdd")


def save_results(findings: Findings, path: str | Path) -> None:
    """Write everything found into one HDF5 file, atomically.

    Parameters
    ----------
    findings
        What the main job found.
    path
        The file, with the groups of `GROUPS`.

    Raises
    ------
    OutputError
        If the file cannot be written.
    """
    with replacing(path) as temporary:
        write_results(findings, temporary)


def write_results(findings: Findings, path: Path) -> None:
    """Write the file as it is named, without a way back: for a place that is replaced as a whole."""
    as_tree(findings).to_netcdf(path, engine="h5netcdf")


def as_tree(findings: Findings) -> xr.DataTree:
    """Arrange what was found as the tree that is stored."""
    import xarray as xr

    dataset = findings.decomposition
    trajectory = findings.trajectory
    motion = xr.Dataset({name: dataset[name] for name in _MOTION})
    motion.attrs = {
        "name": trajectory.name,
        "origin": trajectory.origin,
        "rates": trajectory.rates_from,
        "fingerprint": trajectory.fingerprint,
    }
    root = xr.Dataset(
        attrs={
            "format": FORMAT,
            "schema": SCHEMA_VERSION,
            **findings.provenance,
            **{f"residual_{r.quantity}": r.largest for r in findings.residuals},
            **{f"residual_bound_{r.quantity}": r.bound for r in findings.residuals},
            "warnings": "\n".join(findings.warnings),
        }
    )
    return xr.DataTree.from_dict(
        {
            "/": root,
            "/trajectory": motion,
            "/decomposition": dataset,
            "/dominance": findings.dominance,
            "/simplified_model": _model(findings),
            "/terms": _terms(findings),
            "/trade_off": _trade_off(findings),
            "/beyond": _beyond(findings),
        }
    )


def load_results(path: str | Path) -> xr.DataTree:
    """Read a results file back.

    Returns
    -------
    xarray.DataTree
        The groups of `GROUPS`, in memory.

    Raises
    ------
    StoreError
        If the file is missing, damaged, foreign or of another schema version.
    """
    import xarray as xr

    path = Path(path)
    _require_ours(path)
    with _damage_named(path), xr.open_datatree(path, engine="h5netcdf") as opened:
        tree: xr.DataTree = opened.load()
    try:
        validate(tree["decomposition"].to_dataset())
    except StoreError as error:
        raise _damaged(path, error.what) from None
    return tree


def _require_ours(path: Path) -> None:
    """Say what is wrong with a file before xarray tries to make sense of it; plain h5py fails cleanly."""
    import h5py

    if not path.is_file():
        raise StoreError(
            "there is no such results file",
            where=Location(path),
            next_step="name the analysis.h5 of a results folder",
        )
    with _damage_named(path), h5py.File(path) as file:
        attributes: Any = dict(file.attrs)
        groups = list(file)
        file.visititems(lambda _, item: dict(item.attrs) and None)
    if not np.array_equal(attributes.get("format"), FORMAT) or not set(GROUPS) <= set(groups):
        raise StoreError(
            "this HDF5 file does not hold gd-analyze results",
            where=Location(path),
            expected=f"the groups {', '.join(GROUPS)}",
            found=", ".join(groups) or "no groups",
            next_step="name the analysis.h5 of a results folder",
        )
    schema = np.ravel(attributes.get("schema")).tolist()  # netCDF stores numbers as arrays of one
    if schema != [SCHEMA_VERSION]:
        raise StoreError(
            "the results file is of another schema version",
            where=Location(path),
            expected=str(SCHEMA_VERSION),
            found=", ".join(str(number) for number in schema),
            next_step="use the gd-analyze that wrote it, or run the analysis again",
        )


@contextmanager
def _damage_named(path: Path) -> Iterator[None]:
    try:
        yield
    except Exception as error:  # what a damaged file makes HDF5 and its readers raise has no common class
        raise _damaged(path, str(error) or type(error).__name__) from None


def _damaged(path: Path, found: str) -> StoreError:
    return StoreError(
        "the results file is damaged or not HDF5",
        where=Location(path),
        expected="a file that gd-analyze wrote, e.g. analysis.h5",
        found=found.splitlines()[0],
        next_step="run the analysis again",
    )


def _model(findings: Findings) -> xr.Dataset:
    import xarray as xr

    model, evaluation = findings.model, findings.evaluation
    promise = model.promise
    joints = findings.decomposition.joint.values
    per_joint = {
        "allowed_error": (model.budget, "largest torque error the budget allows"),
        "peak_torque": (promise.peak_torque, "largest magnitude of the exact torque"),
        "largest_error": (promise.largest, "largest torque error at the set points"),
        "rms_error": (promise.rms, "root mean square torque error over the set points"),
    }
    return xr.Dataset(
        {
            **{
                name: ("joint", values, {"units": "N m", "long_name": meaning})
                for name, (values, meaning) in per_joint.items()
            },
            "torque": (
                ("time", "joint"),
                evaluation.simplified,
                {"units": "N m", "long_name": "torque of the simplified model"},
            ),
            "torque_error": (
                ("time", "joint"),
                evaluation.simplified - evaluation.exact,
                {"units": "N m", "long_name": "torque of the simplified model minus the exact torque"},
            ),
            "kept": (
                "part",
                np.isin(_labels(findings), findings.element_model.kept),
                {"long_name": "whether the text's own method keeps the part"},
            ),
        },
        coords={
            "time": findings.decomposition.time,
            "joint": joints,
            "part": _labels(findings),
        },
        attrs={
            "level": model.level,
            "refitted": int(model.refitted),
            "budget": model.budget_stated,
            "errors_are": "sampled at the set points",
            "search": model.provenance["search"],
            "multiplications": model.operations.multiplications,
            "additions": model.operations.additions,
            "sines_cosines": model.operations.sines_cosines,
            "multiplications_full": model.operations_full.multiplications,
            "additions_full": model.operations_full.additions,
            "sines_cosines_full": model.operations_full.sines_cosines,
        },
    )


def _labels(findings: Findings) -> list[str]:
    return [*findings.element_model.kept, *findings.element_model.dropped]


def _terms(findings: Findings) -> xr.Dataset:
    import xarray as xr

    ranking = findings.terms
    meanings = {
        "label": ("", "where the term stands: tau and the row, in absolute rates"),
        "quantity": ("", "inertia (D), coriolis_centrifugal (h) or gravity_loading (c)"),
        "text": ("", "the term, to three digits"),
        "alone_torque": ("N m", "its own largest torque, at alone_joint"),
        "alone_joint": ("", "joint where that is most of the peak torque, from 1"),
        "alone_share": ("1", "alone_torque over that joint's peak torque"),
        "without_share": ("1", "largest error over peak torque without it and all ranked below"),
        "without_joint": ("", "joint of that error, from 1"),
    }
    return xr.Dataset(
        {
            name: (
                "rank",
                np.array([getattr(term, name) for term in ranking.terms]),
                {"long_name": meaning, **({"units": unit} if unit else {})},
            )
            for name, (unit, meaning) in meanings.items()
        },
        coords={"rank": np.arange(1, len(ranking.terms) + 1)},
        attrs={"not_worth_keeping": ranking.not_worth_keeping}
        | ({} if ranking.uncertainty is None else {"torque_uncertainty": ranking.uncertainty}),
    )


def _trade_off(findings: Findings) -> xr.Dataset:
    import xarray as xr

    points = findings.trade_off
    kinds = list(dict.fromkeys((point.level, point.refit) for point in points))
    factors = sorted({point.factor for point in points})
    by_place = {(point.level, point.refit, point.factor): point for point in points}
    table = [[by_place[(*kind, factor)] for factor in factors] for kind in kinds]
    return xr.Dataset(
        {
            "operations": (
                ("kind", "factor"),
                [[point.operations.total for point in row] for row in table],
                {"long_name": "multiplications and additions of one torque evaluation"},
            ),
            "largest_share": (
                ("kind", "factor"),
                [[point.error_share for point in row] for row in table],
                {"units": "1", "long_name": "largest torque error at the set points over peak torque"},
            ),
        },
        coords={
            "kind": [f"{level} refit" if refit else level for level, refit in kinds],
            "factor": ("factor", factors, {"long_name": "multiple of the budget"}),
        },
    )


def _beyond(findings: Findings) -> xr.Dataset:
    """Per joint; what could not be found out is not a number."""
    import xarray as xr

    beyond, n = findings.beyond, findings.arm.n_joints
    certificate, drawn = beyond.certificate, beyond.within_limits
    unknown = np.full(n, np.nan)
    columns = {
        "certified": (
            unknown if certificate is None else certificate.certified,
            "N m",
            "no state between the extremes of the trajectory has a larger torque error",
        ),
        "worst_found": (
            unknown if certificate is None else certificate.worst_found,
            "N m",
            "largest torque error a search found among those states",
        ),
        "within_limits": (
            unknown if drawn is None else drawn.largest,
            "N m",
            "largest torque error over states drawn from the arm's limits",
        ),
        "torque_per_kg": (
            beyond.payload.torque_per_kg,
            "N m / kg",
            "largest torque of a point mass in the hand along the trajectory",
        ),
        "mass_within_budget": (
            beyond.payload.mass_within_budget,
            "kg",
            "largest point mass in the hand that keeps the joint within its budget",
        ),
    }
    return xr.Dataset(
        {
            name: ("joint", values, {"units": unit, "long_name": meaning})
            for name, (values, unit, meaning) in columns.items()
        },
        coords={"joint": findings.decomposition.joint.values},
        attrs={"states_drawn": beyond.drawn},
    )
