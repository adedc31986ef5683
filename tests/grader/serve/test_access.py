"""Every address, for anybody: nobody gets at another's work, at solutions or secrets, or takes the service down."""

import csv
import datetime
import functools
import html
import json
import re
import socket
import threading
import time
import uuid
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import replace
from http.client import HTTPConnection
from typing import Any
from urllib.parse import urlencode

import pytest
from django.conf import settings
from django.core.cache import cache
from django.test import Client, RequestFactory
from django.urls import URLPattern, URLResolver, get_resolver
from django_tasks_db.models import DBTaskResult

from qdot.exercises.assignment.assignment import load_assignment
from qdot.exercises.problem.problem import Problem
from qdot.exercises.writing.problem_texts import write_answer_code
from qdot.exercises.writing.render import find_template_folder
from qdot.grader.grading.certify import find_former_students
from qdot.grader.serve import html_pages, judge_process, marking_online, submitting
from qdot.grader.serve.exchange import make_roster_csv
from qdot.grader.serve.forgetting_online import forget_people
from qdot.grader.serve.frame_requests import FORM_TYPE
from qdot.grader.serve.models import Classroom, Draft, Person, Submission
from qdot.grader.serve.personal_links import make_link
from qdot.grader.serve.server import open_server
from tests.grader.serve.test_submitting import NOW, find_right_answer
from tests.support import ROOT
from tests.support.serving import ASSETS, NOTEBOOK, Browser, Service, find_folder, serve_class, set_clock
from tests.support.suites import sample_for_suite

METHODS = ("GET", "POST", "PUT", "PATCH", "DELETE")
PUBLIC = {"", "in/<str:token>", "out"}
"""Addresses that anybody may open; those of lti/ check signed messages and have tests of their own."""
OF_STAFF = "/class/"


def list_routes(resolver: Any = None, prefix: str = "") -> Iterator[str]:
    for entry in (resolver or get_resolver()).url_patterns:
        route = prefix + str(entry.pattern)
        if isinstance(entry, URLResolver):
            yield from list_routes(entry, route)
        elif isinstance(entry, URLPattern) and not route.startswith("lti/"):
            yield route


def fill_route(route: str, number: int = 1) -> str:
    path = route.replace("<key:key>", "hw").replace("<int:number>", str(number)).replace("<str:token>", "x")
    return f"/{path}"


ROUTES = sorted(set(list_routes()))


@pytest.fixture
def staff_of_other_class(service: Service) -> Person:
    other = Classroom.objects.create(title="Other", is_connected=True)
    service.people["staff:Eve"] = Person.objects.create(classroom=other, role="staff", student_id="staff:Eve")
    service.people["eve"] = Person.objects.create(classroom=other, role="student", student_id="eve")
    return service.people["staff:Eve"]


@functools.cache
def list_secrets() -> tuple[str, ...]:
    """Return texts that no student may get: the secret, ids that generate problems, and right answers."""
    assignment = load_assignment(find_folder())
    secrets = [assignment.secret, "0123456789abcdef"]
    for student in assignment.roster:
        for _, problem in assignment.generate_problems(student.id):
            secrets += [str(problem.id.seed), *list_right_answers(problem)]
    return tuple(secrets)


def list_right_answers(problem: Problem) -> list[str]:
    answers = [write_answer_code(problem, part) for part in problem.parts if part.name != "why"]
    return [answer for answer in answers if len(answer) > 12]


@pytest.mark.parametrize("route", ROUTES)
def test_nobody_gets_in_without_signing_in(service: Service, route: str) -> None:
    for method in METHODS:
        reply = Browser().send(method, fill_route(route), {})
        if route not in PUBLIC:
            assert reply.status_code in (401, 405), (method, reply.content)
            assert_is_one_sentence(reply)


@pytest.mark.parametrize("route", ROUTES)
def test_a_forged_request_is_refused(service: Service, route: str) -> None:
    browser = service.open_browser("s001")
    for method in ("POST", "PUT", "PATCH", "DELETE"):
        reply = browser.client.generic(method, fill_route(route), "{}", "application/json")
        assert reply.status_code in (403, 405), (method, reply.status_code)


