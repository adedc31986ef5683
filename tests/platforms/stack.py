"""STACK: Moodle imports our questions, STACK shows and marks them, and all question tests are run.

`STACK` is the folder of an installed copy of Moodle with the question type STACK, a running database, and a working
Maxima (see STACK's health check). With PostgreSQL, a text longer than its column aborts the import, which shows such
faults. Each run adds a course and leaves it there. stack.php does the work inside Moodle.
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
from tests.platforms.assignments import PLAIN, PUMA, make_request
from tests.platforms.records import Counts, Record, today

Json = dict[str, Any]

PHP = ("php", "-d", "max_input_vars=5000", str(Path(__file__).with_suffix(".php")))
LIMIT, PATIENCE = 30, 300
"""STACK's default time limit in seconds, checked here in processor time; and the limit in elapsed time that is set for
the run, because elapsed time also depends on other programs on the machine.
"""
CHECKS = {1.0: "right = full", None: "not read = not marked"}
"""The checks as which question tests are counted, by the score that they expect; all others are "wrong < full"."""


def run(software: Path, work: Path) -> Record:
    """Import the ready-made set and one with PUMA, show every question, and run all question tests."""
    paths = []
    for kind in (PLAIN, PUMA):
        (file,) = export_stack(make_request(work / kind, kind))
        paths.append(work / file.path)
        paths[-1].write_text(str(file.content), encoding="utf-8")
    with ThreadPoolExecutor() as executor:
        results = list(executor.map(partial(import_and_test, software), paths))
    counts, info, processor_times = Counts(), Json(), list[float]()
    for path, (info, *questions) in zip(paths, results, strict=True):
        if not info["import"]["done"] or info["import"]["messages"]:
            raise RuntimeError(info["import"]["messages"])
        in_time = f"within {LIMIT} s"
        _check_questions(counts, ET.parse(path).getroot(), {question["name"]: question for question in questions})
        seconds_of_tests = [float(test["processor_seconds"]) for question in questions for test in question["tests"]]
        for seconds in seconds_of_tests:
            counts.add(in_time, seconds < LIMIT, f"{seconds} s")
        processor_times += seconds_of_tests
    started = "from an image" if "optimised" in info["platform"] else "for each call"
    counts.but[in_time] = (
        f"Maxima, started {started}, used at most {max(processor_times):.1f} s of processor time per check."
    )
    name = f"Moodle {info['moodle']}, STACK {info['stack']}, {info['database']}"
    return Record("stack", name, today(), counts.freeze())


def import_and_test(software: Path, xml: Path) -> list[Json]:
    """Call stack.php with a file; return its line about the software and the import, then a line for each question."""
    request = json.dumps({"config": str(software / "config.php"), "xml": str(xml), "patience": PATIENCE})
    done = subprocess.run(PHP, input=request, capture_output=True, text=True, check=False)
    if done.returncode:
        raise RuntimeError(done.stderr + done.stdout[-3000:])
    return [json.loads(line) for line in done.stdout.splitlines() if line.startswith('{"')]


def _check_questions(counts: Counts, quiz: ET.Element, stored: dict[str, Json]) -> None:
    for question in quiz.findall("question[@type='stack']"):
        name = question.findtext("name/text", "")
        result = stored.get(name)
        counts.add("imported", result is not None, name)
        if result is None:
            continue
        points = float(question.findtext("defaultgrade", ""))
        counts.add("points as assigned", float(result["defaultmark"]) == points, f"{name} {result['defaultmark']}")
        faults = find_faults(question, result)
        counts.add("shown", not faults, f"{name} {faults}")
        counts.add("blank = 0", result["blank"] == 0, f"{name} {result['blank']}")
        tests = question.findall("qtest")
        counts.add("with all its tests", len(tests) == len(result["tests"]), name)
        for test in result["tests"]:
            check = CHECKS.get(test["expected"] and float(test["expected"]), "wrong < full")
            counts.add(check, test["passed"], f"{name} {test}")


def find_faults(question: ET.Element, result: Json) -> list[str]:
    """Return the faults in a question's page before and after an attempt."""
    page, after = result["page"], result["after"]
    faults = [f"error: {error}" for error in result["errors"]]
    faults += [f"unprocessed: {markup}" for markup in ("@@PLUGINFILE@@", "[[", "{@", "<table>") if markup in after]
    names = [file.get("name", "") for file in question.findall("questiontext/file")]
    faults += [f"no figure {name}" for name in names if name not in page]
    kind, boxes = question.findtext("input/type"), len(re.findall(r'<input[^>]*type="(?:text|radio)"', page))
    min_boxes = {"matrix": 2, "radio": 2}.get(kind or "", 1)
    faults += [f"{boxes} boxes"] if boxes < min_boxes else []
    solution = re.findall(r"<p>([^<\\]{40,})", question.findtext("generalfeedback/text", ""))
    faults += ["no solution"] if solution and solution[0].strip() not in after else []
    return faults
