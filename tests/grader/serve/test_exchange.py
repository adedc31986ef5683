"""The service and `qdot grade` mark the same work the same, and a class can be taken from one to the other and back."""

import datetime
import random
import tempfile
from pathlib import Path

import pytest

from qdot.exercises.assignment.assignment import load_assignment
from qdot.exercises.writing.problem_texts import write_answer_code
from qdot.grader.reports.grades_table import make_results_jsonl
from qdot.grader.serve.class_list import load_class_assignment
from qdot.grader.serve.exchange import export_class, import_class
from qdot.grader.serve.scores import compute_results
from tests.support.serving import STUDENTS, Service, serve_class, set_clock
from tests.support.submitting import grade, make_correct_cells, write_notebook
from tests.support.suites import select_for_suite

LATE = 'due = 2027-01-10T12:00:00+00:00\nlate = {per_day = 0.1, grace = "15 min"}'
BEST = """due = 2027-01-10T12:00:00+00:00
late = {per_day = 0.3}
attempts = {best_of = 2, apart = "10 min"}
feedback = "values"
follow_through = 0.5
"""
START = datetime.datetime(2027, 1, 9, 12, tzinfo=datetime.UTC)


def submit_at_random(service: Service, rng: random.Random) -> None:
    """Let the students type answers and upload notebooks, early and late, and the staff decide some points."""
    now, assignment = START, service.assignment
    with set_clock(START):  # sessions end after two weeks
        browsers = {student.id: service.open_browser(student.id) for student in STUDENTS}
        staff = service.open_browser("staff:Grace")
    for _ in range(select_for_suite(7, 60)):
        now += datetime.timedelta(seconds=rng.choice((1, 40, 500, 3000, 9000)))
        student = rng.choice(STUDENTS[:2]).id  # the third submits nothing
        with set_clock(now):
            if rng.random() < 0.2:
                cells = make_correct_cells(service.assignment, student)
                reply = browsers[student].upload("mine.ipynb", write_notebook(assignment, student, cells).encode())
                assert reply.status_code in (202, 409), reply.content
                service.process_queue()
                continue
            slot, problem = rng.choice(assignment.generate_problems(student))
            part = rng.choice(problem.parts)
            right = "because it is stretched" if part.name == "why" else write_answer_code(problem, part)
            text = rng.choice((right, right, right.replace("+", "-"), right.replace("sin", "cos"), "theta1 +"))
            reply = browsers[student].answer(f"{slot}.{part.name}", text)
            assert reply.status_code in (200, 409), reply.content
    with set_clock(now):
        results = staff.get("/a/hw/class/results").json()
        person = service.people["s001"].pk
        decisions = [
            *({"group": group["group"], "points": 0.5, "comment": ""} for group in results["groups"][:1]),
            {"student": person, "part": "p1.jacobian", "points": 1.25, "comment": "half"},
            {"student": person, "part": "", "points": None, "comment": "well done"},
            *({**row, "points": 2, "answer": row["text"], "comment": "good"} for row in results["to_mark"]),
        ]
        for decision in decisions:
            assert staff.send("POST", "/a/hw/class/overrides", decision).status_code == 200
        if service.assignment.due_date is not None:
            due = (START + datetime.timedelta(days=1, hours=3)).isoformat()
            assert staff.send("POST", "/a/hw/class/extensions", {"student": person, "due": due}).status_code == 200


@pytest.mark.parametrize("policy", ["", LATE, BEST], ids=("last", "late", "best"))
@pytest.mark.parametrize("seed", range(select_for_suite(1, 5)))
def test_export_is_graded_the_same(policy: str, seed: int) -> None:
    def compute_lines(service: Service) -> bytes:
        assignment = load_class_assignment(service.classroom, "hw")
        return make_results_jsonl(compute_results(assignment, service.classroom))

    with tempfile.TemporaryDirectory() as name:
        out = Path(name) / "out"
        with serve_class(policy) as service:
            submit_at_random(service, random.Random(seed))
            export_class(service.classroom, "hw", out)
            lines = compute_lines(service)
        results, _ = grade(load_assignment(out))
        assert make_results_jsonl(list(results.values())) == lines
        with serve_class(policy) as service:
            roster = (service.folder / "roster.csv").read_bytes()
            for path in ("overrides.csv", "roster.csv"):
                (service.folder / path).write_bytes((out / path).read_bytes())
            try:
                assert import_class(service.classroom, "hw", out / "submitted")[0] > 0
                assert import_class(service.classroom, "hw", out / "submitted") == (0, 0)
                service.process_queue()
                assert compute_lines(service) == lines
            finally:
                (service.folder / "overrides.csv").unlink()
                (service.folder / "roster.csv").write_bytes(roster)
