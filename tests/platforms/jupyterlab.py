"""Students' notebooks in JupyterLab, in a browser: what is shown of every cell, and what "Run All Cells" makes of it.

`software` is an environment of Python with JupyterLab, SymPy, NumPy and Playwright, and without qdot, as a student has
it; Chromium is on the path. Pictures of all notebooks are left in `software`/pictures, to be looked at.
"""

import json
import shutil
import subprocess
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from qdot.exercises.short_questions import ALL_QUESTIONS
from tests.platforms.jupyter import TOKEN, jupyter, variables
from tests.platforms.notebooks import BLANK, KEY, MISTAKEN, RIGHT, WRONG, Ours, a_class, answered
from tests.platforms.records import Counts, Record, today
from tests.support.command import run as qdot

SCRIPT = Path(__file__).with_name("jupyterlab_page.py")
SETTINGS = ".jupyter/lab/user-settings/@jupyterlab/notebook-extension/tracker.jupyterlab-settings"
"""The file of JupyterLab's settings for showing notebooks: the whole notebook at once, for the picture."""


def run(software: Path, work: Path) -> Record:
    """Open everybody's notebook, run it, save it, and grade what was saved."""
    assignment, counts = a_class(work / KEY, RIGHT, WRONG, MISTAKEN, BLANK), Counts()
    qdot("generate", assignment.folder)
    students = [one.id for one in assignment.roster]
    lab = work / "lab"
    for student in students:
        text = (assignment.folder / "released" / student / f"{KEY}.ipynb").read_text(encoding="utf-8")
        (lab / student).mkdir(parents=True)
        (lab / student / f"{KEY}.ipynb").write_text(answered(assignment, student, text), encoding="utf-8")
    notebooks = [f"{student}/{KEY}.ipynb" for student in students]
    for student, shown in zip(students, opened(software, lab, work, notebooks), strict=True):
        ours = Ours(assignment, student, lab / student / f"{KEY}.ipynb")
        hold(ours, shown, counts)
    return Record("generate", f"{version(software)}, in Chromium", today(), counts.told())


def version(software: Path) -> str:
    """Return which JupyterLab it is."""
    done = subprocess.run([software / "bin" / "jupyter-lab", "--version"], capture_output=True, text=True)
    return f"JupyterLab {done.stdout.strip()}"


def opened(software: Path, lab: Path, home: Path, notebooks: Sequence[str]) -> Any:
    """Return what is shown of each notebook below `lab`."""
    (home / SETTINGS).parent.mkdir(parents=True)
    (home / SETTINGS).write_text('{"windowingMode": "none"}')
    pictures = software / "pictures"
    pictures.mkdir(exist_ok=True)
    with jupyter(software, lab, home) as address:
        return watched(software, home, f"{address}/lab/tree/{{name}}?reset&token={TOKEN}", "", notebooks)


def watched(software: Path, home: Path, address: str, saved: str, notebooks: Sequence[str]) -> Any:
    """Return what the script of the page prints of notebooks at an address."""
    chromium = shutil.which("chromium") or "chromium"
    command: list[str | Path] = [
        software / "bin" / "python", SCRIPT, address, saved, chromium, software / "pictures", *notebooks
    ]  # fmt: skip
    done = subprocess.run(command, env=variables(software, home), capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(done.stderr[-3000:])
    return json.loads(done.stdout)


def hold(ours: Ours, shown: list[Any], counts: Counts) -> None:
    """Check what is shown of a student's notebook, and the points of the saved file."""
    cells = json.loads(ours.notebook.read_text(encoding="utf-8"))["cells"]
    counts.add("imported", len(shown) == len(cells), f"{ours.student}: {len(shown)} of {len(cells)} cells")
    titles = {
        f"{slot}-{part.name}-question": ALL_QUESTIONS[part.kind].title
        for slot, problem in ours.assignment.generate_problems(ours.student)
        for part in problem.parts
    } | {"title": ours.assignment.title}
    checks = {f"{name.replace('.', '-')}-check" for name in ours.result.parts}
    for cell, seen in zip(cells, shown, strict=False):
        where = f"{ours.student} {cell['id']}: {seen}"
        if cell["cell_type"] == "markdown":
            missing = list(_missing("".join(cell["source"]), titles.get(cell["id"], ""), seen))
            counts.add("shown", not missing, f"{missing} {where}")
            continue
        counts.add("run", not seen["errors"] and bool(cell["execution_count"]), where)
        if cell["id"] in checks and ours.student in (RIGHT, BLANK):
            said = [line for line in seen["output"].splitlines() if line.strip()]
            due = "Yes" if ours.student == RIGHT else "Not yet"
            counts.add("self-checks answer", bool(said) and all(due in line for line in said), where)
    for part in ours.result.parts.values():
        points, most = part.points or 0, part.max_points
        what = {RIGHT: "right = full", BLANK: "blank = 0"}.get(ours.student, "wrong < full")
        is_due = {RIGHT: points == most, BLANK: points == 0}.get(ours.student, points < most)
        counts.add(what, is_due, f"{ours.student} {part.name}: {points} of {most}")


def _missing(source: str, title: str, seen: Any) -> Iterator[str]:
    """Yield what is not to be seen of a cell of text: figures, formulas, tables, or what is beside the page."""
    if source.count("<img") != len(seen["images"]) or not all(seen["images"]):
        yield "figures"
    if "$" in seen["words"] or seen["broken"] or (source.count("$") >= 2) != (seen["formulas"] > 0):
        yield "formulas"
    if ("\n|" in source) != (seen["rows"] > 0):
        yield "tables"
    if seen["wide"] > 0:
        yield "beside the page"
    if title not in seen["words"]:
        yield "title"
