"""`gd.simplify` is `gd-analyze simplify`: one function with the same arguments gives the same model."""

from __future__ import annotations

import json
import shlex

import numpy as np
import pytest

import gd_analyze as gd
from gd_analyze.errors import UsageError


@pytest.fixture
def command(run, tmp_path):
    """The model that the command writes."""

    def model(words: str) -> gd.types.SimplifiedModel:
        path = tmp_path / "model.json"
        assert run("simplify", *shlex.split(words), "--out", path).code == 0
        return gd.load_model(path)

    return model


def assert_same(model: gd.types.SimplifiedModel, other: gd.types.SimplifiedModel) -> None:
    assert model.operations == other.operations
    assert model.level == other.level
    assert str(model.accuracy.budget) == str(other.accuracy.budget)
    # The file keeps every digit.
    np.testing.assert_array_equal(model.accuracy.allowed, other.accuracy.allowed)
    np.testing.assert_array_equal(model.accuracy.errors.largest, other.accuracy.errors.largest)
    proofs = (model.accuracy.certificate, other.accuracy.certificate)
    bounds, other_bounds = (None if proof is None else proof.certified.tolist() for proof in proofs)
    assert bounds == other_bounds


@pytest.mark.slow
def test_near_pick_and_place_the_puma_takes_the_same_number_of_operations(command, puma, pick_and_place):
    model = gd.simplify(puma, pick_and_place)
    assert_same(model, command("puma560 pick-and-place"))
    assert model.accuracy.certificate is not None
    assert (model.accuracy.certificate.certified <= model.accuracy.allowed).all()


@pytest.mark.parametrize(
    ("words", "arguments"),
    [
        ("two_link", {}),
        ("two_link two-link-swing --budget 5% --margin 0.5deg", {"budget": "5%", "margin": "0.5deg"}),
        (
            "two_link two-link-swing --budget 20% --certified",
            {"budget": "20%", "certified": True},
        ),
        ("two_link two-link-swing --budget 20% --at-set-points", {"budget": "20%", "at_set_points": True}),
        ("two_link two-link-swing --level element --budget 20%", {"level": "element", "budget": "20%"}),
        ("two_link --level energy --budget 20%", {"level": "energy", "budget": "20%"}),
    ],
)
def test_options_are_arguments(command, words, arguments):
    motion = "two-link-swing" if "swing" in words else None
    assert_same(gd.simplify("two_link", motion, **arguments), command(words))


def test_a_region_may_be_any_box(two_link, swing):
    box = gd.types.Box.around(swing.q, swing.qd, swing.qdd)
    model = gd.simplify(two_link, swing, "20%", region=box, certified=True)
    certificate = gd.certify(model, box)
    assert (certificate.certified <= model.accuracy.allowed).all()
    np.testing.assert_array_equal(certificate.certified, model.accuracy.certificate.certified)


@pytest.mark.parametrize(
    "arguments",
    [
        {"region": 3},
        {"certified": True, "at_set_points": True},
        {"margin": "1deg", "at_set_points": True},
        {"verdicts": "text"},
        {"verdicts": "mine", "level": "element"},
        {"level": "element", "certified": True},
        {"level": "element", "at_set_points": True},
        {"budget": "tracking 1deg"},
        {"margin": "1deg", "trajectory": None},
        {"level": "exact"},
    ],
    ids=json.dumps,
)
def test_what_does_not_go_together_is_refused(arguments):
    given = {"trajectory": "two-link-swing"} | arguments
    with pytest.raises(UsageError) as caught:
        gd.simplify("two_link", given.pop("trajectory"), **given)
    assert next(iter(arguments)) in caught.value.details["where"]
