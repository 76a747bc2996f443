"""Long functions tell their stages, and every step of a stage, to whoever is given as their progress."""

from __future__ import annotations

import pytest

import gd_analyze as gd
from told import Told

LABELS = {
    "read_trajectory": ["reading"],
    "read_log": ["reading"],
    "decompose": ["decomposing"],
    "simplify": ["searching at level term, at most 30 s"],
    "certify": ["certifying"],
    "evaluate": ["evaluating"],
    "trade_off": ["simplifying"],
    "batch": ["analysing"],
}


@pytest.fixture
def calls(two_link, swing, swing_findings, tmp_path):
    exact, row = gd.types.ExactDynamics.of(two_link, swing), {"arm": "two_link"}
    return {
        "read_trajectory": ["two-link-swing", two_link],
        "read_log": ["two-link-swing", two_link],
        "decompose": [two_link, swing],
        "simplify": [two_link, swing, "60%"],
        "certify": [swing_findings.model, gd.types.Box.of(two_link)],
        "evaluate": [swing_findings.model, swing],
        "trade_off": [exact, "40%"],
        "batch": [[row | {"trajectory": "two-link-swing", "level": "element"}], tmp_path],
    }


@pytest.mark.parametrize("name", LABELS)
def test_every_step_of_a_stage_is_told(name, calls):
    told = Told()
    getattr(gd, name)(*calls[name], progress=told)
    assert [label for label, _ in told.stages] == LABELS[name]
    for (_, total), steps in zip(told.stages, told.steps, strict=True):
        assert total is None or sum(steps) == total > 0
    assert told.counts == (["1 of 1 rows"] if name == "batch" else [])


def test_the_main_job_tells_all_it_does_from_reading_to_writing(two_link, tmp_path):
    told = Told()
    gd.analyze(two_link, "two-link-swing", tmp_path, level="element", formats=["json"], progress=told)
    labels = [label for label, _ in told.stages]
    assert (labels[:2], labels[-1]) == (["reading", "decomposing"], "writing json")
    assert len(set(labels)) == len(labels) > 4
