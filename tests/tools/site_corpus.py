"""What the site's own tests hold it against: what Python's reader and grader say. `python -m tests.tools.site_corpus`.

corpus.json in site/tests has the checked answers of corpus.jsonl with keys, readings.json texts with their trees, and
answers to problems with their outcomes (`readers`), forms.json the texts of tests/data/forms.jsonl in the same form,
slips.json slips in right answers (`site_slips`).
"""

import json
from typing import Any

from qdot.exercises.common.files import write_atomically
from qdot.exercises.common.stream import Stream
from qdot.exercises.formula.equality import Domain, choose_default_role
from qdot.exercises.formula.parser import parse_formula
from qdot.exercises.formula.trees import ParseError, as_matrix, find_names, node_text
from qdot.exercises.site.keys import make_values_key
from qdot.exercises.site.record import make_arm_record
from qdot.grader.judging.compare_command import compare
from tests.grader.judging.test_forms import TEXTS, part_of, problem
from tests.support import ROOT
from tests.tools.fuzz import KNOWN
from tests.tools.readers import kept_question, part_json, tree_text, verdict, verdict_on
from tests.tools.site_slips import slips_text

TARGET = ROOT / "site" / "tests" / "corpus.json"
FORMS = ROOT / "site" / "tests" / "forms.json"
SLIPS = ROOT / "site" / "tests" / "slips.json"
READINGS = ROOT / "site" / "tests" / "readings.json"


def corpus_text() -> str:
    """Return the file's text, a case a line."""
    cases = [json.dumps(corpus_case(record), ensure_ascii=False) for record in records()]
    return "[\n" + ",\n".join(cases) + "\n]\n"


def records() -> list[dict[str, Any]]:
    """Return the checked answers, but for sets of angles, of which there are many in readings.json."""
    lines = (ROOT / "tests" / "data" / "corpus.jsonl").read_text(encoding="utf-8").splitlines()
    return [record for record in map(json.loads, lines) if record["type"] != "angles"]


def readings_text() -> str:
    """Return the file's text: what is asked, as site/tests/readings.ts has it, and what Python says, a case a line."""
    question = kept_question()
    asked = question.as_json()
    asked["readings"] = [[text, k, tree_text(text, KNOWN[k])] for text, k in question.readings]
    asked["answers"] = [[*answer, *verdict(*answer)] for answer in question.answers]
    lists = (f"{json.dumps(name)}: [\n{_lines(rows)}\n]" for name, rows in asked.items())
    return "{\n" + ",\n".join(lists) + "\n}\n"


def forms_text() -> str:
    """Return the file's text: the forms that people type as text, but for letters, which are clicked in a browser."""
    asked = problem()
    parts: dict[str, Any] = {}
    answers: list[list[Any]] = []
    for form in TEXTS:
        part = part_of(form)
        if part.answer.offered_options:
            continue
        name = f"{part.name} {form['right']}" if "right" in form else part.name
        parts[name] = part_json(asked, part) | {"name": name}
        answers.append([0, name, form["typed"], *verdict_on(asked, part, form["typed"], f"forms/{form['typed']!a}")])
    kept = {"id": str(asked.id), "robot": make_arm_record(asked)["robot"], "parts": list(parts.values())}
    lists: dict[str, list[Any]] = {"symbols": [], "readings": [], "problems": [kept], "answers": answers}
    return "{\n" + ",\n".join(f"{json.dumps(name)}: [\n{_lines(rows)}\n]" for name, rows in lists.items()) + "\n}\n"


def _lines(rows: list[Any]) -> str:
    return ",\n".join(json.dumps(row) for row in rows)


def corpus_case(record: dict[str, Any]) -> dict[str, Any]:
    """Return a checked answer with what the site grades it by, and the grader's outcome."""
    kind, student, reference = record["type"], record["student"], record["reference"]
    found = {
        "id": record["id"],
        "type": kind,
        "student": student,
        "outcome": compare(kind, student, reference, ()).outcome,
    }
    node = parse_formula(reference)
    rows = as_matrix(node)
    texts = [entry for row in _texts(reference) for entry in row] if kind == "matrix" else [reference]
    domain = Domain({name: choose_default_role(name) for name in sorted({*find_names(node), *_names_of(student)})})
    key = make_values_key(texts, (len(rows), len(rows[0])), domain, Stream(f"corpus/{record['id']}"))
    return {**found, "key": key}


def _names_of(student: str) -> set[str]:
    try:
        return {name for name in find_names(parse_formula(student)) if choose_default_role(name) != "signed"}
    except ParseError:
        return set()


def _texts(reference: str) -> list[list[str]]:
    return [[node_text(entry) for entry in row] for row in as_matrix(parse_formula(reference))]


if __name__ == "__main__":
    write_atomically(TARGET, corpus_text())
    write_atomically(READINGS, readings_text())
    write_atomically(FORMS, forms_text())
    write_atomically(SLIPS, slips_text())
