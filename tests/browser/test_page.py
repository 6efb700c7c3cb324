"""The report in a browser: what is drawn, zoomed, read, hidden, saved and printed."""

from __future__ import annotations

import contextlib
import csv
import io
import math

import pytest
from axe_playwright_python.sync_playwright import Axe
from conftest import OUT

DEG = 180.0 / math.pi
# Of the report: figures of the same drive, and one of the frequency.
DRIVE, COHERENCE, COMPARISON = 0, 1, 2
AXE = (Axe(), {"resultTypes": ["violations"]})


def traces() -> dict[str, list[float]]:
    with open(OUT / "traces.csv", newline="") as file:
        header, *rows = csv.reader(file)
    return {name: [float(row[k] or "nan") for row in rows] for k, name in enumerate(header)}


@contextlib.contextmanager
def hidden(page, figure: int, but: str):
    """Without the other series of a figure."""
    others = page.page.locator(f"#f{figure} button[data-name]").all()
    names = {b.get_attribute("data-name"): b for b in others if b.get_attribute("data-name") != but}
    for turn in range(2):
        for button in names.values():
            button.click()
        page.page.wait_for_timeout(100)
        if turn == 0:
            yield


@pytest.mark.parametrize("file", sorted(OUT.rglob("*.html")), ids=lambda file: file.stem)
def test_a_page_draws_every_series_of_every_figure(opened, file):
    assert file.stat().st_size < 2_000_000
    page = opened(file)
    figures = page.description()["figures"]
    assert figures and page.page.locator("figure.live").count() == len(figures)
    columns = page.description()["columns"]
    for number, figure in enumerate(figures):
        assert page.page.locator(f"#f{number} figcaption b").text_content().strip().endswith(".")
        for k, panel in enumerate(figure["panels"]):
            for series in panel["series"]:
                values = columns[series["y"]]
                if series["isData"] and any(v is not None for v in values.get("d") or values["v"]):
                    count = page.painted(number, k, series["color"])
                    if count < 5:
                        # A good model covers what was measured.
                        with hidden(page, number, series["name"]):
                            count = page.painted(number, k, series["color"])
                    assert count >= 5, (figure["title"], k, series["name"], count)


def test_a_dragged_range_is_shown_by_all_axes_of_the_drive_and_no_others(opened):
    page = opened()
    home = page.range(DRIVE, 0)
    others = page.range(COHERENCE, 0)
    page.drag(DRIVE, 1, 0.25, 0.5)
    low, high = page.range(DRIVE, 1)
    share = (high - low) / (home[1] - home[0])
    assert share == pytest.approx(0.25, abs=0.01) and low > home[0]
    for figure, panel in [(DRIVE, 0), (DRIVE, 2), (COMPARISON, 0), (COMPARISON, 1)]:
        assert page.range(figure, panel) == (low, high)
    assert page.range(COHERENCE, 0) == others
    box = page.box(COMPARISON, 1)
    page.page.mouse.dblclick(box["x"] + 50, box["y"] + 30)
    assert page.range(DRIVE, 0) == home


def test_y_shows_what_is_in_the_range_of_x(opened):
    page = opened()
    plot = page.page.locator(f"#f{DRIVE} .plot").first
    before = [float(v) for v in plot.get_attribute("data-y").split()]
    page.drag(DRIVE, 0, 0.002, 0.02)
    low, high = (float(v) for v in plot.get_attribute("data-y").split())
    first, last = page.range(DRIVE, 0)
    data = traces()
    seen = [DEG * s for t, s in zip(data["time_s"], data["steering_rad"]) if first <= t <= last]
    assert low <= min(seen) and high >= max(seen)
    assert high - low < 0.8 * (before[1] - before[0])