@pytest.mark.parametrize("route", ROUTES)
def test_a_student_gets_nothing_of_the_staff_or_of_others(service: Service, route: str) -> None:
    ada, bo = service.open_browser("s001"), service.open_browser("s002")
    secret_text = "0.123456789*theta1"
    assert bo.answer("p1.position", secret_text).status_code == 200
    theirs = Submission.objects.get().pk
    secrets = [*list_secrets(), secret_text, "s002", "Quux"]
    for method in METHODS:
        content: dict[str, Any] = {"request": str(uuid.uuid4()), "part": "p1.position", "text": "1", "student": theirs}
        reply = ada.send(method, fill_route(route, theirs), content)
        if OF_STAFF in route or "submissions" in route:
            assert reply.status_code in (404, 405), (method, reply.content)
        text = reply.content.decode(errors="replace")
        assert not [secret for secret in secrets if secret in text or json.dumps(secret)[1:-1] in text]
        assert "Traceback" not in text and reply.status_code != 500


@pytest.mark.parametrize("route", [route for route in ROUTES if OF_STAFF in route])
def test_staff_get_nothing_of_another_class(service: Service, staff_of_other_class: Person, route: str) -> None:
    service.open_browser("s001").answer("p1.position", "0.123456789*theta1")
    student = service.people["s001"]
    eve = service.open_browser(staff_of_other_class.student_id)
    target = {"student": student.pk}
    contents = ({**target, "part": "p1.position", "points": 1}, {**target, "due": None}, {"token": "x"})
    for method in METHODS:
        for content in contents:
            reply = eve.send(method, fill_route(route, student.pk), content)
            assert "0.123456789" not in reply.content.decode(errors="replace")
            assert "Ada" not in reply.content.decode(errors="replace")
            if "students" in route or "extensions" in route:
                assert reply.status_code in (404, 405), reply.content
    assert not student.overrides.exists()


@pytest.mark.parametrize("who", ["s001", "staff:Grace"])
@pytest.mark.parametrize("route", [route for route in ROUTES if route not in PUBLIC])
def test_wrong_bodies_get_one_sentence(service: Service, who: str, route: str) -> None:
    browser = service.open_browser(who)
    bodies: tuple[Any, ...] = (
        None, [], "x", 1, {}, {"request": "x"}, {"request": str(uuid.uuid4()), "part": "p9.position", "text": "1"},
        {"request": str(uuid.uuid4()), "part": "p1.position", "text": "1" * 20_001}, {"student": "s001"},
        {"request": str(uuid.uuid4()), "part": "p1.position", "text": "a\x00b"}, {"student": 10**30, "part": ""},
        {"request": str(uuid.uuid4()), "part": "p1.position", "text": "function: [[1]]"}, {"student": True, "due": 1},
        {"request": str(uuid.uuid4()), "part": ["p1.position"], "text": {"a": 1}}, {"part": {}, "points": "nan"},
        {"group": "p1.position/x", "points": 1e9}, {"group": "nothing", "points": float("nan")}, {"due": "tomorrow"},
    )  # fmt: skip
    for body in sample_for_suite(bodies, 9):
        for method in ("POST", "PUT"):
            reply = browser.send(method, fill_route(route), body)
            assert reply.status_code != 500, (method, body, reply.content)
            if reply.status_code >= 400:
                assert_is_one_sentence(reply)


def assert_is_one_sentence(reply: Any) -> None:
    if reply.status_code == 405:
        return
    sentence = json.loads(reply.content)["error"]
    assert sentence[0].isupper() or sentence.startswith("qdot")
    assert sentence.endswith(".")
    assert "Traceback" not in sentence


def test_headers_are_set_on_every_page(service: Service) -> None:
    browser = service.open_browser("s001")
    for path in ("/", "/a/hw/", "/a/hw/work", "/nothing", "/a/hw/class/"):
        reply = browser.get(path)
        policy = reply["Content-Security-Policy"]
        assert "default-src 'none'" in policy
        assert "frame-ancestors 'self'" in policy
        assert "unsafe-eval" not in policy
        assert reply["X-Content-Type-Options"] == "nosniff"
        assert reply["Cache-Control"] == "no-store"
        assert reply["Referrer-Policy"] == "same-origin"


def test_an_unknown_host_is_named(service: Service, caplog: pytest.LogCaptureFixture) -> None:
    cache.clear()
    for _ in range(2):
        reply = Client(headers={"Host": "127.0.0.1:8000"}).get("/a/hw/work")
        assert reply.status_code == 400
        assert reply.json()["error"].startswith("qdot is at http://testserver, but a request named the host '127.0.0.1")
    assert len(caplog.messages) == 1 and "--url" in caplog.messages[0]


def test_a_personal_link_leads_to_the_only_assignment(service: Service) -> None:
    for student, address in (("s001", "/a/hw/"), ("staff:Grace", "/a/hw/class/")):
        reply = service.open_browser(student).get("/")
        assert (reply.status_code, reply.headers["Location"]) == (302, address)


