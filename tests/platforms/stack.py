"""STACK: what we export is imported by Moodle's importer, shown and marked by STACK, which runs all question tests.

`STACK` is the folder of an installed copy of Moodle with the question type STACK, whose database runs and whose Maxima
answers (STACK's health check says so). On PostgreSQL, a text that is longer
than its column ends an import. A course is made in it for each run, and stays. What PHP does of it is in stack.php.
"""

import json
import re
import subprocess
import xml.etree.ElementTree as ET
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path
from typing import Any

from qdot.exercises.exports.stack import export_stack
from tests.platforms.given import PLAIN, PUMA, order
from tests.platforms.records import Counts, Record, today

Json = dict[str, Any]

PHP = ("php", "-d", "max_input_vars=5000", str(Path(__file__).with_suffix(".php")))
LIMIT, PATIENCE = 30, 300
"""Seconds that STACK comes with as its time limit, of processor time here: STACK's clock counts what others do on the
machine, too, so that it is given so many seconds for the run.
"""
DUE = {1.0: "right = full", None: "not read = not marked"}
"""The name of the count for a question test, by its expected score. Any other score means a wrong answer."""


def run(software: Path, work: Path) -> Record:
    """Import the ready-made set and one with PUMA, show every question, and run all question tests."""
    paths = []
    for which in (PLAIN, PUMA):
        (file,) = export_stack(order(work / which, which))
        paths.append(work / file.path)
        paths[-1].write_text(str(file.content), encoding="utf-8")
    with ThreadPoolExecutor() as both:
        answers = list(both.map(partial(ask, software), paths))
    counts, about, used = Counts(), Json(), list[float]()
    for path, (about, *questions) in zip(paths, answers, strict=True):
        if not about["import"]["done"] or about["import"]["said"]:
            raise RuntimeError(about["import"]["said"])
        in_time = f"within {LIMIT} s"
        _see(counts, ET.parse(path).getroot(), {one["name"]: one for one in questions})
        spent = [float(test["used"]) for one in questions for test in one["tests"]]
        for seconds in spent:
            counts.add(in_time, seconds < LIMIT, f"{seconds} s")
        used += spent
    started = "from an image" if "optimised" in about["platform"] else "again for each check"
    counts.but[in_time] = f"Maxima, started {started}, used at most {max(used):.1f} s of processor time per check."
    name = f"Moodle {about['moodle']}, STACK {about['stack']}, {about['database']}"
    return Record("stack", name, today(), counts.told())


def ask(software: Path, xml: Path) -> list[Json]:
    """Return what was said of the import, and of each question."""
    given = json.dumps({"config": str(software / "config.php"), "xml": str(xml), "patience": PATIENCE})
    done = subprocess.run(PHP, input=given, capture_output=True, text=True, check=False)
    if done.returncode:
        raise RuntimeError(done.stderr + done.stdout[-3000:])
    return [json.loads(line) for line in done.stdout.splitlines() if line.startswith('{"')]


def _see(counts: Counts, quiz: ET.Element, stored: dict[str, Json]) -> None:
    for question in quiz.findall("question[@type='stack']"):
        name = question.findtext("name/text", "")
        one = stored.get(name)
        counts.add("imported", one is not None, name)
        if one is None:
            continue
        points = float(question.findtext("defaultgrade", ""))
        counts.add("points as assigned", float(one["defaultmark"]) == points, f"{name} {one['defaultmark']}")
        faults = faults_of(question, one)
        counts.add("shown", not faults, f"{name} {faults}")
        counts.add("blank = 0", one["blank"] == 0, f"{name} {one['blank']}")
        tests = question.findall("qtest")
        counts.add("with all its tests", len(tests) == len(one["tests"]), name)
        for test in one["tests"]:
            due = DUE.get(test["due"] and float(test["due"]), "wrong < full")
            counts.add(due, test["passed"], f"{name} {test}")


def faults_of(question: ET.Element, one: Json) -> list[str]:
    """Return what a student would not see as we wrote it, before and after an attempt."""
    page, after = one["page"], one["after"]
    faults = [f"error: {error}" for error in one["errors"]]
    faults += [f"left: {sign}" for sign in ("@@PLUGINFILE@@", "[[", "{@", "<table>") if sign in after]
    names = [file.get("name", "") for file in question.findall("questiontext/file")]
    faults += [f"no figure {name}" for name in names if name not in page]
    kind, boxes = question.findtext("input/type"), len(re.findall(r'<input[^>]*type="(?:text|radio)"', page))
    least = {"matrix": 2, "radio": 2}.get(kind or "", 1)
    faults += [f"{boxes} boxes"] if boxes < least else []
    solution = re.findall(r"<p>([^<\\]{40,})", question.findtext("generalfeedback/text", ""))
    faults += ["no solution"] if solution and solution[0].strip() not in after else []
    return faults
