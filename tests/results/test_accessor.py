"""The accessor `gd` of datasets says what the functions say, wherever the dataset comes from."""

from __future__ import annotations

from xml.etree import ElementTree

import matplotlib
import numpy as np
import pytest
from matplotlib import pyplot

import gd_analyze as gd
from gd_analyze.errors import UsageError

matplotlib.use("agg")


def test_elements_by_label(pick_and_place_dataset):
    dataset = pick_and_place_dataset
    d12 = dataset.gd.D("D12")
    assert d12.dims == ("time", "effect")
    np.testing.assert_array_equal(d12.values, dataset.inertia.values[:, :, 0, 1])
    assert d12.attrs["units"] == "kg m^2"
    np.testing.assert_array_equal(dataset.gd.h("h2").values, dataset.coriolis_centrifugal.values[:, :, 1])
    np.testing.assert_array_equal(dataset.gd.h("h213").values, dataset.christoffel.values[:, :, 1, 0, 2])
    np.testing.assert_array_equal(dataset.gd.c("c3").values, dataset.gravity_loading.values[:, 2])
    for call in (
        lambda: dataset.gd.D("D17"),
        lambda: dataset.gd.D("h2"),
        lambda: dataset.gd.c(2),
        lambda: dataset[["torque"]].gd.D("D12"),
        lambda: gd.rank(dataset).gd.D("D12"),
    ):
        with pytest.raises(UsageError):
            call()


def test_verdicts_and_ranking(pick_and_place_dataset):
    dataset, over_time = pick_and_place_dataset, gd.tables.dominance_over_time(pick_and_place_dataset)
    expected = gd.tables.verdicts(over_time)
    for each in (dataset, over_time):
        assert each.gd.verdicts().equals(expected)
    ranking = gd.rank(dataset, threshold=0.2)
    frame = ranking.gd.ranking()
    assert frame.equals(dataset.gd.ranking(threshold=0.2))
    assert frame.index.tolist() == ranking.element.values.tolist()
    assert len(frame) == 21 + 6 + 6
    np.testing.assert_array_equal(frame.part_peak_rotation, ranking.part_peak.sel(effect="rotation"))
    assert frame.verdict.tolist() == ranking.verdict.values.tolist()
    with pytest.raises(UsageError, match="options already"):
        ranking.gd.ranking(threshold=0.2)
    with pytest.raises(UsageError, match="not what `decompose` returns"):
        ranking.gd.verdicts()


def test_stored_results_have_it(stored, puma_findings):
    tree = gd.tables.load_results(stored)
    frame = tree["dominance"].to_dataset().gd.ranking()
    assert frame.verdict.tolist() == puma_findings.tables["dominance"].verdict.values.tolist()


@pytest.mark.slow
def test_figures_are_those_of_the_report(puma_findings):
    ours, reports = puma_findings.decomposition.gd.plot, puma_findings.plot
    for draw in ("inertia", "coriolis_centrifugal", "gravity_loading"):
        panels = [getattr(each, draw)() for each in (ours, reports)]
        for own, other in zip(*panels, strict=True):
            assert own.get_title(loc="left") == other.get_title(loc="left")
            for line, expected in zip(own.lines, other.lines, strict=True):
                np.testing.assert_array_equal(line.get_xydata(), expected.get_xydata())
    pyplot.close("all")
    assert "inertia()" in repr(ours)


def test_curves_stop_at_gaps(puma, pick_and_place):
    motions = gd.pool([pick_and_place, gd.read_trajectory("wrist-move", puma)])
    dataset = gd.decompose(puma, motions)
    for part, gap in ((dataset, pick_and_place.n_set_points), (dataset.isel(time=slice(20, None)), 11)):
        (axes,) = part.gd.plot.inertia(["D12"], marked=False)
        breaks = pick_and_place.n_set_points - (20 if part is not dataset else 0)
        assert breaks == gap
        assert all(np.isnan(line.get_ydata()).any() for line in axes.lines)
    pyplot.close("all")


def test_a_notebook_shows_the_largest_elements(pick_and_place_dataset):
    for dataset in (pick_and_place_dataset, gd.rank(pick_and_place_dataset)):
        page = ElementTree.fromstring(f"<p>{dataset.gd._repr_html_()}</p>")
        rows = [[*row.itertext()] for row in page.iter("tr")]
        assert len(rows) == 13
        assert [row[0] for row in rows[1:]] == gd.rank(pick_and_place_dataset).element.values[:12].tolist()
        assert len(repr(dataset.gd)) < 200
