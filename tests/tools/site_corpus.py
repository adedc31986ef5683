"""Write Python's results for the site's own tests: `python -m tests.tools.site_corpus`.

The files in site/tests contain:

- corpus.json: the checked answers of corpus.jsonl with keys
- readings.json: texts with trees, and answers with outcomes (`readers`)
- forms.json: the texts of tests/data/forms.jsonl in the same form
- slips.json: mistakes in right answers; only the keys of their parts are updated
- notebook.json: a student's notebook, and which of all these answers `qdot check` can read
"""

import json
import re
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from qdot.exercises.common.files import write_atomically
from qdot.exercises.common.stream import Stream
from qdot.exercises.formula.equality import Domain, choose_default_role
from qdot.exercises.formula.parser import parse_formula
from qdot.exercises.formula.trees import ParseError, as_matrix, find_names, format_tree
from qdot.exercises.generation import generate
from qdot.exercises.notebook.notebook import NotebookContent, make_notebook_metadata, make_student_notebook
from qdot.exercises.site.keys import make_key, make_values_key
from qdot.exercises.site.record import MistakeSentences, make_arm_record
from qdot.grader.grading.check import find_claimed_form, is_readable
from qdot.grader.judging.compare_command import compare
from tests.grader.judging.test_forms import TEXTS, part_of, problem
from tests.support import ROOT
from tests.tools.fuzz import SYMBOL_SETS
from tests.tools.readers import judge_answer, judge_part, list_problems, make_part_record, make_stored_query, write_tree

TARGET = ROOT / "site" / "tests" / "corpus.json"
FORMS = ROOT / "site" / "tests" / "forms.json"
SLIPS = ROOT / "site" / "tests" / "slips.json"
READINGS = ROOT / "site" / "tests" / "readings.json"
NOTEBOOK = ROOT / "site" / "tests" / "notebook.json"
NOTEBOOK_PARTS = ("position", "jacobian", "determinant", "joint-effect", "joint-rates", "singular-angles")


def make_corpus_text() -> str:
    cases = [json.dumps(make_corpus_case(record), ensure_ascii=False) for record in load_corpus_records()]
    return "[\n" + ",\n".join(cases) + "\n]\n"


def load_corpus_records() -> list[dict[str, Any]]:
    """Return the checked answers without sets of angles, because readings.json has many of these."""
    lines = (ROOT / "tests" / "data" / "corpus.jsonl").read_text(encoding="utf-8").splitlines()
    return [record for record in map(json.loads, lines) if record["type"] != "angles"]


def make_readings_text() -> str:
    """Return the file's text: the query in the form of site/tests/readings.ts, with Python's results.

    Each case is on a line.
    """
    query = make_stored_query()
    content = query.as_json()
    content["readings"] = [[text, k, write_tree(text, SYMBOL_SETS[k])] for text, k in query.readings]
    content["answers"] = [[*answer, *judge_answer(*answer)] for answer in query.answers]
    return _write_lists(content)


def make_forms_text() -> str:
    """Return the file's text: the typed forms, without letters, because a browser has buttons for these."""
    chapter_problem = problem()
    parts: dict[str, Any] = {}
    answers: list[list[Any]] = []
    for record in TEXTS:
        part, text = part_of(record), record["typed"]
        if part.answer.offered_options:
            continue
        name = f"{part.name} {record['right']}" if "right" in record else part.name
        parts[name] = make_part_record(chapter_problem, part) | {"name": name}
        answers.append([0, name, text, *judge_part(chapter_problem, part, text, f"forms/{text!a}")])
    robot = make_arm_record(chapter_problem)["robot"]
    problem_record = {"id": str(chapter_problem.id), "robot": robot, "parts": list(parts.values())}
    lists: dict[str, list[Any]] = {"symbols": [], "readings": [], "problems": [problem_record], "answers": answers}
    return _write_lists(lists)


