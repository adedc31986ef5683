"""Otter, click by click: a student's notebook in JupyterLab with Otter's own check, and what `otter run` gives for it.

`OTTER` is an environment of Python with otter-grader and JupyterLab, into which the exported qdot is installed.
"""

import json
import shutil
from pathlib import Path

from nbformat.v4 import new_code_cell, new_markdown_cell, new_notebook

from exercises.notebook import KERNEL, notebook_text
from tests.platforms.jupyter import TOKEN, jupyter
from tests.platforms.notebooks import install, part_of
from tests.platforms.otter import call
from tests.platforms.pictures.album import Album, browser, opened
from tests.platforms.pictures.given import ADA, HENRI, KEY, assignment, exported
from tests.platforms.pictures.jupyter import DETERMINANT, answered, run_all, settle

CHECKED = "p1-determinant"
TOLD = """import json
for test in json.load(open("results.json"))["tests"]:
    if "max_score" in test and test.get("output"):
        print(test["name"], test["score"], "of", test["max_score"])
        print(test["output"])"""
"""Prints what Gradescope shows of the questions."""


def notebook(software: Path, work: Path) -> None:
    """Take the pictures of Ada's notebook, in which an answer is checked, and of the marks that Henri's gets."""
    made = assignment(work / KEY)
    folder = exported(made, "otter", work / "lab")
    (wheel,) = folder.glob("*.whl")
    install(software, wheel)
    call(software, folder, "assign", f"{KEY}.ipynb", "dist")
    for student, wrong in ((ADA.id, ""), (HENRI.id, DETERMINANT)):
        path = folder / "students" / student / f"{KEY}.ipynb"
        path.write_text(answered(made, student, path.read_text(encoding="utf-8"), wrong), encoding="utf-8")
    ids = checked(folder / "students" / ADA.id / f"{KEY}.ipynb")
    (folder / "marks.ipynb").write_text(marking(folder), encoding="utf-8")
    album = Album("otter")
    settle(work)
    with jupyter(software, folder, work) as address, browser() as chromium:
        page = opened(chromium)
        run_all(page, f"{address}/doc/tree/students/{ADA.id}/{KEY}.ipynb?reset&token={TOKEN}")
        cells = page.locator(".jp-Notebook .jp-Cell")
        check = cells.nth(ids.index("otter-check"))
        check.get_by_text("passed").first.wait_for()
        album.take("checked", page, cells.nth(ids.index(f"{CHECKED}-question")), check, tallest=700)
        page = opened(chromium)
        run_all(page, f"{address}/doc/tree/marks.ipynb?reset&token={TOKEN}")
        page.get_by_text("right but for its sign").first.wait_for()
        cells = page.locator(".jp-Notebook .jp-Cell")
        album.take("marked", page, cells.nth(1), around=-2)  # the frame of the next cell is close below


def checked(path: Path) -> list[str]:
    """Have Otter look at an answer of a student's notebook; return the ids of its cells."""
    content = json.loads(path.read_text(encoding="utf-8"))
    cells = content["cells"]
    start = new_code_cell(f'import otter\n\ngrader = otter.Notebook("{KEY}.ipynb")', id="otter-start")
    answer = next(index for index, cell in enumerate(cells) if part_of(cell) == DETERMINANT)
    cells.insert(answer + 1, new_code_cell(f'grader.check("{CHECKED}")', id="otter-check"))
    cells.insert(answer, start)
    path.write_text(json.dumps(content, indent=1), encoding="utf-8")
    return [cell["id"] for cell in cells]


def marking(folder: Path) -> str:
    """Return a notebook of the staff's that marks Henri's by the autograder."""
    (autograder,) = (folder / "dist" / "autograder").glob("*.zip")
    shutil.copy(autograder, folder / "autograder.zip")  # a name without the time fits into the picture
    command = f"!otter run -a autograder.zip students/{HENRI.id}/{KEY}.ipynb"
    cells = [
        new_markdown_cell(f"A notebook of {HENRI.name}'s", id="title"),
        new_code_cell(command, id="run"),
        new_code_cell(TOLD, id="told"),
    ]
    return notebook_text(new_notebook(metadata={"kernelspec": KERNEL}, cells=cells))