def test_wheel_buttons_and_shift_move_and_zoom(opened):
    page = opened()
    home = page.range(DRIVE, 0)
    box = page.box(DRIVE, 0)
    page.page.mouse.move(box["x"] + 0.5 * box["width"], box["y"] + 20)
    page.page.mouse.wheel(0, -40)
    page.page.wait_for_timeout(100)
    assert page.range(DRIVE, 0) == home, "the wheel alone is the page's"
    page.page.keyboard.down("Control")
    box = page.box(DRIVE, 0)
    page.page.mouse.move(box["x"] + 0.5 * box["width"], box["y"] + 20)
    page.page.mouse.wheel(0, -200)
    page.page.keyboard.up("Control")
    page.page.wait_for_timeout(100)
    zoomed = page.range(DRIVE, 0)
    assert zoomed[0] > home[0] and zoomed[1] < home[1]
    page.page.keyboard.down("Shift")
    page.drag(DRIVE, 0, 0.6, 0.4)
    page.page.keyboard.up("Shift")
    moved = page.range(DRIVE, 0)
    length = zoomed[1] - zoomed[0]
    assert moved[0] - zoomed[0] == pytest.approx(0.2 * length, rel=0.05)
    tools = page.page.locator(f"#f{DRIVE} .tools button")
    for name, expected in [("Zoom in", 0.5), ("Zoom out", 1.0)]:
        tools.and_(page.page.get_by_label(name)).click()
        low, high = page.range(DRIVE, 2)
        assert high - low == pytest.approx(expected * length, rel=1e-6)
    tools.and_(page.page.get_by_label("Move left")).click()
    assert page.range(DRIVE, 0)[0] < moved[0]
    tools.and_(page.page.get_by_label("Reset")).click()
    assert page.range(DRIVE, 0) == home


def test_logarithmic_axes_zoom_by_decades(opened):
    page = opened()
    low, high = page.range(COHERENCE, 0)
    page.drag(COHERENCE, 0, 0.0, 0.5)
    first, last = page.range(COHERENCE, 0)
    assert first == pytest.approx(low, rel=0.01) and last == pytest.approx(math.sqrt(low * high), rel=0.02)
    for _ in range(12):
        page.page.locator(f"#f{COHERENCE} .tools").get_by_label("Zoom in").click()
    first, last = page.range(COHERENCE, 0)
    assert low < first < last < math.sqrt(low * high)


@pytest.mark.parametrize("width", [1280, 400])
def test_a_map_keeps_its_scale(opened, width):
    page = opened(viewport={"width": width, "height": 800})
    figures = page.description()["figures"]
    road = next(k for k, f in enumerate(figures) if f["title"] == "Reference road and tracks")

    def units():
        """Metres in a pixel, along both axes."""
        box = page.box(road, 0)
        plot = page.page.locator(f"#f{road} .plot")
        for name, length in [("data-x", "width"), ("data-y", "height")]:
            low, high = (float(v) for v in plot.get_attribute(name).split())
            yield (high - low) / box[length]

    x, y = units()
    assert x == pytest.approx(y, rel=0.02)
    page.drag(road, 0, 0.3, 0.6)
    zoomed, y = units()
    assert zoomed == pytest.approx(0.3 * x, rel=0.05) and zoomed == pytest.approx(y, rel=0.02)


def test_two_fingers_zoom_and_one_moves(opened):
    page = opened(has_touch=True)
    home = page.range(DRIVE, 0)
    box = page.box(DRIVE, 0)
    session = page.context.new_cdp_session(page.page)

    def touch(kind, *shares):
        y = box["y"] + 0.5 * box["height"]
        points = [{"x": box["x"] + s * box["width"], "y": y, "id": k} for k, s in enumerate(shares)]
        session.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})

    touch("touchStart", 0.4, 0.6)
    touch("touchMove", 0.3, 0.7)
    touch("touchEnd")
    zoomed = page.range(DRIVE, 0)
    assert (zoomed[1] - zoomed[0]) / (home[1] - home[0]) == pytest.approx(0.5, abs=0.05)
    touch("touchStart", 0.5)
    touch("touchMove", 0.4)
    touch("touchMove", 0.3)
    touch("touchEnd")
    assert page.range(DRIVE, 0)[0] > zoomed[0]


