"""`qdot serve` as a tool of Moodle (LTI 1.3): registered, linked by a teacher, and used by three students.

`software` is the folder of an installed copy of Moodle with a running database and an address on this machine; the
variable MOODLE_ADMIN holds the name and the password of its administrator, as in admin:password. Each run adds courses
and tools, and leaves them there.
"""

import datetime
import json
import os
import re
import shutil
import subprocess
import sys
import time
import urllib.error
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from qdot.exercises.assignment.assignment import Assignment, Student, load_assignment
from qdot.exercises.assignment.release import init_assignment
from qdot.exercises.writing.problem_texts import write_answer_code
from tests.platforms.moodle import call_moodle
from tests.platforms.moodle_scorm import _serve_moodle
from tests.platforms.records import Counts, Record, today
from tests.support.running_service import find_free_port
from tests.support.submitting import make_correct_notebook

Json = dict[str, Any]

SCRIPT = Path(__file__).with_suffix(".php")
STUDENTS = (Student("ada", "Ada", "ada@example.org"), Student("bo", "Bo", "bo@example.org"), Student("cy", "Cy"))
"""Ada answers in the browser, Bo uploads a notebook, and Cy, who is matched by identifier only, has an extension."""
SETTINGS = """title = "Velocity kinematics"
key = "velocity"
due = {due:%Y-%m-%dT%H:%M:%S}+00:00
late = {{per_day = 0.5}}
[[problem]]
family = "planar-2r"
questions = ["position", "jacobian", "determinant"]
points = [1, 2, 1]
"""


def run(software: Path, work: Path) -> Record:
    """Serve an assignment whose due date has passed, and have a class use it, registered dynamically and by hand."""
    counts, folder = Counts(), work / "homework"
    assignment = _make_assignment(folder)
    admin = dict(zip(("username", "password"), os.environ["MOODLE_ADMIN"].split(":", 1), strict=True))
    with _serve_class(folder) as tool:
        for is_dynamic in (True, False):
            way = "dynamic registration" if is_dynamic else "registration by hand"
            emails = {student.id: student.email or "cy2@example.org" for student in STUDENTS}
            setup = call_moodle(software, SCRIPT, action="make course", people={"grace": "grace@example.org", **emails})
            with _serve_moodle(software, setup["root"]):
                registration, number = _register(software, folder, tool, setup["root"], is_dynamic)
                request = {
                    **setup, "tool": tool, "admin": admin, "registration": registration, "number": number,
                    "config": str(software / "config.php"), "key": assignment.key,
                    "answers": _list_answers(assignment), "notebook": make_correct_notebook(assignment, "bo"),
                    "pictures": os.environ.get("QDOT_PICTURES", ""),
                }  # fmt: skip
                for check, passed, details in _run_browser(request):
                    counts.add(check, passed, f"{way}: {details}")
    return Record("serve", f"{setup['software']} in Chromium", today(), counts.freeze())


def _make_assignment(folder: Path) -> Assignment:
    init_assignment(folder, "Velocity kinematics", "velocity", STUDENTS, "0123456789abcdef")
    due = datetime.datetime.now(datetime.UTC) - datetime.timedelta(hours=2)
    (folder / "assignment.toml").write_text(SETTINGS.format(due=due), encoding="utf-8")
    return load_assignment(folder)


def _list_answers(assignment: Assignment) -> dict[str, str]:
    (slot, problem), *_ = assignment.generate_problems("ada")
    return {f"{slot}.{part.name}": write_answer_code(problem, part) for part in problem.parts}


def _register(software: Path, folder: Path, tool: str, root: str, is_dynamic: bool) -> tuple[str, int]:
    """Begin a registration; return its address, or "" and the number of the tool that was added by hand."""
    command = ("register", str(folder), "--platform", "moodle", "--site", root, "--url", tool)
    lines = _call_qdot(*command)
    addresses = dict(re.findall(rf"{re.escape(tool)}(/lti/(?:register|login|launch|keys))(\S*)", lines))
    if is_dynamic:
        return tool + "/lti/register" + addresses["/lti/register"], 0
    pasted = {
        "tool": f"{tool}/", "keys": f"{tool}/lti/keys", "redirect": f"{tool}/lti/launch",
        "login": f"{tool}/lti/login{addresses['/lti/login']}",
    }  # fmt: skip
    added = call_moodle(software, SCRIPT, action="add tool", addresses=pasted)
    _call_qdot(*command, "--client-id", added["client"])
    return "", int(added["tool"])


def _call_qdot(*arguments: str) -> str:
    command = [sys.executable, "-m", "qdot.grader.cli.main", "serve", *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


def _run_browser(request: Json) -> list[tuple[str, bool, str]]:
    """Let the people of a course work in their browsers; return the checks that moodle_lti.mjs made."""
    command: list[str | Path] = [shutil.which("node") or "node", SCRIPT.with_suffix(".mjs")]
    done = subprocess.run(command, input=json.dumps(request), capture_output=True, text=True, check=False)
    if done.returncode:
        raise RuntimeError(done.stderr[-3000:] + done.stdout[-3000:])
    checks: list[tuple[str, bool, str]] = json.loads(done.stdout)
    return checks


@contextmanager
def _serve_class(folder: Path) -> Iterator[str]:
    port = find_free_port()
    url = f"http://127.0.0.1:{port}"
    command = [sys.executable, "-m", "qdot.grader.cli.main", "serve", str(folder), "--port", str(port), "--url", url]
    with (folder / "service.log").open("w") as log:
        service = subprocess.Popen(command, stdout=log, stderr=log, start_new_session=True)
        try:
            for _ in range(240):
                if service.poll() is not None or _answers(url):
                    break
                time.sleep(0.5)
            yield url
        finally:
            os.killpg(service.pid, 15)
            service.wait()


def _answers(url: str) -> bool:
    try:
        with urllib.request.urlopen(f"{url}/lti/keys", timeout=10):
            return True
    except (urllib.error.URLError, TimeoutError):
        return False
