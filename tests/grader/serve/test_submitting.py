"""What students submit is stored once, judged by the settings of the assignment, and never lost."""

import datetime
import uuid
from unittest.mock import patch

import pytest
from django.utils import timezone
from django_tasks_db.models import DBTaskResult

from qdot.exercises.writing.problem_texts import write_answer_code
from qdot.grader.grading.result import NotebookMarks
from qdot.grader.serve import scores
from qdot.grader.serve.marking_online import MAX_FAILURES, queue_unmarked
from qdot.grader.serve.models import Submission
from qdot.grader.serve.server import reclaim_tasks
from tests.support.serving import NOTEBOOK, Service, serve_class, set_clock
from tests.support.submitting import make_correct_cells, write_notebook


def read_marks(submission: Submission) -> NotebookMarks:
    return scores.load_marks([submission.pk])[submission.pk]


NOW = datetime.datetime(2027, 1, 9, 12, tzinfo=datetime.UTC)


def find_right_answer(service: Service, student: str, part: str) -> str:
    slot, _, name = part.partition(".")
    problem = dict(service.assignment.generate_problems(student))[slot]
    return write_answer_code(problem, problem[name])


def test_verdict_comes_at_once_and_only_the_problem_of_the_answer_is_marked(service: Service) -> None:
    browser = service.open_browser("s001")
    wrong_position = find_right_answer(service, "s001", "p1.position").replace("theta1 + theta2", "theta2")
    reply = browser.answer("p1.position", wrong_position).json()
    shown = reply["results"]["p1.position"]
    assert shown["outcome"] == "partial"
    assert "angles of the parallel joints" in shown["sentences"][0]
    assert shown["counterexample"] and "expected" not in str(shown)
    assert set(reply["results"]) == {"p1.position", "p1.jacobian", "p1.determinant", "p1.why"}
    reply = browser.answer("p2.determinant", find_right_answer(service, "s001", "p2.determinant")).json()
    assert reply["results"]["p2.determinant"]["points"] == reply["results"]["p2.determinant"]["max_points"]
    first, second = (read_marks(row).problems[0] for row in Submission.objects.order_by("pk"))
    assert first == second
    work = browser.get("/a/hw/work").json()
    assert work["answers"] == {
        "p1.position": wrong_position, "p2.determinant": find_right_answer(service, "s001", "p2.determinant"),
    }  # fmt: skip
    assert work["results"]["p1.position"]["sentences"] == shown["sentences"]


def test_the_same_request_is_stored_once(service: Service) -> None:
    browser, request = service.open_browser("s001"), str(uuid.uuid4())
    replies = [browser.answer("p1.position", "theta1", request).json() for _ in range(3)]
    assert replies[0] == replies[1] == replies[2]
    assert service.open_browser("s002").answer("p1.position", "theta1", request).status_code == 200
    assert Submission.objects.count() == 2
    request = str(uuid.uuid4())
    for _ in range(2):
        assert browser.upload("a.ipynb", NOTEBOOK, request).status_code == 202
    assert DBTaskResult.objects.count() == 1


def test_drafts_stay_until_the_answer_is_submitted(service: Service) -> None:
    browser = service.open_browser("s001")
    for text in ("the", "theta1"):
        assert browser.send("PUT", "/a/hw/drafts", {"part": "p1.position", "text": text}).status_code == 200
    assert browser.get("/a/hw/work").json()["drafts"] == {"p1.position": "theta1"}
    assert service.open_browser("s002").get("/a/hw/work").json()["drafts"] == {}
    browser.answer("p1.position", "theta1")
    assert browser.get("/a/hw/work").json()["drafts"] == {}