def test_an_answer_that_takes_long_is_marked_in_the_queue(service: Service, monkeypatch: pytest.MonkeyPatch) -> None:
    browser, request = service.open_browser("s001"), str(uuid.uuid4())
    quick = browser.answer("p1.position", "theta1").json()
    monkeypatch.setattr(judge_process, "QUICK_JUDGING", 0.0)
    for _ in range(2):  # a repeated request isn't judged again
        assert browser.answer("p1.position", "theta1 + 0", request).json()["state"] == "waiting"
    browser.upload("a.ipynb", NOTEBOOK)
    first, second = DBTaskResult.objects.ready()  # notebooks come first
    assert first.priority > second.priority
    service.process_queue()
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
    assert service.process_queue() == 1
    assert browser.get("/a/hw/work").json()["submissions"][0]["state"] == "marked"


def test_one_student_can_t_fill_the_queue_or_the_disk(service: Service, monkeypatch: pytest.MonkeyPatch) -> None:
    browser, other = service.open_browser("s001"), service.open_browser("s002")
    statuses = [browser.upload("a.ipynb", NOTEBOOK).status_code for _ in range(submitting.MAX_WAITING + 1)]
    assert statuses == [202] * submitting.MAX_WAITING + [429]
    assert other.upload("a.ipynb", NOTEBOOK).status_code == 202
    service.process_queue()
    monkeypatch.setattr(submitting, "MAX_STORED_BYTES", 10 * len(NOTEBOOK))
    assert browser.upload("a.ipynb", NOTEBOOK + b" " * 1000).status_code == 413
    monkeypatch.setattr(submitting, "MAX_SUBMISSIONS", 6)
    assert browser.upload("a.ipynb", NOTEBOOK).status_code == 202
    service.process_queue()
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


OWN = "http://testserver"
EVIL = "https://evil.example"
WORK = "/a/hw/work"


def find_key(browser: Browser) -> str:
    return str(browser.client.session.session_key)


@pytest.fixture
def key(service: Service) -> str:
    return find_key(service.open_browser("s001"))


def get(key: str, path: str = WORK, client: Client | None = None, **headers: str) -> Any:
    return (client or Client()).get(path, headers={"X-Session": key, **headers})


def post_form(path: str, fields: dict[str, str], origin: str = OWN) -> Any:
    headers = {"Origin": origin, "Accept": "text/html"}
    return Client(enforce_csrf_checks=True).post(path, urlencode(fields), FORM_TYPE, headers=headers)


def find_session(page: Any) -> str:
    return "".join(re.findall('id="session".*?name="session" value="([^"]*)">', page.content.decode()))


def find_token(page: Any) -> str:
    return "".join(re.findall('<meta name="csrf" content="([^"]*)">', page.content.decode()))


def test_a_page_gets_the_key_only_if_it_was_opened_with_it(service: Service, key: str) -> None:
    page = post_form("/a/hw/", {"session": key, "method": "GET"})
    assert find_session(page) == key
    assert page["Cache-Control"] == "no-store"
    browser = service.open_browser("s002")
    assert find_token(browser.get("/a/hw/")) and not find_session(browser.get("/a/hw/"))


def test_the_key_and_the_page_s_token_let_a_script_submit(key: str) -> None:
    token = find_token(post_form("/a/hw/", {"session": key, "method": "GET"}))
    body = {"part": "p1.position", "text": "1"}

    def put(**headers: str) -> int:
        client = Client(enforce_csrf_checks=True)
        reply = client.put("/a/hw/drafts", body, "application/json", headers={"X-Session": key, **headers})
        return reply.status_code

    assert put(Origin=OWN) == 403
    assert [put(Origin=origin, **{"X-CSRFToken": token}) for origin in (OWN, EVIL, "null")] == [200, 401, 401]
    assert put(**{"X-CSRFToken": token}) == 401
    assert get(key).json()["drafts"] == {"p1.position": "1"}


def test_a_link_becomes_a_form_and_so_does_a_redirection(key: str) -> None:
    page = post_form("/", {"session": key, "method": "GET"})
    assert 'action="/a/hw/"' in page.content.decode() and f'value="{key}"' in page.content.decode()
    notebook = post_form("/a/hw/notebook.ipynb", {"session": key, "method": "GET"})
    assert notebook["Content-Disposition"] == 'attachment; filename="hw.ipynb"'


