"""Paper's pictures: the first page of an exam and of its marking sheet, by Poppler. They need the extra pdf."""

import io
import subprocess
from pathlib import Path

from PIL import Image

from tests.platforms.pictures.album import Album, small
from tests.platforms.pictures.given import KEY, assignment
from tests.support.command import run as qdot

SHARPNESS = 100
"""Dots per inch."""
TALLEST = {"exam": 900, "marking": 620}
"""Pixels of each picture, from the top of the page."""


def run(_: Path, work: Path) -> None:
    """Take both pictures of version A."""
    album, folder = Album("paper"), assignment(work / KEY).folder
    for sheet, tallest in TALLEST.items():
        qdot("export", folder, "--to", "pdf", "--sheet", sheet, "--versions", "1", "--out", work / sheet)
        (made,) = (work / sheet).rglob("A.pdf")
        command = ["pdftoppm", "-png", "-r", str(SHARPNESS), "-f", "1", "-l", "1", str(made)]
        page = Image.open(io.BytesIO(subprocess.run(command, capture_output=True, check=True).stdout)).convert("RGB")
        cut = page.crop((0, 0, page.width, min(page.height, tallest)))
        album.path(sheet).write_bytes(small(cut, sheet))
        print(f"paper-{sheet}.png", cut.size, flush=True)
