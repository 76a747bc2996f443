"""[FGL87]'s own model: the torque error of dropping parts, summed here from the decomposition."""

from __future__ import annotations

import numpy as np
import pytest

import gd_analyze as gd
from gd_analyze.simplification.element import (
    VERDICT_SOURCES,
    ElementPart,
    model_by_verdicts,
    operations_by_quantity,
    parts_of,
)
from gd_analyze.types import ExactDynamics
from long_cases import long


@pytest.fixture(scope="module")
def exact(puma) -> ExactDynamics:
    return ExactDynamics.of(puma, gd.decompose(puma, "pick-and-place", drives=False), drives=False)


def dropped_torque(dataset, kept: set[str]) -> np.ndarray:
    """Largest torque per joint of the parts of D and h that are not kept, labels such as "D12 rotation"."""
    lost = np.zeros(dataset.torque.shape)
    for e, effect in enumerate(("translation", "rotation")):
        for i in range(6):
            if f"h{i + 1} {effect}" not in kept:
                lost[:, i] += dataset.coriolis_centrifugal.values[:, e, i]
            for j in range(6):
                if f"D{min(i, j) + 1}{max(i, j) + 1} {effect}" not in kept:
                    lost[:, i] += dataset.inertia.values[:, e, i, j] * dataset.qdd.values[:, j]
    return np.abs(lost).max(axis=0)


@pytest.mark.parametrize(
    ("verdicts", "per_cent"),
    [("text", [2.62, 3.84, 3.76, 11.57, 2.92, 0.0]), long("own", [0.0, 0.0, 1.26, 1.05, 0.0, 0.0])],
)
def test_its_error_is_the_torque_of_the_dropped_parts(exact, verdicts, per_cent, tmp_path):
    model = model_by_verdicts(exact, verdicts)
    errors = model.accuracy.errors
    # Per cent of peak along pick-and-place, links alone, worked out beforehand to two decimals.
    assert np.abs(100 * errors.largest_share - per_cent).max() < 0.006
    lost = dropped_torque(exact.decomposed, {part.label for part in model.terms})
    # Torques of 42 N m, summed in another order.
    assert np.abs(errors.largest - lost).max() < 1e-12
    gd.save_model(model, tmp_path / "model.json")
    again = gd.load_model(tmp_path / "model.json")
    states = gd.tables.states_in_box(exact.arm, 50)
    assert np.array_equal(again.torque(*states.arrays), model.torque(*states.arrays))
    assert "coriolis_centrifugal" in gd.export(again, ["c"]).files["puma560.h"]


def test_our_own_verdicts_are_those_of_the_ranking(exact):
    ranking = gd.rank(exact.decomposed)
    kept = set(model_by_verdicts(exact, "own").terms)
    for label, verdict in zip(ranking.element.values, ranking.dominant.values, strict=True):
        parts = [part for part in parts_of(6) if part.element.label == label]
        expected = {part for part in parts if verdict in (part.effect, "both")}
        assert expected == kept & set(parts), label


def test_operations_are_those_of_d_h_and_c(exact):
    every, text = (
        {name: count.total for name, count in operations_by_quantity(exact.form, kept).items()}
        for kept in (parts_of(6), model_by_verdicts(exact, "text").terms)
    )
    assert list(every) == ["D", "h", "c", "D, h and c"]
    for name in every:
        assert text[name] <= every[name]
    # What the three share is computed once.
    assert max(every["D"], every["h"]) < every["D, h and c"] < every["D"] + every["h"] + every["c"]
    assert operations_by_quantity(exact.form, set[ElementPart]())["D, h and c"].total == 0


def test_an_arm_that_the_text_does_not_show_is_refused(two_link):
    exact = ExactDynamics.of(two_link, gd.decompose(two_link, "two-link-swing"))
    assert model_by_verdicts(exact, VERDICT_SOURCES[0]).terms
    with pytest.raises(gd.GdAnalyzeError, match="two_link"):
        model_by_verdicts(exact, "text")