def test_attempts_and_due_dates_are_those_of_the_assignment() -> None:
    settings = """due = 2027-01-09T13:00:00+00:00
late = {per_day = 0.1, until = 2027-01-12T13:00:00+00:00}
attempts = {best_of = 2, apart = "1 h"}
"""
    with serve_class(settings) as service:
        right = find_right_answer(service, "s001", "p2.determinant")
        with set_clock(NOW):
            browser, other = service.open_browser("s001"), service.open_browser("s002")
            assert browser.get("/a/hw/work").json()["attempts"]["left"] == 2
            assert browser.answer("p2.determinant", "1").json()["attempts"]["left"] == 1
        with set_clock(NOW + datetime.timedelta(hours=3)):  # the second attempt, late
            reply = browser.answer("p2.determinant", right).json()
            assert reply["is_late"], reply
            assert reply["score"] == pytest.approx(0.9 * 1)
        with set_clock(NOW + datetime.timedelta(hours=6)):
            reply = browser.answer("p2.determinant", "1")
            assert (reply.status_code, reply.json()["error"][:8]) == (409, "You have")
            assert browser.get("/a/hw/work").json()["closed"]
        with set_clock(NOW + datetime.timedelta(days=4)):
            assert other.answer("p2.determinant", "1").status_code == 409
            staff = service.open_browser("staff:Grace")
            due = (NOW + datetime.timedelta(days=5)).isoformat()
            content = {"student": service.people["s002"].pk, "due": due}
            assert staff.send("POST", "/a/hw/class/extensions", content).status_code == 200
            assert other.answer("p2.determinant", "1").json()["is_late"] is False


def test_a_notebook_is_graded_from_the_queue_and_its_answers_are_the_basis_of_typed_ones(service: Service) -> None:
    browser = service.open_browser("s001")
    cells = make_correct_cells(service.assignment, "s001")
    reply = browser.upload("mine.ipynb", write_notebook(service.assignment, "s001", cells).encode())
    assert (reply.status_code, reply.json()["place"]) == (202, 0)
    number = reply.json()["submission"]
    assert browser.get(f"/a/hw/submissions/{number}").json()["state"] == "waiting"
    assert browser.answer("p1.why", "stretched").status_code == 409
    assert service.process_queue() == 1
    state = browser.get(f"/a/hw/submissions/{number}").json()
    assert state["state"] == "marked" and state["results"]["p1.jacobian"]["outcome"] == "correct"
    assert browser.answer("p1.why", "stretched").json()["results"]["p1.jacobian"]["outcome"] == "correct"
    assert "Ada" in browser.get("/a/hw/feedback").content.decode()


def test_an_imported_notebook_of_another_student_is_pointed_out_to_both_sides(service: Service) -> None:
    browser = service.open_browser("s001")
    browser.upload("mine.ipynb", NOTEBOOK)
    notebook = write_notebook(service.assignment, "s002", make_correct_cells(service.assignment, "s002"))
    Submission.objects.update(content=notebook.encode())
    service.process_queue()
    (note,) = browser.get("/a/hw/work").json()["notes"]
    assert note.startswith("This notebook was released to another student.") and note.endswith("wrong one.")
    notes = {
        row["student_id"]: row["notes"]
        for row in service.open_browser("staff:Grace").get("/a/hw/class/results").json()["students"]
    }
    assert notes["s001"] == "The notebook was released to 's002'" and not notes["s002"]
    assert browser.answer("p1.position", "theta1").json()["notes"] == []


@pytest.mark.parametrize(
    ("name", "content", "sentence"),
    [
        ("a.exe", b"", "Submit the notebook itself"), ("../../my work.ipynb", b"no notebook", ": my work.ipynb is"),
        ("a.zip", b"PK", "a.zip is not"), ("a.ipynb", b"", "empty"), ("b.ipynb", b'{"cells": [', "b.ipynb is not"),
        ("a.py", b"print(1)", "answers no question of this assignment"), ("x" * 300 + "\n.md", b"# hi", "answers no"),
        ("a.ipynb", NOTEBOOK.replace(b"{}, ", b'{"qdot": {"assignment": "hw9"}}, '), "to the assignment 'hw9'"),
    ],
)  # fmt: skip
def test_a_file_that_is_no_notebook_takes_no_marks_away(
    service: Service, name: str, content: bytes, sentence: str
) -> None:
    browser = service.open_browser("s001")
    browser.answer("p1.determinant", find_right_answer(service, "s001", "p1.determinant"))
    reply = browser.upload(name, content)
    assert reply.status_code == 415 and sentence in reply.json()["error"]
    assert (service.process_queue(), browser.get("/a/hw/work").json()["score"]) == (0, 1)