def make_slips_text() -> str:
    """Return the file's text: mistakes in right answers, singly and in pairs, with updated keys, a problem per line."""
    cases = map(_renew_keys, json.loads(SLIPS.read_text(encoding="utf-8")))
    return "[\n" + ",\n".join(map(json.dumps, cases)) + "\n]\n"


def _renew_keys(record: dict[str, Any]) -> dict[str, Any]:
    stored_problem, sentences, parts = generate(record["id"]), MistakeSentences(), []
    for stored_part in record["parts"]:
        part = stored_problem[stored_part["name"]]
        key = sentences.shorten_key(make_key(stored_problem, part))
        parts.append(make_part_record(stored_problem, part) | {"key": key})
    return record | {"robot": make_arm_record(stored_problem)["robot"], "parts": parts, "said": sentences.rows}


def make_notebook_text() -> str:
    """Return the file's text: {"notebook", "metadata", "answers": [[part, text, whether `qdot check` can read it]]}."""
    chapter_problem = problem()
    few_parts = replace(chapter_problem, parts=tuple(chapter_problem[name] for name in NOTEBOOK_PARTS))
    notebook = make_student_notebook(NotebookContent("Week 3", "velocity", "501", [("p1", few_parts)]))
    for cell in notebook.cells:
        cell.source = re.sub("<img [^>]*>", "", cell.source)
    slots = [(f"p{number}", item) for number, item in enumerate((chapter_problem, *list_problems()), 1)]
    metadata = json.loads(json.dumps(make_notebook_metadata("student", "velocity", "501", slots)))
    typed_answers = [("p1", part_of(record).name, record["typed"]) for record in TEXTS]
    typed_answers += [(f"p{k + 2}", name, text) for k, name, text in make_stored_query().answers]
    answers = [[f"{slot}.{name}", text, check_answer(metadata, slot, name, text)] for slot, name, text in typed_answers]
    content = {"notebook": notebook, "metadata": metadata}
    head = ",\n".join(f"{json.dumps(name)}: {json.dumps(value)}" for name, value in content.items())
    return f'{{\n{head},\n"answers": [\n{_write_lines(answers)}\n]\n}}\n'


def check_answer(metadata: Mapping[str, object], slot: str, part: str, text: str) -> bool:
    """Return whether `qdot check` can read a text as the answer to a part of a notebook with these metadata."""
    answer_form = find_claimed_form(metadata, slot, part)
    assert answer_form is not None
    return is_readable(text, answer_form)


def _write_lists(content: Mapping[str, list[Any]]) -> str:
    lists = (f"{json.dumps(name)}: [\n{_write_lines(rows)}\n]" for name, rows in content.items())
    return "{\n" + ",\n".join(lists) + "\n}\n"


def _write_lines(rows: list[Any]) -> str:
    return ",\n".join(json.dumps(row) for row in rows)


def make_corpus_case(record: dict[str, Any]) -> dict[str, Any]:
    """Return a checked answer with the site's key for it, and the grader's outcome."""
    answer_type, student, reference = record["type"], record["student"], record["reference"]
    outcome = compare(answer_type, student, reference, ()).outcome
    tree = parse_formula(reference)
    rows = as_matrix(tree)
    texts = [format_tree(entry) for row in rows for entry in row] if answer_type == "matrix" else [reference]
    names = sorted({*find_names(tree), *_find_answer_names(student)})
    domain = Domain({name: choose_default_role(name) for name in names})
    key = make_values_key(texts, (len(rows), len(rows[0])), domain, Stream(f"corpus/{record['id']}"))
    return {"id": record["id"], "type": answer_type, "student": student, "outcome": outcome, "key": key}


def _find_answer_names(student: str) -> set[str]:
    try:
        return {name for name in find_names(parse_formula(student)) if choose_default_role(name) != "signed"}
    except ParseError:
        return set()


if __name__ == "__main__":
    write_atomically(TARGET, make_corpus_text())
    write_atomically(READINGS, make_readings_text())
    write_atomically(FORMS, make_forms_text())
    write_atomically(SLIPS, make_slips_text())
    write_atomically(NOTEBOOK, make_notebook_text())
