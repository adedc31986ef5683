"""Quizzes by jupyterquiz, displayed in JupyterLab in a browser, each answered right and wrong there.

`software` is the environment of tests.platforms.jupyterlab, with jupyterquiz.
"""

import json
import re
import subprocess
from html import unescape
from pathlib import Path
from typing import Any

from qdot.exercises.exports.registry import EXPORT_FORMATS
from tests.platforms.given import EVERYTHING, order
from tests.platforms.jupyterlab import opened, version
from tests.platforms.records import Counts, Record, today

NOTEBOOK = "quizzes.ipynb"
COUNTED = re.compile(r"\s*\[\d+/\d+\]\s*$")
PACKAGE = "import importlib.metadata; print(importlib.metadata.version('jupyterquiz'))"


def run(software: Path, work: Path) -> Record:
    """Export every question, run the notebook that shows them, and answer each."""
    counts, lab = Counts(), work / "lab"
    lab.mkdir()
    for file in EXPORT_FORMATS["jupyterquiz"].files(order(work / EVERYTHING, EVERYTHING, 1)):
        (lab / file.path).write_text(str(file.content), encoding="utf-8")
    cells = json.loads((lab / NOTEBOOK).read_text(encoding="utf-8"))["cells"]
    names = [cell["id"].removesuffix("-quiz") for cell in cells if cell["cell_type"] == "code"]
    questions = [json.loads((lab / f"{name}.json").read_text(encoding="utf-8"))[0] for name in names]
    ((shown, told),) = opened(software, lab, work, {NOTEBOOK: [_answers(one) for one in questions]})
    seen = [each for cell, each in zip(cells, shown, strict=True) if cell["cell_type"] == "code"]
    for name, question, cell, said in zip(names, questions, seen, told, strict=True):
        counts.add("imported", bool(cell["output"].strip()) and not cell["errors"], f"{name}: {cell}")
        due = question["question"].count("<math"), question["question"].count("<img")
        there = cell["maths"] >= due[0], len(cell["images"]) >= due[1], all(cell["images"]), "<" not in cell["output"]
        counts.add("shown", all(there), f"{name}: {there}")
        for answer, (verdict, feedback) in zip(_answers(question), said, strict=True):
            what = "right = full" if answer["correct"] else "wrong < full"
            is_due = verdict == ("correct" if answer["correct"] else "incorrect")
            counts.add(what, is_due, f"{name} {answer}: {verdict}")
            counts.add("feedback as ours", _same(feedback, answer["feedback"]), f"{name} {answer}: {feedback}")
    done = subprocess.run([software / "bin" / "python", "-c", PACKAGE], capture_output=True, text=True)
    name = f"jupyterquiz {done.stdout.strip()} in {version(software)}"
    return Record("jupyterquiz", name, today(), counts.told())


def _answers(question: Any) -> list[Any]:
    """Return what is answered to a question, and what is due: all options, or each known number and another."""
    if question["type"] != "numeric":
        return [{**answer, "chosen": answer["answer"]} for answer in question["answers"]]
    *known, other = question["answers"]
    numbers = [(answer, answer["value"] if "value" in answer else sum(answer["range"]) / 2) for answer in known]
    biggest = max(abs(number) for _, number in numbers)
    return [
        *({**answer, "typed": f"{number:.10g}"} for answer, number in numbers),
        {**other, "correct": False, "typed": f"{1000 * (1 + biggest):.10g}"},
    ]


def _same(shown: str, ours: str) -> bool:
    """Return whether feedback is ours; where several options are right, how many were found stands behind it."""
    return "".join(COUNTED.sub("", shown).split()) == "".join(unescape(ours).split())
