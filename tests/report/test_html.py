from __future__ import annotations

import json
import re
from collections import Counter
from dataclasses import replace
from html.parser import HTMLParser
from itertools import pairwise

import numpy as np
import pytest
from report_arms import swing

from gd_analyze.elements import elements
from gd_analyze.formulas.formula import Symbol
from gd_analyze.formulas.mathml import PageMathML
from gd_analyze.formulas.parts import parts_formulas
from gd_analyze.formulas.writing import term_formula
from gd_analyze.levels import ELEMENT
from gd_analyze.levels.parts import kept_effects, parts_of
from gd_analyze.main_job import Settings, find
from gd_analyze.report.beyond_chart import beyond_chart
from gd_analyze.report.colours import COLOURS, TEMPLATES
from gd_analyze.report.document import document
from gd_analyze.report.figures import motion_figure
from gd_analyze.report.html import TERMS_SHOWN, render_html
from gd_analyze.report.interactive import DIGITS, MOST_FRAMES, MOST_POINTS, as_text, page_data
from gd_analyze.report.terms import exact_elements, tallies
from gd_analyze.results import Findings, rows_of, summary
from gd_analyze.results.rows import dropped_parts, joint_rows
from gd_analyze.results.words import SYMBOLS
from gd_analyze.robots import RobotArm, load_arm
from gd_analyze.trajectories import Trajectory, read_trajectory

MATHS = PageMathML()
MOTION = ("q", "qd", "qdd")
HOSTILE = '</script><script>alert(1)</script><b title="'


