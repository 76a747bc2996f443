"""Everything found as labelled tables, a group per concept: what the results file holds."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gd_analyze.findings import Findings
from gd_analyze.levels import parts_of
from gd_analyze.schema import SCHEMA_VERSION
from gd_analyze.search import RankedTerm, curves

if TYPE_CHECKING:
    import xarray as xr

FORMAT = "gd-analyze results"
_MOTION = ("q", "qd", "qdd")


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


def _model(findings: Findings) -> xr.Dataset:
    import xarray as xr

    model, evaluation = findings.model, findings.evaluation
    promise = model.promise.errors
    joints = findings.decomposition.joint.values
    per_joint = {
        "allowed_error": (model.promise.allowed, "largest torque error the budget allows"),
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
                np.isin(_labels(findings), [part.label for part in findings.element_model.terms]),
                {"long_name": "whether the text's own method keeps the part"},
            ),
        },
        coords={
            "time": findings.decomposition.time,
            "joint": joints,
            "part": _labels(findings),
        },
        attrs={
            "level": model.level.name,
            "refitted": int(model.refitted),
            "budget": model.promise.budget,
            "errors_are": "sampled at the set points",
            "search": model.promise.search,
            "multiplications": model.operations.multiplications,
            "additions": model.operations.additions,
            "sines_cosines": model.operations.sines_cosines,
            "multiplications_full": model.operations_full.multiplications,
            "additions_full": model.operations_full.additions,
            "sines_cosines_full": model.operations_full.sines_cosines,
        },
    )


def _labels(findings: Findings) -> list[str]:
    kept = [part.label for part in findings.element_model.terms]
    return [*kept, *(part.label for part in parts_of(findings.arm.n_joints) if part.label not in kept)]


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
                np.array([_term(term)[name] for term in ranking.terms]),
                {"long_name": meaning, **({"units": unit} if unit else {})},
            )
            for name, (unit, meaning) in meanings.items()
        },
        coords={"rank": np.arange(1, len(ranking.terms) + 1)},
        attrs={"not_worth_keeping": ranking.not_worth_keeping}
        | ({} if ranking.uncertainty is None else {"torque_uncertainty": ranking.uncertainty}),
    )


def _term(ranked: RankedTerm) -> dict[str, object]:
    from dataclasses import asdict

    from gd_analyze.harmonics.terms import TorqueTerm
    from gd_analyze.harmonics.torque_rendering import energy_term_text, torque_term_text

    term, weight = ranked.term, ranked.weight
    plain = {name: value for name, value in asdict(ranked).items() if name not in ("term",)}
    if isinstance(term, TorqueTerm):
        label, text = f"tau{term.row + 1}", torque_term_text(term, weight)
    else:
        label = "U" if term.is_potential else f"D'{term.i + 1}{term.j + 1}"
        text = energy_term_text(term, weight)
    return {"rank": ranked.rank, "label": label, "quantity": term.quantity, "text": text, **plain}


def _trade_off(findings: Findings) -> xr.Dataset:
    import xarray as xr

    by_kind = curves(findings.trade_off)
    table = list(by_kind.values())
    factors = [point.factor for point in table[0]]
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
            "kind": [f"{level} refit" if refit else level.name for level, refit in by_kind],
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