def test_the_notebook_of_another_student_is_refused(service: Service) -> None:
    notebook = write_notebook(service.assignment, "s002", make_correct_cells(service.assignment, "s002"))
    reply = service.open_browser("s001").upload("mine.ipynb", notebook.encode())
    assert (reply.status_code, "released to another student" in reply.json()["error"]) == (415, True)
    assert not Submission.objects.exists()


def test_the_notebook_to_take_away_has_the_answers_and_the_page_those_of_the_notebook(service: Service) -> None:
    browser = service.open_browser("s001")
    answers = {
        "p1.position": find_right_answer(service, "s001", "p1.position"), "p1.determinant": "it's\n\"wrong\"",
        "p1.why": "Both links\nare in line.",
    }  # fmt: skip
    for part, text in answers.items():
        browser.answer(part, text)
    for part in ("p1.position", "p2.determinant"):
        browser.send("PUT", "/a/hw/drafts", {"part": part, "text": "later"})
    before = browser.get("/a/hw/work").json()
    notebook = browser.get("/a/hw/notebook.ipynb").content
    with set_clock(timezone.now() + datetime.timedelta(seconds=5)):
        assert browser.upload("a.ipynb", notebook).status_code == 202
        service.process_queue()
        work = browser.get("/a/hw/work").json()
        assert (work["score"], work["answers"]["p1.why"]) == (before["score"], answers["p1.why"])
        points, expected = ({name: part["points"] for name, part in page["results"].items()} for page in (work, before))
        assert points == expected
        assert work["drafts"] == {"p2.determinant": "later"}
        assert browser.get("/a/hw/notebook.ipynb").content == notebook
    with set_clock(timezone.now() + datetime.timedelta(seconds=10)):
        browser.upload("b.ipynb", NOTEBOOK)
        service.process_queue()
        assert browser.get("/a/hw/work").json()["answers"] == {"p1.position": "1"}
        results = browser.answer("p1.position", answers["p1.position"]).json()["results"]
        assert results["p1.position"]["outcome"] == "correct"


def test_what_a_killed_process_left_is_done_later(service: Service) -> None:
    browser = service.open_browser("s001")
    browser.answer("p1.position", "theta1")
    Submission.objects.update(state="waiting", marks=None, received=NOW - datetime.timedelta(days=3650))
    for _ in range(2):  # it is queued once
        queue_unmarked()
    assert service.process_queue() == 1
    assert Submission.objects.get().state == "marked"
    browser.upload("a.ipynb", NOTEBOOK)
    for _ in range(MAX_FAILURES - 1):
        DBTaskResult.objects.ready().get().claim("killed")
        reclaim_tasks()
    assert DBTaskResult.objects.ready().count() == 1
    DBTaskResult.objects.ready().get().claim("killed again")
    reclaim_tasks()
    assert not DBTaskResult.objects.ready().exists()
    assert "ended several times" in str(read_marks(Submission.objects.get(answers__isnull=True)).obstacle)


def test_what_fails_again_and_again_is_left_ungraded(service: Service) -> None:
    service.open_browser("s001").upload("a.ipynb", NOTEBOOK)
    Submission.objects.update(received=NOW - datetime.timedelta(days=3650))
    for _ in range(MAX_FAILURES):
        row = DBTaskResult.objects.get(status="READY")
        row.claim("worker")
        row.set_failed(OSError("the database was gone"))
        queue_unmarked()
    assert (DBTaskResult.objects.count(), Submission.objects.get().state) == (MAX_FAILURES, "marked")
    assert service.open_browser("s001").get("/a/hw/work").json()["results"]["p1.position"]["points"] is None


def test_another_person_in_the_same_browser_is_noticed(service: Service) -> None:
    browser = service.open_browser("s001")
    work = browser.get("/a/hw/work").json()
    assert browser.get("/a/hw/work", **{"X-Person": str(work["person"])}).status_code == 200
    assert browser.get("/a/hw/work", **{"X-Person": "999"}).status_code == 401


def test_an_empty_answer_replaces_none(service: Service) -> None:
    browser = service.open_browser("s001")
    score = browser.answer("p2.determinant", find_right_answer(service, "s001", "p2.determinant")).json()["score"]
    for text in ("", "  \n"):
        reply = browser.answer("p2.determinant", text)
        assert (reply.status_code, reply.json()) == (400, {"error": "Type an answer first."})
    assert (browser.get("/a/hw/work").json()["score"], score > 0) == (score, True)


