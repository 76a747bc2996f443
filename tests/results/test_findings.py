"""The main job: files hold what was found, the result says it in facts, and bad input costs nothing."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import gd_analyze as gd
from gd_analyze import Trajectory, analyze
from gd_analyze.cache import without_cache
from gd_analyze.errors import OutputError, UsageError
from gd_analyze.report.main_report import JSON, main_result
from gd_analyze.results.model_facts import headline, worst_error
from gd_analyze.results.run_facts import run_headline
from gd_analyze.simplification.harmonic import TERM
from gd_analyze.simplification.search import SearchOptions
from gd_analyze.simplification.simplify import simplify_exact
from gd_analyze.studies.main_job import find
from gd_analyze.studies.settings import default_folder
from gd_analyze.tables import with_payload
from gd_analyze.types import Progress, Settings
from recordings import with_torques
from strategies import names_in


def test_nothing_is_written_without_a_folder(two_link, swing, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert analyze(two_link, swing).model.operations.total > 0
    assert names_in(tmp_path) == []


@pytest.mark.parametrize(
    ("options", "more"),
    [
        ({"budget": "1%,0.2"}, "-budget-1pct_0.2_N_m"),
        (
            {"level": "energy", "at_set_points": True, "christoffel": False},
            "-level-energy-at-set-points-no-christoffel",
        ),
    ],
)
def test_the_default_folder_says_the_options(two_link, swing, options, more):
    assert default_folder(two_link, swing, Settings(**options)).name == f"two_link-two-link-swing{more}"


def test_a_folder_or_a_format_that_cannot_be_writes_nothing(two_link, swing, blocked_folder, tmp_path):
    with pytest.raises(OutputError) as caught:
        analyze(two_link, swing, blocked_folder)
    assert str(blocked_folder) in caught.value.details["where"]
    with pytest.raises(UsageError, match="docx"):
        analyze(two_link, swing, tmp_path / "new", formats=("h5", "docx"))
    assert names_in(tmp_path) == ["file"]


@pytest.mark.slow
def test_budget_and_options_reach_what_they_are_for(puma, pick_and_place):
    found = gd.analyze(puma, pick_and_place, budget="5%", drives=True, christoffel=False, terms=True)
    assert (found.model.accuracy.budget, found.model.drives) == ("5%", True)
    assert "christoffel" not in found.decomposition
    assert "coriolis_centrifugal_terms" in found.decomposition
    peak = np.abs(found.decomposition.torque.values).max(axis=0)
    np.testing.assert_array_equal(found.dominance.attrs["floor"], 0.05 * peak / 8)
    np.testing.assert_array_equal(found.model.accuracy.allowed, 0.05 * peak)


def test_the_budget_holds_near_the_motion(puma_findings):
    """Proven, in one figure of the headline; the slider's model is the one shown."""
    model, tube = puma_findings.model, puma_findings.tables["tube"]
    assert (tube.tube_certified.values <= model.accuracy.allowed).all()
    assert tube.attrs["tried"] == 0
    headline = run_headline(puma_findings)
    exact, torque = (
        model.form.functions.operations,
        f"torque in {model.operations.pair} instead of 284 and 10.",
    )
    assert exact.total <= 359
    apart = model.functions.operations.in_words
    assert headline.startswith(f"D, h and c in {apart} instead of {exact.pair}; {torque}")
    assert headline.endswith("(proven).")


@pytest.mark.slow
def test_at_set_points_it_holds_there_only(puma, pick_and_place, puma_findings):
    found = gd.analyze(puma, pick_and_place, drives=True, at_set_points=True, level="term")
    allowed = puma_findings.model.accuracy.allowed
    assert (found.model.accuracy.errors.largest <= allowed).all()
    assert (found.tables["tube"].tube_certified.values > allowed).any()
    assert default_folder(puma, pick_and_place, Settings(at_set_points=True)).name.endswith("-at-set-points")


def test_where_a_bound_is_loose_states_are_tried_and_stored(two_link, swing, monkeypatch, tmp_path):
    monkeypatch.setattr("gd_analyze.certification.holding.LOOSE_BOUND", 0.0)
    with without_cache():
        found = gd.analyze(two_link, swing, budget="60%")
    tube, model = found.tables["tube"], found.model
    assert model.saves
    assert tube.attrs["tried"] == 200_000
    assert (tube.tube_worst_found.values <= model.accuracy.allowed).all()
    assert (tube.tube_certified >= tube.tube_worst_found).all()
    assert "200 000 states" in run_headline(found)
    facts = main_result(found, JSON).values()
    assert facts["tried_error"] == pytest.approx(float(tube.tube_worst_found_share.max()))
    assert facts["tube"]["tried"] == 200_000
    gd.tables.save_results(found, tmp_path / "analysis.h5")
    again = gd.load_findings(tmp_path / "analysis.h5")
    assert run_headline(again) == run_headline(found).replace("proven", "stated in the file")


@pytest.mark.slow
def test_the_number_of_terms_counts_unlisted_ones(puma, pick_and_place) -> None:
    """Carrying something off the last axis makes more terms than a ranking lists; all are counted."""
    arm = with_payload(puma, 2.0, np.array([0.05, 0.0, 0.1]))
    findings = gd.analyze(arm, pick_and_place, level="term", at_set_points=True)
    total = findings.tables["terms"].attrs["total"]
    assert total == len(TERM.terms(findings.model.form)) > findings.tables["terms"].sizes["rank"]
    assert main_result(findings, JSON).values()["terms_total"] == total


