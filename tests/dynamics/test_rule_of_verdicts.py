"""One rule of verdicts: whoever gives one says the same of an element, at every threshold."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

import gd_analyze as gd
from gd_analyze.dynamics.verdicts import effect_words, least_changes, representing
from gd_analyze.simplification.element import model_by_verdicts, parts_of
from gd_analyze.types import ExactDynamics
from strategies import examples, motions

# Quarters from -2 to 2: equal parts, parts that cancel, and shares at the thresholds 25, 50 and 75 %.
SERIES = st.lists(st.tuples(*[st.integers(-8, 8)] * 2), min_size=1, max_size=4)
THRESHOLDS = st.integers(1, 99).map(lambda percent: percent / 100)


@examples(200)
@given(SERIES, THRESHOLDS)
@example([(4, 4)], 0.5)
@example([(4, 5)], 0.9)
@example([(4, -4)], 0.9)
def test_what_represents_an_element_leaves_out_what_is_not_needed(series, threshold):
    parts = np.array(series, dtype=float).T / 4
    part_peaks, peak = np.abs(parts).max(axis=1), np.abs(parts.sum(axis=0)).max()
    word = effect_words(representing(part_peaks, least_changes(part_peaks, peak, 2.0, threshold)))
    translation, rotation = part_peaks
    if not part_peaks.any():
        assert word == "zero"
    elif translation > threshold * peak and rotation > threshold * peak:
        assert word == "both"
    else:
        assert word == ("translation" if translation >= rotation else "rotation")
        # Less than half of the peak is made by the other part, or it is not needed.
        assert min(part_peaks) <= threshold * peak


@examples(24)
@given(motions(max_joints=2, count=6, massive=True), THRESHOLDS)
def test_ranking_set_points_probabilities_and_level_element_agree(case, threshold):
    require_agreement(*case, threshold)


@pytest.mark.parametrize("threshold", [0.1, 0.5, 0.6, 0.9, 0.99])
def test_they_agree_on_the_puma(puma, pick_and_place, threshold):
    require_agreement(puma, pick_and_place, threshold)


def require_agreement(arm, motion, threshold: float) -> None:
    dataset = gd.decompose(arm, motion, drives=False)
    ranking = gd.rank(dataset, threshold=threshold, budget=0.0)
    over_time = gd.tables.dominance_over_time(dataset, ranking)
    at_set_points = gd.tables.verdicts(over_time)
    exact = ExactDynamics.of(arm, dataset, drives=False)
    kept = set(model_by_verdicts(exact, "own", threshold).terms)
    sure = gd.tables.robustness(arm, motion, "mass=0%", threshold=threshold, samples=1)
    for label in ranking.element.values.tolist():
        row = ranking.sel(element=label)
        dominant = str(row.dominant.values)
        effects = {part.effect for part in parts_of(arm.n_joints) if part.element.label == label} & {
            part.effect for part in kept if part.element.label == label
        }
        assert effects == {"both": {"translation", "rotation"}, "zero": set()}.get(dominant, {dominant})
        # What stands at a set point stands over the motion.
        words = set(at_set_points.sel(element=label).values.tolist()) - {"zero", "negligible"}
        assert dominant == "both" or words <= {"gravity" if label[0] == "c" else dominant}
        part_peak, peak = row.part_peak.values, float(row.peak)
        # Probabilities are computed in single precision: near ties and near zero it decides otherwise.
        apart = [*np.abs(part_peak - threshold * peak), abs(part_peak[0] - part_peak[1])]
        if label[0] != "c" and part_peak.all() and min(apart) > 1e-4 * part_peak.max():
            assert sure.over_motion.sel(element=label, verdict=dominant) == 1.0
