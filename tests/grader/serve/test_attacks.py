"""What a student may try who wants the service down, or another's data: one person takes little from the others."""

import uuid
from typing import Any

import pytest
from django_tasks_db.models import DBTaskResult

from qdot.grader.serve import judge_process, marking_online, submitting
from qdot.grader.serve.models import Submission
from tests.support.serving import Service


def test_an_answer_that_takes_long_is_marked_in_the_queue(service: Service, monkeypatch: pytest.MonkeyPatch) -> None:
    browser, request = service.open_browser("s001"), str(uuid.uuid4())
    quick = browser.answer("p1.position", "theta1").json()
    monkeypatch.setattr(judge_process, "QUICK_JUDGING", 0.0)
    for _ in range(2):  # a repeated request isn't judged again
        assert browser.answer("p1.position", "theta1 + 0", request).json()["state"] == "waiting"
    browser.upload("a.ipynb", b"{}")
    first, second = DBTaskResult.objects.ready()  # notebooks come first
    assert first.priority > second.priority
    service.work_off_queue()
    rows = list(Submission.objects.filter(answers__isnull=False))
    assert [(row.state, row.points) for row in rows] == [("marked", quick["score"])] * 2


def test_judges_that_are_busy_are_reported_and_lose_nothing(service: Service, monkeypatch: pytest.MonkeyPatch) -> None:
    browser = service.open_browser("s001")

    def be_busy(*_: Any) -> None:
        raise TimeoutError

    with monkeypatch.context() as patch:
        patch.setattr(marking_online.find_judges(), "run", be_busy)
        assert browser.answer("p1.position", "theta1").json()["state"] == "waiting"
        reply = browser.get("/a/hw/notebook.ipynb")
        assert (reply.status_code, reply.json()["error"][:12]) == (503, "qdot has too")
    assert service.work_off_queue() == 1
    assert browser.get("/a/hw/work").json()["submissions"][0]["state"] == "marked"


def test_one_student_can_t_fill_the_queue_or_the_disk(service: Service, monkeypatch: pytest.MonkeyPatch) -> None:
    browser, other = service.open_browser("s001"), service.open_browser("s002")
    statuses = [browser.upload("a.ipynb", b"{}").status_code for _ in range(submitting.MAX_WAITING + 1)]
    assert statuses == [202] * submitting.MAX_WAITING + [429]
    assert other.upload("a.ipynb", b"{}").status_code == 202
    service.work_off_queue()
    monkeypatch.setattr(submitting, "MAX_STORED_BYTES", 20)
    assert browser.upload("a.ipynb", b"{}" * 6).status_code == 413
    monkeypatch.setattr(submitting, "MAX_SUBMISSIONS", 6)
    assert browser.upload("a.ipynb", b"{}").status_code == 202
    service.work_off_queue()
    assert browser.upload("a.ipynb", b"{}").status_code == 409
    assert browser.answer("p1.position", "theta1").status_code == 409
    assert browser.answer("p1.position", "theta1").status_code == 409
