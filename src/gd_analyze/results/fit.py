"""Whether the parts of a results file belong together: every table, model and term to one arm and motion."""

from __future__ import annotations

from collections.abc import Mapping
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


def require_tables_fit(tables: Mapping[str, xr.Dataset], arm: RobotArm) -> None:
    """Check that labels of tables are the arm's, and that all of them are about the same set points.

    Raises
    ------
    StoreError
        If not.
    """
    names = [joint.name for joint in arm.joints]
    of_arm = {
        "element": sorted(element.label for element in elements(arm.n_joints)),
        "part": sorted(part.label for part in parts_of(arm.n_joints)),
    }
    time = tables["trajectory"].time.values
    for group, table in tables.items():
        for name, labels in of_arm.items():
            if name in table.dims:
                _require_equal(f"{name} of {group}", sorted(table[name].values.tolist()), labels)
        if "joint_name" in table:
            _require_equal(f"joint_name of {group}", table.joint_name.values.tolist(), names)
        if "time" in table.dims and not np.array_equal(table.time.values, time):
            raise StoreError(f"time of {group} is not that of the trajectory")
    _require_stretches(tables["trajectory"])
    _require_known_together(tables)
    _require_path(tables)
    if "motions" in tables:
        _require_motions(tables)
    if "measured_torque" in tables:
        _require_readings(tables["measured_torque"])
    kinds = [joint.kind for joint in arm.joints]
    _require_equal("joint_kind of decomposition", tables["decomposition"].joint_kind.values.tolist(), kinds)


def _require_stretches(motion: xr.Dataset) -> None:
    """Check that stretches begin with the first set point, and then at later and later ones."""
    if "stretch_from" in motion:
        begins = motion.stretch_from.values
        if begins[0] != 1 or (np.diff(begins) <= 0).any() or begins[-1] > motion.sizes["time"]:
            raise StoreError("stretch_from of trajectory is not where stretches begin", found=str(begins[:9]))


def _require_known_together(tables: Mapping[str, xr.Dataset]) -> None:
    """Check that what is not a number is what cannot be known: of all joints, or of a part that is kept."""
    beyond, drawn = tables["beyond"], tables["beyond"].attrs["states_drawn"] > 0
    certified = bool(beyond.certified.notnull().all())
    stated = bool(beyond.uncertainty.notnull().all())
    for name, known in {
        "certified": certified,
        "worst_found": certified,
        "within_limits": drawn,
        "within_limits_share": drawn,
        "uncertainty": stated,
    }.items():
        if not (beyond[name].notnull() == known).all():
            raise StoreError(f"{name} of beyond is known where it cannot be, or not known where it must be")
    tube = tables["tube"]
    proven = bool(tube.tube_certified.notnull().all())
    for name in ("tube_certified", "tube_worst_found", "tube_along"):
        if not (tube[name].notnull() == proven).all():
            raise StoreError(f"{name} of tube is known where it cannot be, or not known where it must be")
    if proven and not (tube.tube_along.max("segment") == tube.tube_certified).all():
        raise StoreError("tube_certified of tube is not the largest of tube_along")
    parts = tables["parts"]
    for name in ("torque_peak", "torque_share"):
        if (parts[name].isnull() & ~parts.kept).any():
            raise StoreError(f"{name} of parts is not known of a part that is left out")


def _require_readings(measured: xr.Dataset) -> None:
    """Check that every joint that is said to be measured has a reading, and friction all its terms."""
    there = (measured.measured.notnull() & measured.filtered.notnull()).any("time").values
    for joint, read, verdict in zip(measured.joint.values, there, measured.verdict.values, strict=True):
        if verdict != "not measured" and not read:
            raise StoreError(f"measured_torque has no reading of joint {joint}, of which it says: {verdict}")
    fitted = sorted(OPTIONAL["measured_torque"] & {*measured.data_vars})
    if fitted:
        _require_equal("friction of measured_torque", fitted, sorted(OPTIONAL["measured_torque"]))


def _require_path(tables: Mapping[str, xr.Dataset]) -> None:
    """Check that budgets lead through the model that is shown, and name terms or parts as others do."""
    path, shown = tables["budgets"], tables["simplified_model"].attrs
    level = level_named(shown["level"])
    kept = ["kept"] if level.has_torque_terms else ["kept_parts"] if level is ELEMENT else []
    _require_equal("what budgets say of the model", [*{"kept", "kept_parts"} & {*path}], kept)
    if "rank" in path.dims:
        ranks = tables["terms"]["rank"].values.tolist()
        _require_equal("rank of budgets", path["rank"].values.tolist(), ranks)
    at_one = path.operations.values[path.factor.values == 1.0].tolist()
    operations = [int(shown["multiplications"] + shown["additions"])]
    _require_equal("operations of budgets at a factor of 1", at_one, operations)


def _require_motions(tables: Mapping[str, xr.Dataset]) -> None:
    """Check that what is told motion by motion is about all set points, and of the elements as ranked."""
    motions, ranking = tables["motions"], tables["dominance"]
    count = tables["trajectory"].sizes["time"]
    _require_equal("set_points of motions, summed up,", int(motions.set_points.values.sum()), count)
    for name in ("element", "quantity"):
        _require_equal(f"{name} of motions", motions[name].values.tolist(), ranking[name].values.tolist())
    over_all = tables["simplified_model"]
    for name in ("peak_torque", "largest_error"):
        if (motions[name].max("motion") > over_all[name]).any():
            raise StoreError(f"{name} of motions is above that over all of them")


def require_models_fit(
    model: SimplifiedModel, element_model: SimplifiedModel, tables: Mapping[str, xr.Dataset], arm: RobotArm
) -> None:
    """Check that models are of the arm, and of the levels that are stated.

    Raises
    ------
    StoreError
        If not.
    """
    for one in (model, element_model):
        if describe(one.arm) != describe(arm):
            raise StoreError("a model is of another arm than the tables")
    _require_equal("level of the model", model.level.name, tables["simplified_model"].attrs["level"])
    stated = tables["motions"].motion.values.tolist() if "motions" in tables else []
    _require_equal("motions of the model", [one.name for one in model.accuracy.motions], stated)
    _require_equal("level of the model by elements", element_model.level.name, ELEMENT.name)


def require_terms_fit(ranked: Torques, tables: Mapping[str, xr.Dataset]) -> None:
    """Check that the ranked terms are those of their table, in its order.

    Raises
    ------
    StoreError
        If not.
    """
    weights = tables["terms"].weight.values.tolist()
    _require_equal("the weights of the ranked terms", [*ranked.values()], weights)


def _require_equal(what: str, found: Any, expected: Any) -> None:
    if found != expected:
        raise StoreError(f"{what} is not what belongs to the rest", expected=str(expected), found=str(found))