def test_sentences_have_an_end_and_no_entities() -> None:
    with serve_class("due = 2027-01-08T12:00:00+00:00\nlate = {per_day = 0.5}") as service, set_clock(NOW):
        browser = service.open_browser("s001")
        browser.answer("p2.determinant", find_right_answer(service, "s001", "p2.determinant"))
        shown = browser.answer("p1.position", "theta1 < 'x'").json()["results"]["p1.position"]
        assert shown["sentences"][0].startswith("qdot couldn't parse your answer: unexpected '&lt;'")
        (note,) = browser.get("/a/hw/work").json()["notes"]
        assert note.endswith("you lose 50 % of your 1 point.")


def test_a_mistake_in_one_field_is_shown_as_it_was_typed(service: Service) -> None:
    shown = service.open_browser("s001").answer("p1.jacobian", "[[1, theta1*(], [0, 0]]").json()["results"]
    (sentence,) = shown["p1.jacobian"]["sentences"]
    assert sentence.startswith("qdot couldn't parse entry (1, 2) of your answer") and "near 'theta1*(')" in sentence


def test_a_part_that_does_not_exist_is_named(service: Service) -> None:
    reply = service.open_browser("s001").answer("p1.jacobean", "1")
    assert (reply.status_code, "did you mean 'p1.jacobian'?" in reply.json()["error"]) == (404, True)


ALL_FORMS = """
[[problem]]
family = "planar-2r"
questions = "quiz"
[[problem]]
family = "planar-2r"
questions = ["determinant", "singular-angles", "joint-rates"]
"""
"""Questions with answers of every form: choices, numbers, formulas and sets."""
WRONG_ANSWERS = {
    "singular-angles-choice": "B", "singular-configurations": "B", "match-columns": "CB", "true-or-false": "true",
    "speed": "7", "determinant": "7*a1", "singular-angles": "theta2 = 1", "joint-rates": "[7, 7]",
}  # fmt: skip
"""A wrong answer of the right form to each of these questions, for s001."""


def test_tries_are_limited_for_each_question_and_unreadable_answers_cost_none() -> None:
    with serve_class("attempts = {tries = 2}", ALL_FORMS) as service:
        browser = service.open_browser("s001")
        results = browser.get("/a/hw/work").json()["results"]
        assert {name.partition(".")[2] for name in results} == set(WRONG_ANSWERS)
        assert {shown["tries_left"] for shown in results.values()} == {2}
        for name in results:
            right, wrong = find_right_answer(service, "s001", name), WRONG_ANSWERS[name.partition(".")[2]]
            for text, left in (("???", 2), (wrong, 1), (wrong, 1), (right, 0), (right, 0)):
                shown = browser.answer(name, text).json()["results"][name]
                assert (shown["outcome"] == "correct", shown["tries_left"]) == (text == right, left), (name, text)
            reply = browser.answer(name, "theta1")
            assert (reply.status_code, "all tries of this question (2)" in reply.json()["error"]) == (409, True)
        assert browser.upload("a.ipynb", NOTEBOOK).status_code == 409


@pytest.mark.parametrize("text", ["None", "theta1 +", "[1, 2]"])
def test_an_answer_that_could_not_be_judged_costs_no_try(text: str) -> None:
    with serve_class("attempts = {tries = 1}") as service:
        browser = service.open_browser("s001")
        assert browser.answer("p2.determinant", text).json()["results"]["p2.determinant"]["tries_left"] == 1
        assert browser.answer("p1.why", "in words").json()["results"]["p1.why"]["tries_left"] == 1


def test_an_answer_that_is_not_judged_yet_uses_up_a_try() -> None:
    with serve_class("attempts = {tries = 1}") as service:
        browser = service.open_browser("s001")
        with patch("qdot.grader.serve.student_pages.mark_answers"):
            assert browser.answer("p2.determinant", "theta1 +").json()["state"] == "waiting"
            assert browser.answer("p2.determinant", "1").status_code == 409
        Submission.objects.update(received=NOW - datetime.timedelta(days=3650))
        queue_unmarked()
        service.process_queue()
        assert browser.answer("p2.determinant", "1").status_code == 200
