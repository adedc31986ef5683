"""A student's notebook in JupyterLab; the variable JUPYTERLAB has the path of its Python environment."""

import json
from pathlib import Path

from playwright.sync_api import Page  # type: ignore[import-not-found, unused-ignore]

from tests.platforms.jupyter import TOKEN, serve_jupyterlab
from tests.platforms.jupyterlab_page import DONE, IDLE, SCROLL_TO_TOP, SETTLED
from tests.platforms.notebooks import fill_in, write_right_answers
from tests.platforms.pictures.album import Album, launch_browser, open_page
from tests.platforms.pictures.homework import ADA, KEY, make_assignment
from tests.support.command import run as qdot

SETTINGS = {
    "notebook-extension/tracker": {"windowingMode": "none"},
    "apputils-extension/notification": {"fetchNews": "false", "checkForUpdates": False},
}
"""JupyterLab's settings: notebooks are rendered whole, and no notification covers them."""


def take_notebook_pictures(software: Path, work: Path) -> None:
    """Take the pictures of a student's notebook: the statement of a problem, and a question with its answer."""
    assignment = make_assignment(work / KEY)
    qdot("generate", assignment.folder)
    lab = work / "lab"
    lab.mkdir()
    released = (assignment.folder / "released" / ADA.id / f"{KEY}.ipynb").read_text(encoding="utf-8")
    (lab / f"{KEY}.ipynb").write_text(fill_in(released, write_right_answers(assignment, ADA.id)), encoding="utf-8")
    album = Album("jupyterlab")
    write_settings(work)
    with serve_jupyterlab(software, lab, work) as address, launch_browser() as chromium:
        page = open_page(chromium)
        run_all(page, f"{address}/doc/tree/{KEY}.ipynb?reset&token={TOKEN}")
        cells = page.locator(".jp-Notebook .jp-Cell")
        ids = [cell["id"] for cell in json.loads((lab / f"{KEY}.ipynb").read_text(encoding="utf-8"))["cells"]]
        album.take("statement", page, cells.nth(ids.index("p1-statement")), max_height=700)
        first, last = ids.index("p1-determinant-question"), ids.index("p1-determinant")
        album.take("checked", page, cells.nth(first), cells.nth(last), max_height=700)


def write_settings(home: Path) -> None:
    for name, value in SETTINGS.items():
        path = home / ".jupyter/lab/user-settings/@jupyterlab" / f"{name}.jupyterlab-settings"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps(value), encoding="utf-8")


def run_all(page: Page, address: str) -> None:
    page.goto(address)
    page.wait_for_selector(IDLE)
    page.locator(".lm-MenuBar-item", has_text="Run").click()
    page.locator(".lm-Menu-item", has_text="Run All Cells").first.click()
    page.wait_for_function(DONE, polling=500)
    page.wait_for_function(SETTLED, polling=500)
    height = page.evaluate("() => document.querySelector('.jp-WindowedPanel-outer').scrollHeight")
    page.set_viewport_size({"width": 860, "height": min(16_000, height + 200)})
    page.evaluate(SCROLL_TO_TOP)
    page.wait_for_timeout(3000)
