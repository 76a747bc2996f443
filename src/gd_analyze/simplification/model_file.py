"""Simplified models as JSON: versioned, checked against a schema and against themselves, never code.

Cheap results are recomputed; the others must be consistent, and remain statements of the file.
"""

from __future__ import annotations

import hashlib
import json
from contextlib import suppress
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, TypeAdapter, ValidationError

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import GdAnalyzeError, Location, ModelError, OutputError
from gd_analyze.files import megabytes, path_of, read_at_most, warn_of_others, write_text
from gd_analyze.motions.formats import shipped_trajectories
from gd_analyze.operations.program import plain_program, read_back
from gd_analyze.robots.catalogue import OF_LOGS, builtin_arms, is_xml
from gd_analyze.robots.description import arm_from_description, describe
from gd_analyze.robots.plausibility import warn_of_implausible
from gd_analyze.simplification.accuracy import (
    Accuracy,
    AlongMotion,
    ErrorTable,
    NormShare,
    Proven,
    SearchStep,
)
from gd_analyze.simplification.exact import ExactForm, JointForm
from gd_analyze.simplification.level import Checked
from gd_analyze.simplification.levels import LEVELS
from gd_analyze.simplification.model import SimplifiedModel, require_model
from gd_analyze.simplification.model_claims import (
    WRITE_AGAIN,
    measured_where_possible,
    require_consistent,
    require_equal,
    require_not_refuted,
    require_terms_computed,
    with_states_named,
)
from gd_analyze.text import field_fault, in_python, json_fault

MODEL_FORMAT: Literal["gd-analyze simplified model"] = "gd-analyze simplified model"
VERSION: Literal[7] = 7
# A term takes some hundred bytes; a model of a hundred thousand terms is not simplified.
LARGEST_FILE = 100_000_000
_BEGIN = 200  # bytes that hold the format's name
_MODEL = "a JSON file that gd-analyze wrote, e.g. model.json"


class _JointError(Checked):
    joint: str
    peak_torque: float
    allowed_error: float
    largest_error: float
    rms_error: float
    uncertainty: float | None


class _SetPoints(Checked):
    trajectory: str
    trajectory_fingerprint: str
    set_points: int
    motions: str | None = None


class _Drawn(Checked):
    box: str
    states: int
    seed: int


class _Unnamed(Checked):
    pass


_FittedOn = _SetPoints | _Drawn | _Unnamed
_FITTED_ON: TypeAdapter[_FittedOn] = TypeAdapter(_FittedOn)
# Share of the states, and share of the norm that they keep: None for an error without torque.
_Norm = tuple[Annotated[float, Field(gt=0.0, le=1.0)], Annotated[float, Field(ge=0.0)] | None]


class _AlongMotion(Checked):
    name: str
    fingerprint: str
    set_points: int
    errors: list[_JointError]


_Limits = tuple[list[float], list[float], list[float]]


class _Bound(Checked):
    joint: str
    certified: Annotated[float, Field(ge=0.0)]
    lower: float
    upper: float
    velocity: Annotated[float, Field(ge=0.0)]
    acceleration: Annotated[float, Field(ge=0.0)]
    # Of a tube: limits of q, qd and qdd of all joints in its piece with the largest bound of this one
    piece: tuple[_Limits, _Limits] | None


class _Certificate(Checked):
    """Bounds on the torque error, and their box, or the smallest box around the tube."""

    joints: list[_Bound]
    effort: Annotated[int, Field(ge=1)]
    margin: str
    trajectory_fingerprint: str

    def as_proven(self) -> Proven:
        joints: dict[str, Any] = {
            name: np.array([getattr(row, name) for row in self.joints]) for name in _PROVEN
        }
        pieces = [row.piece for row in self.joints if row.piece is not None]
        shape = (len(self.joints), 2, 3, len(self.joints))
        is_tube = bool(self.trajectory_fingerprint)
        if len(pieces) != (len(self.joints) if is_tube else 0):
            raise ValueError("a certificate near a motion has a piece for every joint, and no other has any")
        return Proven(
            **joints,
            **{name: getattr(self, name) for name in _ABOUT},
            where="",  # follows from the numbers and the arm
            pieces=np.array(pieces).reshape(shape) if is_tube else None,
        )


