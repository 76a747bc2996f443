"""Simplified models as JSON: versioned, checked against a schema and against their arm, never code.

A file holds what cannot be derived: the arm, which of its terms are kept, and what was found of the model's
accuracy. Coefficients and programs follow from the arm and the terms.
"""

from __future__ import annotations

import hashlib
import json
import warnings
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, ValidationError

from gd_analyze.arrays import FloatArray
from gd_analyze.dynamics.friction import FRICTION_TERMS
from gd_analyze.errors import GdAnalyzeError, GdAnalyzeWarning, Location, ModelError
from gd_analyze.files import megabytes, path_of, read_at_most, replaces_own, warn_of_others, write_text
from gd_analyze.motions.formats import shipped_trajectories
from gd_analyze.motions.margin import Margin
from gd_analyze.motions.read import read_trajectory
from gd_analyze.motions.states import States, states_in_box, states_of
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.arm_file import arm_in
from gd_analyze.robots.catalogue import OF_LOGS, builtin_arms, is_xml
from gd_analyze.robots.description import describe
from gd_analyze.robots.limits import box_limits
from gd_analyze.robots.plausibility import warn_of_implausible
from gd_analyze.simplification.accuracy import Accuracy, AlongMotion, Proven
from gd_analyze.simplification.exact import ExactForm, JointForm
from gd_analyze.simplification.exact_dynamics import ExactDynamics, allowed_by
from gd_analyze.simplification.levels import LEVELS
from gd_analyze.simplification.model import SimplifiedModel, require_model
from gd_analyze.text import field_fault, in_python, json_fault

MODEL_FORMAT: Literal["gd-analyze simplified model"] = "gd-analyze simplified model"
VERSION: Literal[8] = 8
WRITE_AGAIN = "write the model again with `gd-analyze ROBOT TRAJECTORY` or `gd-analyze simplify ROBOT -o`"
# A term takes some hundred bytes; a model of a hundred thousand terms is not simplified.
LARGEST_FILE = 100_000_000
# Most drawn states at which errors are measured again: a tenth of a second.
MOST_MEASURED_AGAIN = 10_000
# An error measured on another machine may exceed the allowed one by rounding.
_ROUNDING = 1e-9
_MODEL = "a JSON file that gd-analyze wrote, e.g. model.json"


class ModelDocument(BaseModel):
    """The whole file."""

    model_config = ConfigDict(extra="forbid", allow_inf_nan=False)

    format: Literal["gd-analyze simplified model"]
    version: Literal[8]
    level: str
    velocities: Literal["absolute", "joint"]  # those of the terms
    drives: bool
    accuracy: Accuracy
    arm: dict[str, Any]
    terms: Literal["all"] | list[Any]  # those kept, as the level writes them; "all" is the exact torque
    provenance: dict[str, str]
    digest: str


def document_of(model: SimplifiedModel) -> ModelDocument:
    """Write a model into its schema; the digest is left empty."""
    level = model.level
    return ModelDocument(
        format=MODEL_FORMAT,
        version=VERSION,
        level=level.name,
        velocities="joint" if isinstance(model.form, JointForm) else "absolute",
        drives=model.drives,
        accuracy=model.accuracy,
        arm=describe(model.arm),
        terms="all" if model.drops_nothing else [level.entry(term) for term in model.terms],
        provenance=dict(model.provenance),
        digest="",
    )


def model_of(document: ModelDocument) -> SimplifiedModel:
    """Rebuild a model, with its errors measured again where its states are at hand.

    Raises
    ------
    ModelError
        If numbers are not those of the arm's joints, or the model misses its budget.
    """
    level, arm = LEVELS[document.level], arm_in(document.arm)
    form = ExactForm(arm, document.drives)
    form = form.in_joint_velocities if document.velocities == "joint" else form
    terms = level.terms(form) if document.terms == "all" else level.from_entries(form, document.terms)
    model = SimplifiedModel(
        level=level,
        form=form,
        terms=terms,
        accuracy=_accuracy_of(arm, document.accuracy),
        provenance=document.provenance,
    )
    return _measured_where_possible(model)