class Page(HTMLParser):
    """Everything a test asks of a page: elements with attributes, text, and what stands inside scripts."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.elements: list[tuple[str, dict[str, str]]] = []
        self.scripts: list[str] = []
        self.styles: list[str] = []
        self.text = ""
        self.inside = ""
        self.feed(text)
        self.close()

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, {name: value or "" for name, value in attributes}))
        self.inside = tag
        if tag in ("script", "style"):
            (self.scripts if tag == "script" else self.styles).append("")

    def handle_endtag(self, tag: str) -> None:
        self.inside = ""

    def handle_data(self, data: str) -> None:
        if self.inside == "script":
            self.scripts[-1] += data
        elif self.inside == "style":
            self.styles[-1] += data
        else:
            self.text += data

    def all(self, tag: str) -> list[dict[str, str]]:
        return [attributes for name, attributes in self.elements if name == tag]

    @property
    def data(self) -> dict:
        return json.loads(self.scripts[0])


@pytest.fixture(scope="module")
def source(puma_findings: Findings) -> str:
    return render_html(puma_findings)


@pytest.fixture(scope="module")
def page(source: str) -> Page:
    return Page(source)


def test_the_document_is_whole(source: str, page: Page) -> None:
    assert source.startswith("<!doctype html>")
    assert source.rstrip().endswith("</html>")
    assert len(page.all("h1")) == 1
    levels = [int(tag[1]) for tag, _ in page.elements if re.fullmatch("h[1-6]", tag)]
    assert all(after <= before + 1 for before, after in pairwise(levels))


def test_nothing_is_asked_of_the_network(page: Page) -> None:
    loading = {"src", "srcset", "poster", "data", "action", "background", "xlink:href"}
    assert not [(tag, a) for tag, a in page.elements if loading & a.keys()]
    assert not page.all("link")
    assert all(a["href"].startswith("#") for a in page.all("a"))
    assert not re.search(r"url\(|@import", "".join(page.styles))
    policy = next(a["content"] for a in page.all("meta") if "http-equiv" in a)
    assert "default-src 'none'" in policy
    assert "http" not in policy


def test_links_lead_to_sections(page: Page) -> None:
    identifiers = {a["id"] for _, a in page.elements if "id" in a}
    assert {a["href"][1:] for a in page.all("a")} <= identifiers
    counted = Counter(a["id"] for _, a in page.elements if "id" in a)
    assert max(counted.values()) == 1


def test_the_answer_comes_first(puma_findings: Findings, page: Page) -> None:
    headline = summary.headline(puma_findings)
    assert headline in page.text
    assert page.text.index(headline) < page.text.index("The arm and its motion")
    for value, caption in summary.facts(puma_findings):
        assert value in page.text
        assert caption in page.text


def test_every_figure_is_placed_and_has_data(puma_findings: Findings, page: Page) -> None:
    placed = Counter(a["data-figure"] for a in page.all("div") if "data-figure" in a)
    figures = page.data["figures"]
    assert placed.keys() == figures.keys()
    n = puma_findings.arm.n_joints
    assert {element.label for element in elements(n)} <= placed.keys()
    assert all(a["aria-label"] for a in page.all("div") if "data-figure" in a)


def test_curves_are_the_decomposition(puma_findings: Findings, page: Page) -> None:
    dataset = puma_findings.decomposition
    # Six significant digits are kept; what the ranking calls zero is drawn as zero.
    tolerance = 0.5 * 10.0 ** (1 - DIGITS)
    for element in elements(puma_findings.arm.n_joints):
        parts = element.parts(dataset)
        traces = {
            trace["role"]: np.array(trace["y"]) for trace in page.data["figures"][element.label]["traces"]
        }
        scale = np.abs(dataset[element.quantity].values).max()
        noise = 64 * np.finfo(float).eps * scale
        np.testing.assert_allclose(traces["combined"], parts.sum(axis=0), rtol=tolerance, atol=2 * noise)
        if element.quantity != "gravity_loading":
            np.testing.assert_allclose(traces["translation"], parts[0], rtol=tolerance, atol=noise)
            np.testing.assert_allclose(traces["rotation"], parts[1], rtol=tolerance, atol=noise)
        if element.quantity == "coriolis_centrifugal":
            whole = traces["centrifugal"] + traces["coriolis"]
            # Two addends, each rounded to six digits of its own size.
            largest = np.abs(traces["centrifugal"]).max() + np.abs(traces["coriolis"]).max()
            np.testing.assert_allclose(whole, traces["combined"], atol=3 * tolerance * largest)


def test_tables_have_captions_and_buttons_names(source: str, page: Page) -> None:
    assert len(page.all("table")) == len(page.all("caption")) > 5
    for attributes in page.all("div"):
        if attributes.get("role") == "group":
            assert attributes["aria-label"]
    assert all(a.get("type") == "button" for a in page.all("button"))
    assert '<button type="button" id="theme" aria-label=' in source


def test_the_model_equations_hold_exactly_what_is_kept(puma_findings: Findings, source: str) -> None:
    n = puma_findings.arm.n_joints
    kept = {part.label for part in puma_findings.element_model.terms}
    for i, formula in enumerate(puma_findings.element_model.formulas):
        acting = {
            part.element.label
            for part in parts_of(n)
            if part.label in kept
            and i in (part.element.i, part.element.j if part.element.j is not None else -1)
        }
        symbols = [piece.product.powers[0].base for piece in formula.pieces]
        assert {symbol.letter + symbol.index for symbol in symbols} == acting
        for symbol in symbols:
            if symbol.word:
                other = {"tran": "rotation", "rot": "translation"}[symbol.word]
                assert f"{symbol.letter}{symbol.index} {other}" not in kept
            assert MATHS.symbol(symbol) in source


def test_drives_are_written_into_the_model(puma_findings: Findings) -> None:
    n = puma_findings.arm.n_joints
    formulas = parts_formulas(kept_effects(n, puma_findings.element_model.terms), n, drives=True)
    for i, formula in enumerate(formulas):
        assert Symbol("J", str(i + 1)) in [piece.product.powers[0].base for piece in formula.pieces]


def test_text_verdicts_stand_beside_ours_for_the_texts_arm_only(
    page: Page, arms: dict[str, RobotArm]
) -> None:
    assert "Beside the founding text's verdicts" in page.text
    assert "VAX-11/780" in page.text
    other = Page(render_html(find(arms["sliding"], swing(arms["sliding"]))))
    assert "Beside the founding text's verdicts" not in other.text
    assert "Fig 3.10" not in other.text


def test_names_cannot_become_markup(puma_findings: Findings) -> None:
    arm = puma_findings.arm
    joints = (replace(arm.joints[0], name=HOSTILE), *arm.joints[1:])
    hostile = replace(
        puma_findings,
        arm=replace(arm, title=HOSTILE, joints=joints, sources=(HOSTILE,)),
        trajectory=replace(puma_findings.trajectory, name=HOSTILE, origin=HOSTILE),
        warnings=(HOSTILE,),
        provenance={"command": HOSTILE},
    )
    harmless, attacked = Page(render_html(puma_findings)), Page(render_html(hostile))
    assert "<script>alert" not in render_html(hostile)
    assert len(attacked.all("script")) == len(harmless.all("script"))
    assert len(attacked.all("b")) == len(harmless.all("b"))
    assert HOSTILE in attacked.text
    assert attacked.data["viewer"]["joints"][0]["name"] == as_text(HOSTILE)


def test_warnings_are_prominent(puma_findings: Findings, page: Page) -> None:
    assert not [a for a in page.all("div") if a.get("role") == "alert"]
    warned = Page(render_html(replace(puma_findings, warnings=("joint 2 leaves its range", "and again"))))
    assert [a for a in warned.all("div") if a.get("role") == "alert"]
    assert warned.text.index("joint 2 leaves its range") < warned.text.index("The arm and its motion")


def test_sliding_joints_have_their_units(arms: dict[str, RobotArm]) -> None:
    arm = arms["sliding"]
    page = Page(render_html(find(arm, swing(arm))))
    figures = page.data["figures"]
    units = {label: figures[label]["unit"] for label in ("D11", "D12", "D23", "h1", "h2", "c3", "error-3")}
    assert units == {
        "D11": "kg m²",
        "D12": "kg m",
        "D23": "kg",
        "h1": "N m",
        "h2": "N",
        "c3": "N",
        "error-3": "N",
    }
    assert {"q-revolute", "q-prismatic"} <= figures.keys()
    assert figures["qd-prismatic"]["unit"] == "m/s"
    # A shared scale must not mix units.
    by_scale: dict[str, set[str]] = {}
    for figure in figures.values():
        by_scale.setdefault(figure.get("scale", ""), set()).add(figure["unit"])
    assert all(len(found) == 1 for scale, found in by_scale.items() if scale)


@pytest.mark.parametrize("count", [1, 2, 21])
@pytest.mark.parametrize("which", ["one joint", "sliding", "puma560"])
def test_any_arm_and_length(arms: dict[str, RobotArm], which: str, count: int) -> None:
    arm = arms.get(which) or load_arm(which)
    page = Page(render_html(find(arm, swing(arm, count))))
    assert len(page.data["axes"]["all"]["point"]) == count
    assert page.data["viewer"]["at"][-1] == count
    assert len(page.data["viewer"]["points"][0]) == 2 * arm.n_joints + 1
    assert page.text.count("NaN") == page.text.count("nan ") == 0


def test_an_arm_without_torque(arms: dict[str, RobotArm]) -> None:
    arm = replace(arms["one joint"], gravity=np.zeros(3))
    still = np.zeros((3, 1))
    page = Page(render_html(find(arm, Trajectory(np.arange(3.0), still, still, still))))
    assert all(y == 0 for trace in page.data["figures"]["torque-1"]["traces"] for y in trace["y"])
    assert "∞" not in page.text


def test_more_than_nine_joints() -> None:
    small = load_arm("two_link")
    arm = replace(small, name="chain", joints=small.joints * 5, links=small.links * 5, dh_table=(), drives=())
    findings = find(arm, swing(arm, 3))
    # Ten joints are more than a second would identify: whole elements, and said so.
    assert findings.model.level is ELEMENT
    assert "10 joints, more than 8" in findings.warnings[0]
    source = render_html(findings)
    assert "D1,10" in Page(source).data["figures"]
    assert "<mn>1,10</mn>" in source


def test_long_trajectories_are_thinned_and_say_so(arms: dict[str, RobotArm]) -> None:
    arm = arms["one joint"]
    count = 20_000
    findings = find(arm, swing(arm, count))
    page = Page(render_html(findings))
    for name, figure in page.data["figures"].items():
        if name == "trade-off":
            continue
        axis = page.data["axes"][figure["axis"]]
        assert len(axis["point"]) == len(axis["time"]) <= MOST_POINTS
        assert axis["point"][0] == 1
        assert axis["point"][-1] == count
        for trace in figure["traces"]:
            assert len(trace["y"]) == len(axis["point"])
    assert len(page.data["viewer"]["at"]) == MOST_FRAMES
    assert f"thinned to at most {MOST_POINTS}" in page.text
    drawn = np.array(page.data["figures"]["c1"]["traces"][0]["y"])
    exact = findings.decomposition.gravity_loading.values[:, 0]
    # Only rounding to six digits stands between the drawn and the true extremes.
    assert drawn.max() == pytest.approx(exact.max(), rel=10.0 ** (1 - DIGITS))
    assert drawn.min() == pytest.approx(exact.min(), rel=10.0 ** (1 - DIGITS))


def test_terms_and_their_equations_are_on_the_page(puma_findings: Findings, source: str, page: Page) -> None:
    model = puma_findings.model
    written = model.formulas
    assert len(written) == puma_findings.arm.n_joints
    pieces = [piece for formula in written for piece in formula.pieces]
    assert sum(piece.quantity != "carried" for piece in pieces) == len(model.torques)
    assert all(element in source for formula in written for element in MATHS.elements(formula))
    rows = [a for a in page.all("tr") if a.get("data-group") in SYMBOLS]
    assert len(rows) == TERMS_SHOWN
    for term, weight in [*puma_findings.ranked_terms.items()][:TERMS_SHOWN]:
        assert MATHS.elements(term_formula(term, weight))[0] in source


def test_the_glance_counts_every_term_once(puma_findings: Findings, page: Page) -> None:
    exact = puma_findings.model.form.torques
    kept, n = puma_findings.model.torques, puma_findings.arm.n_joints
    cells = [cell for line in tallies(exact, kept, n) for cell in line]
    assert sum(cell.kept for cell in cells) == len(puma_findings.model.torques)
    assert sum(cell.total for cell in cells) == len(exact)
    assert all(cell.kept <= cell.total for cell in cells)
    shown = [a["title"] for a in page.all("td") if "tally-cell" in a.get("class", "")]
    assert shown == [f"{cell.what}: {cell.kept} of {cell.total} terms kept" for cell in cells]


def test_the_trade_off_is_drawn_and_tabled(puma_findings: Findings, page: Page) -> None:
    figure = page.data["figures"]["trade-off"]
    table = puma_findings.tables["trade_off"]
    points = {(row["kind"], row["budget"]): row for row in rows_of(table, "kind", "factor")}
    drawn = 0
    for trace in figure["traces"]:
        for x, y, budget in zip(trace["x"], trace["y"], trace["budget"], strict=True):
            point = points[trace["role"].replace("-", " "), budget]
            assert y == point["operations"]
            # Drawn with six digits.
            assert x == pytest.approx(100 * point["largest_share"], rel=10.0 ** (1 - DIGITS))
            drawn += 1
    assert drawn == len(points)
    assert figure["model"]["y"] == puma_findings.model.operations.total
    assert figure["exact"] == puma_findings.model.operations_full.total
    assert len([a for a in page.all("tr") if a.get("class") == "asked"]) == 1


def test_marks_beyond_the_trajectory_are_in_order(puma_findings: Findings) -> None:
    rows = joint_rows(puma_findings, "simplified_model", "beyond")
    chart = beyond_chart(rows)
    for mark, row in zip(chart["marks"], rows, strict=True):
        places = {place: row[name] for name, place in mark.items() if name != "uncertainty"}
        places[chart["budget"]] = row["allowed_error"]
        assert list(dict(sorted(places.items()))) == sorted(places, key=places.__getitem__)
        assert all(0.0 <= place <= 100.0 for place in places)


@pytest.mark.parametrize("level", ["element", "energy"])
@pytest.mark.parametrize("which", ["sliding", "puma560"])
def test_every_level_has_its_page(arms: dict[str, RobotArm], which: str, level: str) -> None:
    arm = arms.get(which) or load_arm(which)
    page = Page(render_html(find(arm, swing(arm), Settings(level=level))))
    identifiers = [a["id"] for _, a in page.elements if "id" in a]
    harmonic = level != "element"
    assert ("elements" in identifiers) == harmonic
    assert ("No certificate at this level" in page.text) == (not harmonic)
    assert any("tally-cell" in a.get("class", "") for a in page.all("td")) == harmonic
    levels = [int(tag[1]) for tag, _ in page.elements if re.fullmatch("h[1-6]", tag)]
    assert all(after <= before + 1 for before, after in pairwise(levels))


def test_the_exact_equations_say_where_terms_come_from(puma_findings: Findings, page: Page) -> None:
    written = exact_elements(puma_findings)
    assert [a for a in page.all("details") if a.get("class") == "exact"]
    effects = Counter(
        "gravity" if formula.left.letter == "c" else term.effect
        for formula, terms in written
        for term in terms
    )
    assert effects.keys() == {"translation", "rotation", "both", "gravity"}
    shown = Counter(a["class"] for a in page.all("span") if a.get("title", "").count(", link "))
    assert shown == {f"e-{effect}": count for effect, count in effects.items()}


def test_equations_too_long_to_read_are_left_to_the_command(
    puma_findings: Findings, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("gd_analyze.report.terms.MOST_EXACT_TERMS", 10)
    page = Page(render_html(puma_findings))
    assert not page.all("details")
    assert "too long to be read on a page" in page.text


def test_page_data_is_json(puma_findings: Findings) -> None:
    data = page_data(puma_findings)
    assert json.loads(json.dumps(data, allow_nan=False)) == data


def test_a_part_is_zero_where_the_ranking_says_so(puma_findings: Findings, source: str, page: Page) -> None:
    """One criterion for headline, figures, page and PDF."""
    dominance, parts = puma_findings.dominance, puma_findings.tables["parts"]
    zero = {
        f"{label} {effect}"
        for label, peaks in zip(dominance.element.values, dominance.part_peak.values, strict=True)
        for effect, peak in zip(dominance.effect.values, peaks, strict=True)
        if peak == 0.0
    }
    dropped = dropped_parts(puma_findings)
    told = {row["part"] if " " in row["part"] else f"{row['part']} translation" for row in dropped.zero}
    # Gravity has no rotational part, so none is dropped; a part that is kept is not told to be zero.
    assert told <= zero
    kept = {label for label, is_kept in zip(parts.part.values, parts.kept.values, strict=True) if is_kept}
    assert {name for name in zero - told if not name.startswith("c")} <= kept
    assert f"{len(dropped.zero)} parts are zero" in page.text
    shown = document(puma_findings)["elements"]
    assert [len(shown[name]) for name in ("costing", "zero", "idle")] == [*map(len, dropped)]
    for name in zero:
        element, _, effect = name.partition(" ")
        traces = {trace["role"]: trace["y"] for trace in page.data["figures"][element]["traces"]}
        assert not any(traces.get(effect, ()))


def test_angles_are_in_degrees_on_every_motion_plot(arms: dict[str, RobotArm]) -> None:
    arm = arms["sliding"]
    findings = find(arm, swing(arm))
    figures = page_data(findings)["figures"]
    units = [figures[f"{name}-{kind}"]["unit"] for kind in ("revolute", "prismatic") for name in MOTION]
    assert units == ["deg", "deg/s", "deg/s²", "m", "m/s", "m/s²"]
    for name in MOTION:
        drawn = figures[f"{name}-revolute"]["traces"][0]["y"]
        exact = np.degrees(getattr(findings.trajectory, name)[:, 0])
        np.testing.assert_allclose(drawn, exact, rtol=10.0 ** (1 - DIGITS))
    said = {text.text for text in motion_figure(findings).texts}
    assert {"position q, deg or m", "rate q̇, deg/s or m/s", "acceleration q̈, deg/s² or m/s²"} <= said


def test_all_colours_stand_in_one_table(source: str) -> None:
    """A colour said anywhere else would be one that page and paper do not share."""
    for path in TEMPLATES.parent.rglob("*"):
        if path.suffix in (".py", ".css", ".js", ".typ", ".j2"):
            assert not re.search(r"#[0-9a-fA-F]{6}\b", path.read_text(encoding="utf-8")), path.name
    for name, (light, dark) in COLOURS.items():
        assert f"--{name}: light-dark({light}, {dark});" in source


def test_a_link_in_a_joints_name_is_text(two_link):
    """Plotly takes tags in every text it is given; the page's own text is escaped by its templates."""
    name = '<a href="https://example.com">R&D</a>'
    arm = replace(two_link, joints=(replace(two_link.joints[0], name=name), *two_link.joints[1:]))
    findings = find(arm, read_trajectory("two-link-swing", arm))
    data = page_data(findings)
    labels = [trace["label"] for figure in data["figures"].values() for trace in figure["traces"]]
    names = [joint["name"] for joint in data["viewer"]["joints"]]
    assert '1 &lt;a href="https://example.com">R&amp;D&lt;/a>' in labels
    assert not any("<" in text for text in (*labels, *names))
    assert '<a href="https://example.com' not in render_html(findings)
