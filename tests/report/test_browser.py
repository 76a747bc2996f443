"""The report in a real browser: drawn, switched, played, without an error and without a request."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from gd_analyze.report.html import render_html
from gd_analyze.results import Findings

BROWSERS = ("chromium", "chromium-browser", "google-chrome")
FLAGS = (
    "--headless=new",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--enable-unsafe-swiftshader",
    "--window-size=1280,900",
)
PATIENCE = 20


class Tab:
    """One loaded report."""

    def __init__(self, driver: Any) -> None:
        self.driver = driver

    def run(self, script: str, *arguments: object) -> Any:
        return self.driver.execute_script(script, *arguments)

    def settle(self) -> None:
        """Draw everything that is not drawn yet, and wait for it."""
        self.driver.execute_async_script(
            "const done = arguments[0]; report.drawAll().then(() => report.viewer.draw()).then(() => done());"
        )

    def click(self, selector: str) -> None:
        self.run("document.querySelector(arguments[0]).click()", selector)
        self.settle()

    def until(self, condition: str) -> None:
        from selenium.webdriver.support.ui import WebDriverWait

        WebDriverWait(self.driver, PATIENCE, 0.05).until(lambda _: self.run(f"return Boolean({condition})"))

    def width(self, pixels: int) -> None:
        self.driver.execute_cdp_cmd(
            "Emulation.setDeviceMetricsOverride",
            {"width": pixels, "height": 844, "deviceScaleFactor": 1, "mobile": False},
        )

    def visible(self, figure: str) -> dict[str, bool]:
        """Which curves of a figure are shown, by role."""
        return self.run(
            "const div = document.querySelector(`.plot.small[data-figure='${arguments[0]}']`);"
            "const drawn = div.querySelectorAll('.scatterlayer .trace').length;"
            "const shown = Object.fromEntries(div.data.map((trace) => [trace.meta, trace.visible]));"
            "if (drawn !== Object.values(shown).filter(Boolean).length) throw new Error('drawn otherwise');"
            "return shown;",
            figure,
        )


@pytest.fixture(scope="module")
def tab(puma_findings: Findings, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Tab]:
    browser = next(filter(None, map(shutil.which, BROWSERS)), None)
    driver_program = shutil.which("chromedriver")
    if browser is None or driver_program is None:
        missing = f"none of {', '.join(BROWSERS)}" if browser is None else "no chromedriver"
        pytest.skip(f"{missing} on this machine")
    from selenium import webdriver

    folder: Path = tmp_path_factory.mktemp("browser")
    file = folder / "report.html"
    file.write_text(render_html(puma_findings), encoding="utf-8")
    options = webdriver.ChromeOptions()
    options.binary_location = browser
    for flag in (*FLAGS, f"--user-data-dir={folder / 'profile'}"):
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    driver = webdriver.Chrome(options=options, service=webdriver.ChromeService(driver_program))
    try:
        driver.set_script_timeout(PATIENCE)
        driver.get(file.as_uri())
        tab = Tab(driver)
        tab.settle()
        yield tab
    finally:
        driver.quit()


def test_every_figure_is_drawn(tab: Tab) -> None:
    wanted = tab.run("return document.querySelectorAll('.plot').length")
    drawn = tab.run(
        "return [...document.querySelectorAll('.plot.js-plotly-plot')].filter("
        "(div) => div.data.length && div.querySelectorAll('.scatterlayer .js-line').length).length"
    )
    assert wanted == drawn > 30
    assert tab.run("return document.getElementById('scene').data.length") > 3
    assert tab.run("return Boolean(document.querySelector('#scene canvas'))")


def test_curve_switches_act_on_all_panels(tab: Tab) -> None:
    for role in ("translation", "rotation", "combined"):
        tab.click(f"[data-role={role}]")
        for figure in ("D11", "D36", "h4"):
            assert tab.visible(figure)[role] is False
        assert (
            tab.run("return document.querySelector(arguments[0]).ariaPressed", f"[data-role={role}]")
            == "false"
        )
        tab.click(f"[data-role={role}]")
        for figure in ("D11", "D36", "h4"):
            assert tab.visible(figure)[role] is True
    assert tab.visible("h4")["coriolis"] is False
    tab.click("[data-role=coriolis]")
    assert tab.visible("h4")["coriolis"] is True
    tab.click("[data-role=coriolis]")


def test_horizontal_axis_and_shared_scale(tab: Tab, puma_findings: Findings) -> None:
    last = "return document.querySelector(\".plot.small[data-figure='D22']\").data[0].x.at(-1)"
    ranges = (
        "return ['D11', 'D66'].map((name) =>"
        " document.querySelector(`.plot.small[data-figure='${name}']`).layout.yaxis.range[1])"
    )
    assert tab.run(last) == puma_findings.trajectory.n_set_points
    tab.click("[data-x=time]")
    assert tab.run(last) == pytest.approx(puma_findings.trajectory.time[-1])
    tab.click("[data-x=point]")
    own = tab.run(ranges)
    assert own[0] > 100 * own[1]
    tab.click("[data-shared='1']")
    shared = tab.run(ranges)
    assert shared[0] == shared[1] >= own[0]
    tab.click("[data-shared='']")
    assert tab.run(ranges) == own


def test_pointing_shows_all_three_values(tab: Tab, puma_findings: Findings) -> None:
    from selenium.webdriver import ActionChains
    from selenium.webdriver.common.by import By

    panel = tab.driver.find_element(By.CSS_SELECTOR, ".plot.small[data-figure='D23']")
    tab.run("arguments[0].scrollIntoView({ block: 'center' })", panel)
    ActionChains(tab.driver).move_to_element(panel).perform()
    readout = "document.querySelector(\".panel[data-element='D23'] .readout\").textContent"
    tab.until(f"{readout}.startsWith('#')")
    text = tab.run(f"return {readout}")
    point = int(text[1:].partition(",")[0]) - 1
    parts = puma_findings.decomposition.inertia.values[point, :, 1, 2]
    for value in (*parts, parts.sum()):
        assert f"{value:.4g}" in text


def test_an_element_can_be_enlarged(tab: Tab) -> None:
    tab.click(".panel[data-element='h3'] .enlarge")
    assert tab.run("return document.getElementById('lens').dataset.element") == "h3"
    unit = "return document.querySelector('#lens .plot').layout.yaxis.title.text"
    assert tab.run(unit) == "N m"
    tab.click(".panel[data-element='D12'] .enlarge")
    assert tab.run(unit) == "kg m²"


def test_theme_switch_recolours_page_and_figures(tab: Tab) -> None:
    look = (
        "return [getComputedStyle(document.body).backgroundColor,"
        " document.querySelector(\".plot.small[data-figure='D11']\").data[1].line.color,"
        " document.querySelector(\".plot.small[data-figure='D11']\").layout.font.color,"
        " document.getElementById('scene').data[3].line.color]"
    )
    before = tab.run(look)
    tab.click("#theme")
    after = tab.run(look)
    assert all(a != b for a, b in zip(before, after, strict=True))
    tab.click("#theme")
    assert tab.run(look) == before


def test_the_arm_plays(tab: Tab) -> None:
    hand = "return document.getElementById('scene').data[3].x.at(-1)"
    tab.run("report.viewer.goTo(0)")
    start = tab.run(hand)
    tab.run("document.getElementById('speed').value = '4'; document.getElementById('play').click()")
    tab.until("report.viewer.frame > 5")
    assert tab.run("return document.getElementById('play').ariaPressed") == "true"
    tab.run("document.getElementById('play').click()")
    frame = tab.run("return report.viewer.frame")
    assert tab.run(hand) != start
    assert tab.run("return Number(document.getElementById('frame').value)") == frame
    assert f"Set point {frame + 1} " in tab.run("return document.getElementById('clock').textContent")
    tab.run(
        "const slider = document.getElementById('frame'); slider.value = 2;"
        "slider.dispatchEvent(new Event('input'))"
    )
    assert tab.run("return report.viewer.frame") == 2


def test_the_ranking_sorts_and_filters(tab: Tab) -> None:
    rows = "[...document.querySelectorAll('#dominance tbody tr')]"
    column = f"return {rows}.map((row) => row.cells[5].dataset.value)"
    button = "#dominance thead th:nth-child(6) button"
    tab.click(button)
    falling = [float(value) for value in tab.run(column)]
    assert falling == sorted(falling, reverse=True)
    assert tab.run("return document.querySelector('#dominance th:nth-child(6)').ariaSort") == "descending"
    tab.click(button)
    assert [float(value) for value in tab.run(column)] == sorted(falling)
    tab.click(".filter [data-group=rotation]")
    shown = tab.run(f"return {rows}.filter((row) => row.offsetHeight).map((row) => row.dataset.group)")
    assert set(shown) == {"rotation"}
    tab.click(".filter [data-group='']")
    tab.click("#dominance thead th:first-child button")


def test_the_terms_sort_and_filter_by_themselves(tab: Tab) -> None:
    rows = "[...document.querySelectorAll('#term-ranking tbody tr')]"
    elements_before = tab.run("return document.querySelectorAll('#dominance tbody tr:not([hidden])').length")
    tab.click("#term-ranking thead th:nth-child(6) button")
    torques = [float(v) for v in tab.run(f"return {rows}.map((row) => row.cells[5].dataset.value)")]
    assert torques == sorted(torques, reverse=True)
    tab.click(".filter[data-table=term-ranking] [data-group=gravity_loading]")
    shown = tab.run(f"return {rows}.filter((row) => row.offsetHeight).map((row) => row.dataset.group)")
    assert set(shown) == {"gravity_loading"}
    assert (
        tab.run("return document.querySelectorAll('#dominance tbody tr:not([hidden])').length")
        == elements_before
    )
    tab.click(".filter[data-table=term-ranking] [data-group='']")
    tab.click("#term-ranking thead th:first-child button")


def test_the_trade_off_shows_every_kind_and_this_model(tab: Tab, puma_findings: Findings) -> None:
    plot = "document.querySelector(\".plot[data-figure='trade-off']\")"
    roles = tab.run(f"return {plot}.data.map((trace) => trace.meta)")
    assert roles == ["element", "term", "term-refit", "energy", "energy-refit", "model"]
    star = tab.run(f"return [{plot}.data.at(-1).x[0], {plot}.data.at(-1).y[0]]")
    assert star[1] == puma_findings.model.operations.total
    assert star[0] == pytest.approx(100 * puma_findings.model.promise.errors.largest_share.max(), rel=1e-5)
    assert tab.run(f"return {plot}.layout.shapes.length") == 2


def test_printing_draws_in_light_and_comes_back(tab: Tab) -> None:
    tab.click("#theme")
    dark = tab.run("return document.documentElement.dataset.theme")
    printed = tab.driver.execute_cdp_cmd(
        "Page.printToPDF", {"printBackground": True, "preferCSSPageSize": True}
    )
    assert len(printed["data"]) > 50_000
    tab.settle()
    assert tab.run("return document.documentElement.dataset.theme") == dark
    assert not tab.run("return document.documentElement.classList.contains('printing')")
    tab.click("#theme")


@pytest.mark.parametrize("pixels", [1280, 390])
def test_the_page_never_scrolls_sideways(tab: Tab, pixels: int) -> None:
    tab.width(pixels)
    tab.settle()
    assert tab.run("return document.documentElement.scrollWidth") <= pixels
    tab.width(1280)


def test_without_webgl_a_still_stands_in(tab: Tab) -> None:
    script = tab.driver.execute_cdp_cmd(
        "Page.addScriptToEvaluateOnNewDocument",
        {
            "source": "const get = HTMLCanvasElement.prototype.getContext;"
            "HTMLCanvasElement.prototype.getContext = function (kind, ...rest) {"
            " return kind.includes('webgl') ? null : get.call(this, kind, ...rest); };"
        },
    )
    tab.driver.refresh()
    assert tab.run("return document.getElementById('nogl').offsetHeight") > 0
    assert tab.run("return document.querySelector('.stroboscope').getBoundingClientRect().height") > 100
    tab.run("report.viewer.goTo(3)")
    assert "Set point 4 " in tab.run("return document.getElementById('clock').textContent")
    tab.driver.execute_cdp_cmd("Page.removeScriptToEvaluateOnNewDocument", script)


def test_the_console_stays_clean(tab: Tab) -> None:
    entries = tab.driver.get_log("browser")
    assert not [entry for entry in entries if entry["level"] == "SEVERE"]


def test_nothing_was_asked_of_the_network(tab: Tab) -> None:
    events = (json.loads(entry["message"])["message"] for entry in tab.driver.get_log("performance"))
    asked = {
        event["params"]["request"]["url"]
        for event in events
        if event["method"] == "Network.requestWillBeSent"
    }
    assert tab.driver.current_url in asked
    assert not [url for url in asked if url.startswith(("http", "ws", "ftp"))]
