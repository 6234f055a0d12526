"""Zoom, pan, crops, values under the cursor, panels, the address, and leaving the viewer."""

from __future__ import annotations

import numpy as np
import pytest

from tests.report.made_up import SIDE
from tests.report.viewer.browser import SIZE, Viewer
from tests.report.viewer.conftest import OTHER_VIEW
from tests.report.viewer.expected import levels


def at(viewer: Viewer) -> tuple[float, float, float]:
    """Return the center and the zoom in the address."""
    x, y, zoom = (float(value) for value in viewer.address("at").split(","))
    return x, y, zoom


def wheel(viewer: Viewer, x: float, y: float, steps: int) -> None:
    for _ in range(abs(steps)):
        viewer.mouse("mouseWheel", x, y, deltaX=0, deltaY=-120 if steps > 0 else 120)
    viewer.settle()


def point(viewer: Viewer, x: float, y: float) -> str:
    """Point at fractions of the canvas; return the pixel that the list names."""
    viewer.mouse("mouseMoved", x, y)
    viewer.settle()
    return viewer.text(".pixel")


def test_the_wheel_zooms_about_the_cursor(viewer: Viewer) -> None:
    before = point(viewer, 0.62, 0.3)
    wheel(viewer, 0.62, 0.3, 8)
    assert at(viewer)[2] == pytest.approx(np.exp(8 * 0.18), rel=0.01)
    assert point(viewer, 0.62, 0.3) == before
    wheel(viewer, 0.62, 0.3, -8)
    assert at(viewer) == pytest.approx((0.5, 0.5, 1), abs=0.01)


def test_enlarged_pixels_are_squares_of_one_color(viewer: Viewer) -> None:
    viewer.open("view=01-panes&at=0.5,0.5,4")
    pixels = viewer.canvas()[..., :3]
    known = {tuple(color) for color in levels().reshape(-1, 3).astype(int).tolist()}
    shown = {tuple(color) for color in pixels.reshape(-1, 3).tolist()}
    assert shown <= known
    assert len(shown) < 60


def test_a_drag_pans_and_r_resets(viewer: Viewer) -> None:
    wheel(viewer, 0.5, 0.5, 8)
    x, y, zoom = at(viewer)
    viewer.drag((0.5, 0.5), (0.4, 0.7))
    moved = at(viewer)
    assert moved[0] > x + 0.01
    assert moved[1] < y - 0.01
    assert moved[2] == zoom
    viewer.press("r")
    assert viewer.address("at") == ""
    assert (viewer.picture(SIDE) == levels()).all()


def test_values_under_the_cursor_are_those_of_all_methods(viewer: Viewer) -> None:
    viewer.open("view=01-panes&at=0.5,0.5,8")
    row, column = SIDE // 2, SIDE // 2
    assert point(viewer, 0.51, 0.51) == f"x {column}, y {row}"
    rows = viewer.script(
        "return [...document.querySelectorAll('#viewer .side tbody tr')].map("
        "row => ['key', 'name', 'mean', 'color', 'error'].map("
        "kind => row.querySelector('.' + kind).textContent))"
    )
    found = {row[1]: row for row in rows}
    for place, name in enumerate("abcdefghij"):
        expected = "  ".join(f"{value:.0f}" for value in levels(0.01 * place)[row, column])
        assert found[name][3] == expected
        assert found[name][0] == (str(place + 1) if place < 9 else "")
    assert found["a"][4] == "0.0000"
    assert float(found["i"][4]) > 0.01
    assert found["dead"][3] == "failed: no <b>shader</b>"
    assert found["exact compositing"][0] == "⇧1"


