"""What a person at a notebook types: names of arms and motions, options by name; and how values show."""

from __future__ import annotations

import dataclasses
from xml.etree import ElementTree

import numpy as np
import pytest

import gd_analyze as gd
from gd_analyze import builtin_arms
from gd_analyze.errors import ArmError, OutputError, TrajectoryError, UsageError
from gd_analyze.figures.structure import matrix_figure
from gd_analyze.figures.svg import figure_svg
from gd_analyze.motions.formats import shipped_trajectories
from gd_analyze.report.document import result_document
from gd_analyze.report.main_report import main_result
from gd_analyze.report.terminal import text_of
from gd_analyze.result import SeenFact
from gd_analyze.results.run_facts import elements_by_verdict, run_headline

ROBOT, MOTION = "two_link", "two-link-swing"


@pytest.mark.parametrize(
    "words",
    [(ROBOT, MOTION), (builtin_arms()[ROBOT], str(shipped_trajectories()[MOTION]))],
    ids=["names", "paths"],
)
def test_names_and_paths_will_do_wherever_an_arm_or_a_motion_is_asked_for(two_link, swing, words):
    arm, motion = words
    model, by_value = gd.simplify(arm, motion, "5%"), gd.simplify(two_link, swing, "5%")
    assert model.torques == by_value.torques
    expected = gd.evaluate(by_value, swing).errors.largest
    np.testing.assert_array_equal(gd.evaluate(model, motion).errors.largest, expected)
    np.testing.assert_array_equal(gd.decompose(arm, motion).torque, gd.decompose(two_link, swing).torque)
    assert gd.equations(arm) == gd.equations(two_link)
    assert gd.tables.harmonics_of(arm).inertia.keys() == gd.tables.harmonics_of(two_link).inertia.keys()
    np.testing.assert_array_equal(gd.tables.states_in_box(arm, 3).q, gd.tables.states_in_box(two_link, 3).q)


def test_the_main_job_by_names_and_options_into_a_folder(two_link, swing, tmp_path):
    folder = tmp_path / "results"
    found = gd.analyze(ROBOT, MOTION, folder, formats=("json", "csv"), budget="5%", margin="5deg")
    settings = gd.types.Settings(budget=gd.types.Budget.parse("5%"), margin=gd.types.Margin.parse("5deg"))
    assert found.provenance["run"] == gd.analyze(two_link, swing, settings=settings).provenance["run"]
    assert sorted(path.name for path in folder.iterdir()) == ["dominance.csv", "model.json"]
    assert gd.load_model(folder / "model.json").torques == found.model.torques
    with pytest.raises(OutputError, match="another run"):
        gd.analyze(ROBOT, MOTION, folder, formats=("json",))
    gd.analyze(ROBOT, MOTION, folder, formats=("json",), overwrite=True)
    assert [path.name for path in folder.iterdir()] == ["model.json"]


def test_what_is_no_arm_no_motion_and_no_option():
    for error, told, call in (
        (ArmError, "there is no arm 'puma'", lambda: gd.analyze("puma", MOTION)),
        (TrajectoryError, "there is no trajectory", lambda: gd.analyze(ROBOT, "swing")),
        (UsageError, "did you mean 'budget'", lambda: gd.analyze(ROBOT, MOTION, bugdet="1%")),
        (
            UsageError,
            "given twice",
            lambda: gd.analyze(ROBOT, MOTION, None, gd.types.Settings(), budget="1%"),
        ),
        (UsageError, "this is not a budget", lambda: gd.types.Settings(budget=1.5)),
    ):
        with pytest.raises(error, match=told):
            call()


@pytest.fixture(scope="module")
def shown(puma, pick_and_place, puma_findings) -> dict[str, object]:
    exact, model = gd.types.ExactDynamics.of(puma, pick_and_place), puma_findings.model
    return {
        "arm": puma,
        "trajectory": pick_and_place,
        "findings": puma_findings,
        "model": model,
        "evaluation": gd.evaluate(model, pick_and_place, fail_over="1%"),
        "ranking": gd.tables.rank_terms(exact),
        "certificate": gd.certify(model, gd.types.Box.around(*exact.states.arrays), effort=500),
        "exact dynamics": exact,
        "states": exact.states,
        "harmonics": gd.tables.harmonics_of(puma),
        "program": model.program,
    }


def test_values_are_a_line_and_a_small_table(shown):
    for name, value in shown.items():
        assert repr(value).startswith(type(value).__name__)
        assert len(repr(value)) < 300
        assert "\n" not in repr(value)
        if hasattr(value, "_repr_html_"):
            page = ElementTree.fromstring(f"<p>{value._repr_html_()}</p>")
            tables = [[len(row) for row in table.iter("tr")] for table in page.iter("table")]
            assert all(len(set(rows)) == 1 for rows in tables), f"as many cells in every row of {name}"
            assert 6 <= sum(map(len, tables)) < 60


def test_findings_say_what_the_terminal_says(puma_findings):
    told = text_of(result_document(main_result(puma_findings)))
    assert str(puma_findings) == told.rstrip()
    page = ElementTree.fromstring(f"<p>{puma_findings._repr_html_()}</p>")
    words = " ".join("".join(page.itertext()).split())
    assert run_headline(puma_findings) in words  # with the proven error
    shown = {"".join(cell.itertext()) for cell in page.iter("td")}
    section = elements_by_verdict(puma_findings)
    assert {fact.written for fact in section.parts if isinstance(fact, SeenFact)} <= shown
    figure = ElementTree.fromstring(figure_svg(matrix_figure(puma_findings)))
    (drawn,) = page.iter(figure.tag)
    assert ElementTree.tostring(drawn) == ElementTree.tostring(figure)


def test_names_of_others_are_escaped(two_link, swing):
    script = "<script>alert(1)</script>"
    joints = (dataclasses.replace(two_link.joints[0], name=script), two_link.joints[1])
    arm = dataclasses.replace(two_link, name=script, title=f"{script} & co", joints=joints)
    motion = dataclasses.replace(swing, name=script)
    findings = gd.analyze(arm, motion)
    for value in (arm, motion, findings, findings.model, gd.evaluate(findings.model, motion)):
        page = ElementTree.fromstring(f"<p>{value._repr_html_()}</p>")
        assert script in "".join(page.itertext())
        assert not [*page.iter("script")]
