"""Students practise on problems that are not theirs, and nothing of it is stored or counts."""

import datetime
import json
from typing import Any

import pytest

from qdot.exercises.writing.problem_texts import write_answer_code
from qdot.grader.grading.certify import find_former_students
from qdot.grader.serve.models import Draft, Submission
from tests.grader.serve.test_submitting import NOW, find_right_answer
from tests.support.serving import Browser, Service, serve_class, set_clock

PRACTICE = """practice = true
due = 2027-01-09T13:00:00+00:00
late = {per_day = 0.1, until = 2027-01-10T13:00:00+00:00}
attempts = {tries = 1}
"""


def send(browser: Browser, path: str, part: str, text: str, method: str = "POST") -> dict[str, Any]:
    reply = browser.send(method, f"/a/hw/practice/{path}", {"part": part, "text": text})
    assert reply.status_code == 200, reply.content
    return dict(reply.json())


def test_practice_is_judged_without_limits_and_stores_nothing() -> None:
    with serve_class(PRACTICE) as service, set_clock(NOW + datetime.timedelta(days=9)):  # all is over
        browser, part = service.open_browser("s001"), "p1.determinant"
        right = find_right_answer(service, "practice:1", part)
        assert browser.get("/a/hw/practice/1/").status_code == 200
        own_work = browser.get("/a/hw/work").json()
        assert (own_work["practice"]["next"], own_work["closed"] != "") == ("practice/1/", True)
        for text in ("theta1", "2*a1", right):
            reply = send(browser, "1/answers", part, text)
            assert (reply["results"][part]["outcome"] == "correct") == (text == right), reply["results"][part]
        send(browser, "1/drafts", "p1.position", "the", "PUT")
        work = browser.get("/a/hw/practice/1/work").json()
        assert (work["answers"], work["drafts"], work["score"]) == ({part: right}, {"p1.position": "the"}, 1)
        assert work["results"][part]["outcome"] == "correct" and work["results"][part]["tries_left"] is None
        other = service.open_browser("s002").get("/a/hw/practice/1/work").json()
        assert (other["answers"], other["problems"]) == ({}, work["problems"])
        assert browser.get("/a/hw/practice/2/work").json()["problems"] != work["problems"]
        assert not Submission.objects.exists() and not Draft.objects.exists()
        assert find_former_students(service.assignment) == []  # `qdot generate` warns of none
        assert not list(service.folder.glob("released/*[:-]*")) and list(
            service.folder.glob("online/released/practice-1/*")
        )
        assert browser.get("/a/hw/work").json()["score"] is None


def test_practice_says_nothing_about_problems_that_count() -> None:
    with serve_class("practice = true") as service:
        browser = service.open_browser("s001")
        own = find_right_answer(service, "s001", "p1.jacobian")
        shown = send(browser, "1/answers", "p1.jacobian", own)["results"]["p1.jacobian"]
        assert shown["outcome"] != "correct" and "student" not in json.dumps(shown)
        text = json.dumps(browser.get("/a/hw/practice/1/work").json()["problems"])
        for slot, problem in service.assignment.generate_problems("practice:1"):
            assert str(problem.id.seed) not in text and slot in text
            answers = [write_answer_code(problem, part) for part in problem.parts if part.name != "why"]
            assert not [answer for answer in answers if len(answer) > 12 and json.dumps(answer)[1:-1] in text]


@pytest.mark.parametrize("path", ["0/work", "101/work", "1/work", "1/"])
def test_no_practice_where_the_assignment_has_none(service: Service, path: str) -> None:
    assert service.open_browser("s001").get(f"/a/hw/practice/{path}").status_code == 404


@pytest.mark.parametrize("path", ["1/work", "1/"])
def test_a_set_with_the_students_own_arms_is_refused(path: str) -> None:
    with serve_class('practice = true\nvariation = "chapter"') as service:
        reply = service.open_browser("s001").get(f"/a/hw/practice/{path}")
        assert (reply.status_code, "same arms as yours" in reply.content.decode()) == (409, True)
