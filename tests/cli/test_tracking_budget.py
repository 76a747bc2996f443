"""`simplify --budget "tracking ..."`: a model, how it tracks, and what cannot be asked for."""

from __future__ import annotations

import re

import numpy as np
import pytest

import gd_analyze as gd

SWING = "simplify two_link two-link-swing --budget"


@pytest.mark.slow
def test_a_model_is_made_for_it_and_tracks_as_well(run):
    words = "tracking 3deg at 40 rad/s"
    found = run(SWING, words, "-o", "model.json", "--json").json
    assert found["tracking"] == words
    assert 0.0 < found["tracking_simulated"] <= 1.0
    model = gd.load_model("model.json")
    assert model.saves
    study = gd.control(
        model, "two-link-swing", gd.types.ControlSettings(40.0, rates=(1000.0,), speeds=(1.0,))
    )
    shares = [x.peak_error.max() / np.radians(3.0) for x in study.loops if "simplified" in x.controller.title]
    assert found["tracking_simulated"] in (pytest.approx(share) for share in shares)


def test_it_is_shown_in_millimetres(run):
    shown = run(SWING, "tracking 50mm at the end effector").words
    assert re.search(r"\d mm, simulated", shown)
    assert "tracking 50mm at the end effector" in shown


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("simplify two_link --budget", "trajectory"),
        ("two_link two-link-swing --budget", "`gd-analyze simplify`"),
    ],
)
def test_it_is_of_one_motion(run, line, said):
    found = run(line, "tracking 0.1deg")
    assert found.code == 2
    assert said in found.err


def test_what_the_exact_model_cannot_track_is_told(run):
    found = run(SWING, "tracking 0.0001deg")
    assert found.code == 2
    assert "exact" in found.err
