"""SCORM packages in Moodle: added as activities, done by students in its own player, their scores in its gradebook.

`software` is the folder of an installed copy of Moodle, whose database runs, and whose address is one of this machine.
A course is made in it for each run, and stays.
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
from tests.platforms.given import PLAIN, order
from tests.platforms.records import Counts, Record, today

Json = dict[str, Any]

HERE = Path(__file__)
VARIANTS = 6
"""The number of variants of each problem; two students get the same arms in one of a thousand runs."""
STUDENTS = ("ada", "henri")
"""One student answers everything right; the other gives one wrong answer, the last."""


def run(software: Path, work: Path) -> Record:
    """Export a set that is ready-made, add both of its packages to a course, and have two students do them."""
    counts, packages = Counts(), work / "packages"
    files = {}
    for file in EXPORT_FORMATS["scorm"].export(order(work / PLAIN, PLAIN, VARIANTS)):
        name = Path(file.path).stem.removeprefix(f"{PLAIN}-")
        archive = work / f"{name}.zip"
        archive.write_bytes(file.content if isinstance(file.content, bytes) else file.content.encode())
        with ZipFile(archive) as package:
            package.extractall(packages / name)
        files[name] = str(archive)
    made = _asked(software, packages=files, students=STUDENTS)
    for name, activity in made["activities"].items():
        counts.add("imported", activity["units"] == 1, f"{name}: {activity}")
    with _served(software, made["root"]):
        told = _done(packages, made)
    marks = _asked(software, course=made["course"])["marks"]
    for student, rounds in told.items():
        for name, found in rounds.items():
            which, number = f"{student}, {name}", len(found["items"])
            counts.add("shown", number > 0 and not found["errors"], f"{which}: {found['errors']}")
            kept = (found["again"]["items"], found["again"]["places"]) == (found["items"], found["before"])
            counts.add("kept until the next visit", kept, f"{which}: {found}")
            mark = float(marks.get(f"{name} {student}") or -1)
            highest = float(made["activities"][name]["highest"])
            right = mark == highest if student == STUDENTS[0] else 0 < mark < highest
            counts.add("marks in its gradebook", right, f"{which}: {mark} of {highest}")
    same = {tuple(told[student][name]["items"]) for student in STUDENTS for name in files}
    counts.add("arms of one's own", len(same) == len(STUDENTS), f"{same}")
    return Record("scorm", f"{made['software']}, its player in Chromium", today(), counts.told())


def _asked(software: Path, **request: object) -> Json:
    """Return what Moodle made of a request."""
    command = ["php", "-d", "max_input_vars=5000", str(HERE.with_suffix(".php"))]
    given = json.dumps({"config": str(software / "config.php"), **request})
    done = subprocess.run(command, input=given, capture_output=True, text=True, check=False)
    if done.returncode:
        raise RuntimeError(done.stderr + done.stdout[-3000:])
    answer: Json = json.loads(done.stdout[done.stdout.index("{") :])
    return answer


def _done(packages: Path, made: Json) -> Json:
    """Return what the students' browsers saw."""
    asked = {key: made[key] for key in ("root", "students", "activities")}
    command: list[str | Path] = [shutil.which("node") or "node", HERE.with_name("moodle_scorm_page.mjs")]
    given = json.dumps({"folder": str(packages), **asked})
    done = subprocess.run(command, input=given, capture_output=True, text=True, check=False)
    if done.returncode:
        raise RuntimeError(done.stderr[-3000:])
    told: Json = json.loads(done.stdout)
    return told


@contextmanager
def _served(software: Path, root: str) -> Iterator[None]:
    """Serve Moodle at its address with PHP's own server, unless it is already being served."""
    if _answers(root):
        yield
        return
    command = ["php", "-d", "max_input_vars=5000", "-S", urlsplit(root).netloc, "-t", str(software)]
    quiet = subprocess.DEVNULL
    several = {**os.environ, "PHP_CLI_SERVER_WORKERS": "4"}
    server = subprocess.Popen(command, stdout=quiet, stderr=quiet, env=several, start_new_session=True)
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
