"""Pictures of browser pages that are cropped, reduced to few colours and stored in docs/pictures/."""

import io
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from PIL import Image
from playwright.sync_api import (  # type: ignore[import-not-found, unused-ignore]
    Browser,
    Locator,
    Page,
    sync_playwright,
)

FOLDER = Path(__file__).parents[3] / "docs" / "pictures"
WINDOW = {"width": 860, "height": 900}
COLOURS = (256, 128, 64, 32)
MAX_BYTES = 60_000
"""Size of a picture; a larger one gets fewer colours."""
PATIENCE = 240_000
"""Milliseconds that a page may take."""
MARGIN = 8
"""Pixels around the cropped part."""


@contextmanager
def launch_browser() -> Iterator[Browser]:
    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch(
            executable_path=shutil.which("chromium") or "chromium", args=["--no-sandbox"]
        )
        try:
            yield chromium
        finally:
            chromium.close()


def open_page(chromium: Browser, width: int = WINDOW["width"]) -> Page:
    """Open a page with separate cookies, in light colours."""
    context = chromium.new_context(viewport={**WINDOW, "width": width}, color_scheme="light")
    context.set_default_timeout(PATIENCE)
    return context.new_page()


@dataclass(frozen=True)
class Album:
    """Pictures of one platform, whose file names begin with its name."""

    platform: str

    def path(self, name: str) -> Path:
        return FOLDER / f"{self.platform}-{name}.png"

    def take(self, name: str, page: Page, *parts: Locator, max_height: int = 620) -> None:
        """Store a picture of a page from the first to the last of some parts, or of the whole page if there are none.

        Its bottom is cut off if it is taller than `max_height` pixels.
        """
        page.mouse.move(0, 0)
        page.evaluate("() => window.scrollTo(0, 0)")  # otherwise fixed elements would cover the page
        page.wait_for_timeout(700)
        raw = page.screenshot(full_page=True, animations="disabled", caret="hide")
        whole = Image.open(io.BytesIO(raw)).convert("RGB")
        boxes = [box for part in parts if (box := part.bounding_box())]
        assert len(boxes) == len(parts), f"{name}: a part is not visible"
        if boxes:
            left, right = min(box["x"] for box in boxes), max(box["x"] + box["width"] for box in boxes)
            top, bottom = min(box["y"] for box in boxes), max(box["y"] + box["height"] for box in boxes)
        else:
            left, top, right, bottom = 0, 0, whole.width, whole.height
        bottom = min(bottom, top + max_height)
        window_width = page.viewport_size["width"] if page.viewport_size else whole.width  # not wider than the window
        cut = whole.crop((
            max(0, int(left - MARGIN)), max(0, int(top - MARGIN)),
            min(window_width, whole.width, int(right + MARGIN)), min(whole.height, int(bottom + MARGIN)),
        ))  # fmt: skip
        cut = shrink_to_window(cut) if cut.width > WINDOW["width"] else cut
        FOLDER.mkdir(exist_ok=True)
        self.path(name).write_bytes(compress(cut, name))
        print(f"{self.platform}-{name}.png", cut.size, flush=True)


def shrink_to_window(picture: Image.Image) -> Image.Image:
    width = WINDOW["width"]
    return picture.resize((width, picture.height * width // picture.width), Image.Resampling.LANCZOS)


def compress(picture: Image.Image, name: str) -> bytes:
    """Return a picture as a PNG of at most MAX_BYTES, with as many of COLOURS as possible."""
    for colours in COLOURS:
        png = io.BytesIO()
        picture.quantize(colours, dither=Image.Dither.NONE).save(png, "PNG", optimize=True)
        if len(png.getvalue()) <= MAX_BYTES:
            return png.getvalue()
    raise RuntimeError(f"{name}: {len(png.getvalue())} bytes with {COLOURS[-1]} colours; crop it further")