def test_values_under_the_cursor_are_those_of_the_log(opened):
    page = opened()
    box = page.box(DRIVE, 1)
    page.page.mouse.move(box["x"] + 0.4 * box["width"], box["y"] + 40)
    read = page.page.locator(f"#f{DRIVE} .panel").nth(1).locator(".value").all_text_contents()
    rate, time = (float(text.replace("−", "-")) for text in read)
    low, high = page.range(DRIVE, 1)
    assert time == pytest.approx(low + 0.4 * (high - low), abs=(high - low) / box["width"] + 0.02)
    data = traces()
    nearest = min(range(len(data["time_s"])), key=lambda k: abs(data["time_s"][k] - time))
    assert data["time_s"][nearest] == pytest.approx(time, abs=1e-3)
    assert DEG * data["yaw_rate_radps"][nearest] == pytest.approx(rate, abs=1e-3 + 1e-4 * abs(rate))
    # The axes of the other figure of the drive have the same cursor.
    shown = page.page.locator(f"#f{COMPARISON} .panel").first.locator(".value").all_text_contents()
    assert shown[0] == read[0] and len([text for text in shown if text]) == len(shown)


def test_a_series_is_hidden_in_all_panels_and_shown_again(opened):
    page = opened()
    page.drag(DRIVE, 0, 0.1, 0.3)
    before = page.range(COMPARISON, 0)
    color = next(
        s["color"]
        for s in page.description()["figures"][COMPARISON]["panels"][0]["series"]
        if s["name"] == "identified"
    )
    count = [page.painted(COMPARISON, k, color) for k in range(3)]
    assert min(count) > 50
    buttons = page.page.locator(f"#f{COMPARISON} button[data-name=identified]")
    buttons.first.click()
    assert [b.get_attribute("aria-pressed") for b in buttons.all()] == ["false"] * buttons.count()
    page.page.wait_for_timeout(100)
    assert [page.painted(COMPARISON, k, color) for k in range(3)] == [0, 0, 0]
    assert page.range(COMPARISON, 0) == before, "the range stays"
    buttons.last.click()
    page.page.wait_for_timeout(100)
    assert [page.painted(COMPARISON, k, color) for k in range(3)] == count


def test_csv_has_the_samples(opened):
    page = opened(accept_downloads=True)
    with page.page.expect_download() as download:
        page.page.locator(f"#f{COMPARISON} .tools").get_by_text("CSV").click()
    assert download.value.suggested_filename == "measured-and-identified-model.csv"
    text = download.value.path().read_text(encoding="utf-8")
    header, *rows = csv.reader(io.StringIO(text))
    data = traces()
    assert header[:2] == ["Time (s)", "Yaw rate (deg/s): measured"]
    expected = {
        "Time (s)": data["time_s"],
        "Yaw rate (deg/s): measured": [DEG * v for v in data["yaw_rate_radps"]],
        "Yaw rate (deg/s): identified": [DEG * v for v in data["simulated_yaw_rate_radps"]],
        "Yaw (deg): measured": [DEG * v for v in data["yaw_rad"]],
    }
    for name, values in expected.items():
        column = [row[header.index(name)] for row in rows]
        largest = max(abs(v) for v in values if math.isfinite(v))
        assert len(column) == len(values)
        for cell, value in zip(column, values):
            assert (cell == "") == math.isnan(value)
            assert cell == "" or float(cell) == pytest.approx(value, abs=1e-5 * largest), name


def violations(page) -> list[str]:
    axe, options = AXE
    found = axe.run(page.page, options=options).response["violations"]
    return [f"{v['id']}: {node['html'][:150]}" for v in found for node in v["nodes"]]


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("width", [1280, 400])
def test_contrast_labels_and_structure_pass_axe(opened, scheme, width):
    page = opened(color_scheme=scheme, viewport={"width": width, "height": 800})
    page.page.locator("details").evaluate_all("all => all.forEach(d => d.open = true)")
    assert violations(page) == []