_PROVEN = ("certified", "lower", "upper", "velocity", "acceleration")
_ABOUT = ("effort", "margin", "trajectory_fingerprint")


class ModelDocument(Checked):
    """The whole file."""

    format: Literal["gd-analyze simplified model"]
    version: Literal[7]
    level: str
    velocities: Literal["absolute", "joint"]  # those of the terms
    drives: bool
    budget: str
    errors_are: Literal["sampled at the states of fitted_on"]
    errors: list[_JointError]
    fitted_on: _FittedOn
    motions: list[_AlongMotion]
    norms: list[_Norm]
    search: list[SearchStep]
    certificate: _Certificate | None
    gamma: Annotated[float, Field(ge=0.0)] | None
    arm: dict[str, Any]
    terms: list[dict[str, Any]]  # in the level's own format
    steps: list[list[str | float]]
    outputs: list[str | float]
    provenance: dict[str, str]
    digest: str


def document_of(model: SimplifiedModel) -> ModelDocument:
    """Write a model into its schema; the digest is left empty."""
    accuracy = model.accuracy
    steps, outputs = plain_program(model.program)
    return ModelDocument(
        format=MODEL_FORMAT,
        version=VERSION,
        level=model.level.name,
        velocities="joint" if isinstance(model.form, JointForm) else "absolute",
        drives=model.drives,
        budget=accuracy.budget,
        errors_are="sampled at the states of fitted_on",
        errors=_errors(model, accuracy),
        fitted_on=_FITTED_ON.validate_python(dict(accuracy.fitted_on)),
        motions=[
            _AlongMotion(
                name=m.name, fingerprint=m.fingerprint, set_points=m.set_points, errors=_errors(model, m)
            )
            for m in accuracy.motions
        ],
        norms=[(norm.states, norm.share if np.isfinite(norm.share) else None) for norm in accuracy.norms],
        search=list(accuracy.steps),
        certificate=_certificate(model),
        gamma=accuracy.gamma,
        arm=describe(model.arm),
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
            peak_torque=errors.peak_torque[i],
            allowed_error=stated.allowed[i],
            largest_error=errors.largest[i],
            rms_error=errors.rms[i],
            uncertainty=None if spread is None else spread[i],
        )
        for i, joint in enumerate(model.arm.joints)
    ]


def _certificate(model: SimplifiedModel) -> _Certificate | None:
    stated = model.accuracy.certificate
    if stated is None:
        return None
    joints = [
        _Bound(
            joint=joint.name,
            **{name: getattr(stated, name)[i] for name in _PROVEN},
            piece=None if stated.pieces is None else stated.pieces[i].tolist(),
        )
        for i, joint in enumerate(model.arm.joints)
    ]
    return _Certificate(joints=joints, **{name: getattr(stated, name) for name in _ABOUT})


def _model_of(document: ModelDocument) -> SimplifiedModel:
    level = LEVELS[document.level]
    form = ExactForm(arm_from_description(document.arm), document.drives)
    form = form.in_joint_velocities if document.velocities == "joint" else form
    inputs = {f"{name}{i + 1}" for name in ("q", "qd", "qdd") for i in range(form.arm.n_joints)}
    allowed, errors, spread = _stated(document.errors)
    return SimplifiedModel(
        level=level,
        form=form,
        terms=level.from_entries(form, document.terms),
        program=read_back(document.steps, document.outputs, inputs),
        accuracy=Accuracy(
            allowed,
            document.budget,
            errors,
            document.fitted_on.model_dump(exclude_none=True),
            tuple(document.search),
            uncertainty=spread,
            motions=tuple(
                AlongMotion(motion.name, motion.fingerprint, motion.set_points, *_stated(motion.errors))
                for motion in document.motions
            ),
            norms=tuple(NormShare(np.inf if x is None else x, part) for part, x in document.norms),
            certificate=None if document.certificate is None else document.certificate.as_proven(),
            gamma=document.gamma,
        ),
        provenance=document.provenance,
    )


