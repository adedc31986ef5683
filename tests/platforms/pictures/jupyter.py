"""JupyterLab, click by click: a student's notebook, a quiz of jupyterquiz, and what nbgrader's formgrader shows.

`JUPYTERLAB` and `NBGRADER` are environments of Python, those of the modules jupyterlab and nbgrader beside this
package.
"""

import json
import subprocess
from pathlib import Path

from playwright.sync_api import Page  # type: ignore[import-not-found, unused-ignore]

from exercises.assignment import Assignment
from exercises.notebook import notebook_text, solution_notebook
from tests.platforms.jupyter import TOKEN, jupyter, variables
from tests.platforms.jupyterlab_page import DONE, IDLE, OPTION, SETTLED, TO_THE_TOP
from tests.platforms.notebooks import install, part_of
from tests.platforms.pictures.album import Album, browser, opened
from tests.platforms.pictures.given import ADA, HENRI, KEY, assignment, exported
from tests.support.command import run as qdot

COURSE = "kinematics"
DETERMINANT = "p1.determinant"
SETTINGS = {
    "notebook-extension/tracker": {"windowingMode": "none"},
    "apputils-extension/notification": {"fetchNews": "false", "checkForUpdates": False},
}
"""How JupyterLab shows notebooks: all of one at once, and nothing over it."""


# --- notebooks ---


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


def answered(made: Assignment, student: str, text: str, wrong: str = "") -> str:
    """Return the notebook that was handed out to a student with right answers; the part `wrong` has another sign."""
    solved = solution_notebook(made.title, made.key, student, made.problems(student), made.hints)
    answers = {part_of(cell): cell["source"] for cell in json.loads(notebook_text(solved))["cells"]}
    asked = json.loads(text)
    for cell in asked["cells"]:
        part = part_of(cell)
        if part:
            name, answer = "".join(answers[part]).split(" = ", 1)
            cell["source"] = f"{name} = -({answer.strip()})" if part == wrong else f"{name} = {answer}"
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


def quiz(software: Path, work: Path) -> None:
    """Take the picture of a quiz of jupyterquiz, one of whose wrong options was chosen."""
    lab = exported(assignment(work / KEY), "jupyterquiz", work / "lab")
    settle(work)
    with jupyter(software, lab, work) as address, browser() as chromium:
        page = opened(chromium)
        run_all(page, f"{address}/doc/tree/quizzes.ipynb?reset&token={TOKEN}")
        shown = page.locator(".jp-Notebook .Quiz").last
        options = json.loads((lab / "p2-axis-choice.json").read_text(encoding="utf-8"))[0]["answers"]
        wrong = next(option["answer"] for option in options if not option["correct"])
        shown.locator("label.MCButton").nth(shown.evaluate(OPTION, wrong)).click()
        Album("jupyterquiz").take("answered", page, shown, tallest=560, lower=True)


# --- nbgrader ---


def formgrader(software: Path, work: Path) -> None:
    """Take the pictures of the formgrader: the assignments, the gradebook, and what was marked."""
    made = assignment(work / KEY)
    course = exported(made, "nbgrader", work / "course")
    (wheel,) = course.glob("*.whl")
    install(software, wheel)
    settings, exchange = course / "nbgrader_config.py", work / "exchange"
    exchange.mkdir(mode=0o777)
    exchange.chmod(0o777)
    own = f'\nc.Exchange.root = "{exchange}"\nc.CourseDirectory.course_id = "{COURSE}"\n'
    settings.write_text(settings.read_text(encoding="utf-8") + own, encoding="utf-8")
    nbgrader(software, work, course, "generate_assignment", KEY)
    nbgrader(software, work, course, "db", "student", "import", "students.csv")
    nbgrader(software, work, course, "release_assignment", KEY)
    for student, wrong in ((ADA.id, ""), (HENRI.id, DETERMINANT)):
        file = work / student / KEY / f"{KEY}.ipynb"
        file.parent.mkdir(parents=True)
        text = (course / "handout" / student / KEY / file.name).read_text(encoding="utf-8")
        file.write_text(answered(made, student, text, wrong), encoding="utf-8")
        options = f"--Exchange.root={exchange}", f"--CourseDirectory.student_id={student}"
        nbgrader(software, work, work / student, "submit", KEY, *options)
    nbgrader(software, work, course, "collect", KEY)
    album = Album("nbgrader")
    with jupyter(software, course, work) as address, browser() as chromium:
        page = opened(chromium)
        page.goto(f"{address}/formgrader?token={TOKEN}")
        page.get_by_role("link", name=KEY, exact=True).wait_for()
        row = page.locator("tr", has=page.get_by_role("link", name=KEY, exact=True))
        row.locator(".num-submissions a").click()
        students = page.locator("table")
        for student in (ADA.id, HENRI.id):
            done_by(page, student, "autograde")
        page.reload()
        page.locator("tr", has_text=HENRI.id).wait_for()
        album.take("submissions", page, students)
        page.goto(f"{address}/formgrader/gradebook/{KEY}/{KEY}")
        page.locator("tbody tr a.name-hidden").first.wait_for()
        album.take("gradebook", page, page.locator("table"))
        page.locator("tbody tr", has_text="3.8 / 4").locator("a.name-hidden").click()
        marked = page.locator(".cell", has_text="right but for its sign")
        marked.first.wait_for()
        page.wait_for_timeout(5000)
        answer = page.locator(".cell", has_text="p1_determinant =").last
        album.take("marked", page, answer, marked.last, tallest=600)
        page.goto(f"{address}/formgrader/manage_submissions/{KEY}")
        for step in ("generate-feedback", "release-feedback"):
            done_by(page, HENRI.id, step)
        assert list((exchange / COURSE / "feedback").glob("*.html")), "no feedback in the exchange"
        page.goto((course / "feedback" / HENRI.id / KEY / f"{KEY}.html").as_uri())
        said = page.get_by_text("right but for its sign").first
        said.wait_for()
        answer = page.locator(".nbgrader_cell", has_text="p1_determinant =").last
        album.take("feedback", page, answer, said, tallest=420)


def done_by(page: Page, student: str, step: str) -> None:
    """Click a step of the formgrader's in a student's row of the submissions, and close what it says."""
    page.locator("tr", has_text=student).locator(f".{step} a").click()
    dialog = page.locator(".modal").locator("visible=true").last
    dialog.wait_for()
    assert "Success" in dialog.inner_text(), f"{step} of {student}: {dialog.inner_text()}"
    dialog.locator(".modal-footer button").last.click()
    page.locator(".modal").first.wait_for(state="hidden")


def nbgrader(software: Path, work: Path, folder: Path, *words: str) -> None:
    """Give a command of nbgrader's in the course folder, or in a student's."""
    command: list[str | Path] = [software / "bin" / "nbgrader", *words, f"--CourseDirectory.course_id={COURSE}"]
    done = subprocess.run(command, cwd=folder, env=variables(software, work), capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(f"nbgrader {words[0]}: {done.stdout[-2000:]}{done.stderr[-2000:]}")
