"""Students' notebooks in JupyterLab, in a browser: what each cell displays, and the results of "Run All Cells".

`software` is an environment of Python with JupyterLab, SymPy, NumPy and Playwright, and without qdot, like a
student's; Chromium is on the path. Pictures of all notebooks are written to `software`/pictures for inspection.
"""

import json
import shutil
import subprocess
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from qdot.exercises.assignment.assignment import Assignment
from qdot.exercises.short_questions import question_of
from tests.platforms.jupyter import TOKEN, make_environment, serve_jupyterlab
from tests.platforms.notebooks import BLANK, KEY, RIGHT, QdotGrading, fill_in_answers, make_class_assignment
from tests.platforms.records import Counts, Record, today
from tests.support.command import run as qdot

SCRIPT = Path(__file__).with_name("jupyterlab_page.py")
SETTINGS = ".jupyter/lab/user-settings/@jupyterlab/notebook-extension/tracker.jupyterlab-settings"
"""JupyterLab's file of display settings; a notebook is rendered whole, for the picture."""


def run(software: Path, work: Path) -> Record:
    """Open each student's notebook, run it, save it, and grade the saved file."""
    assignment, counts = make_class_assignment(work / KEY), Counts()
    lab = work / "lab"
    notebooks = write_submissions(assignment, lab)
    for name, cells in zip(notebooks, run_notebooks(software, lab, work, notebooks), strict=True):
        check_notebook(QdotGrading(assignment, name.split("/")[0], lab / name), cells, counts)
    return Record("generate", f"{get_version(software)}, in Chromium", today(), counts.freeze())


def write_submissions(assignment: Assignment, folder: Path) -> list[str]:
    qdot("generate", assignment.folder)
    names = [f"{student.id}/{KEY}.ipynb" for student in assignment.roster]
    for name in names:
        text = (assignment.folder / "released" / name).read_text(encoding="utf-8")
        (folder / name).parent.mkdir(parents=True)
        (folder / name).write_text(fill_in_answers(assignment, name.split("/")[0], text), encoding="utf-8")
    return names


def get_version(software: Path) -> str:
    done = subprocess.run([software / "bin" / "jupyter-lab", "--version"], capture_output=True, text=True)
    return f"JupyterLab {done.stdout.strip()}"


def run_notebooks(software: Path, lab: Path, home: Path, notebooks: Sequence[str]) -> Any:
    """Return, for each notebook below `lab`, what the browser displays of its cells."""
    (home / SETTINGS).parent.mkdir(parents=True)
    (home / SETTINGS).write_text('{"windowingMode": "none"}')
    pictures = software / "pictures"
    pictures.mkdir(exist_ok=True)
    with serve_jupyterlab(software, lab, home) as address:
        chromium, page = shutil.which("chromium") or "chromium", f"{address}/lab/tree/{{name}}?reset&token={TOKEN}"
        command: list[str | Path] = [software / "bin" / "python", SCRIPT, page, chromium, pictures, *notebooks]
        done = subprocess.run(command, env=make_environment(software, home), capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(done.stderr[-3000:])
    return json.loads(done.stdout)


def check_notebook(grading: QdotGrading, displayed_cells: list[Any], counts: Counts) -> None:
    """Check what the browser displays of a student's notebook, and the marks of the saved notebook."""
    cells = json.loads(grading.notebook.read_text(encoding="utf-8"))["cells"]
    counts.add(
        "imported",
        len(displayed_cells) == len(cells),
        f"{grading.student}: {len(displayed_cells)} of {len(cells)} cells",
    )
    titles = {
        f"{slot}-{part.name}-question": question_of(part).make_title(problem.chain)
        for slot, problem in grading.assignment.generate_problems(grading.student)
        for part in problem.parts
    } | {"title": grading.assignment.title}
    for cell, displayed in zip(cells, displayed_cells, strict=False):
        details = f"{grading.student} {cell['id']}: {displayed}"
        if cell["cell_type"] == "markdown":
            faults = list(_find_faults("".join(cell["source"]), titles.get(cell["id"], ""), displayed))
            counts.add("shown", not faults, f"{faults} {details}")
            continue
        counts.add("run", not displayed["errors"] and bool(cell["execution_count"]), details)
        if cell["id"] == "self-check" and grading.student in (RIGHT, BLANK):
            verdicts = [line for line in displayed["output"].splitlines() if "? " in line]
            expected = "Yes" if grading.student == RIGHT else "Not yet"
            counts.add("self-checks answer", bool(verdicts) and all(expected in line for line in verdicts), details)
    for part in grading.result.parts.values():
        points, max_points = part.points or 0, part.max_points
        check = {RIGHT: "right = full", BLANK: "blank = 0"}.get(grading.student, "wrong < full")
        as_expected = {RIGHT: points == max_points, BLANK: points == 0}.get(grading.student, points < max_points)
        counts.add(check, as_expected, f"{grading.student} {part.name}: {points} of {max_points}")


def _find_faults(source: str, title: str, displayed: Any) -> Iterator[str]:
    """Yield what a text cell does not display correctly; "overflow" is content beyond the right edge of the page."""
    if source.count("<img") != len(displayed["images"]) or not all(displayed["images"]):
        yield "figures"
    if "$" in displayed["words"] or displayed["broken"] or (source.count("$") >= 2) != (displayed["formulas"] > 0):
        yield "formulas"
    if ("\n|" in source) != (displayed["rows"] > 0):
        yield "tables"
    if displayed["wide"] > 0:
        yield "overflow"
    if title not in displayed["words"]:
        yield "title"