def test_c_shows_the_crops_of_the_scene(viewer: Viewer) -> None:
    viewer.press("c")
    assert viewer.address("crop") == "middle"
    quarter = SIDE // 4
    _, _, width, height = viewer.box()
    side = min(width, height)
    region = (
        slice((height - side) // 2, (height + side) // 2),
        slice((width - side) // 2, (width + side) // 2),
    )
    inside = levels()[quarter:-quarter, quarter:-quarter]
    assert (viewer.picture(SIDE // 2, region) == inside).all()
    viewer.press("c")
    assert viewer.address("crop") == ""
    viewer.open(f"view={OTHER_VIEW}")
    disabled = viewer.script(
        "return [...document.querySelectorAll('#viewer .bar button')]"
        ".find(e => e.textContent === 'Crop').disabled"
    )
    assert disabled


def panes(viewer: Viewer) -> list[dict[str, float]]:
    """Return the rectangles of the panes on the canvas."""
    found = viewer.script(
        "return [...document.querySelectorAll('#viewer .pane-label')].map(e => ({"
        "x: e.offsetLeft, y: e.offsetTop, width: e.offsetWidth, height: e.offsetHeight}))"
    )
    return list(found)


def test_panels_show_all_pictures_and_move_together(viewer: Viewer) -> None:
    viewer.press("p")
    assert [label.partition(" ·")[0] for label in viewer.labels()] == [
        "exact compositing", "matched tracing", "full path tracing", *"abcdefghij",
    ]  # fmt: skip
    places = panes(viewer)
    last = places[-1]
    _, _, width, height = viewer.box()
    wheel(viewer, (last["x"] + 20) / width, (last["y"] + 30) / height, 6)
    pixels = viewer.canvas()[..., :3].astype(int)

    def middle(pane: dict[str, float]) -> np.ndarray:
        x, y = int(pane["x"] + pane["width"] / 2), int(pane["y"] + pane["height"] / 2)
        return pixels[y - 20 : y + 20, x - 20 : x + 20]

    # The exact picture, and those of the tracer and of the method without an error.
    for other in (1, 2, 3):
        assert (middle(places[0]) == middle(places[other])).all()
    assert (middle(places[0]) != middle(last)).any()
    assert np.abs(middle(places[0]) - middle(last)).max() < 15
    viewer.mouse("mousePressed", 0.99, 0.99, button="left", clickCount=1)
    viewer.mouse("mouseReleased", 0.99, 0.99, button="left", clickCount=1)
    viewer.settle()
    viewer.press("m")
    assert viewer.address("layout") == "panels"
    assert viewer.address("map") == "flip"


def test_a_click_on_a_panel_chooses_its_method(viewer: Viewer) -> None:
    viewer.press("p")
    pane = panes(viewer)[6]
    _, _, width, height = viewer.box()
    place = (pane["x"] + pane["width"] / 2) / width, (pane["y"] + pane["height"] / 2) / height
    for kind in ("mousePressed", "mouseReleased"):
        viewer.mouse(kind, *place, button="left", clickCount=1)
    viewer.press("p")
    assert viewer.labels()[0].startswith("d ")


def test_the_address_holds_the_state(viewer: Viewer) -> None:
    viewer.press("3", "m", "m", "E", "shift+2", "s")
    wheel(viewer, 0.5, 0.5, 3)
    before = viewer.canvas()
    viewer.address("view")
    address = viewer.script("return location.hash.slice(1)")
    viewer.press("r", "1")
    viewer.open(address)
    assert (viewer.canvas() == before).all()
    for name, value in (("method", "c"), ("map", "signed"), ("gain", "1"), ("layout", "split")):
        assert viewer.address(name) == value


@pytest.mark.parametrize(
    "address",
    [
        "view=01-panes&method=none&truth=x&against=y&map=z&layout=w&tone=q&stops=NaN&crop=toString",
        "view=01-panes&at=,,&divider=x&crop=__proto__&stops=",
    ],
)
def test_an_address_that_makes_no_sense_is_like_none(viewer: Viewer, address: str) -> None:
    viewer.open(address)
    assert (viewer.picture(SIDE) == levels()).all()


def test_a_link_opens_and_escape_and_back_leave(viewer: Viewer) -> None:
    viewer.press("escape")
    assert not viewer.shown
    viewer.wait(lambda: viewer.script("return location.hash") == "#stack-01-panes")
    link = viewer.driver.find_elements("css selector", "#stack-01-panes .tile a")[2]
    link.click()
    viewer.settle()
    assert viewer.labels() == ["full path tracing"]
    viewer.driver.back()
    viewer.wait(lambda: not viewer.shown)
    # A browser may close the viewer by itself, as by a gesture.
    viewer.open("view=01-panes")
    viewer.script("document.getElementById('viewer').close()")
    viewer.wait(lambda: viewer.script("return location.hash") == "#stack-01-panes")


def test_f_fills_the_screen_and_leaves_it(viewer: Viewer) -> None:
    viewer.press("f")
    viewer.wait(lambda: viewer.script("return document.fullscreenElement?.className") == "frame")
    viewer.press("f")
    viewer.wait(lambda: viewer.script("return document.fullscreenElement") is None)


def test_help_names_every_key_and_escape_closes_it_first(viewer: Viewer) -> None:
    viewer.press("?")
    shown = "return document.querySelector('#viewer .help').hidden"
    assert viewer.script(shown) is False
    text = viewer.text(".keys")
    for words in ("error map: FLIP, signed × 8, absolute × 8", "full screen", "Shift 1 … 3"):
        assert words in text
    viewer.press("escape")
    assert viewer.script(shown) is True
    assert viewer.shown


def test_buttons_do_the_same_and_say_what_is_on(viewer: Viewer) -> None:
    buttons = viewer.driver.find_elements("css selector", "#viewer .bar button")
    by_text = {button.text: button for button in buttons}
    by_text["›"].click()
    by_text["Map"].click()
    viewer.settle()
    assert viewer.labels()[0].startswith("b ")
    assert by_text["Map"].get_attribute("aria-pressed") == "true"
    assert by_text["Split"].get_attribute("aria-pressed") == "false"
    assert all(button.get_attribute("aria-label") for button in buttons)
    # Keys still work after a click.
    viewer.press("r")
    assert (viewer.picture(SIDE) == levels(0.01)).all()


@pytest.mark.parametrize("width", [390, 800, 1400])
def test_nothing_is_cut_off_on_any_screen(viewer: Viewer, width: int) -> None:
    metrics = {"width": width, "height": 844, "deviceScaleFactor": 2, "mobile": width < 500}
    viewer.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
    try:
        viewer.press("p", "m")
        inside = viewer.script(
            "const parts = '#viewer .bar *, #viewer .legend, #viewer .side';"
            "return [...document.querySelectorAll(parts)].every(e => {"
            " const b = e.getBoundingClientRect();"
            " return b.left >= 0 && b.right <= innerWidth && b.bottom <= innerHeight; })"
        )
        assert inside
        assert viewer.script("return document.documentElement.scrollWidth") <= width
        _, _, across, down = viewer.box()
        assert across >= 0.6 * width
        assert down >= 250
        # The canvas has the pixels of the screen, not those of the layout.
        assert viewer.canvas().shape[:2] == (2 * down, 2 * across)
    finally:
        viewer.driver.execute_cdp_cmd(
            "Emulation.setDeviceMetricsOverride",
            {"width": SIZE[0], "height": SIZE[1], "deviceScaleFactor": 1, "mobile": False},
        )


def test_two_fingers_zoom_one_pans_and_a_tap_points(viewer: Viewer) -> None:
    viewer.touch("touchStart", (0.4, 0.5), (0.6, 0.5))
    viewer.touch("touchMove", (0.3, 0.5), (0.7, 0.5))
    viewer.touch("touchMove", (0.2, 0.5), (0.8, 0.5))
    viewer.touch("touchEnd")
    viewer.settle()
    x, y, zoom = at(viewer)
    assert zoom == pytest.approx(3, rel=0.1)
    assert (x, y) == pytest.approx((0.5, 0.5), abs=0.03)
    viewer.touch("touchStart", (0.5, 0.5))
    viewer.touch("touchMove", (0.55, 0.5))
    viewer.touch("touchMove", (0.6, 0.5))
    viewer.touch("touchEnd")
    viewer.settle()
    assert at(viewer)[0] < x - 0.02
    assert viewer.text(".pixel") == "point at a pixel"
    viewer.touch("touchStart", (0.5, 0.5))
    viewer.touch("touchEnd")
    viewer.settle()
    assert viewer.text(".pixel").startswith("x ")
