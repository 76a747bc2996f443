"""Check that the parts of a results file belong together: to one arm, motion and model."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from gd_analyze.dynamics.dominance import elements
from gd_analyze.errors import StoreError
from gd_analyze.harmonics.terms import Torques
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.description import describe
from gd_analyze.schema import OPTIONAL
from gd_analyze.simplification.element import ELEMENT, parts_of
from gd_analyze.simplification.levels import level_named
from gd_analyze.simplification.model import SimplifiedModel

if TYPE_CHECKING:
    import xarray as xr

Models = tuple[SimplifiedModel, SimplifiedModel, Torques]
# What a value is, the value found and the value expected.
Comparison = tuple[str, Any, Any]


def require_fit(tables: Mapping[str, xr.Dataset], arm: RobotArm, models: Models | None = None) -> None:
    """Check that all tables are about one arm, one set of points and one model."""
    for pairs in (_labels(tables, arm), _numbers(tables), _models(tables, arm, models) if models else ()):
        for subject, value, expected in pairs:
            if value != expected:
                raise StoreError(
                    f"{subject} does not fit the rest of the file", expected=str(expected), found=str(value)
                )


# For a long motion these hold a selection of set points.
_OF_SOME_SET_POINTS = {"dominance_over_time", "robustness"}


def _labels(tables: Mapping[str, xr.Dataset], arm: RobotArm) -> Iterator[Comparison]:
    of_arm = {
        "element": sorted(element.label for element in elements(arm.n_joints)),
        "part": sorted(part.label for part in parts_of(arm.n_joints)),
    }
    names, time = [joint.name for joint in arm.joints], tables["trajectory"].time.values
    for group, table in tables.items():
        for name, labels in of_arm.items():
            if name in table.dims:
                # Gravity loading has one part, so its verdict is certain.
                expected_labels = [label for label in labels if group != "robustness" or label[0] != "c"]
                yield f"{name} of {group}", sorted(table[name].values.tolist()), expected_labels
        if "joint_name" in table:
            yield f"joint_name of {group}", table.joint_name.values.tolist(), names
        if "time" in table.dims:
            expected_time = time[np.isin(time, table.time.values)] if group in _OF_SOME_SET_POINTS else time
            if group == "every_set_point":
                expected_time = table.time.values if np.isin(time, table.time.values).all() else time
            yield f"time of {group}", np.array_equal(table.time.values, expected_time), True
    kinds = tables["decomposition"].joint_kind.values.tolist()
    yield "joint_kind of decomposition", kinds, [joint.kind for joint in arm.joints]
    if "motions" in tables:
        for name in ("element", "quantity"):
            ranked = tables["dominance"][name].values.tolist()
            yield f"{name} of motions", tables["motions"][name].values.tolist(), ranked


def _numbers(tables: Mapping[str, xr.Dataset]) -> Iterator[Comparison]:
    """Numbers are nan exactly where they are unknown, and equal where they are stored twice."""
    motion, beyond, tube, parts = (tables[name] for name in ("trajectory", "beyond", "tube", "parts"))
    model_table, budgets = tables["simplified_model"], tables["budgets"]
    if "stretch_from" in motion:
        begins = motion.stretch_from.values
        in_order = begins[0] == 1 and (np.diff(begins) > 0).all() and begins[-1] <= motion.sizes["time"]
        yield "stretch_from of trajectory", bool(in_order), True
    has_states, is_certified = beyond.attrs["states_drawn"] > 0, bool(beyond.certified.notnull().all())
    has_uncertainty = bool(beyond.uncertainty.notnull().all())
    is_proven = bool(tube.tube_certified.notnull().all())
    is_known = {"certified": is_certified, "worst_found": is_certified, "uncertainty": has_uncertainty}
    is_known |= {"within_limits": has_states, "within_limits_share": has_states}
    for name, expected in is_known.items():
        yield f"{name} of beyond", bool((beyond[name].notnull() == expected).all()), True
    is_tried = is_proven or tube.attrs["tried"] > 0
    for name, expected in (
        ("tube_certified", is_proven),
        ("tube_along", is_proven),
        ("tube_worst_found", is_tried),
    ):
        yield f"{name} of tube", bool((tube[name].notnull() == expected).all()), True
    if is_proven:
        largest = tube.tube_along.max("segment")
        yield "tube_certified of tube", tube.tube_certified.values.tolist(), largest.values.tolist()
    for name in ("torque_peak", "torque_share"):
        yield f"{name} of parts", bool((parts[name].notnull() | parts.kept_by_element).all()), True
    level = level_named(model_table.attrs["level"])
    expected_keys = {"kept"} if level.has_torque_terms else {"kept_parts"} if level is ELEMENT else set()
    yield "what budgets keep", {"kept", "kept_parts"} & {*budgets}, expected_keys
    if "rank" in budgets.dims:
        yield "rank of budgets", budgets["rank"].values.tolist(), tables["terms"]["rank"].values.tolist()
    position, total = (
        int(budgets.attrs["asked"]),
        int(model_table.attrs["multiplications"] + model_table.attrs["additions"]),
    )
    yield "asked of budgets", position < budgets.sizes["position"], True
    yield "operations of budgets at the run's own", int(budgets.operations.values[position]), total
    if "motions" in tables:
        motions = tables["motions"]
        yield "set_points of motions", int(motions.set_points.values.sum()), motion.sizes["time"]
        for name in ("peak_torque", "largest_error"):
            yield f"{name} of motions", bool((motions[name].max("motion") <= model_table[name]).all()), True
    if "measured_torque" in tables:
        table = tables["measured_torque"]
        is_read = (table.measured.notnull() & table.filtered.notnull()).any("time").values
        has_verdict = table.verdict.values != "not measured"
        yield "verdict of measured_torque without readings", bool((has_verdict & ~is_read).any()), False
        friction = OPTIONAL["measured_torque"]
        yield "friction of measured_torque", friction & {*table.data_vars} or friction, friction


def _models(tables: Mapping[str, xr.Dataset], arm: RobotArm, models: Models) -> Iterator[Comparison]:
    model, by_elements, ranked = models
    for stored_model in (model, by_elements):
        yield "the arm of a model", describe(stored_model.arm), describe(arm)
    yield "level of the model", model.level.name, tables["simplified_model"].attrs["level"]
    yield "level of the model by elements", by_elements.level.name, ELEMENT.name
    stated = tables["motions"].motion.values.tolist() if "motions" in tables else []
    yield "motions of the model", [motion.name for motion in model.accuracy.motions], stated
    yield "the weights of the ranked terms", [*ranked.values()], tables["terms"].weight.values.tolist()
