"""Simplified models as JSON: versioned, checked against a schema, never code."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import Any, Literal

import numpy as np
from pydantic import Field, SerializerFunctionWrapHandler, TypeAdapter, ValidationError, model_serializer

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import GdAnalyzeError, Location, ModelError
from gd_analyze.files import megabytes, read_at_most, warn_of_others, write_text
from gd_analyze.operations.program import OperationCount, read_back, written
from gd_analyze.robots.description import arm_from_description, describe_with_drives, fingerprint
from gd_analyze.robots.plausibility import warn_of_implausible
from gd_analyze.simplification.accuracy import Accuracy, AlongMotion, ErrorTable, LevelTried, SearchStep
from gd_analyze.simplification.exact_form import ExactForm
from gd_analyze.simplification.level import Checked
from gd_analyze.simplification.levels import LEVELS, level_named
from gd_analyze.simplification.measures import NormShare
from gd_analyze.simplification.model import SimplifiedModel
from gd_analyze.simplification.model_checks import (
    measured_where_possible,
    require_consistent,
    require_equal,
    require_terms_computed,
)
from gd_analyze.text import in_python

FORMAT = "gd-analyze simplified model"
VERSION = 2


class _JointError(Checked):
    joint: str
    unit: str
    peak_torque: float
    allowed_error: float
    largest_error: float
    rms_error: float
    # Of the torque, where the parameters' are stated; files of before it was kept have none.
    uncertainty: float | None = None


class _Step(Checked):
    name: str
    operations: int


class _LevelTried(Checked):
    level: str
    operations: int | None = None
    why: str = ""


class _SetPoints(Checked):
    trajectory: str
    trajectory_fingerprint: str
    set_points: int


class _SeveralMotions(_SetPoints):
    motions: str


class _Drawn(Checked):
    box: str
    states: int
    seed: int


class _Unnamed(Checked):
    pass


_MadeFor = _SetPoints | _SeveralMotions | _Drawn | _Unnamed
_MADE_FOR: TypeAdapter[_MadeFor] = TypeAdapter(_MadeFor)


class _AlongMotion(Checked):
    name: str
    fingerprint: str
    set_points: int
    errors: list[_JointError]


class _NormShare(Checked):
    states: float = Field(gt=0.0, le=1.0)
    # None where only an error is, and no torque.
    share: float | None = Field(ge=0.0)


class ModelDocument(Checked):
    """The whole file; `terms` are as the level's own entry says."""

    format: Literal["gd-analyze simplified model"]
    version: Literal[2]
    level: str
    drives: bool
    refitted: bool
    budget: str
    errors_are: Literal["sampled at the states of fitted_on"]
    errors: list[_JointError]
    fitted_on: _MadeFor
    # Of a model made for several motions: what is promised along each.
    motions: list[_AlongMotion] = Field(default_factory=list)
    # Norm of the error over norm of the torque, by the share of the states that keep it; not in older files.
    norms: list[_NormShare] = Field(default_factory=list)
    # Where the cheapest level was looked for: what each took.
    levels: list[_LevelTried] = Field(default_factory=list)
    search: list[_Step]
    solved: bool
    cut_short: bool = False
    operations: OperationCount
    operations_full: OperationCount
    arm_fingerprint: str
    arm: dict[str, Any]
    terms: list[dict[str, Any]]
    steps: list[list[str | float]]
    outputs: list[str | float]
    provenance: dict[str, str]
    digest: str

    @model_serializer(mode="wrap")
    def _without_what_is_not_there(self, write: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Of one motion the file says nothing of motions, of one level nothing of others."""
        said: dict[str, Any] = write(self)
        unsaid = ("motions", "norms", "levels")
        return {key: value for key, value in said.items() if value or key not in unsaid}


def document_of(model: SimplifiedModel) -> ModelDocument:
    """Write a model into its schema; the digest is left empty."""
    accuracy = model.accuracy
    steps, outputs = written(model.program)
    return ModelDocument(
        format=FORMAT,
        version=VERSION,
        level=model.level.name,
        drives=model.drives,
        refitted=model.refitted,
        budget=accuracy.budget,
        errors_are="sampled at the states of fitted_on",
        errors=_errors(model, accuracy),
        fitted_on=_MADE_FOR.validate_python(dict(accuracy.fitted_on)),
        motions=[
            _AlongMotion(
                name=one.name,
                fingerprint=one.fingerprint,
                set_points=one.set_points,
                errors=_errors(model, one),
            )
            for one in accuracy.motions
        ],
        norms=[
            _NormShare(states=norm.states, share=norm.share if np.isfinite(norm.share) else None)
            for norm in accuracy.norms
        ],
        levels=[_LevelTried(**one._asdict()) for one in accuracy.levels],
        search=[_Step(name=step.name, operations=step.operations) for step in accuracy.steps],
        solved=accuracy.solved,
        cut_short=accuracy.cut_short,
        operations=model.operations,
        operations_full=model.operations_full,
        arm_fingerprint=fingerprint(model.arm, model.drives),
        arm=describe_with_drives(model.arm),
        terms=model.level.to_entries(model.terms),
        steps=steps,
        outputs=outputs,
        provenance=dict(model.provenance),
        digest="",
    )


def _errors(model: SimplifiedModel, stated: Accuracy | AlongMotion) -> list[_JointError]:
    errors, spread = stated.errors, stated.uncertainty
    return [
        _JointError(
            joint=joint.name,
            unit=joint.effort_unit,
            peak_torque=errors.peak_torque[i],
            allowed_error=stated.allowed[i],
            largest_error=errors.largest[i],
            rms_error=errors.rms[i],
            uncertainty=None if spread is None else spread[i],
        )
        for i, joint in enumerate(model.arm.joints)
    ]


def model_of(document: ModelDocument) -> SimplifiedModel:
    """Rebuild the model; a ValueError or an error of this project's where the parts do not fit the arm."""
    level = level_named(document.level)
    form = ExactForm(arm_from_description(document.arm), document.drives)
    n = form.arm.n_joints
    inputs = {f"{name}{i + 1}" for name in ("q", "qd", "qdd") for i in range(n)}

    allowed, errors, spread = _stated(document.errors)
    return SimplifiedModel(
        level=level,
        form=form,
        terms=level.from_entries(form, document.terms),
        program=read_back(document.steps, document.outputs, inputs),
        refitted=document.refitted,
        operations_full=document.operations_full,
        accuracy=Accuracy(
            allowed,
            document.budget,
            errors,
            document.fitted_on.model_dump(),
            tuple(SearchStep(step.name, step.operations) for step in document.search),
            document.solved,
            document.cut_short,
            uncertainty=spread,
            motions=tuple(
                AlongMotion(one.name, one.fingerprint, one.set_points, *_stated(one.errors))
                for one in document.motions
            ),
            norms=tuple(
                NormShare(np.inf if norm.share is None else norm.share, norm.states)
                for norm in document.norms
            ),
            levels=tuple(LevelTried(one.level, one.operations, one.why) for one in document.levels),
        ),
        provenance=document.provenance,
    )


def _stated(errors: list[_JointError]) -> tuple[FloatArray, ErrorTable, FloatArray | None]:
    """Allowed errors, errors and uncertainty of all joints."""
    rows = [(row.peak_torque, row.allowed_error, row.largest_error, row.rms_error) for row in errors]
    peak, allowed, largest, rms = np.array(rows, dtype=float).reshape(-1, 4).T
    spread = [row.uncertainty for row in errors if row.uncertainty is not None]
    return allowed, ErrorTable(peak, largest, rms), np.array(spread) if len(spread) == len(errors) else None


def checked(model: SimplifiedModel, document: ModelDocument) -> SimplifiedModel:
    """Hold a rebuilt model against what its document states of it; `accuracy.measured` says what could be.

    Raises
    ------
    ModelError
        If the program does not compute the terms everywhere, or a statement is not true or contradicts
        itself.
    """
    require_equal("arm_fingerprint", document.arm_fingerprint, fingerprint(model.arm, model.drives))
    require_equal("operations", document.operations, model.operations)
    joints = [(joint.name, joint.effort_unit) for joint in model.arm.joints]
    for of in (document.errors, *(one.errors for one in document.motions)):
        require_equal("joints of errors", [(row.joint, row.unit) for row in of], joints)
    if document.motions or isinstance(document.fitted_on, _SeveralMotions):
        every = sum(one.set_points for one in document.motions)
        require_equal("set_points of motions", every, document.fitted_on.model_dump().get("set_points"))
    require_terms_computed(model)
    require_consistent(model)
    return measured_where_possible(model)


def checked_model(document: ModelDocument) -> SimplifiedModel:
    """Rebuild a model and hold it against its document; errors as of `model_of` and `checked`."""
    return checked(model_of(document), document)


# A term takes some hundred bytes, and models of a hundred thousand of them are not worth the name.
LARGEST_FILE = 100_000_000

_WRITE_AGAIN = "write the model again with `gd-analyze ROBOT TRAJECTORY` or `gd-analyze simplify ROBOT -o`"


def save_model(model: SimplifiedModel, path: str | Path) -> None:
    """Write a model as JSON, atomically.

    Raises
    ------
    OutputError
        If the file cannot be written.
    """
    write_text(path, model_text(model))


def model_text(model: SimplifiedModel) -> str:
    """What a model's file holds."""
    document = document_of(model)
    document.digest = _digest(document.model_dump())
    return json.dumps(document.model_dump(), indent=2, ensure_ascii=False) + "\n"


def load_model(path: str | Path) -> SimplifiedModel:
    """Read a model that `save_model` wrote; nothing in the file is executed.

    Raises
    ------
    ModelError
        If the file cannot be read, is not such a model, or was changed so that it no longer fits itself: its
        program must compute its terms at every state, the arm must be the one it was made for, and what it
        states must hold where that can be looked at, see `Accuracy.measured`.

    Warns
    -----
    GdAnalyzeWarning
        Of numbers of the arm that look like slips, as when it was read, and if files of another run stand
        beside it in a folder of results.
    """
    path = Path(path)
    raw = _read(path)
    if raw.get("version") != VERSION:
        raise ModelError(
            "the model file is of another version",
            where=Location(path),
            expected=f"version {VERSION}",
            found=f"version {in_python(raw.get('version'))}",
            next_step="use the gd-analyze that wrote it, or write the model again",
        )
    if raw.get("level") not in list(LEVELS):
        raise ModelError(
            "the model file is of a level that is not known",
            where=f"{path}: level",
            expected=f"one of {', '.join(LEVELS)}",
            found=in_python(raw.get("level")),
            next_step=_WRITE_AGAIN,
        )
    try:
        document = ModelDocument.model_validate(raw)
        model = model_of(document)
    except ValidationError as error:
        first = error.errors()[0]
        raise ModelError(
            "the model file is damaged",
            where=f"{path}: {'.'.join(str(key) for key in first['loc'])}",
            expected=first["msg"],
            found=in_python(first.get("input")),
            next_step=_WRITE_AGAIN,
        ) from None
    except (GdAnalyzeError, LookupError, TypeError, ArithmeticError, ValueError, AttributeError) as error:
        raise ModelError(
            "the model file is damaged: its arm or its terms cannot be rebuilt",
            where=Location(path),
            found=(str(error) or type(error).__name__).splitlines()[0],
            next_step=_WRITE_AGAIN,
        ) from None
    if raw["digest"] != _digest(raw):
        raise ModelError(
            "the model file was changed after it was written: its stated errors no longer hold",
            where=Location(path),
            expected=f"digest {_digest(raw)[:16]}... of its content",
            found=f"digest {str(raw['digest'])[:16]}...",
            next_step="write the model again for the arm and the parts you mean",
        )
    try:
        model = checked(model, document)
    except GdAnalyzeError as error:
        details = error.details
        raise ModelError(
            error.what,
            where=": ".join([str(path), *filter(None, [details.get("where")])]),
            expected=details.get("expected"),
            found=details.get("found"),
            next_step=_WRITE_AGAIN,
        ) from None
    warn_of_implausible(model.arm, stacklevel=2)
    warn_of_others(path, model.provenance.get("run", ""))
    return model


def _read(path: Path) -> dict[str, Any]:
    """Read the JSON of a model file, of any version and whatever it says."""
    try:
        data = read_at_most(path, LARGEST_FILE)
        if data is None:
            raise _foreign(path, f"a file of more than {megabytes(LARGEST_FILE)}")
        raw = json.loads(data.decode("utf-8"))
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
    except ValueError:
        raise _foreign(path, "a number of thousands of digits") from None
    except RecursionError:
        raise _foreign(path, "brackets nested beyond any model") from None
    if not isinstance(raw, dict) or raw.get("format") != FORMAT:
        raise _foreign(path, "other JSON")
    return raw


def _digest(document: dict[str, Any]) -> str:
    """SHA-256 of everything in the file but the digest itself."""
    content = {key: value for key, value in document.items() if key != "digest"}
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()


def _foreign(path: Path, found: str) -> ModelError:
    return ModelError(
        "this is not a gd-analyze model",
        where=Location(path),
        expected="a JSON file that gd-analyze wrote, e.g. model.json",
        found=found,
        next_step="name the model.json of a results folder",
    )
