"""The page in a real browser without a network: what is drawn, what can be done, what is printed."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib import image

from gomboc_cad.report.protocol import share_at_least
from tests.external import require_module
from tests.report.conftest import MakeResults, write_page
from tests.report.test_page import NASTY, rename_everything

ARGUMENTS = ["--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"]
"""WebGL without a graphics card."""

VIEWER = "#viewer canvas"


@pytest.fixture(scope="module")
def browser(chromium: str) -> Iterator[Any]:
    playwright = require_module("playwright.sync_api", "test")
    with playwright.sync_playwright() as driver:
        opened = driver.chromium.launch(executable_path=chromium, args=ARGUMENTS)
        yield opened
        opened.close()


class Opened:
    """A page with everything that it asked for and said."""

    def __init__(self, browser: Any, file: Path, **options: Any) -> None:
        self.context = browser.new_context(offline=True, **options)
        self.page = self.context.new_page()
        self.asked: list[str] = []
        self.said: list[str] = []
        self.page.on("request", lambda request: self.asked.append(request.url))
        self.page.on("console", lambda message: self.said.append(message.text))
        self.page.on("pageerror", lambda error: self.said.append(str(error)))
        self.page.on("dialog", lambda dialog: (self.said.append(dialog.message), dialog.dismiss()))
        self.page.goto(file.as_uri())

    def pixels(self, selector: str = VIEWER) -> np.ndarray:
        """What is drawn there, two frames from now, shape (rows, columns, channels)."""
        self.page.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
        return image.imread(BytesIO(self.page.locator(selector).first.screenshot()), format="png")

    def changed(self, do: Callable[[], Any]) -> float:
        """Share of the view's pixels that an action changes."""
        before = self.pixels()
        do()
        after = self.pixels()
        assert before.shape == after.shape
        return float((np.abs(before - after).max(axis=2) > 0.02).mean())


OpenPage = Callable[..., Opened]


@pytest.fixture
def open_page(browser: Any) -> Iterator[OpenPage]:
    opened: list[Opened] = []

    def make(folder: Path, **options: Any) -> Opened:
        opened.append(Opened(browser, folder / "report.html", **options))
        return opened[-1]

    yield make
    for each in opened:
        each.context.close()


@pytest.fixture(scope="module")
def wide(browser: Any, housing: Path) -> Iterator[Opened]:
    """The housing's page on a usual screen."""
    opened = Opened(browser, housing / "report.html", viewport={"width": 1200, "height": 900})
    yield opened
    opened.context.close()


def test_offline_it_asks_for_nothing_but_itself_and_has_no_complaint(wide: Opened, housing: Path) -> None:
    wide.pixels()
    assert wide.asked == [(housing / "report.html").as_uri()]
    assert wide.said == []


def test_what_an_engineer_looks_for_is_to_be_seen(wide: Opened) -> None:
    text = wide.page.inner_text("body")
    for expected in ("imu-housing", "PASS", "S-margin", "0.382\u00a0mm", "How to accept the made part"):
        assert expected in text
    picture = image.imread(BytesIO(wide.page.screenshot()), format="png")
    assert picture[..., :3].std() > 0.03


def test_the_view_draws_and_turns_by_pointer_wheel_keys_and_buttons(wide: Opened) -> None:
    page = wide.page
    assert page.is_visible(VIEWER)
    assert not page.is_visible("#still")
    assert wide.pixels()[..., :3].std() > 0.05
    page.locator(VIEWER).scroll_into_view_if_needed()
    box = page.locator(VIEWER).bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2

    def drag() -> None:
        page.mouse.move(x, y)
        page.mouse.down()
        page.mouse.move(x + 120, y + 30, steps=3)
        page.mouse.up()

    def wheel() -> None:
        page.mouse.move(x, y)
        page.mouse.wheel(0, -200)

    page.focus(VIEWER)
    start = wide.pixels()
    assert wide.changed(drag) > 0.02
    assert wide.changed(wheel) > 0.02
    page.focus(VIEWER)
    for key in ("ArrowLeft", "ArrowUp", "-"):
        assert wide.changed(lambda key=key: page.keyboard.press(key)) > 0.01, key
    assert wide.changed(lambda: page.click("button[data-view=above]")) > 0.02
    page.focus(VIEWER)
    page.keyboard.press("Home")
    assert np.abs(wide.pixels() - start).max() < 0.02


def test_each_colour_is_drawn_with_its_own_scale(wide: Opened) -> None:
    for name in ("drill", "curvature", "deviation"):
        share = wide.changed(lambda name=name: wide.page.check(f"input[name=coloring][value={name}]"))
        assert share > 0.02, name
        visible = wide.page.locator(".scale:visible")
        assert visible.count() == 1
        assert visible.get_attribute("data-coloring") == name


