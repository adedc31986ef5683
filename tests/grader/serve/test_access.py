"""Every address of the service, for every role: nobody gets at another's work, at solutions, or at secrets."""

import json
import uuid
from collections.abc import Iterator
from typing import Any

import pytest
from django.core.cache import cache
from django.test import Client
from django.urls import URLPattern, URLResolver, get_resolver

from qdot.exercises.problem.problem import Problem
from qdot.exercises.writing.problem_texts import write_answer_code
from qdot.grader.serve.models import Classroom, Person, Submission
from tests.support.serving import Browser, Service

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


def list_secrets(service: Service) -> list[str]:
    """Return texts that no student may get: the secret, ids that generate problems, and right answers."""
    secrets = [service.assignment.secret, "0123456789abcdef"]
    for student in service.assignment.roster:
        for _, problem in service.assignment.generate_problems(student.id):
            secrets += [str(problem.id.seed), *list_right_answers(problem)]
    return secrets


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
    secrets = [*list_secrets(service), secret_text, "s002", "Quux"]
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
    for body in bodies:
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
