"""Model files changed by someone who sets the digest right again."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from gd_analyze.errors import ModelError
from gd_analyze.simplification.model import SimplifiedModel
from gd_analyze.simplification.model_file import _digest, load_model, save_model

Document = dict[str, Any]


def changed(model: SimplifiedModel, path: Path, change: Callable[[Document], Any]) -> Path:
    """Write a model, change its document, and sign it again."""
    save_model(model, path)
    document = json.loads(path.read_text(encoding="utf-8"))
    change(document)
    document["digest"] = _digest(document)
    path.write_text(json.dumps(document), encoding="utf-8")
    return path


def refused(model: SimplifiedModel, path: Path, change: Callable[[Document], Any]) -> ModelError:
    """Load it changed: it must be refused, with the file's name and a way out."""
    with pytest.raises(ModelError) as caught:
        load_model(changed(model, path, change))
    assert str(path) in caught.value.details["where"]
    assert caught.value.details["next"]
    return caught.value


class Steps:
    """The steps of a document, to be added to; what is there already is used again."""

    def __init__(self, document: Document) -> None:
        self.document = document

    def __call__(self, operation: str, *arguments: Any) -> str:
        step, steps = [operation, *arguments], self.document["steps"]
        if step not in steps:
            steps.append(step)
            kind = {"multiply": "multiplications", "cos": "sines_cosines", "sin": "sines_cosines"}
            kind |= {"add": "additions", "subtract": "additions"}
            if operation in kind:
                self.document["operations"][kind[operation]] += 1
        return f"s{steps.index(step)}"

    def add_to_output(self, what: Any) -> None:
        """Add something to the first output."""
        self.document["outputs"][0] = self("add", what, self.document["outputs"][0])