def _stated(errors: list[_JointError]) -> tuple[FloatArray, ErrorTable, FloatArray | None]:
    """Allowed errors, errors and uncertainty of all joints."""
    rows = [(row.peak_torque, row.allowed_error, row.largest_error, row.rms_error) for row in errors]
    peak, allowed, largest, rms = np.array(rows, dtype=float).reshape(-1, 4).T
    spread = [row.uncertainty for row in errors if row.uncertainty is not None]
    return allowed, ErrorTable(peak, largest, rms), np.array(spread) if len(spread) == len(errors) else None


def checked_model(document: ModelDocument, rebuilt: SimplifiedModel | None = None) -> SimplifiedModel:
    """Rebuild a model, unless `rebuilt` is given, and check it against its document."""
    model = rebuilt or _model_of(document)
    joints = [joint.name for joint in model.arm.joints]
    if document.certificate is not None:
        require_equal("joints of certificate", [row.joint for row in document.certificate.joints], joints)
    for errors in (document.errors, *(motion.errors for motion in document.motions)):
        require_equal("joints of errors", [row.joint for row in errors], joints)
    if document.motions or "motions" in model.accuracy.fitted_on:
        total = sum(motion.set_points for motion in document.motions)
        require_equal("set_points of motions", total, model.accuracy.fitted_on.get("set_points"))
    require_terms_computed(model)
    require_consistent(model)
    require_not_refuted(model)
    return measured_where_possible(with_states_named(model))


def save_model(model: SimplifiedModel, path: str | Path) -> None:
    """Write a model as JSON, atomically.

    Raises
    ------
    OutputError
        If the file cannot be written.
    """
    require_model(model)
    write_text(path, model_text(model))


def replaces_model(path: Path) -> bool:
    """Whether a model would be replaced by one that is written there.

    Raises
    ------
    OutputError
        If the file there is neither a model nor empty.
    """
    if not path.is_file() or not path.stat().st_size:
        return False
    with suppress(OSError), path.open("rb") as file:
        if MODEL_FORMAT.encode() in file.read(_BEGIN):
            return True
    raise OutputError(
        "the model would replace a file that is not a model",
        where=Location(path),
        expected="a new name, or a model that gd-analyze wrote",
        next_step="choose another name with --out, or remove the file",
    )


def model_text(model: SimplifiedModel) -> str:
    """Content of a model's file."""
    document = document_of(model).model_dump()
    return json.dumps(document | {"digest": digest_of_model(document)}, indent=2, ensure_ascii=False) + "\n"


def load_model(path: str | Path) -> SimplifiedModel:
    """Read a model that `save_model` wrote; nothing in the file is executed.

    Raises
    ------
    ModelError
        If the file cannot be read, is not such a model, or is inconsistent: its program must compute its
        terms at every state, the arm must be the one it was fitted on, and its statements must hold where
        they can be checked, see `Accuracy.measured`.

    Warns
    -----
    GdAnalyzeWarning
        If numbers of the arm are implausible, or its folder contains files of another run.
    """
    path = path_of(path)
    raw = _read(path)
    for key, possible in (("version", [VERSION]), ("level", list(LEVELS))):
        if raw.get(key) not in possible:
            expected, value = " or ".join(map(str, possible)), in_python(raw.get(key))
            raise _refused(f"the model file has another {key}", f"{path}: {key}", expected, value)
    try:
        document = ModelDocument.model_validate(raw)
        model = _model_of(document)
    except ValidationError as error:
        first = error.errors()[0]
        where = f"{path}: {'.'.join(str(key) for key in first['loc'])}"
        raise _refused("the model file is damaged", where, *field_fault(first)) from None
    except (GdAnalyzeError, LookupError, TypeError, ArithmeticError, ValueError, AttributeError) as error:
        message = "the model file is damaged: its arm or its terms cannot be rebuilt"
        value = (str(error) or type(error).__name__).splitlines()[0]
        raise _refused(message, str(path), None, value) from None
    if raw["digest"] != digest_of_model(raw):
        message = "the model file was changed after it was written: its stated errors no longer hold"
        stated = f"digest {str(raw['digest'])[:16]}..."
        raise _refused(message, str(path), f"digest {digest_of_model(raw)[:16]}... of its content", stated)
    try:
        model = checked_model(document, model)
    except GdAnalyzeError as error:
        raise fault_of_file(path, error) from None
    warn_of_implausible(model.arm, stacklevel=2)
    warn_of_others(path, model.provenance.get("run", ""))
    return model


