"""Take pictures with a browser, crop and compress them, and store them in docs/pictures/."""

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
LARGEST = 60_000
"""The largest size of a picture in bytes; a larger one gets fewer colours."""
PATIENCE = 240_000
"""The time limit for a page in milliseconds."""
AROUND = 8
"""The margin around a cropped picture in pixels."""


@contextmanager
def browser() -> Iterator[Browser]:
    """Yield a Chromium without a window."""
    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch(
            executable_path=shutil.which("chromium") or "chromium", args=["--no-sandbox"]
        )
        try:
            yield chromium
        finally:
            chromium.close()


def opened(chromium: Browser, width: int = WINDOW["width"]) -> Page:
    """Return a page of a reader of its own, which nobody else's cookies are in, in light colours."""
    context = chromium.new_context(viewport={**WINDOW, "width": width}, color_scheme="light")
    context.set_default_timeout(PATIENCE)
    return context.new_page()


@dataclass(frozen=True)
class Album:
    """The pictures of one platform. Their names begin with its name."""

    platform: str

    def path(self, name: str) -> Path:
        """Return where a picture is kept."""
        return FOLDER / f"{self.platform}-{name}.png"

    def take(
        self, name: str, page: Page, *parts: Locator, tallest: int = 620, lower: bool = False, around: int = AROUND
    ) -> None:
        """Keep a picture of what is between the first and the last of some parts of a page; of all, without parts.

        What is taller than `tallest` pixels is cut off below, with `lower` above; pixels `around` it are in it.
        """
        page.mouse.move(0, 0)
        page.evaluate("() => window.scrollTo(0, 0)")  # what stays on top of a window would lie over the page
        page.wait_for_timeout(700)
        raw = page.screenshot(full_page=True, animations="disabled", caret="hide")
        whole = Image.open(io.BytesIO(raw)).convert("RGB")
        boxes = [box for part in parts if (box := part.bounding_box())]
        assert len(boxes) == len(parts), f"{name}: not to be seen"
        if boxes:
            left, right = min(box["x"] for box in boxes), max(box["x"] + box["width"] for box in boxes)
            top, bottom = min(box["y"] for box in boxes), max(box["y"] + box["height"] for box in boxes)
        else:
            left, top, right, bottom = 0, 0, whole.width, whole.height
        top, bottom = (max(top, bottom - tallest), bottom) if lower else (top, min(bottom, top + tallest))
        window = page.viewport_size["width"] if page.viewport_size else whole.width  # no wider than its reader sees it
        cut = whole.crop((
            max(0, int(left - around)), max(0, int(top - around)),
            min(window, whole.width, int(right + around)), min(whole.height, int(bottom + around)),
        ))  # fmt: skip
        cut = narrower(cut) if cut.width > WINDOW["width"] else cut
        FOLDER.mkdir(exist_ok=True)
        self.path(name).write_bytes(small(cut, name))
        print(f"{self.platform}-{name}.png", cut.size, flush=True)


def narrower(picture: Image.Image) -> Image.Image:
    """Return a picture of a wide page no wider than one of a usual window."""
    width = WINDOW["width"]
    return picture.resize((width, picture.height * width // picture.width), Image.Resampling.LANCZOS)


def small(picture: Image.Image, name: str) -> bytes:
    """Return a picture as PNG of few colours, in at most LARGEST bytes."""
    for colours in COLOURS:
        made = io.BytesIO()
        picture.quantize(colours, dither=Image.Dither.NONE).save(made, "PNG", optimize=True)
        if len(made.getvalue()) <= LARGEST:
            return made.getvalue()
    raise RuntimeError(f"{name}: {len(made.getvalue())} bytes of {COLOURS[-1]} colours; cut it smaller")