def test_a_narrow_window_shows_all_but_wide_tables(opened):
    page = opened(viewport={"width": 400, "height": 800})
    assert page.page.evaluate("document.documentElement.scrollWidth") <= 400
    for box in (c.bounding_box() for c in page.page.locator("figure canvas, figure button").all()):
        assert box["x"] >= 0 and box["x"] + box["width"] <= 400
    # Turned, the figures follow.
    page.page.set_viewport_size({"width": 800, "height": 400})
    page.page.wait_for_timeout(200)
    assert page.page.locator("figure canvas").first.bounding_box()["width"] > 700


def test_the_keyboard_reads_zooms_and_hides(opened):
    page = opened()
    name = "Yaw rate (deg/s) over Time (s): measured, "
    plot = page.page.locator(f"#f{COMPARISON}").get_by_role("application", name=name).first
    home = page.range(COMPARISON, 0)
    plot.focus()
    status = page.page.locator(f"#f{COMPARISON} [role=status]")
    page.page.keyboard.press("ArrowRight")
    first = status.text_content()
    assert first.startswith("Time (s) ") and "measured " in first and "identified " in first
    page.page.keyboard.press("ArrowRight")
    assert status.text_content() != first
    page.page.keyboard.press("+")
    low, high = page.range(COMPARISON, 0)
    assert high - low == pytest.approx(0.5 * (home[1] - home[0]))
    page.page.keyboard.press("Shift+ArrowRight")
    assert page.range(COMPARISON, 0)[0] > low
    page.page.keyboard.press("0")
    assert page.range(COMPARISON, 0) == home
    # The tab key leads to every tool, legend and figure.
    page.page.locator(f"#f{COMPARISON} .tools button").first.focus()
    reached = set()
    for _ in range(20):
        page.page.keyboard.press("Tab")
        reached.add(page.page.evaluate("document.activeElement.className + document.activeElement.textContent"))
    assert any(text.startswith("plot") for text in reached) and "CSV" in reached
    button = page.page.locator(f"#f{COMPARISON} button[data-name=measured]").first
    button.focus()
    page.page.keyboard.press("Enter")
    assert button.get_attribute("aria-pressed") == "false"


def test_dark_colours_follow_the_system_and_the_button(opened):
    page = opened(color_scheme="dark")

    def paper():
        return page.page.evaluate("getComputedStyle(document.body).backgroundColor")

    dark = paper()
    assert max(int(v) for v in dark.removeprefix("rgb(").removesuffix(")").split(",")) < 60
    # What is black on paper is light.
    assert page.painted(DRIVE, 1, "#000000") == 0 and page.painted(DRIVE, 1, "#ebebeb") > 50
    page.page.get_by_role("button", name="Light colours").click()
    page.page.wait_for_timeout(100)
    assert paper() == "rgb(255, 255, 255)" and page.painted(DRIVE, 1, "#000000") > 50
    page.page.get_by_role("button", name="Dark colours").click()
    assert paper() == dark


def test_print_shows_still_figures_on_white_and_what_is_folded(opened):
    page = opened(color_scheme="dark")
    provenance = page.page.locator("section > details")
    assert provenance.get_attribute("open") is None
    assert not provenance.locator("table").first.is_visible()
    page.page.emulate_media(media="print")
    page.page.evaluate("dispatchEvent(new Event('beforeprint'))")
    assert page.page.locator("figure svg[role=img]").first.is_visible()
    assert not page.page.locator(".panels, .tools, nav").first.is_visible()
    assert provenance.locator("table").first.is_visible()
    assert page.page.evaluate("getComputedStyle(document.body).color") == "rgb(27, 27, 27)"
    page.page.evaluate("dispatchEvent(new Event('afterprint'))")
    page.page.emulate_media(media="screen")
    assert not provenance.locator("table").first.is_visible()
    assert page.page.pdf().startswith(b"%PDF")


def test_without_scripts_the_figures_are_still(opened):
    page = opened(java_script_enabled=False)
    svgs = page.page.locator("figure svg[role=img]")
    figures = page.page.locator("figure").count()
    assert svgs.count() == figures > 8
    assert all(svg.is_visible() for svg in svgs.all())
    assert page.page.locator(".panels").count() == 0

