"""Simplified models as JSON: versioned, checked against a schema, never code."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from gd_analyze.errors import GdAnalyzeError, Location, ModelError
from gd_analyze.files import megabytes, read_at_most, warn_of_others, write_text
from gd_analyze.robots.slips import warn_of_implausible
from gd_analyze.simplification.levels import LEVELS
from gd_analyze.simplification.model import SimplifiedModel
from gd_analyze.simplification.model_schema import (
    FORMAT,
    VERSION,
    ModelDocument,
    checked,
    document_of,
    model_of,
)
from gd_analyze.simplification.old_files import from_version_1
from gd_analyze.text import in_python

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
        states must hold where that can be looked at, see `Promise.measured`.

    Warns
    -----
    GdAnalyzeWarning
        Of numbers of the arm that look like slips, as when it was read, and if files of another run stand
        beside it in a folder of results.
    """
    path = Path(path)
    raw = _read(path)
    if raw.get("version") not in (1, VERSION):
        raise ModelError(
            "the model file is of another version",
            where=Location(path),
            expected=f"version {VERSION} or 1",
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
        content = from_version_1(raw) if raw["version"] == 1 else raw
        document = ModelDocument.model_validate(content)
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
