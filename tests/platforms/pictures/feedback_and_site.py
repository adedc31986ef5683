"""The README's pictures: a student's feedback page, and the practice site. They need no other program."""

import functools
import http.server
import json
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from qdot.exercises.assignment.assignment import Student, load_assignment
from qdot.exercises.assignment.release import init_assignment
from qdot.exercises.problem.problem import name_answer_variable
from qdot.grader.grading.batch import grade_class
from qdot.grader.reports.graded_folder import write_page
from qdot.grader.sandbox.sandbox import Limits
from qdot.grader.submissions.submission import find_submissions
from tests.platforms.pictures.album import Album, launch_browser, open_page
from tests.support.command import run as qdot
from tests.support.submitting import code_cell, write_notebook

TOML = """title = "Velocity kinematics"
key = "velocity"
[[problem]]
family = "planar-2r"
variation = "chapter"
questions = ["position", "jacobian"]
"""
WIDE = 1180


def take_pictures(_: Path, work: Path) -> None:
    album = Album("qdot")
    with launch_browser() as chromium:
        page = open_page(chromium)
        page.goto(_write_feedback(work / "class").as_uri())
        album.take("feedback", page, page.locator("article.part").last, max_height=760)
        with _serve_site(work / "site") as address:
            page = open_page(chromium, WIDE)
            page.goto(f"{address}/practice.html")
            page.wait_for_selector("canvas")
            page.wait_for_timeout(3000)
            album.take("site", page, max_height=640)


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
