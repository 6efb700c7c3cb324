"""Fixtures: the pages that STEERWRIGHT_PAGES names, in the Chromium that STEERWRIGHT_CHROMIUM names."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page, sync_playwright

OUT = Path(os.environ["STEERWRIGHT_PAGES"])
REPORT = OUT / "report.html"
ARGUMENTS = ["--no-sandbox", "--disable-gpu", "--disable-background-networking", "--disable-component-update"]


@pytest.fixture(scope="session")
def browser():
    with sync_playwright() as playwright:
        launched = playwright.chromium.launch(
            executable_path=os.environ["STEERWRIGHT_CHROMIUM"], args=ARGUMENTS
        )
        yield launched
        launched.close()


class Opened:
    """A page, with what it wrote to the console and what it asked for."""

    def __init__(self, browser: Browser, file: Path, **options) -> None:
        options = {"viewport": {"width": 1280, "height": 900}, **options}
        self.context = browser.new_context(**options)
        # A page is slow beside the other suites; how fast it is, is not tested here.
        self.context.set_default_timeout(180_000)
        self.page: Page = self.context.new_page()
        self.problems: list[str] = []
        self.requests: list[str] = []
        self.page.on("console", lambda message: self.report(message.text))
        self.page.on("pageerror", lambda error: self.problems.append(str(error)))
        self.page.on("request", lambda request: self.requests.append(request.url))
        self.page.goto(file.as_uri())

    def report(self, text: str) -> None:
        # Reading pixels is what these tests do, not the page.
        if "willReadFrequently" not in text:
            self.problems.append(text)

    def description(self) -> dict:
        return json.loads(self.page.locator("#figures").text_content())

    def range(self, figure: int, panel: int) -> tuple[float, float]:
        """What a panel shows of x."""
        plot = self.page.locator(f"#f{figure} .plot").nth(panel)
        low, high = plot.get_attribute("data-x").split()
        return float(low), float(high)

    def box(self, figure: int, panel: int) -> dict:
        """Where a panel's plot is in the window."""
        over = self.page.locator(f"#f{figure} .u-over").nth(panel)
        over.scroll_into_view_if_needed()
        return over.bounding_box()

    def drag(self, figure: int, panel: int, start: float, end: float) -> None:
        """Drags between two shares of a panel's width."""
        box = self.box(figure, panel)
        y = box["y"] + 0.5 * box["height"]
        self.page.mouse.move(box["x"] + start * box["width"], y)
        self.page.mouse.down()
        self.page.mouse.move(box["x"] + end * box["width"], y + 2, steps=4)
        self.page.mouse.up()

    def painted(self, figure: int, panel: int, color: str) -> int:
        """Pixels of a panel's canvas within its plot that are about of a colour."""
        return self.page.evaluate(
            """([figure, panel, color]) => {
                const host = document.querySelectorAll(`#f${figure} .plot`)[panel];
                const canvas = host.querySelector("canvas");
                const [whole, over] = [canvas, host.querySelector(".u-over")].map(e => e.getBoundingClientRect());
                const ratio = canvas.width / whole.width;
                const box = [over.left - whole.left, over.top - whole.top, over.width, over.height];
                const { data } = canvas.getContext("2d").getImageData(...box.map(v => Math.round(v * ratio)));
                const wanted = [1, 3, 5].map(k => parseInt(color.slice(k, k + 2), 16));
                let count = 0;
                for (let k = 0; k < data.length; k += 4)
                    if (data[k + 3] > 150 && wanted.every((v, i) => Math.abs(data[k + i] - v) < 40)) count++;
                return count;
            }""",
            [figure, panel, color],
        )


@pytest.fixture
def opened(browser):
    """Opens a page; without problems and requests to anything outside in the end."""
    pages: list[Opened] = []

    def open_page(file: Path = REPORT, **options) -> Opened:
        pages.append(Opened(browser, file, **options))
        return pages[-1]

    yield open_page
    for page in pages:
        page.context.close()
        assert page.problems == []
        outside = [url for url in page.requests if not url.startswith(("file:", "blob:file:", "blob:null"))]
        assert outside == []
