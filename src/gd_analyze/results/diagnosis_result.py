"""A diagnosis as a table and a result: the answer, what remains by joint, the ranking, where to look."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.diagnosis.answer import (
    answer,
    has_useless_columns,
    is_for_identification,
    what_remains_follows,
)
from gd_analyze.diagnosis.causes import CLEAR_FALL, CLEAR_FALL_SHARE
from gd_analyze.diagnosis.diagnose import Diagnosis
from gd_analyze.diagnosis.hypothesis import Candidate
from gd_analyze.errors import in_options
from gd_analyze.figures.diagnosis import compared_joints, diagnosed_torque_figure, where_figure
from gd_analyze.result import (
    Drawing,
    Fact,
    Part,
    Result,
    Section,
    Table,
    Value,
    Values,
    joint_values,
    values_of,
)
from gd_analyze.robots.arm import RobotArm
from gd_analyze.schema import declared_table, table
from gd_analyze.text import joint_name

if TYPE_CHECKING:
    import xarray as xr

_REMAINS = ["remains_before", "remains_after", "follows"]
# Causes that a person sees in the ranking.
_SHOWN_CAUSES = 6


def diagnosis_table(diagnosis: Diagnosis) -> xr.Dataset:
    """Tabulate a diagnosis: joints, causes, all that was tried, faulty readings and the samples compared."""
    arm, problem, corrected = diagnosis.arm, diagnosis.problem, diagnosis.corrected
    samples, n = problem.samples, arm.n_joints
    is_compared = bool(corrected.moving)
    follows = what_remains_follows(corrected) if is_compared else [""] * n
    nothing = np.full((len(samples), n), np.nan)
    measured, fitted = problem.torques() if problem.moving else (nothing, nothing)
    mended, fitted_mended = corrected.torques() if is_compared else (nothing, nothing)
    claimed = [*diagnosis.causes, *diagnosis.rivals]
    is_fitted = np.isfinite(diagnosis.after.residuals)
    values: dict[str, Any] = {
        "remains_before": diagnosis.before.residuals,
        "remains_after": diagnosis.after.residuals,
        "remains_as_filed": diagnosis.as_filed.share,
        "residual_as_filed": diagnosis.as_filed.rms,
        "below_95_as_filed": diagnosis.as_filed.below_95,
        "offset": np.where(is_fitted, diagnosis.after.joint_numbers[:, -1], np.nan),
        "is_offset": np.isin(np.arange(1, n + 1), list(diagnosis.offsets)),
        "follows": _texts(follows),
        **_candidates("cause", claimed),
        "cause_rival": np.array([candidate in diagnosis.rivals for candidate in claimed], dtype=bool),
        **_candidates("tried", diagnosis.ranking),
        "tried_remains": _numbers([_remains(candidate) for candidate in diagnosis.ranking]),
        "tried_residuals": np.array([_residuals(candidate) for candidate in diagnosis.ranking]).reshape(
            -1, n
        ),
        "tried_numbers": np.array([candidate.numbers for candidate in diagnosis.ranking], dtype=np.int64),
        "tried_fall": _numbers([candidate.fall for candidate in diagnosis.ranking]),
        "fault_name": _texts([fault.name for fault in diagnosis.faults]),
        "fault_joint": np.array([fault.joint + 1 for fault in diagnosis.faults], dtype=np.int64),
        "fault_what": _texts([fault.what for fault in diagnosis.faults]),
        "fault_remedy": _texts([in_options(fault.remedy) for fault in diagnosis.faults]),
        "fault_share": _numbers([fault.share for fault in diagnosis.faults]),
        "sample_time": samples.clock,
        "sample_q": samples.q,
        "sample_qd": samples.qd,
        "sample_qdd": samples.qdd,
        "sample_measured": measured,
        "sample_fitted": fitted,
        "sample_mended": mended,
        "sample_fitted_mended": fitted_mended,
    }
    attributes = {
        "answer": answer(diagnosis),
        "remedy": str(diagnosis.remedy),
        "options": diagnosis.remedy.options if diagnosis.remedy.is_all_typed else "",
        "identify": int(is_for_identification(diagnosis)),
        "useless_columns": int(has_useless_columns(diagnosis)),
        "logs": "\n".join(diagnosis.logs),
        "tells": int(diagnosis.tells),
        "masses_off": diagnosis.after.off if is_compared else 0.0,
        "margin": CLEAR_FALL,
        "misfit": CLEAR_FALL_SHARE,
    }
    return table("diagnosis", values, arm.is_revolute, attrs=attributes)


def _candidates(prefix: str, candidates: Sequence[Candidate]) -> dict[str, Any]:
    return {
        f"{prefix}_{name}": _texts([str(getattr(candidate, name)) for candidate in candidates])
        for name in ("name", "what", "remedy", "unsure")
    }


def _texts(texts: Sequence[str]) -> np.ndarray:
    return np.array(texts, dtype=str)


def _numbers(values: Sequence[float]) -> FloatArray:
    return np.array(values, dtype=float)


def _remains(candidate: Candidate) -> float:
    assert candidate.fit is not None  # judged
    return candidate.fit.remains


def _residuals(candidate: Candidate) -> FloatArray:
    assert candidate.fit is not None  # judged
    return candidate.fit.residuals


def diagnosis_result(diagnosis: Diagnosis, provenance: Mapping[str, str]) -> Result:
    """Facts, tables and drawings."""
    arm, tabulated = diagnosis.arm, diagnosis_table(diagnosis)
    facts = diagnosis_facts(tabulated)
    return Result(
        title=arm.title or arm.name,
        subtitle=f"diagnosed with {', '.join(diagnosis.logs)}",
        headline=str(tabulated.attrs["answer"]),
        facts=tuple(fact for fact in facts if isinstance(fact, Value) or fact.value is not None),
        parts=(*diagnosis_tables(tabulated, arm), *_drawings(tabulated, arm)),
        provenance=dict(provenance),
    )


def diagnosis_facts(tabulated: xr.Dataset) -> tuple[Fact | Value, ...]:
    """The cause, its remedy, and what remains before and after."""
    has_cause = tabulated.sizes["cause"] > 0
    name = str(tabulated.cause_name.values[0]) if has_cause else None
    remedy = str(tabulated.attrs["remedy"]) if has_cause else None
    before, after = (_mean(tabulated[f"remains_{when}"].values) for when in ("before", "after"))
    off = float(tabulated.attrs["masses_off"]) if compared_joints(tabulated) else None
    return (
        Value("cause", name),
        Fact("remedy", "Remedy", remedy, shown="text"),
        Fact("remains_before", "Torque that remains, as logged", before, "of RMS", "percent"),
        Fact("remains_after", "Torque that remains, mended", after, "of RMS", "percent").seen_if(has_cause),
        Fact("masses_off", "Links' torque changed by the fit", off, "", "percent"),
        Fact("tells", "Log tells of more than friction", bool(tabulated.attrs["tells"]), shown="flag"),
        Value("logs", str(tabulated.attrs["logs"]).split("\n")),
    )


def _mean(residuals: FloatArray) -> float:
    """Quadratic mean of the joints that are compared; nan if there are none."""
    is_compared = np.isfinite(residuals)
    return float(np.sqrt(np.mean(residuals[is_compared] ** 2))) if is_compared.any() else np.nan


def diagnosis_tables(tabulated: xr.Dataset, arm: RobotArm) -> tuple[Part, ...]:
    """What remains by joint, the causes, all that was tried, and faulty readings."""
    causes = _rows(tabulated, "cause")
    return (
        _joints(tabulated, arm),
        *([Value("causes", causes)] if causes else []),
        *causes_table(tabulated),
        *faults_table(tabulated),
    )


def _joints(tabulated: xr.Dataset, arm: RobotArm) -> Table:
    before, after, follows = (tabulated[name].values for name in _REMAINS)
    note = (
        "Held-out residual as a share of the joint's measured RMS; –: at rest, or no torque. Fitted: "
        "friction, an offset, drive inertia, and links within the usual error of a file."
    )
    return declared_table(
        "diagnosis",
        "joints",
        "What remains, by joint",
        joint_values(arm.joints)
        | {"before": before, "after": after, "follows": follows, "offset": tabulated.offset.values},
        ["joint", *_REMAINS, "offset"],
        note=note,
        seen={
            "remains_before": before,
            "remains_after": after if tabulated.sizes["cause"] else None,
            "follows": follows if any(follows) else None,
        },
    )


def causes_table(tabulated: xr.Dataset) -> Iterator[Table]:
    """All that was tried as first cause, the best first; none if nothing was tried."""
    rows = _rows(tabulated, "tried")
    if not rows:
        return
    keys = ("name", "what", "remains", "residuals", "numbers", "fall", "remedy", "unsure")
    note = (
        f"A cause is named if the score falls by more than {tabulated.attrs['margin']:g} and by "
        f"{tabulated.attrs['misfit']:.0%} of what then stays unexplained, and the residual falls clearly, "
        "too. The score counts every fitted number against a cause."
    )
    yield _of_diagnosis(
        "tried",
        "ranking",
        "Causes tried",
        values_of(rows, *keys),
        ["what", "remains", "numbers", "fall"],
        note,
        _SHOWN_CAUSES,
    )


def faults_table(tabulated: xr.Dataset) -> Iterator[Table]:
    """Faulty readings; none if there are none."""
    yield from table_of_faults(_rows(tabulated, "fault"))


def table_of_faults(rows: Sequence[Mapping[str, Any]]) -> Iterator[Table]:
    """Faulty readings, each with name, joint from 1, what it is, remedy and share; none if there are none."""
    if rows:
        values = values_of(rows, "name", "joint", "what", "remedy", "share")
        note = "These readings are left out, and velocities such as these not used."
        names = ["what", "remedy", "share"]
        yield _of_diagnosis("fault", "faults", "Faulty readings", values, names, note)


def _of_diagnosis(
    dim: str, key: str, title: str, values: Values, names: Sequence[str], note: str, top: int | None = None
) -> Table:
    """A table along a dimension, whose name the declarations begin with."""
    seen = {f"{dim}_{name}": values[name] for name in names}
    return declared_table("diagnosis", key, title, values, [*seen], note=note, top=top, seen=seen)


def _rows(tabulated: xr.Dataset, dim: str) -> list[dict[str, Any]]:
    """Rows along a dimension, by the names of its variables without the dimension's."""
    names = [str(name) for name in tabulated.data_vars if tabulated[name].dims[:1] == (dim,)]
    columns = [tabulated[name].values.tolist() for name in names]
    keys = [name.removeprefix(f"{dim}_") for name in names]
    return [dict(zip(keys, row, strict=True)) for row in zip(*columns, strict=True)]


def _drawings(tabulated: xr.Dataset, arm: RobotArm) -> Iterator[Section]:
    joints = compared_joints(tabulated)
    if not joints:
        return
    has_cause = tabulated.sizes["cause"] > 0
    title = "Torque measured, and fitted by file and friction"
    torque = Drawing(
        "torque",
        f"{title}: as logged, and with the causes." if has_cause else f"{title}.",
        diagnosed_torque_figure(tabulated, arm),
    )
    yield Section(None, "Where to look", (torque, where_drawing(tabulated, arm, joints)))


def where_drawing(tabulated: xr.Dataset, arm: RobotArm, joints: Sequence[int]) -> Drawing:
    """What remains of some joints, from 0, against position, velocity, acceleration and time."""
    subject = "What remains"
    if len(joints) == 1:
        subject += f" at joint {joint_name(joints[0] + 1, arm.joints[joints[0]].name)}"
    looks = "as logged and with the causes" if tabulated.sizes["cause"] else "as logged"
    return Drawing(
        "where",
        f"{subject}, {looks}.",
        where_figure(tabulated, arm, joints),
        "Look for a trend in the residual, with links and drives fitted.",
    )
