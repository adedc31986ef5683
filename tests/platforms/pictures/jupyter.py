"""A student's notebook in JupyterLab, whose environment of Python `JUPYTERLAB` names."""

import json
from pathlib import Path

from playwright.sync_api import Page  # type: ignore[import-not-found, unused-ignore]

from qdot.exercises.assignment.assignment import Assignment
from qdot.exercises.notebook.notebook import make_solution_notebook, write_notebook
from tests.platforms.jupyter import TOKEN, jupyter
from tests.platforms.jupyterlab_page import DONE, IDLE, SETTLED, TO_THE_TOP
from tests.platforms.notebooks import part_of
from tests.platforms.pictures.album import Album, browser, opened
from tests.platforms.pictures.given import ADA, KEY, assignment
from tests.support.command import run as qdot

SETTINGS = {
    "notebook-extension/tracker": {"windowingMode": "none"},
    "apputils-extension/notification": {"fetchNews": "false", "checkForUpdates": False},
}
"""How JupyterLab shows notebooks: all of one at once, and nothing over it."""


def notebook(software: Path, work: Path) -> None:
    """Take the pictures of a student's notebook: a question, an answer that is right, and the notebook's own check."""
    made = assignment(work / KEY)
    qdot("generate", made.folder)
    lab = work / "lab"
    lab.mkdir()
    handed_out = (made.folder / "released" / ADA.id / f"{KEY}.ipynb").read_text(encoding="utf-8")
    (lab / f"{KEY}.ipynb").write_text(answered(made, ADA.id, handed_out), encoding="utf-8")
    album = Album("jupyterlab")
    settle(work)
    with jupyter(software, lab, work) as address, browser() as chromium:
        page = opened(chromium)
        run_all(page, f"{address}/doc/tree/{KEY}.ipynb?reset&token={TOKEN}")
        cells = page.locator(".jp-Notebook .jp-Cell")
        ids = [cell["id"] for cell in json.loads((lab / f"{KEY}.ipynb").read_text(encoding="utf-8"))["cells"]]
        album.take("statement", page, cells.nth(ids.index("p1-statement")), tallest=700)
        first, last = ids.index("p1-determinant-question"), ids.index("p1-determinant-check")
        album.take("checked", page, cells.nth(first), cells.nth(last), tallest=700)


def answered(made: Assignment, student: str, text: str) -> str:
    """Return the notebook that was handed out to a student with right answers."""
    solved = make_solution_notebook(made.title, made.key, student, made.generate_problems(student), made.hints)
    answers = {part_of(cell): cell["source"] for cell in json.loads(write_notebook(solved))["cells"]}
    asked = json.loads(text)
    for cell in asked["cells"]:
        part = part_of(cell)
        if part:
            cell["source"] = answers[part]
    return json.dumps(asked, indent=1)


def settle(home: Path) -> None:
    """Write JupyterLab's settings into a home folder."""
    for name, value in SETTINGS.items():
        path = home / ".jupyter/lab/user-settings/@jupyterlab" / f"{name}.jupyterlab-settings"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps(value), encoding="utf-8")


def run_all(page: Page, address: str) -> None:
    """Open a notebook and have all of its cells run from the menu."""
    page.goto(address)
    page.wait_for_selector(IDLE)
    page.locator(".lm-MenuBar-item", has_text="Run").click()
    page.locator(".lm-Menu-item", has_text="Run All Cells").first.click()
    page.wait_for_function(DONE, polling=500)
    page.wait_for_function(SETTLED, polling=500)
    height = page.evaluate("() => document.querySelector('.jp-WindowedPanel-outer').scrollHeight")
    page.set_viewport_size({"width": 860, "height": min(16_000, height + 200)})
    page.evaluate(TO_THE_TOP)
    page.wait_for_timeout(3000)