def _accuracy_of(arm: RobotArm, stated: Accuracy) -> Accuracy:
    """What a file states, and what follows from that: allowed errors, and the names of states."""
    _require_of_joints(arm, stated)
    allowed, certificate = allowed_by(stated.asked, stated.references(arm)), stated.certificate
    if certificate is not None:
        where = _states_of(arm, certificate, str(stated.fitted_on.get("trajectory")))
        certificate = replace(certificate, where=where, proven_here=False)
    motions = tuple(_along(arm, stated, motion, allowed) for motion in stated.motions)
    return replace(stated, allowed=allowed, motions=motions, certificate=certificate, measured=False)


def _along(arm: RobotArm, stated: Accuracy, motion: AlongMotion, allowed: FloatArray) -> AlongMotion:
    """Accuracy along one of several motions; a joint without torque there is allowed the error over all."""
    by = replace(stated, errors=motion.errors, uncertainty=motion.uncertainty).references(arm)
    # Rounded as errors of several motions are weighed, so that a file read and written stays the same.
    weights = np.maximum(allowed / allowed_by(stated.asked, by), 1.0)
    return replace(motion, allowed=allowed / np.where(motion.errors.peak_torque > 0.0, weights, 1.0))


def _require_of_joints(arm: RobotArm, stated: Accuracy) -> None:
    """Raise a ModelError unless there is a number for every joint of the arm."""
    n, bound = arm.n_joints, stated.certificate
    arrays = {"uncertainty": stated.uncertainty, **vars(stated.errors)}
    for motion in stated.motions:
        arrays[f"motion {motion.name}: uncertainty"] = motion.uncertainty
        arrays |= {f"motion {motion.name}: {name}": array for name, array in vars(motion.errors).items()}
    if stated.log is not None:
        of_log = ("rms_exact", "rms", "below_95", *FRICTION_TERMS, "left", "growth")
        arrays |= {f"log {name}": getattr(stated.log, name) for name in of_log}
    if bound is not None:
        names = ("certified", "lower", "upper", "velocity", "acceleration")
        arrays |= {f"certificate {name}": getattr(bound, name) for name in names}
    shapes: list[tuple[str, tuple[int, ...], tuple[int, ...]]] = [
        (name, array.shape, (n,)) for name, array in arrays.items() if array is not None
    ]
    if bound is not None and bound.trajectory_fingerprint:
        pieces = () if bound.pieces is None else bound.pieces.shape
        shapes.append(("certificate pieces", pieces, (n, 2, 3, n)))
    for name, shape, expected in shapes:
        if shape != expected:
            message = f"not the numbers of {n} joints"
            raise ModelError(message, where=name, expected=f"shape {expected}", found=f"shape {shape}")


def _states_of(arm: RobotArm, bound: Proven, trajectory: str) -> str:
    """Name of the states of a bound, by its numbers."""
    if bound.margin:
        return f"{Margin.parse(bound.margin).in_words(arm)} of {trajectory}"
    with warnings.catch_warnings(action="ignore", category=GdAnalyzeWarning):  # given when the arm is read
        *limits, remark = vars(box_limits(arm)).values()
    stated = bound.lower, bound.upper, bound.velocity, bound.acceleration
    is_all = all(np.array_equal(a, b) for a, b in zip(stated, limits, strict=True))
    return f"the arm's limits{remark}" if is_all else "the box"


def _measured_where_possible(model: SimplifiedModel) -> SimplifiedModel:
    """Measure errors again at states of a box or a shipped motion; others remain stated."""
    accuracy, states = model.accuracy, None
    count, seed, name = (accuracy.fitted_on.get(key) for key in ("states", "seed", "trajectory"))
    # A different arm may have the name of one that a motion was planned for, with limits that it exceeds.
    with warnings.catch_warnings(action="ignore", category=GdAnalyzeWarning), suppress(GdAnalyzeError):
        if isinstance(count, int) and isinstance(seed, int):
            if 0 < count <= MOST_MEASURED_AGAIN and seed >= 0:
                states = states_in_box(model.arm, count, seed)
        elif name in shipped_trajectories():
            states = states_of(read_trajectory(str(name), model.arm))
    if states is None or dict(states.described) != dict(accuracy.fitted_on):
        return model
    return measured_at(model, states)


