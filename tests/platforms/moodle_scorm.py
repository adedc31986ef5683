"""SCORM packages as activities in Moodle: students answer them in its player, and its gradebook has their scores.

`software` is the folder of an installed copy of Moodle with a running database and an address on this machine. Each run
adds a course and leaves it there.
"""

import json
import os
import shutil
import subprocess
import time
import urllib.error
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit
from zipfile import ZipFile

from qdot.exercises.exports.registry import EXPORT_FORMATS
from tests.platforms.assignments import PLAIN, make_request, write_files
from tests.platforms.moodle import call_moodle
from tests.platforms.records import Counts, Record, today

Json = dict[str, Any]

SCRIPT = Path(__file__).with_suffix(".php")
VARIANTS = 6
"""Number of variants of each problem; so many that two students get the same arms in only one of a thousand runs."""
STUDENTS = ("ada", "henri")
"""The first answers everything right; the second answers the last question wrong."""


def run(software: Path, work: Path) -> Record:
    """Export a ready-made set, add both of its packages to a course, and have two students answer them."""
    counts, packages = Counts(), work / "packages"
    files = {}
    exported_files = EXPORT_FORMATS["scorm"].export(make_request(work / PLAIN, PLAIN, VARIANTS))
    for archive in write_files(exported_files, work / "exported"):
        name = archive.stem.removeprefix(f"{PLAIN}-")
        with ZipFile(archive) as package:
            package.extractall(packages / name)
        files[name] = str(archive)
    setup = call_moodle(software, SCRIPT, packages=files, students=STUDENTS)
    for name, activity in setup["activities"].items():
        counts.add("imported", activity["units"] == 1, f"{name}: {activity}")
    with _serve_moodle(software, setup["root"]):
        visits = _run_browser(packages, setup)
    marks = call_moodle(software, SCRIPT, course=setup["course"])["marks"]
    for student, student_visits in visits.items():
        for name, visit in student_visits.items():
            who, number = f"{student}, {name}", len(visit["items"])
            counts.add("shown", number > 0 and not visit["errors"], f"{who}: {visit['errors']}")
            restored = (visit["again"]["items"], visit["again"]["places"]) == (visit["items"], visit["before"])
            counts.add("kept until the next visit", restored, f"{who}: {visit}")
            mark = float(marks.get(f"{name} {student}") or -1)
            highest = float(setup["activities"][name]["highest"])
            as_expected = mark == highest if student == STUDENTS[0] else 0 < mark < highest
            counts.add("marks in its gradebook", as_expected, f"{who}: {mark} of {highest}")
    item_lists = {tuple(visits[student][name]["items"]) for student in STUDENTS for name in files}
    counts.add("arms of one's own", len(item_lists) == len(STUDENTS), f"{item_lists}")
    return Record("scorm", f"{setup['software']}, its player in Chromium", today(), counts.freeze())


def _run_browser(packages: Path, setup: Json) -> Json:
    """Answer the packages in the students' browsers; return what moodle_scorm_page.mjs saw."""
    setup_part = {key: setup[key] for key in ("root", "students", "activities")}
    command: list[str | Path] = [shutil.which("node") or "node", SCRIPT.with_name("moodle_scorm_page.mjs")]
    text = json.dumps({"folder": str(packages), **setup_part})
    done = subprocess.run(command, input=text, capture_output=True, text=True, check=False)
    if done.returncode:
        raise RuntimeError(done.stderr[-3000:])
    visits: Json = json.loads(done.stdout)
    return visits


@contextmanager
def _serve_moodle(software: Path, root: str) -> Iterator[None]:
    """Serve Moodle at its address with PHP's own server, unless a server already answers there."""
    if _answers(root):
        yield
        return
    command = ["php", "-d", "max_input_vars=5000", "-S", urlsplit(root).netloc, "-t", str(software)]
    environment = {**os.environ, "PHP_CLI_SERVER_WORKERS": "4"}
    server = subprocess.Popen(
        command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, env=environment, start_new_session=True
    )
    try:
        for _ in range(60):
            if _answers(root):
                break
            time.sleep(0.5)
        yield
    finally:
        os.killpg(server.pid, 15)
        server.wait()


def _answers(root: str) -> bool:
    try:
        with urllib.request.urlopen(f"{root}/login/index.php", timeout=30):
            return True
    except (urllib.error.URLError, TimeoutError):
        return False
