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
from tests.platforms.assignments import PLAIN, PUMA, TEXTBOOK, make_request, write_files
from tests.platforms.records import Counts, Record, today
from tests.platforms.typed_answers import (
    DETERMINANTS,
    INVALID,
    POSITIONS,
    RIGHT,
    SETS,
    STACK_CHECKS,
    WRONG,
    write_numbers,
)

Json = dict[str, Any]

PHP = ("php", "-d", "max_input_vars=5000", str(Path(__file__).with_suffix(".php")))
LIMIT, PATIENCE = 30, 300
"""STACK's default time limit in seconds, checked here in processor time; and the limit in elapsed time that is set for
the run, because elapsed time also depends on other programs on the machine.
"""
CHECKS = {1.0: RIGHT, None: INVALID}
"""The checks as which question tests are counted, by the score that they expect; all others are WRONG."""


def run(software: Path, work: Path) -> Record:
    """Import three assignments, show every question, run all question tests, restore the quizzes, and type answers."""
    files = []
    for kind in (PLAIN, PUMA, TEXTBOOK):
        files.append(write_files(export_stack(make_request(work / kind, kind)), work))
    with ThreadPoolExecutor() as executor:
        results = list(executor.map(partial(import_and_test, software), *zip(*files, strict=True)))
    counts, info, processor_times = Counts(), Json(), list[float]()
    for (path, _), (info, *lines) in zip(files, results, strict=True):
        if not info["import"]["done"] or info["import"]["messages"]:
            raise RuntimeError(info["import"]["messages"])
        (restored,) = (line["quiz"] for line in lines if "quiz" in line)
        if not restored["done"] or restored["messages"]:
            raise RuntimeError(restored["messages"])
        in_time, root = f"within {LIMIT} s", ET.parse(path).getroot()
        for place in ("bank", "quiz"):
            questions = [line for line in lines if line.get("place") == place]
            _check_questions(counts, root, {question["name"]: question for question in questions})
            seconds_of_tests = [
                float(test["processor_seconds"]) for question in questions for test in question["tests"]
            ]
            for seconds in seconds_of_tests:
                counts.add(in_time, seconds < LIMIT, f"{seconds} s")
            processor_times += seconds_of_tests
        _check_slots(counts, root, restored)
        _check_typed_answers(counts, [line for line in lines if line.get("typed")])
    started = "from STACK's optimised image" if "optimised" in info["platform"] else "for each call"
    counts.but[in_time] = (
        f"Maxima, started {started}, used at most {max(processor_times):.1f} s of processor time per check."
    )
    name = f"Moodle {info['moodle']}, STACK {info['stack']}, {info['database']}"
    return Record("stack", name, today(), counts.freeze())


def import_and_test(software: Path, xml: Path, quiz: Path) -> list[Json]:
    """Call stack.php with two files; return its line about the software and the import, then those about questions."""
    answers = make_typed_answers(ET.parse(xml).getroot()) if TEXTBOOK in xml.name else {}
    typed = {name: [typed for _, typed in typed_answers] for name, typed_answers in answers.items()}
    paths = {"config": str(software / "config.php"), "xml": str(xml), "quiz": str(quiz)}
    request = json.dumps({**paths, "patience": PATIENCE, "typed": typed})
    done = subprocess.run(PHP, input=request, capture_output=True, text=True, check=False)
    if done.returncode:
        raise RuntimeError(done.stderr + done.stdout[-3000:])
    lines = [json.loads(line) for line in done.stdout.splitlines() if line.startswith('{"')]
    for line in lines:
        checks = [check for check, _ in answers.get(line.get("name", ""), ())]
        for result, check in zip(line.get("typed", ()), checks, strict=False):
            result["check"] = check
    return lines


def make_typed_answers(quiz: ET.Element) -> dict[str, list[tuple[str, str | list[list[str]]]]]:
    """Return answers to TEXTBOOK's questions, by the name of the question, each with its check."""
    answers: dict[str, list[tuple[str, str | list[list[str]]]]] = {}
    for question in quiz.findall("question[@type='stack']"):
        name = question.findtext("name/text", "")
        if ", position:" in name:
            answers[name] = [(check, [[entry] for entry in entries]) for check, entries in POSITIONS]
        elif ", determinant:" in name:
            answers[name] = list(DETERMINANTS)
        elif ", singular-angles:" in name:
            answers[name] = list(SETS)
        elif ", speed:" in name:
            (value,) = re.findall(r"^ta1: (.*);$", question.findtext("questionvariables/text", ""), re.MULTILINE)
            answers[name] = [
                (STACK_CHECKS.get(form, RIGHT), text) for form, text in write_numbers(float(value)).items()
            ]
    return answers


def _check_typed_answers(counts: Counts, questions: list[Json]) -> None:
    for question in questions:
        for result in question["typed"]:
            check, score = result["check"], result["score"]
            if check == INVALID:
                as_expected = score is None and result["status"] == "invalid" and bool(result["errors"])
            else:
                as_expected = score is not None and (float(score) == 1) == (check == RIGHT)
            counts.add(f"typed: {check}", as_expected, f"{question['name']} {result}")


def _check_slots(counts: Counts, bank: ET.Element, quiz: Json) -> None:
    paths = [text.text or "" for text in bank.findall("question[@type='category']/category/text")]
    same = [slot["category"] for slot in quiz["slots"]] == [path.rsplit("/", 1)[-1] for path in paths]
    counts.add("slots of the quiz", same, f"{quiz['slots']} for {paths}")


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
        counts.add("with all its tests", len(tests) == result["test_count"], name)
        for test in result["tests"]:
            check = CHECKS.get(test["expected"] and float(test["expected"]), WRONG)
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