def _refused(message: str, where: str, expected: str | None, value: str | None) -> ModelError:
    return ModelError(message, where=where, expected=expected, found=value, next_step=WRITE_AGAIN)


def fault_of_file(path: Path, error: GdAnalyzeError) -> ModelError:
    """The error of a model whose statements do not hold, with the file that states them."""
    details = error.details
    where = ": ".join([str(path), *filter(None, [details.get("where")])])
    return _refused(error.what, where, details.get("expected"), details.get("found"))


def _read(path: Path) -> dict[str, Any]:
    """Read the JSON of a model file, unchecked."""
    content = "other JSON"
    try:
        data = read_at_most(path, LARGEST_FILE)
        raw = None if data is None else json.loads(data.decode("utf-8"))
        if data is None:
            content = f"a file of more than {megabytes(LARGEST_FILE)}"
        elif isinstance(raw, dict) and raw.get("format") == MODEL_FORMAT:
            return raw
    except OSError as error:
        if (refusal := _other_input(path)) is not None:
            raise refusal from None
        message, next_step = "cannot read the model file", "check the path and your read permission"
        if path.is_dir():
            next_step = "name the model.json in that folder"
        elif not path.exists():
            next_step = "check the path; `gd-analyze simplify ROBOT -o model.json` makes a model"
        raise ModelError(message, where=Location(path), found=error.strerror, next_step=next_step) from None
    except UnicodeDecodeError:
        content = "a file that is not text"
    except json.JSONDecodeError as error:
        content = json_fault(error)
        if (refusal := _other_input(path)) is not None:
            raise refusal from None
        if error.pos > 0:
            message, where = (
                "the model file is damaged: it is not JSON",
                Location(path, error.lineno, error.colno),
            )
            raise ModelError(message, where=where, found=content, next_step=WRITE_AGAIN) from None
    except (ValueError, RecursionError) as error:
        content = json_fault(error)
    message, next_step = "this is not a gd-analyze model", "name the model.json of a results folder"
    raise _other_input(path) or ModelError(
        message, where=Location(path), expected=_MODEL, found=content, next_step=next_step
    )


def _other_input(path: Path) -> ModelError | None:
    """Error for an arm or a motion in the place of a model; None if its name tells neither."""
    name, suffix = str(path), path.suffix.lower()
    if name in builtin_arms() or suffix == ".toml" or (path.is_file() and is_xml(path)):
        content, step = "an arm", f"make a model of it with `gd-analyze simplify {name} -o model.json`"
    elif name in shipped_trajectories() or suffix in OF_LOGS:
        content, step = (
            "a motion",
            f"name the model; `gd-analyze simplify ROBOT {name} -o model.json` makes one",
        )
    else:
        return None
    message = f"this is {content}, not a model"
    return ModelError(message, where=Location(path), expected=_MODEL, next_step=step)


def digest_of_model(document: dict[str, Any]) -> str:
    """SHA-256 of everything in the file except the digest."""
    content = {key: value for key, value in document.items() if key != "digest"}
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()