def test_parts_are_hidden_and_the_product_cut_open(wide: Opened) -> None:
    names = wide.page.locator("#shown label").all_inner_texts()
    assert {"Outer surface", "shell", "Table", "Centre of mass"} <= set(names)

    def toggle(name: str) -> None:
        wide.page.locator("#shown label", has_text=re.compile(f"^{name}$")).locator("input").click()

    assert wide.changed(lambda: toggle("Outer surface")) > 0.02
    assert wide.changed(lambda: toggle("shell")) > 0.02
    toggle("Outer surface")
    toggle("shell")
    assert wide.changed(lambda: wide.page.check("#cut")) > 0.02
    wide.page.uncheck("#cut")


def test_a_part_with_the_name_of_a_script_stays_text(wide: Opened) -> None:
    assert "<script>alert(1)</script>" in wide.page.locator("#shown label").all_inner_texts()
    assert wide.said == []


def test_a_spec_full_of_scripts_runs_none(open_page: OpenPage, changed: MakeResults) -> None:
    folder = changed("verdict.json", rename_everything)
    write_page(folder)
    opened = open_page(folder)
    assert opened.said == []
    assert opened.page.inner_text("h1") == NASTY
    assert opened.page.locator("#asked").get_by_text(NASTY).count() > 3


def test_dark_and_light_have_enough_contrast(open_page: OpenPage, housing: Path) -> None:
    grounds = []
    for scheme in ("light", "dark"):
        page = open_page(housing, color_scheme=scheme).page
        ink, ground = (
            page.evaluate(f"getComputedStyle(document.body).{key}") for key in ("color", "backgroundColor")
        )
        assert contrast(ink, ground) > 7.0
        soft = page.evaluate("getComputedStyle(document.querySelector('figcaption, .what')).color")
        assert contrast(soft, ground) > 4.5
        grounds.append(ground)
    assert grounds[0] != grounds[1]


def contrast(one: str, other: str) -> float:
    """Ratio of luminances, WCAG 2.2."""

    def luminance(color: str) -> float:
        values = np.array([float(value) for value in re.findall(r"[\d.]+", color)[:3]]) / 255.0
        linear = np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)
        return float(linear @ [0.2126, 0.7152, 0.0722])

    low, high = sorted((luminance(one), luminance(other)))
    return (high + 0.05) / (low + 0.05)


def test_a_narrow_screen_needs_no_scrolling_sideways(open_page: OpenPage, housing: Path, buoy: Path) -> None:
    for folder in (housing, buoy):
        page = open_page(folder, viewport={"width": 400, "height": 800}).page
        assert page.evaluate("document.documentElement.scrollWidth") <= 400


def test_it_prints_on_whole_pages(open_page: OpenPage, housing: Path) -> None:
    page = open_page(housing).page
    sheet = page.pdf(prefer_css_page_size=True)
    assert 6 <= len(re.findall(rb"/Type\s*/Page\b", sheet)) <= 30
    page.emulate_media(media="print")
    assert page.is_visible("#still")
    assert not page.is_visible(VIEWER)
    # What is wider than the paper is cut off.
    page.set_viewport_size({"width": 688, "height": 1000})
    assert page.evaluate("document.documentElement.scrollWidth") <= 688


def test_without_webgl_a_still_picture_stays(browser: Any, housing: Path) -> None:
    context = browser.new_context(offline=True)
    page = context.new_page()
    page.add_init_script("HTMLCanvasElement.prototype.getContext = () => null")
    page.goto((housing / "report.html").as_uri())
    assert page.is_visible("#still")
    assert not page.is_visible("#viewer")
    context.close()


@pytest.mark.parametrize(("drops", "misses"), [(59, 0), (30, 2), (1000, 13), (3, 3)])
def test_the_form_says_what_the_drops_show(wide: Opened, drops: int, misses: int) -> None:
    wide.page.fill("#drops", str(drops))
    wide.page.fill("#misses", str(misses))
    said = wide.page.inner_text("#share-at-least")
    assert said == f"{100.0 * share_at_least(drops, misses):.1f} %, with 95 % confidence"
    wide.page.fill("#misses", "two")
    assert wide.page.inner_text("#share-at-least") == "–"


def test_the_form_can_be_filled_in(wide: Opened) -> None:
    field = wide.page.get_by_label("Part number").last
    field.fill("A1-0007")
    assert field.input_value() == "A1-0007"
    unlabelled = wide.page.evaluate(
        "[...document.querySelectorAll('#protocol input, #protocol textarea')]"
        ".filter((each) => !each.labels.length && !each.getAttribute('aria-label')).length"
    )
    assert unlabelled == 0
