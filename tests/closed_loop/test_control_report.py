"""The report of a study: page, PDF and JSON."""

from __future__ import annotations

import dataclasses
import json
import re
import shutil
import subprocess
from html.parser import HTMLParser

import numpy as np
import pytest

from gd_analyze.errors import UsageError
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.report.inline_svg import inline_svg
from gd_analyze.robots.catalogue import load_arm
from gd_analyze.simplification.simplify import simplify
from gd_analyze.studies.control import control
from gd_analyze.studies.control_document import control_document
from gd_analyze.studies.control_figures import LOOKS, error_figure, speed_figure
from gd_analyze.studies.control_files import FILES, render_control_html, render_control_pdf, write_control
from gd_analyze.studies.control_verdict import FIXED_GAINS, SIMPLIFIED, sentences
from gd_analyze.studies.controllers import CONTROLLERS, Controller
from gd_analyze.studies.settings import ControlSettings
from gd_analyze.text import number


class _Page(HTMLParser):
    """Text of a page, and the ids in it."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.text, self.ids, self._skip = "", [], False
        self.feed(page)
        self.text = " ".join(self.text.split())

    def handle_starttag(self, tag, attrs):
        self._skip = tag in ("style", "script") or (self._skip and tag != "body")
        self.ids += [value for name, value in attrs if name == "id"]

    def handle_data(self, data):
        self.text += "" if self._skip else data


def test_the_page_shows_the_numbers_and_asks_nothing_of_the_network(swing_study):
    page = render_control_html(swing_study)
    read = _Page(page)
    for table in control_document(swing_study)["tables"].values():
        assert table["caption"] in read.text
        for row in table["rows"]:
            assert row[0] in read.text
            assert all("e-" in cell or cell in read.text for cell in row)
    for said in sentences(swing_study):
        assert said in read.text
    assert "odd" in read.text
    assert not re.search(r"(?:src|href)=\"(?!#)", page)
    # The one address is the SVG namespace, which is a name and is never fetched.
    assert set(re.findall(r"https?://[^\"'\s)]+", page)) <= {"http://www.w3.org/2000/svg"}
    assert len(read.ids) == len(set(read.ids))
    # Colours of the drawings follow the theme.
    drawings = "".join(re.findall(r"<figure.*?</figure>", page, re.DOTALL))
    assert "var(--ink)" in drawings
    assert not re.search("#[0-9a-f]{6}", drawings)


def test_names_from_files_are_only_text(hostile_study):
    page = render_control_html(hostile_study)
    assert "<script>alert" not in page
    assert "<b>&" not in page
    render_control_pdf(hostile_study)


def test_the_document_is_plain_and_complete(swing_study):
    told = json.loads(json.dumps(control_document(swing_study), allow_nan=False))
    assert len(told["loops"]) == len(swing_study.loops)
    assert set(told["tracks_up_to"]) == {c.title for c in CONTROLLERS}
    fixed = swing_study.loop(FIXED_GAINS, 200.0, 1.0)
    assert told["good_enough"] in (None, "fixed gains", "computed torque")
    assert (told["good_enough"] is None) <= (not fixed.within(swing_study.tolerance))


def test_a_lost_loop_is_told_of(swing_study):
    def lost(loop):
        if loop.controller not in (SIMPLIFIED, FIXED_GAINS):
            return loop
        error = np.where(loop.time[:, None] > 0.7, np.nan, loop.error)
        endless = np.full(2, np.inf)
        return dataclasses.replace(loop, peak_error=endless, rms_error=endless, lost_at=0.7, error=error)

    study = dataclasses.replace(swing_study, loops=tuple(map(lost, swing_study.loops)))
    assert "lost: more than a turn from the motion after 0.7 s" in sentences(study)[0]
    document = control_document(study)
    json.dumps(document, allow_nan=False)
    assert ["simplified model", "lost", "lost"] in document["tables"]["rates"]["rows"]
    assert "lost" in _Page(render_control_html(study)).text


def test_joints_that_slide_err_in_millimetres():
    """Of an arm with both, the unit stands beside what may be of either."""
    arm = load_arm("stanford")
    s = np.linspace(0.0, 1.0, 11)[:, None]
    blend, far = 10 * s**3 - 15 * s**4 + 6 * s**5, np.array([0.02, 0.02, 0.05, 0.02, 0.02, 0.02])
    start = np.array([0.0, 0.3, 0.5, 0.2, 0.4, 0.0])
    motion = Trajectory.from_arrays(0.4 * s[:, 0], start + blend * far, name="short")
    settings = ControlSettings(rates=(100.0,), speeds=(2.0,))
    study = control(simplify(arm, motion, "5%", level="element"), motion, settings)
    tables = control_document(study)["tables"]
    assert "mm where the joint slides" in tables["peak"]["caption"]
    alone = Controller("pd", "nothing")
    boom = study.loop(alone, 100.0, 2.0).peak_error[2]
    assert {row[0]: row[3] for row in tables["peak"]["rows"]}[alone.title] == number(1e3 * boom)
    assert all(row[1].split()[1] in ("mrad", "mm") for row in tables["rates"]["rows"])
    np.testing.assert_array_equal(study.tolerance, np.where(arm.is_revolute, np.radians(0.1), 1e-3))


def test_every_controller_is_drawn(swing_study):
    assert len(set(LOOKS.values())) == len(CONTROLLERS)
    errors, speeds = error_figure(swing_study), speed_figure(swing_study)
    labels = [shape.label for shape in errors.shapes]
    for controller in CONTROLLERS:
        for joint in (1, 2):
            assert f"{controller.title} {joint}" in labels
        assert controller.title in [shape.label for shape in speeds.shapes]
    assert "tolerance" in [text.text for text in speeds.texts]
    heights = sorted(text.y for text in speeds.texts if text.text in {c.title for c in CONTROLLERS})
    # Names of 7 pt letters stand clear of each other.
    assert min(np.diff(heights)) >= 9.0 - 1e-9


def test_a_drawing_in_a_page_has_names_of_its_own(swing_study):
    svg = speed_figure(swing_study).svg()
    one, other = (inline_svg(svg, name, 'a "label"') for name in ("one", "other"))
    ids = [set(re.findall(r'id="([^"]*)"', drawn)) for drawn in (one, other)]
    assert ids[0]
    assert not ids[0] & ids[1]
    assert set(re.findall(r'href="#([^"]*)"', one)) <= ids[0]
    assert "<style" not in one
    assert "&quot;label&quot;" in one or "'a \"label\"'" in one


def test_the_pdf_is_the_same_every_time_and_holds_the_numbers(swing_study, tmp_path):
    pdf = render_control_pdf(swing_study)
    assert pdf == render_control_pdf(swing_study)
    program = shutil.which("pdftotext")
    if program is None:
        pytest.skip("pdftotext (poppler-utils) is not installed")
    (tmp_path / "c.pdf").write_bytes(pdf)
    done = subprocess.run(
        [program, "-layout", str(tmp_path / "c.pdf"), "-"], capture_output=True, check=True, text=True
    )
    for row in control_document(swing_study)["tables"]["peak"]["rows"]:
        assert row[0] in done.stdout
        assert all("e-" in cell or cell in done.stdout for cell in row[1:])


def test_only_the_files_asked_for_are_written(swing_study, tmp_path):
    write_control(swing_study, tmp_path / "r", ("json",))
    assert [path.name for path in (tmp_path / "r").iterdir()] == [FILES["json"]]
    with pytest.raises(UsageError, match="no format 'csv'"):
        write_control(swing_study, tmp_path / "r", ("csv",))
