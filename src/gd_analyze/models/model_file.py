"""Simplified models as JSON: versioned, checked against a schema, never code."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import Any, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, ValidationError

from gd_analyze.errors import GdAnalyzeError, Location, ModelError
from gd_analyze.files import write_text
from gd_analyze.models.simplified import ErrorTable, SimplifiedModel
from gd_analyze.robots import arm_from_description, describe, fingerprint
from gd_analyze.vectors import FloatArray

FORMAT = "gd-analyze simplified model"
VERSION = 1
_WRITE_AGAIN = "write the model again with `gd-analyze ROBOT TRAJECTORY`"


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", allow_inf_nan=False)


class _Operations(_Strict):
    multiplications: int
    additions: int
    sines_cosines: int


class _JointError(_Strict):
    joint: str
    unit: str
    peak_torque: float
    allowed_error: float
    largest_error: float
    rms_error: float


class _ModelFile(_Strict):
    format: Literal["gd-analyze simplified model"]
    version: Literal[1]
    level: Literal["element"]
    kept: list[str]
    dropped: list[str]
    drives: bool
    budget: str
    errors: list[_JointError]
    errors_are: Literal["sampled at the set points of made_for"]
    made_for: dict[str, str | int]
    operations: _Operations
    operations_full: _Operations
    arm_fingerprint: str
    arm: dict[str, Any]
    provenance: dict[str, str]
    digest: str


def save_model(model: SimplifiedModel, path: str | Path) -> None:
    """Write a model as JSON, atomically.

    Raises
    ------
    OutputError
        If the file cannot be written.
    """

    def count(operations: Any) -> _Operations:
        return _Operations(
            multiplications=operations.multiplications,
            additions=operations.additions,
            sines_cosines=operations.sines_cosines,
        )

    promise = model.promise
    document = _ModelFile(
        format="gd-analyze simplified model",
        version=VERSION,
        level=model.level,
        kept=list(model.kept),
        dropped=list(model.dropped),
        drives=model.drives,
        budget=model.budget_stated,
        errors=[
            _JointError(
                joint=joint.name,
                unit=joint.effort_unit,
                peak_torque=promise.peak_torque[i],
                allowed_error=model.budget[i],
                largest_error=promise.largest[i],
                rms_error=promise.rms[i],
            )
            for i, joint in enumerate(model.arm.joints)
        ],
        errors_are="sampled at the set points of made_for",
        made_for=dict(model.made_for),
        operations=count(model.operations),
        operations_full=count(model.operations_full),
        arm_fingerprint=fingerprint(model.arm, model.drives),
        arm=describe(model.arm),
        provenance=dict(model.provenance),
        digest="",
    )
    document.digest = _digest(document.model_dump())
    write_text(path, json.dumps(document.model_dump(), indent=2, ensure_ascii=False) + "\n")


def load_model(path: str | Path) -> SimplifiedModel:
    """Read a model that `save_model` wrote; nothing in the file is executed.

    Raises
    ------
    ModelError
        If the file cannot be read, is not such a model, or was changed so that it no longer fits itself.
    """
    path = Path(path)
    try:
        raw = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise ModelError(
            "cannot read the model file",
            where=Location(path),
            found=error.strerror,
            next_step="check the path and your right to read it",
        ) from None
    except UnicodeDecodeError:
        raise _foreign(path, "a file that is not text") from None
    except json.JSONDecodeError as error:
        raise ModelError(
            "the model file is damaged: it is not valid JSON",
            where=Location(path, error.lineno, error.colno),
            found=error.msg,
            next_step=_WRITE_AGAIN,
        ) from None
    except RecursionError:
        raise _foreign(path, "brackets nested beyond any model") from None
    if not isinstance(raw, dict) or raw.get("format") != FORMAT:
        raise _foreign(path, "other JSON")
    if raw.get("version") != VERSION:
        raise ModelError(
            "the model file is of another version",
            where=Location(path),
            expected=f"version {VERSION}",
            found=f"version {raw.get('version')}",
            next_step="use the gd-analyze that wrote it, or write the model again",
        )
    try:
        document = _ModelFile.model_validate(raw)
        arm = arm_from_description(document.arm)
        model = SimplifiedModel(
            arm=arm,
            level=document.level,
            kept=tuple(document.kept),
            drives=document.drives,
            budget=_column(document, "allowed_error"),
            budget_stated=document.budget,
            promise=ErrorTable(
                _column(document, "peak_torque"),
                _column(document, "largest_error"),
                _column(document, "rms_error"),
            ),
            made_for=document.made_for,
            provenance=document.provenance,
        )
    except ValidationError as error:
        first = error.errors()[0]
        raise ModelError(
            "the model file is damaged",
            where=f"{path}: {'.'.join(str(key) for key in first['loc'])}",
            expected=first["msg"],
            found=repr(first.get("input"))[:120],
            next_step=_WRITE_AGAIN,
        ) from None
    except (GdAnalyzeError, KeyError, TypeError, ValueError, AttributeError) as error:
        raise ModelError(
            "the model file is damaged: its arm cannot be rebuilt",
            where=Location(path),
            found=(str(error) or type(error).__name__).splitlines()[0],
            next_step=_WRITE_AGAIN,
        ) from None
    if document.digest != _digest(raw):
        raise ModelError(
            "the model file was changed after it was written: its stated errors no longer hold",
            where=Location(path),
            expected=f"digest {_digest(raw)[:16]}... of its content",
            found=f"digest {document.digest[:16]}...",
            next_step="write the model again for the arm and the parts you mean",
        )
    return model


def _digest(document: dict[str, Any]) -> str:
    """SHA-256 of everything in the file but the digest itself."""
    content = {key: value for key, value in document.items() if key != "digest"}
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()


def _column(document: _ModelFile, name: str) -> FloatArray:
    return np.array([getattr(row, name) for row in document.errors])


def _foreign(path: Path, found: str) -> ModelError:
    return ModelError(
        "this is not a gd-analyze model",
        where=Location(path),
        expected="a JSON file that gd-analyze wrote, e.g. model.json",
        found=found,
        next_step="name the model.json of a results folder",
    )