@pytest.mark.parametrize("origin", [EVIL, "null", ""])
def test_nobody_signs_another_s_browser_in_by_a_form(key: str, origin: str) -> None:
    page = post_form("/a/hw/", {"session": key, "method": "GET"}, origin)
    assert (page.status_code, find_session(page)) == (401, "")
    assert get(key, Origin=EVIL).status_code == 401


def test_a_key_in_an_address_or_in_json_does_nothing(key: str) -> None:
    assert Client().get(f"{WORK}?session={key}").status_code == 401
    content = {"session": key, "method": "GET"}
    headers = {"Origin": OWN}
    assert Client().post("/a/hw/answers", content, "application/json", headers=headers).status_code == 401


def test_the_key_must_be_that_of_the_cookie_if_there_is_one(service: Service, key: str) -> None:
    other = service.open_browser("s002")
    assert get(key, client=other.client).status_code == 401
    assert get(find_key(other), client=other.client).json()["student"]["id"] == "s002"
    assert get(key).json()["student"]["id"] == "s001"


def test_the_session_ends_as_others_do(service: Service) -> None:
    ends: dict[str, Callable[[Browser], object]] = {
        "s001": lambda browser: browser.get("/out"),
        "s002": lambda _: make_link(service.people["s002"]),
        "s003": lambda _: forget_people([service.people["s003"]]),
    }
    for student, end in ends.items():
        browser = service.open_browser(student)
        key = find_key(browser)
        assert get(key).status_code == 200
        end(browser)
        assert get(key).status_code == 401
        page = post_form("/a/hw/", {"session": key, "method": "GET"})
        assert page.status_code == 401 and 'id="get-in"' in page.content.decode()


@pytest.mark.parametrize("route", ROUTES)
def test_no_address_lets_a_page_elsewhere_send_the_header(key: str, route: str) -> None:
    names = {"Access-Control-Request-Method": "GET", "Access-Control-Request-Headers": "x-session"}
    for method in ("OPTIONS", *METHODS):
        reply = Client().generic(method, fill_route(route), headers={"Origin": EVIL, "X-Session": key, **names})
        assert not [name for name in reply.headers if name.startswith("Access-Control")]
        assert method in ("OPTIONS", "HEAD") or reply.status_code == 401


def test_the_header_changes_nothing_about_the_site_s_scripts(key: str) -> None:
    names = [name.rpartition(".")[2] for name in settings.MIDDLEWARE]
    assert names.index("WhiteNoiseMiddleware") < names.index("FrameSessionMiddleware")
    assert names.index("FrameSessionMiddleware") + 1 == names.index("SessionMiddleware")
    reply = get(key, "/static/nothing.js")
    assert reply.status_code == 404 and not reply.cookies and key not in reply.content.decode()


TEXTS = json.loads((ROOT / "site" / "src" / "text" / "en.json").read_text(encoding="utf-8"))
HOSTILE = "<b>\"Week\" & 'one'</b>"


@pytest.mark.parametrize("name", sorted(path.name for path in (find_template_folder() / "serve").glob("*.j2")))
def test_texts_without_javascript_are_those_that_the_script_shows(name: str) -> None:
    template = (find_template_folder() / "serve" / name).read_text(encoding="utf-8")
    for key, text in re.findall(r'data-text="([^"]+)"[^>]*>([^<]*)<', template):
        shown = text.replace('{{ "%g" % assignment.points }}', "{points}").replace(
            '{{ "%g" % part.points }}', "{points}"
        )
        assert TEXTS[key] == shown or shown.startswith("{{ advice"), key


def test_the_choice_for_a_course_escapes_titles(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(html_pages, "load_assets", lambda: ASSETS)
    part = {"name": "p1.jacobian", "title": HOSTILE, "points": 2.5}
    assignment = {"key": "week-1", "title": HOSTILE, "points": 4.0, "parts": [part]}
    request = RequestFactory().get("/lti/choose")
    page = html_pages.render_page(
        request, "serve/choose.html.j2", title=HOSTILE, action="/lti/choose", assignments=[assignment]
    ).content.decode()  # fmt: skip
    assert "<b>" not in page and page.count("&lt;b&gt;") == 3
    assert re.findall(r'name="choice" value="([^"]*)"', page) == ["week-1", "week-1/p1.jacobian"]
    values = [json.loads(html.unescape(text)) for text in re.findall(r"data-values='([^']*)'", page)]
    assert values == [{"points": 4.0}, {"points": 2.5}]
    (token,) = re.findall(r'name="csrf" content="(\w+)"', page)
    assert f'name="csrfmiddlewaretoken" value="{token}"' in page


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
