"""A page in a real browser, driven by Playwright: whichever Chromium the machine has."""

from __future__ import annotations

import shutil
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

PROGRAMS = ("chromium", "chromium-browser", "google-chrome")
FLAGS = ["--no-sandbox", "--disable-quic", "--disable-component-update"]
WIDE, NARROW = 1280, 390
PATIENCE = 20.0


class Tab:
    """One loaded page, what it said and what it asked for."""

    def __init__(self, page: Any, file: Path) -> None:
        self.page = page
        self.said: list[str] = []
        self.asked: list[str] = []
        page.on("console", lambda message: self.said.append(f"{message.type}: {message.text}"))
        page.on("pageerror", lambda error: self.said.append(f"error: {error}"))
        page.on("request", lambda request: self.asked.append(request.url))
        page.goto(file.as_uri())

    def run(self, script: str, argument: object = None) -> Any:
        """Evaluate an expression, or a function of one argument."""
        return self.page.evaluate(script, argument)

    def unfold(self) -> None:
        self.run("for (const fold of document.querySelectorAll('details')) fold.open = true")
        self.frame()

    def frame(self) -> None:
        """Wait until what was changed has been laid out and drawn."""
        self.run("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")

    def until(self, condition: str) -> None:
        """Wait until an expression is true; the page's own policy forbids Playwright's way to do so."""
        deadline = time.monotonic() + PATIENCE
        while not self.run(f"Boolean({condition})"):
            if time.monotonic() > deadline:
                raise TimeoutError(f"never: {condition}")
            self.frame()

    def click(self, selector: str) -> None:
        self.run("(selector) => document.querySelector(selector).click()", selector)
        self.frame()

    def drag_budget(self, place: int) -> None:
        self.page.locator("#budget-slider").evaluate(
            "(slider, place) => { slider.value = place; slider.dispatchEvent(new Event('input')); }", place
        )


@contextmanager
def started() -> Iterator[Any]:
    """A browser; skips where there is none."""
    program = next(filter(None, map(shutil.which, PROGRAMS)), None)
    if program is None:
        pytest.skip(f"none of {', '.join(PROGRAMS)} on this machine")
    sync_api = pytest.importorskip("playwright.sync_api", reason="Playwright is not installed")
    with sync_api.sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=program, args=FLAGS)
        try:
            yield browser
        finally:
            browser.close()


@contextmanager
def opened(browser: Any, file: Path, width: int = WIDE, **more: Any) -> Iterator[Tab]:
    """Load a page in a window of its own; `more` as Playwright has it, such as `color_scheme`."""
    page = browser.new_page(viewport={"width": width, "height": 800 if width == WIDE else 844}, **more)
    try:
        yield Tab(page, file)
    finally:
        page.close()