def measured_at(model: SimplifiedModel, states: States) -> SimplifiedModel:
    """Measure a model's errors at the states it was fitted on; a ModelError if it misses its budget there.

    Near these states gamma may be larger than at them.
    """
    exact, stated = ExactDynamics.of(model.arm, states, model.drives), model.accuracy
    if stated.log is not None:
        exact = replace(exact, left_of_log=stated.log.left)
    allowed = exact.allowed(stated.asked)
    gamma = model.gamma(exact) if stated.gamma is None else max(stated.gamma, model.gamma(exact))
    accuracy = replace(stated, allowed=allowed, gamma=gamma, measured=True)
    accuracy = exact.held(accuracy, model.torque(*states.arrays))
    largest, promised = accuracy.errors.largest, model.promised(replace(stated, allowed=allowed))
    if (largest > (1.0 + _ROUNDING) * promised).any():
        joint = int((largest / promised).argmax())
        raise ModelError(
            "the model misses its budget",
            where=f"joint {joint + 1}, {model.arm.joints[joint].name}, at {states.in_words}",
            expected=f"an error of at most {promised[joint]:.6g}",
            found=f"{largest[joint]:.6g}",
            next_step=WRITE_AGAIN,
        )
    return model.stating(accuracy)


def save_model(model: SimplifiedModel, path: str | Path) -> None:
    """Write a model as JSON, atomically.

    Raises
    ------
    OutputError
        If the file cannot be written, or would replace one that is not a model.
    """
    require_model(model)
    replaces_model(path_of(path))
    write_text(path, model_text(model))


def replaces_model(path: Path) -> bool:
    """Whether a model would be replaced by one written there; an OutputError if anything else would."""
    return replaces_own(path, MODEL_FORMAT, "model")


def model_text(model: SimplifiedModel) -> str:
    """Content of a model's file."""
    document = document_of(model).model_dump(mode="json")
    return json.dumps(document | {"digest": digest_of_model(document)}, indent=2, ensure_ascii=False) + "\n"


def load_model(path: str | Path) -> SimplifiedModel:
    """Read a model that `save_model` wrote; nothing in the file is executed.

    Raises
    ------
    ModelError
        If the file cannot be read or is not such a model, if a term is none of its arm's, or if it misses its
        budget at states that are at hand. What else it states of its errors remains stated, see
        `Accuracy.measured`.

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
    if raw.get("digest") != digest_of_model(raw):
        message = "the model file was changed after it was written: its stated errors no longer hold"
        stated = f"digest {str(raw.get('digest'))[:16]}"
        raise _refused(message, str(path), f"digest {digest_of_model(raw)[:16]}... of its content", stated)
    _require_text(raw, path)
    try:
        model = model_of(ModelDocument.model_validate(raw))
    except ValidationError as error:
        first = error.errors()[0]
        where = f"{path}: {'.'.join(str(key) for key in first['loc'])}"
        raise _refused("the model file is damaged", where, *field_fault(first)) from None
    except GdAnalyzeError as error:
        raise fault_of_file(path, error) from None
    except (LookupError, TypeError, ArithmeticError, ValueError, AttributeError) as error:
        message = "the model file is damaged: its arm or its terms cannot be rebuilt"
        value = (str(error) or type(error).__name__).splitlines()[0]
        raise _refused(message, str(path), None, value) from None
    warn_of_implausible(model.arm)
    warn_of_others(path, model.provenance.get("run", ""))
    return model


def _require_text(raw: dict[str, Any], path: Path) -> None:
    """Raise a ModelError where text holds half a character, which JSON can state and no file can hold."""
    try:
        json.dumps(raw, ensure_ascii=False).encode()
    except UnicodeEncodeError as error:
        message, found = "the model file is damaged: this is no text", error.object[error.start : error.end]
        before = error.object[max(0, error.start - 40) : error.start]
        raise _refused(message, f"{path}, after {in_python(before)}", "text", in_python(found)) from None


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