def test_the_tube_holds_what_certify_proves(puma, pick_and_place, puma_findings):
    table, model = puma_findings.tables["tube"], puma_findings.model
    tube = gd.types.Tube.along(puma, pick_and_place)
    certificate = gd.certify(model, tube, effort=100_000)
    np.testing.assert_array_equal(table.tube_along, certificate.along)
    np.testing.assert_array_equal(table.tube_certified, certificate.certified)
    np.testing.assert_array_equal(table.segment_from, tube.begin)
    for name, margins in zip(("q", "qd", "qdd"), tube.margins, strict=True):
        np.testing.assert_array_equal(table[f"tube_margin_{name}"], margins)
    assert (table.tube_certified >= model.accuracy.errors.largest).all()
    assert (table.tube_certified < puma_findings.tables["beyond"].certified).all()
    assert table.attrs["note"] in main_result(puma_findings, JSON).values()["notices"]


@pytest.mark.parametrize("margin", ["3deg,qd=6%", gd.types.Margin(revolute=np.radians(3.0), velocity=0.06)])
def test_the_margin_is_the_users(two_link, swing, margin):
    found = gd.analyze(two_link, swing, margin=margin, budget="5%")
    assert found.tables["tube"].attrs["margin"] == "3deg,1mm,qd=6%,qdd=5%"
    np.testing.assert_allclose(found.tables["tube"].tube_margin_q, np.radians(3.0))
    usual = gd.analyze(two_link, swing, budget="5%")
    assert usual.provenance["run"] != found.provenance["run"]
    with pytest.raises(UsageError, match="margin"):
        Settings(margin="3")


@pytest.mark.filterwarnings("ignore::gd_analyze.GdAnalyzeWarning")
def test_a_torn_motion_has_no_certificate_and_one_point_has(two_link):
    """What is said of the set points themselves stays."""
    q = np.array([[0.0, 0.0], [1.0, 1.0], [1.1, 1.2]])
    torn = gd.analyze(two_link, Trajectory(np.array([0.0, 1e-9, 1.0]), q, 0.1 + 0 * q, 1 + 0 * q, "torn"))
    assert torn.tables["tube"].tube_certified.isnull().all()
    assert main_result(torn, JSON).values()["proven_error"] is None
    assert "not proven" in run_headline(torn) or not torn.model.saves
    one = gd.analyze(two_link, Trajectory(np.zeros(1), q[:1], q[:1], q[:1], "one"))
    assert one.tables["tube"].tube_certified.notnull().all()


@pytest.fixture(scope="module")
def of_budget(puma, pick_and_place):
    exact = gd.types.ExactDynamics.of(puma, pick_and_place, True)
    return lambda budget: simplify_exact(exact, budget, SearchOptions(thorough=False))


def test_errors_are_in_the_terms_of_the_budget(of_budget):
    model = of_budget("1%")
    errors, worst = model.accuracy.errors, worst_error(model)
    expected = errors.worst + 1, "peak torque", errors.largest_share.max()
    assert (worst.joint, worst.of, worst.value) == expected
    # A bound is never shown smaller than it is.
    assert worst_error(model, 0.01001 * errors.peak_torque).size == "1.1 %"
    model = of_budget("1")
    assert worst_error(model, np.full(6, 1.0001)).size == "1.01 N m"
    assert worst_error(model).text == f"{model.accuracy.errors.largest.max():.3g} N m"
    model = of_budget("1% or 10% friction")
    used, worst = model.accuracy.errors.largest / model.accuracy.allowed, worst_error(model)
    assert (worst.joint, worst.of, worst.value) == (used.argmax() + 1, "the budget", used.max())
    references = [worst_error(of_budget(text)).facts("error", "Error")[1].value for text in ("1%", "1")]
    assert references == ["peak torque", "N m"]


@pytest.mark.slow
def test_it_is_said_where_nothing_can_be_dropped(of_budget, swing_findings):
    model = of_budget("0.0001%")
    assert not model.saves
    assert f"{model.operations_full.total} operations" in headline(model)
    assert main_result(swing_findings, JSON).values()["proven_error"] == 0.0


class Events(Progress):
    """Notes stages and warnings in the order in which the main job tells them."""

    def __init__(self) -> None:
        self.events: list[str] = []

    def stage(self, label: str, total: int | None = None) -> None:
        self.events.append(label)

    def ranked(self, ranking: object, budget: str) -> None:
        self.events.append("ranked")


def test_warnings_are_told_when_their_step_ends(two_link, swing) -> None:
    """That log and file do not agree is told before models are searched."""
    torque = gd.decompose(two_link, swing).torque.values
    told = Events()
    with warnings.catch_warnings(action="always"):
        warnings.showwarning = lambda message, *_, **__: told.events.append(str(message))
        found = find(two_link, with_torques(swing, -torque), Settings(level="element"), progress=told)
    (contradiction,) = [text for text in found.warnings if "The file does not fit" in text]
    assert found.warnings[0] == contradiction
    assert told.events.index(contradiction) < told.events.index("ranked")
    assert told.events.index("ranked") < told.events.index("trying other budgets")
    assert told.events.count(contradiction) == 1
