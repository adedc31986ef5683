"""The README's pictures of a student's feedback page and of the site: `python -m tests.platforms.pictures`.

It needs Chromium, and Playwright and Pillow in qdot's environment. All other pictures of docs/ were taken by hand.
"""

import functools
import http.server
import io
import json
import shutil
import tempfile
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from PIL import Image
from playwright.sync_api import Browser, Locator, Page, sync_playwright  # type: ignore[import-not-found, unused-ignore]

from qdot.exercises.assignment.assignment import Student, load_assignment
from qdot.exercises.assignment.release import init_assignment
from qdot.exercises.problem.problem import name_answer_variable
from qdot.grader.grading.batch import grade_class
from qdot.grader.reports.graded_folder import write_page
from qdot.grader.sandbox.sandbox import Limits
from qdot.grader.submissions.submission import find_submissions
from tests.support import ROOT
from tests.support.command import run as qdot
from tests.support.submitting import code_cell, write_notebook

TOML = """title = "Velocity kinematics"
key = "velocity"
[[problem]]
family = "planar-2r"
variation = "chapter"
questions = ["position", "jacobian"]
"""
WINDOW, WIDE = {"width": 860, "height": 900}, 1180
COLOURS = (256, 128, 64, 32)
MAX_BYTES = 60_000
"""Size of a picture; a larger one gets fewer colours."""
MARGIN = 8
"""Pixels around the cropped part."""


def main(work: Path) -> None:
    with sync_playwright() as playwright:
        program = shutil.which("chromium") or "chromium"
        chromium = playwright.chromium.launch(executable_path=program, args=["--no-sandbox"])
        page = _open_page(chromium, _write_feedback(work / "class").as_uri())
        _take_picture("feedback", page, page.locator("article.part").last, max_height=760)
        with _serve_site(work / "site") as address:
            page = _open_page(chromium, f"{address}/practice.html", WIDE)
            page.wait_for_selector("canvas")
            page.wait_for_timeout(3000)
            _take_picture("site", page, max_height=640)
        chromium.close()


def _open_page(chromium: Browser, address: str, width: int = WINDOW["width"]) -> Page:
    """Open a page with separate cookies, in light colours."""
    page = chromium.new_context(viewport={**WINDOW, "width": width}, color_scheme="light").new_page()
    page.goto(address)
    return page


def _take_picture(name: str, page: Page, part: Locator | None = None, *, max_height: int) -> None:
    """Store a picture of a part of a page, or of the whole page; its bottom is cut off at `max_height` pixels."""
    page.mouse.move(0, 0)
    page.evaluate("() => window.scrollTo(0, 0)")  # otherwise fixed elements would cover the page
    page.wait_for_timeout(700)
    raw = page.screenshot(full_page=True, animations="disabled", caret="hide")
    whole = Image.open(io.BytesIO(raw)).convert("RGB")
    box: Any = part.bounding_box() if part else {"x": 0, "y": 0, "width": whole.width, "height": whole.height}
    assert box, f"{name}: the part is not visible"
    window_width = page.viewport_size["width"] if page.viewport_size else whole.width  # not wider than the window
    picture = whole.crop((
        max(0, int(box["x"] - MARGIN)), max(0, int(box["y"] - MARGIN)),
        min(window_width, whole.width, int(box["x"] + box["width"] + MARGIN)),
        min(whole.height, int(box["y"] + min(box["height"], max_height) + MARGIN)),
    ))  # fmt: skip
    if picture.width > WINDOW["width"]:
        size = (WINDOW["width"], picture.height * WINDOW["width"] // picture.width)
        picture = picture.resize(size, Image.Resampling.LANCZOS)
    (ROOT / "docs" / "pictures" / f"qdot-{name}.png").write_bytes(_compress(picture, name))


def _compress(picture: Image.Image, name: str) -> bytes:
    """Return a picture as a PNG of at most MAX_BYTES, with as many of COLOURS as possible."""
    for colours in COLOURS:
        png = io.BytesIO()
        picture.quantize(colours, dither=Image.Dither.NONE).save(png, "PNG", optimize=True)
        if len(png.getvalue()) <= MAX_BYTES:
            return png.getvalue()
    raise RuntimeError(f"{name}: {len(png.getvalue())} bytes with {COLOURS[-1]} colours; crop it further")


def _write_feedback(folder: Path) -> Path:
    """Return the feedback page of a student whose Jacobian has θ2 instead of θ1 + θ2 for link 2."""
    init_assignment(folder, "", "velocity", [Student("s001", "Ada Example")], secret="0123456789abcdef")
    (folder / "assignment.toml").write_text(TOML, encoding="utf-8")
    assignment = load_assignment(folder)
    ((slot, problem),) = assignment.generate_problems("s001")
    names = list(problem.symbols)
    cells = [code_cell(f"from sympy import *\n{', '.join(names)} = symbols({' '.join(names)!r})")]
    for part in problem.parts:
        right = part.answer.write_code()
        wrong = right.replace("theta1 + theta2", "theta2") if part.name == "jacobian" else right
        cells.append(code_cell(f"{name_answer_variable(slot, part.name)} = {wrong}", f"{slot}.{part.name}"))
    submitted = folder / "submitted" / "s001" / "velocity.ipynb"
    submitted.parent.mkdir(parents=True)
    content = json.loads(write_notebook(assignment, "s001", cells))
    content["metadata"]["qdot"]["assignment"] = "velocity"
    submitted.write_text(json.dumps(content), encoding="utf-8")
    submissions = find_submissions(assignment, folder / "submitted").by_student
    (result,) = grade_class(assignment, submissions, 0, Limits(), lambda _: None)
    write_page(assignment, assignment.roster[0], result)
    return folder / "graded" / "feedback" / "s001.html"


@contextmanager
def _serve_site(folder: Path) -> Iterator[str]:
    """Build a site with one family, and yield the address where it is served."""
    qdot("site", "build", "--families", "elbow-3r", "--variants", "1", "--out", folder, "--jobs", "1")
    handler = functools.partial(_QuietHandler, directory=str(folder))
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}"
        server.shutdown()


class _QuietHandler(http.server.SimpleHTTPRequestHandler):
    def log_message(self, format: str, *args: object) -> None:
        pass


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        main(Path(folder))
