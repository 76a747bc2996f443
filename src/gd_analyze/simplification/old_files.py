"""Model files of earlier versions, brought up to the present one."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from gd_analyze.operations.written import written
from gd_analyze.robots.description import arm_from_description
from gd_analyze.simplification.effort import THOROUGH
from gd_analyze.simplification.exact_form import ExactForm
from gd_analyze.simplification.levels import level_named

# How version 1 called a level's terms.
_TERMS = {"element": "kept", "term": "torques", "energy": "energy"}


def from_version_1(raw: dict[str, Any]) -> dict[str, Any]:
    """Write what a file of version 1 says as version 2 does; errors of any kind where it is damaged.

    Version 1 named terms differently at every level, kept the search as a sentence, and had no program for
    models of parts.
    """
    new = {key: value for key, value in raw.items() if key not in ("dropped", *_TERMS.values())}
    provenance = dict(raw["provenance"])
    sentence = provenance.pop("search", "")
    steps = [step.rpartition(" ") for step in sentence.split(", ") if step and step != "solved to the end"]
    terms = raw[_TERMS[raw["level"]]]
    new |= {
        "version": 2,
        "provenance": provenance,
        "search": [{"name": name, "operations": int(operations)} for name, _, operations in steps],
        "solved": sentence.endswith("solved to the end"),
        "terms": [{"part": label} for label in terms] if raw["level"] == "element" else terms,
    }
    if "steps" not in raw:
        level = level_named(raw["level"])
        form = ExactForm(arm_from_description(raw["arm"]), raw["drives"])
        kept = level.from_entries(form, new["terms"])
        program = level.write(form, kept, THOROUGH)
        new["steps"], new["outputs"] = written(program)
        # Counted as it is written now.
        new["operations"] = asdict(program.count)
    return new
