"""What a student may try who wants the service down, or another's data: one person takes little from the others."""

import csv
import datetime
import re
import socket
import threading
import time
import uuid
from contextlib import ExitStack
from dataclasses import replace
from http.client import HTTPConnection
from typing import Any

import pytest
from django_tasks_db.models import DBTaskResult

from qdot.grader.serve import judge_process, marking_online, submitting
from qdot.grader.serve.exchange import make_roster_csv
from qdot.grader.serve.models import Submission
from qdot.grader.serve.personal_links import make_link
from qdot.grader.serve.server import open_server
from tests.grader.serve.test_submitting import NOW
from tests.support.serving import NOTEBOOK, Browser, Service, serve_class, set_clock


def test_an_answer_that_takes_long_is_marked_in_the_queue(service: Service, monkeypatch: pytest.MonkeyPatch) -> None:
    browser, request = service.open_browser("s001"), str(uuid.uuid4())
    quick = browser.answer("p1.position", "theta1").json()
    monkeypatch.setattr(judge_process, "QUICK_JUDGING", 0.0)
    for _ in range(2):  # a repeated request isn't judged again
        assert browser.answer("p1.position", "theta1 + 0", request).json()["state"] == "waiting"
    browser.upload("a.ipynb", NOTEBOOK)
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
        patch.setattr(marking_online.get_judge_pool(), "run", be_busy)
        assert browser.answer("p1.position", "theta1").json()["state"] == "waiting"
        reply = browser.get("/a/hw/notebook.ipynb")
        assert (reply.status_code, reply.json()["error"][:12]) == (503, "qdot is busy")
    assert service.work_off_queue() == 1
    assert browser.get("/a/hw/work").json()["submissions"][0]["state"] == "marked"


def test_one_student_can_t_fill_the_queue_or_the_disk(service: Service, monkeypatch: pytest.MonkeyPatch) -> None:
    browser, other = service.open_browser("s001"), service.open_browser("s002")
    statuses = [browser.upload("a.ipynb", NOTEBOOK).status_code for _ in range(submitting.MAX_WAITING + 1)]
    assert statuses == [202] * submitting.MAX_WAITING + [429]
    assert other.upload("a.ipynb", NOTEBOOK).status_code == 202
    service.work_off_queue()
    monkeypatch.setattr(submitting, "MAX_STORED_BYTES", 10 * len(NOTEBOOK))
    assert browser.upload("a.ipynb", NOTEBOOK + b" " * 1000).status_code == 413
    monkeypatch.setattr(submitting, "MAX_SUBMISSIONS", 6)
    assert browser.upload("a.ipynb", NOTEBOOK).status_code == 202
    service.work_off_queue()
    assert browser.upload("a.ipynb", NOTEBOOK).status_code == 409
    assert browser.answer("p1.position", "theta1").status_code == 409
    assert browser.answer("p1.position", "theta1").status_code == 409


def test_two_answers_of_a_student_are_not_judged_at_the_same_time(
    service: Service, monkeypatch: pytest.MonkeyPatch
) -> None:
    number, events = service.people["s001"].pk, list[str]()
    monkeypatch.setattr(marking_online, "TURN_SECONDS", 0.2)
    with marking_online._wait_for_turn(number):
        with marking_online._wait_for_turn(service.people["s002"].pk):
            events.append("another student")
        assert service.open_browser("s001").answer("p1.position", "theta1").json()["state"] == "waiting"
    assert service.open_browser("s001").answer("p1.position", "theta1").json()["state"] == "marked"
    assert events == ["another student"]


@pytest.mark.parametrize(
    "start", [b"", b"GET / HTTP/1.1\r\nHost: 127", b"POST / HTTP/1.1\r\nContent-Length: 9999\r\n\r\na"]
)
def test_connections_on_which_nothing_comes_keep_nobody_out(start: bytes) -> None:
    def application(environ: Any, start_response: Any) -> list[bytes]:
        start_response("200 OK", [("Content-Length", "2")])
        return [b"ok"]

    server = open_server(application, "http://127.0.0.1", "127.0.0.1", 0)
    threading.Thread(target=server.run, daemon=True).start()
    address = ("127.0.0.1", server.effective_port)
    with ExitStack() as stack:
        for _ in range(150):
            stack.enter_context(socket.create_connection(address)).sendall(start)
        begin, visitor = time.monotonic(), HTTPConnection(*address, timeout=5)
        visitor.request("GET", "/")
        assert visitor.getresponse().read() == b"ok"
        assert time.monotonic() - begin < 5
        visitor.close()
    server.close()


@pytest.mark.parametrize("scheme", ["http", "https"])
def test_every_cookie_is_partitioned_if_the_service_has_a_certificate(scheme: str) -> None:
    def application(environ: Any, start_response: Any) -> list[bytes]:
        cookies = ["a=1; Secure", 'a=""; Max-Age=0; Secure']
        start_response("200 OK", [("Content-Length", "2"), *(("Set-Cookie", cookie) for cookie in cookies)])
        return [b"ok"]

    server, fields = open_server(application, f"{scheme}://127.0.0.1", "127.0.0.1", 0), list[tuple[str, str]]()
    server.application({"REMOTE_ADDR": "127.0.0.1"}, lambda _, sent, *__: fields.extend(sent))
    server.close()
    cookies = [value for name, value in fields if name == "Set-Cookie"]
    assert [cookie.endswith("; Partitioned") for cookie in cookies] == [scheme == "https"] * 2


@pytest.mark.parametrize("level", ["values", "solutions"])
def test_right_answers_are_shown_only_when_nothing_more_can_be_submitted(level: str) -> None:
    pages = dict[str, list[str]]()
    for feedback in ("counterexample", level):
        settings = f'due = {NOW.isoformat()}\nlate = {{until = {NOW.isoformat()}}}\nfeedback = "{feedback}"\n'
        with serve_class(settings) as service:
            later = NOW + datetime.timedelta(seconds=1)
            with set_clock(NOW):
                browser = service.open_browser("s001")
                browser.answer("p1.determinant", "a1*a2*cos(theta2)")
                pages[feedback] = [str(browser.get("/a/hw/work").json()["results"]), _open_feedback(browser)]
            with set_clock(later):
                pages[feedback].append(_open_feedback(browser))
    assert pages["counterexample"][:2] == pages[level][:2]
    assert pages["counterexample"][2] != pages[level][2]


def _open_feedback(browser: Browser) -> str:
    """Return the page of feedback without what differs from one setting to another."""
    page = browser.get("/a/hw/feedback").content.decode()
    return re.sub('content="[0-9a-f]+"', "", page)


def test_a_page_elsewhere_signs_nobody_in_or_out(service: Service) -> None:
    browser, link = service.open_browser("s001"), f"/in/{make_link(service.people['s002'])}"
    for path in (link, "/out"):
        assert browser.get(path, **{"Sec-Fetch-Dest": "image"}).status_code == 403
        assert browser.get("/a/hw/work").json()["student"]["id"] == "s001"
    assert browser.get(link, **{"Sec-Fetch-Dest": "document"}).status_code == 302
    assert browser.get("/a/hw/work").json()["student"]["id"] == "s002"


def test_no_name_is_a_formula_in_a_table(service: Service) -> None:
    name = '=HYPERLINK("https://evil.example","Ada")'
    students = tuple(replace(student, name=name, email="@x") for student in service.assignment.roster)
    table = make_roster_csv(replace(service.assignment, roster=students))
    cells = [cell for row in csv.reader(table.splitlines()) for cell in row]
    assert f"'{name}" in cells
    assert not [cell for cell in cells if cell.startswith(("=", "+", "-", "@"))]
