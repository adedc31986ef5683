"""SCORM's picture: a package as a platform shows it, with a determinant of the wrong sign. The site has to be built.

`SCORM_AGAIN` is a copy of scorm-again, which is to the page what a platform is.
"""

import shutil
from pathlib import Path
from zipfile import ZipFile

from exercises.exports.bank import bank
from tests.platforms.jupyterlite import served
from tests.platforms.pictures.album import Album, browser, opened
from tests.platforms.pictures.given import KEY, assignment, exported, order

WIDE = 1180
PLATFORM = """<!DOCTYPE html><title>Platform</title><style>body {{ margin: 0 }}</style>
<script src="scorm12.min.js"></script><script>window.API = new Scorm12API({{ autocommit: false, logLevel: 5 }});
window.API.loadFromJSON({{ core: {{ student_id: "ada" }} }}, "cmi");</script>
<iframe src="package/index.html" width="1180" height="1100" style="border: 0" title="package"></iframe>"""


def run(software: Path, work: Path) -> None:
    """Answer the determinant of the first problem, with another sign."""
    made, pages = assignment(work / KEY), work / "pages"
    with ZipFile(exported(made, "scorm", work / "exported") / f"{KEY}-scorm12.zip") as package:
        package.extractall(pages / "package")
    shutil.copy(software / "dist" / "scorm12.min.js", pages)
    (pages / "index.html").write_text(PLATFORM.format(), encoding="utf-8")
    determinant = next(iter(bank(order(made)))).problem["determinant"].answer.as_typed()
    with served(pages) as address, browser() as chromium:
        page = opened(chromium, WIDE)
        page.goto(address)
        frame = page.frame_locator("iframe")
        frame.locator(".round-places button").nth(1).click()
        frame.get_by_label("Your answer").fill(f"-({determinant})")
        frame.get_by_role("button", name="Check").click()
        frame.locator(".verdict").first.wait_for()
        page.wait_for_timeout(1500)  # until it has gone to what is said
        frame.locator("body").evaluate("() => window.scrollTo({ top: 0, behavior: 'instant' })")
        Album("scorm").take("answered", page, tallest=900)
