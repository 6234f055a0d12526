"""Chromium without a window, and the viewer in it as a reader sees it."""

from __future__ import annotations

import base64
import io
import shutil
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from PIL import Image

CHROMIUM = ("chromium", "chromium-browser", "google-chrome")
SIZE = (1000, 760)
"""Width and height of the window, in pixels."""
SECONDS = 20.0
"""Longest wait for an effect."""

Levels = npt.NDArray[np.uint8]


@contextmanager
def chromium(downloads: Path) -> Iterator[Any]:
    """Yield a driver of Chromium; skip the test where there is none."""
    pytest.importorskip("selenium", reason="selenium is not installed: pip install oitbench[test]")
    browser = next(filter(None, map(shutil.which, CHROMIUM)), None)
    driver = shutil.which("chromedriver")
    if browser is None or driver is None:
        pytest.skip("there is no Chromium with its driver: apt-get install chromium-driver")
    from selenium import webdriver
    from selenium.webdriver.chrome.service import Service

    options = webdriver.ChromeOptions()
    options.binary_location = browser
    for argument in ("--headless=new", "--no-sandbox", "--disable-gpu", "--mute-audio"):
        options.add_argument(argument)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    options.add_experimental_option("prefs", {"download.default_directory": str(downloads)})
    made = webdriver.Chrome(options=options, service=Service(driver))
    try:
        width, height = SIZE
        made.execute_cdp_cmd(
            "Emulation.setDeviceMetricsOverride",
            {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False},
        )
        made.execute_cdp_cmd("Emulation.setTouchEmulationEnabled", {"enabled": True})
        yield made
    finally:
        made.quit()


class Viewer:
    """A page with an open viewer.

    Parameters
    ----------
    driver : WebDriver
    page : Path
    """

    def __init__(self, driver: Any, page: Path) -> None:
        self.driver, self.page = driver, page

    def open(self, address: str) -> Viewer:
        """Load the page anew with an address behind `#`, and wait until nothing is loading."""
        self.driver.get("about:blank")
        self.driver.get_log("browser")
        self.driver.get(f"{self.page.as_uri()}#{address}")
        self.wait(lambda: self.shown and self.text(".labels"))
        self.settle()
        return self

    def settle(self) -> None:
        """Wait until all pixels are unpacked and drawn."""
        self.wait(lambda: "loading" not in self.text(".labels"))
        # What is drawn follows in the next frame.
        self.script_async("requestAnimationFrame(() => requestAnimationFrame(() => done()))")

    def wait(self, condition: Callable[[], object]) -> None:
        """Wait until a condition holds."""
        end = time.monotonic() + SECONDS
        while not condition():
            assert time.monotonic() < end, "the page does not get there"
            time.sleep(0.02)

    @property
    def shown(self) -> bool:
        """Whether the viewer is open."""
        return bool(self.script("return document.getElementById('viewer').open"))

    def script(self, text: str, *arguments: object) -> Any:
        return self.driver.execute_script(text, *arguments)

    def script_async(self, text: str) -> Any:
        return self.driver.execute_async_script(f"const done = arguments[0]; {text}")

    def press(self, *keys: str) -> None:
        """Press keys one after the other; "shift+1" is a digit with Shift."""
        from selenium.webdriver import ActionChains
        from selenium.webdriver.common.keys import Keys

        names = {"left": Keys.ARROW_LEFT, "right": Keys.ARROW_RIGHT, "escape": Keys.ESCAPE}
        for key in keys:
            chain = ActionChains(self.driver)
            if key.startswith("shift+"):
                chain.key_down(Keys.SHIFT).send_keys(key[-1]).key_up(Keys.SHIFT)
            else:
                chain.send_keys(names.get(key, key))
            chain.perform()
        self.settle()

    def text(self, selector: str) -> str:
        """Return the text of an element of the viewer, shown or not."""
        found = self.script(
            "return document.querySelector(arguments[0]).textContent", f"#viewer {selector}"
        )
        return str(found)

    def labels(self) -> list[str]:
        """Return the texts over the panes."""
        found = self.script(
            "return [...document.querySelectorAll('#viewer .labels > div')].map(e => e.textContent)"
        )
        return [str(text) for text in found]

    def address(self, part: str) -> str:
        """Return a field of the address once it has been written; empty if it is not there."""
        time.sleep(0.25)
        found = self.script(
            "return new URLSearchParams(location.hash.slice(1)).get(arguments[0])", part
        )
        return str(found or "")

    def canvas(self) -> Levels:
        """Return the pixels of the canvas, shape (h, w, 4)."""
        found = self.script("return document.querySelector('#viewer canvas').toDataURL()")
        content = base64.b64decode(str(found).partition(",")[2])
        return np.asarray(Image.open(io.BytesIO(content)).convert("RGBA"))

    def picture(
        self, side: int, region: tuple[slice, slice] = (slice(None), slice(None))
    ) -> Levels:
        """Return the picture in a part of the canvas, which is clear around it.

        The middles of `side` × `side` equal cells are read, shape (side, side, 3).
        """
        pixels = self.canvas()[region]
        rows, columns = (np.flatnonzero((pixels[..., 3] > 0).any(axis=axis)) for axis in (1, 0))
        inside = pixels[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1, :3]
        middles = [((np.arange(side) + 0.5) * extent / side).astype(int) for extent in inside.shape]
        return np.asarray(inside[np.ix_(middles[0], middles[1])])

    def box(self) -> tuple[int, int, int, int]:
        """Return left, top, width and height of the canvas in the window."""
        found = self.script(
            "const b = document.querySelector('#viewer canvas').getBoundingClientRect();"
            "return [b.left, b.top, b.width, b.height]"
        )
        left, top, width, height = (round(value) for value in found)
        return left, top, width, height

    def place(self, x: float, y: float) -> tuple[int, int]:
        """Return the window's pixel at fractions of the canvas."""
        left, top, width, height = self.box()
        return left + round(x * width), top + round(y * height)

    def mouse(self, kind: str, x: float, y: float, **more: Any) -> None:
        """Send an event of the mouse at fractions of the canvas."""
        across, down = self.place(x, y)
        event = {"type": kind, "x": across, "y": down, **more}
        self.driver.execute_cdp_cmd("Input.dispatchMouseEvent", event)

    def drag(self, start: tuple[float, float], end: tuple[float, float]) -> None:
        """Drag with the left button."""
        button: dict[str, Any] = {"button": "left", "buttons": 1, "clickCount": 1}
        self.mouse("mouseMoved", *start)
        self.mouse("mousePressed", *start, **button)
        self.mouse("mouseMoved", (start[0] + end[0]) / 2, (start[1] + end[1]) / 2, **button)
        self.mouse("mouseMoved", *end, **button)
        self.mouse("mouseReleased", *end, **button)
        self.settle()

    def touch(self, kind: str, *points: tuple[float, float]) -> None:
        """Send an event of fingers at fractions of the canvas."""
        places = [self.place(*point) for point in points]
        fingers = [{"x": x, "y": y, "id": number} for number, (x, y) in enumerate(places)]
        self.driver.execute_cdp_cmd(
            "Input.dispatchTouchEvent", {"type": kind, "touchPoints": fingers}
        )

    def complaints(self) -> list[str]:
        """Return the errors that the page has logged."""
        return [line["message"] for line in self.driver.get_log("browser")]
