"""Launches, class lists, deep linking and scores, with a platform of our own (platform.py)."""

import datetime
import itertools
import json
import re
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from typing import Any
from urllib.parse import urlencode

import jwt
import pytest
import requests
from django.contrib.sessions.models import Session
from django.core.cache import cache
from django.db import transaction
from django.test import Client
from django.utils import timezone
from lti_tool.models import Key, LtiRegistration, LtiUser

from qdot.exercises.common.errors import QdotError
from qdot.grader.serve.class_list import update_folder_class
from qdot.grader.serve.frame_requests import FORM_TYPE
from qdot.grader.serve.lti import launch, outbox
from qdot.grader.serve.lti.connection import Connections, find_signing_key, renew_keys
from qdot.grader.serve.lti.outbox import update_scores
from qdot.grader.serve.lti.registering import (
    CopiedValues,
    begin_registration,
    connect_course,
    describe_registration_steps,
    finish_registration,
)
from qdot.grader.serve.models import Classroom, Person, PointsOverride, ScoreDelivery
from tests.grader.serve.platform import AGS, CLAIM, MEMBERSHIP, TOOL, Platform, find_key
from tests.support import DATA
from tests.support.serving import ASSETS, empty_database, find_folder
from tests.support.suites import sample_for_suite

pytestmark = pytest.mark.usefixtures("platform")


ROSTER = "student,name,email\nada,Ada,ada@example.edu\nhenri,Henri,henri@example.edu\n"
ASSIGNMENT = """title = "Velocity kinematics"
key = "velocity"
[[problem]]
family = "planar-2r"
questions = ["position", "jacobian"]
points = [1, 3]
"""


@pytest.fixture(scope="module", autouse=True)
def _folder() -> Iterator[None]:
    """Give the service an assignment whose students have e-mail addresses, and an empty database."""
    folder = find_folder()
    paths = {folder / "assignment.toml": ASSIGNMENT, folder / "roster.csv": ROSTER}
    before = {path: path.read_text(encoding="utf-8") for path in paths}
    for path, text in paths.items():
        path.write_text(text, encoding="utf-8")
    with empty_database():
        yield
    for path, text in before.items():
        path.write_text(text, encoding="utf-8")


@pytest.fixture
def platform(monkeypatch: pytest.MonkeyPatch) -> Iterator[Platform]:
    """Register a platform that answers without a network; what the test writes into the database is undone."""
    platform = Platform(keys=[find_key("first")])
    monkeypatch.setattr("requests.adapters.HTTPAdapter.send", lambda self, request, **_: platform.answer(request))
    monkeypatch.setattr("qdot.grader.serve.lti.outbox._connections", Connections())
    monkeypatch.setattr("qdot.grader.serve.html_pages.load_assets", lambda: ASSETS)
    own_keys = itertools.cycle([find_key("own"), find_key("own next")])
    monkeypatch.setattr("lti_tool.models.JWK.generate", lambda **_: next(own_keys))
    cache.clear()
    with transaction.atomic():
        Session.objects.all().delete()
        renew_keys(timezone.now())
        platform.register()
        yield platform
        transaction.set_rollback(True)


def _find_people(course: str = "c1") -> dict[str, tuple[str, str, bool]]:
    """Return the people of a course by what the platform calls them: identifier, role, and whether they are active."""
    people = Person.objects.filter(classroom__lti_context__id_on_platform=course, lti_user__isnull=False)
    rows = [(person, person.lti_user) for person in people]
    return {user.sub: (person.student_id, person.role, person.is_active) for person, user in rows if user}


# --- launches ---


def test_a_teacher_and_then_students_of_the_course_come_in(platform: Platform) -> None:
    teacher, student = Client(), Client()
    assert platform.launch(Client(), user="ada").status_code == 403  # no teacher has been there
    assert platform.launch(teacher, user="grace", role="Instructor")["Location"] == "/a/velocity/class/"
    answer = platform.launch(student, user="ada")
    assert answer["Location"] == "/a/velocity/"
    assert student.session["person"] and teacher.session["person"] != student.session["person"]
    assert _find_people() == {"grace": (_find_people()["grace"][0], "staff", True), "ada": ("ada", "student", True)}


def test_a_student_who_is_on_no_roster_gets_an_identifier_that_stays(platform: Platform) -> None:
    platform.launch(Client(), user="grace", role="Instructor")
    identifiers = set()
    for email in ("x@example.edu", "ada@example.edu", None):
        platform.launch(Client(), user="newcomer", email=email)
        identifiers.add(_find_people()["newcomer"][0])
    assert len(identifiers) == 1
    assert re.fullmatch("lti-[a-z2-7]{12}", identifiers.pop())
    platform.launch(Client(), user="ada2", email="Ada@Example.edu ")
    platform.launch(Client(), user="impostor", email="ada@example.edu")
    assert _find_people()["ada2"][0] == "ada"
    assert _find_people()["impostor"][0].startswith("lti-")


def test_the_role_is_that_of_the_launch_even_if_it_was_a_higher_one_before(platform: Platform) -> None:
    browser, other_browser = Client(), Client()
    platform.launch(browser, user="grace", role="Instructor")
    platform.launch(other_browser, user="grace", role="Instructor")
    assert other_browser.get("/lti/choose").status_code == 400  # staff, but without a request of the platform
    platform.launch(browser, user="grace", role="Learner")
    assert _find_people()["grace"][1] == "student"
    assert other_browser.get("/lti/choose").status_code == 401
    assert browser.get("/lti/choose").status_code == 404


@pytest.mark.parametrize(
    "roles",
    [
        ["http://purl.imsglobal.org/vocab/lis/v2/institution/person#Instructor"],
        ["http://purl.imsglobal.org/vocab/lis/v2/system/person#Administrator"],
        ["http://purl.imsglobal.org/vocab/lis/v2/membership/Learner#Instructor"],
        ["http://purl.imsglobal.org/vocab/lis/v2/membership#Mentor"],
        ["http://evil.example/vocab/lis/v2/membership#Instructor", 7, None, {}],
        [],
    ],
)
def test_no_other_role_makes_a_teacher(platform: Platform, roles: list[object]) -> None:
    platform.launch(Client(), user="grace", role="Instructor")
    answer = platform.launch(Client(), user="mallory", roles=roles)
    is_learner = any("Learner#" in str(role) for role in roles)
    assert answer.status_code in ((302,) if is_learner else (400, 403))
    assert _find_people().get("mallory", ("", "student"))[1] == "student"


@pytest.mark.parametrize("role", ["Instructor", "Learner"])
def test_another_course_gets_nothing_before_it_is_connected(platform: Platform, role: str) -> None:
    platform.launch(Client(), user="grace", role="Instructor")
    browser = Client()
    assert platform.launch(browser, user="eve", role=role, course="c2").status_code == 403
    assert "person" not in browser.session
    connect_course(Classroom.objects.get(lti_context__id_on_platform="c2"))
    assert platform.launch(browser, user="eve", role=role, course="c2").status_code == 302
    assert set(_find_people("c2")) == {"eve"}
    assert set(_find_people()) == {"grace"}


def test_another_deployment_is_another_course_that_isn_t_connected(platform: Platform) -> None:
    platform.launch(Client(), user="grace", role="Instructor")
    assert platform.launch(Client(), user="ada", deployment_id="d2").status_code == 403
    assert platform.launch(Client(), user="ada", deployment_id="").status_code == 400


def _sign_confused(platform: Platform, claims: dict[str, Any]) -> str:
    """Sign with our public key as if it were a shared secret (HS256)."""
    import base64
    import hashlib
    import hmac

    def encode(data: bytes) -> str:
        return base64.urlsafe_b64encode(data).rstrip(b"=").decode()

    header = {"alg": "HS256", "kid": "first", "typ": "JWT"}
    text = f"{encode(json.dumps(header).encode())}.{encode(json.dumps(claims).encode())}"
    digest = hmac.new(platform.keys[0].export_to_pem(), text.encode(), hashlib.sha256).digest()
    return f"{text}.{encode(digest)}"


_NOW = time.time
_WRONG: dict[str, Callable[[Platform, dict[str, Any]], str]] = {
    "signed by a foreign key": lambda p, c: p.sign(c, find_key("foreign")),
    "signed by a foreign key under the platform's name": lambda p, c: p.sign(c, find_key("foreign"), kid="first"),
    "not signed": lambda p, c: jwt.encode(c, None, algorithm="none", headers={"kid": "first"}),  # type: ignore[arg-type]
    "signed with the public key as a secret": _sign_confused,
    "for another tool": lambda p, c: p.sign({**c, "aud": "client-2"}),
    "for several tools, of which another one is meant": lambda p, c: p.sign(
        {**c, "aud": [p.client_id, "client-2"], "azp": "client-2"}
    ),
    "for several tools, of which none is named": lambda p, c: p.sign({**c, "aud": [p.client_id, "client-2"]}),
    "without an audience": lambda p, c: p.sign({**c, "aud": []}),
    "of another platform": lambda p, c: p.sign({**c, "iss": "https://canvas.example.edu"}),
    "expired": lambda p, c: p.sign({**c, "exp": int(_NOW()) - 90}),
    "without an expiry": lambda p, c: p.sign({k: v for k, v in c.items() if k != "exp"}),
    "of the future": lambda p, c: p.sign({**c, "iat": int(_NOW()) + 90}),
    "with another nonce": lambda p, c: p.sign({**c, "nonce": "n" * 64}),
    "without a nonce": lambda p, c: p.sign({k: v for k, v in c.items() if k != "nonce"}),
    "of another version": lambda p, c: p.sign({**c, f"{CLAIM}version": "1.1"}),
    "of no person": lambda p, c: p.sign({k: v for k, v in c.items() if k != "sub"}),
    "without a course": lambda p, c: p.sign({k: v for k, v in c.items() if k != f"{CLAIM}context"}),
    "no message": lambda p, c: "a.b.c",
    "a list": lambda p, c: ".".join([p.sign(c).split(".")[0], "W10", "AA"]),
    "with a list as its header": lambda p, c: ".".join(["W10", *p.sign(c).split(".")[1:]]),
    "with numbers for texts": lambda p, c: p.sign({**c, "aud": {"a": 1}, "nonce": [1], "sub": {}}),
}


@pytest.mark.parametrize("name", _WRONG)
def test_a_wrong_message_is_refused(platform: Platform, name: str) -> None:
    browser = Client()
    answer = platform.launch(browser, lambda claims: _WRONG[name](platform, claims), user="eve", role="Instructor")
    assert answer.status_code == 400
    assert "person" not in browser.session
    assert not LtiUser.objects.exists()


def test_clocks_may_differ_by_less_than_a_minute(platform: Platform) -> None:
    now = int(time.time())
    for issued, expires in ((now + 40, now + 600), (now - 600, now - 40)):
        answer = platform.launch(Client(), user="grace", role="Instructor", iat=issued, exp=expires)
        assert answer.status_code == 302


def test_a_launch_is_accepted_once_and_from_the_browser_that_began_it(platform: Platform) -> None:
    browser, thief = Client(), Client()
    login = platform.begin(browser)
    claims = {**platform.make_claims("grace", "Instructor"), "nonce": login["nonce"]}
    form = {"state": login["state"], "id_token": platform.sign(claims)}
    assert thief.post("/lti/launch", form).status_code == 400
    other = platform.begin(thief)
    assert thief.post("/lti/launch", {**form, "state": other["state"]}).status_code == 400
    cookies = {name: cookie.value for name, cookie in browser.cookies.items()}
    assert browser.post("/lti/launch", form).status_code == 302
    assert browser.post("/lti/launch", form).status_code == 400  # the cookie is gone
    for name, value in cookies.items():
        thief.cookies[name] = value
    assert thief.post("/lti/launch", form).status_code == 400  # even with the cookie
    assert "person" not in thief.session


def test_a_login_ends_after_five_minutes(platform: Platform, monkeypatch: pytest.MonkeyPatch) -> None:
    browser = Client()
    login = platform.begin(browser)
    claims = {**platform.make_claims("grace", "Instructor"), "nonce": login["nonce"]}
    form = {"state": login["state"], "id_token": platform.sign({**claims, "exp": int(time.time()) + 4000})}
    real = time.time
    monkeypatch.setattr(time, "time", lambda: real() + 301)
    assert browser.post("/lti/launch", form).status_code == 400


def test_a_person_who_was_signed_in_before_isn_t_any_more(platform: Platform) -> None:
    browser = Client()
    platform.launch(browser, user="grace", role="Instructor")
    old_session, old_person = browser.session.session_key, browser.session["person"]
    platform.launch(browser, user="ada")
    assert browser.session.session_key != old_session
    assert browser.session["person"] != old_person


def test_keys_of_the_platform_are_fetched_again_when_they_change(platform: Platform) -> None:
    for _ in range(3):
        platform.launch(Client(), user="grace", role="Instructor")
    assert platform.asked.count("GET /keys") == 1
    platform.keys = [find_key("second")]
    assert platform.launch(Client(), user="grace", role="Instructor").status_code == 302
    assert platform.asked.count("GET /keys") == 2
    for _ in range(3):  # a message with an unknown key doesn't make us ask the platform each time
        assert platform.launch(Client(), lambda claims: platform.sign(claims, find_key("foreign"))).status_code == 400
    assert platform.asked.count("GET /keys") == 2


def test_a_login_goes_to_the_registered_platform_only(platform: Platform) -> None:
    row = LtiRegistration.objects.get()
    query = {"iss": platform.site, "login_hint": "1", "target_link_uri": "https://evil.example/"}
    query["lti1p3_new_window"] = "1"
    answer = Client().post(f"/lti/login/{row.uuid}", query)
    assert "evil" not in answer["Location"]
    assert Client().get(f"/lti/login/{row.uuid}", {**query, "iss": "https://evil.example"}).status_code == 400
    assert Client().get("/lti/login/00000000-0000-4000-8000-000000000000", query).status_code == 404
    row.is_active = False
    row.save()
    assert Client().get(f"/lti/login/{row.uuid}", query).status_code == 404


# --- launches in a frame without cookies ---


def _prepare_launch(platform: Platform, **login: str) -> dict[str, str]:
    """Begin a login in a frame, and return what our page posts after it has read the proof."""
    page = platform.open_frame(Client(), **{"lti_storage_target": "storage", **login})
    claims = {**platform.make_claims("grace", "Instructor"), "nonce": page["nonce"], "exp": int(time.time()) + 4000}
    return {"state": page["key"], "id_token": platform.sign(claims), "proof": page["value"]}


def _post(form: dict[str, str], path: str = "/lti/launch", origin: str | None = TOOL) -> Any:
    headers = {"Origin": origin} if origin else {}
    return Client(enforce_csrf_checks=True).post(path, urlencode(form), FORM_TYPE, headers=headers)


def _find_fields(page: Any) -> dict[str, str]:
    return dict(re.findall(r'name="([\w-]+)" (?:value|content)="([^"]*)"', page.content.decode()))


def test_a_proof_from_the_platform_s_storage_signs_in_without_a_cookie(platform: Platform) -> None:
    answer = _post(_prepare_launch(platform))
    fields = _find_fields(answer)
    assert 'action="/a/velocity/class/"' in answer.content.decode()
    assert fields == {"session": Session.objects.get().session_key, "method": "GET"}
    page = _post(fields, "/a/velocity/class/")
    assert page.status_code == 200 and _find_fields(page)["session"] == fields["session"]
    results = Client().get("/a/velocity/class/results", headers={"X-Session": fields["session"]})
    assert results.json()["title"] == "Velocity kinematics"


@pytest.mark.parametrize("origin", [None, "null", "https://moodle.example.edu", f"{TOOL}.evil.example"])
def test_a_proof_counts_only_from_our_own_page(platform: Platform, origin: str | None) -> None:
    assert _post(_prepare_launch(platform), origin=origin).status_code == 400
    assert not Session.objects.exists()


def test_only_the_proof_of_the_same_login_counts_once_and_for_five_minutes(
    platform: Platform, monkeypatch: pytest.MonkeyPatch
) -> None:
    form, other, late = (_prepare_launch(platform) for _ in range(3))
    for proof in (other["proof"], form["state"], launch.compute_nonce(form["state"]), "x"):
        assert _post({**form, "proof": proof}).status_code == 400
    assert _post({**form, "state": other["state"], "proof": other["proof"]}).status_code == 400
    assert not Session.objects.exists()
    assert _post(form).status_code == 200
    assert _post(form).status_code == 400
    real = time.time
    monkeypatch.setattr(time, "time", lambda: real() + 301)
    assert _post(late).status_code == 400
    assert Session.objects.count() == 1


def test_a_launch_without_a_cookie_only_answers_with_the_page_that_reads_the_proof(platform: Platform) -> None:
    form = _prepare_launch(platform)
    message = {name: form[name] for name in ("state", "id_token")}
    for _ in range(2):
        page = _post(message, origin=platform.site)
        assert _find_fields(page).items() >= message.items()
        assert form["proof"] not in page.content.decode()
        assert 'data-platform="https://moodle.example.edu/auth" data-frame="storage"' in page.content.decode()
    assert not Session.objects.exists()
    assert _post(form).status_code == 200  # the message is not used up
    for state in ("", "state-x", f"{message['state']}x"):
        assert _post({**message, "state": state}).status_code == 400


@pytest.mark.parametrize("frame", ["", "a b", '"><script>', "x" * 100])
def test_without_a_storage_nobody_gets_a_proof(platform: Platform, frame: str) -> None:
    page = platform.open_frame(Client(), lti_storage_target=frame)
    assert page["frame"] == "" and "value" not in page
    assert _post({"state": page["key"], "id_token": "x"}).status_code == 400


def test_no_address_contains_the_proof(platform: Platform) -> None:
    page = platform.open_frame(Client(), lti_storage_target="_parent")
    assert len(page["value"]) == 64
    assert page["value"] not in page["url"] + page["tab"] + page["key"]


def test_the_page_that_tries_cookies_runs_only_the_site_s_script(platform: Platform) -> None:
    row = LtiRegistration.objects.get()
    hint = '"><script>alert(1)</script>'
    query = {"iss": platform.site, "login_hint": hint, "target_link_uri": TOOL}
    answer = Client().get(f"/lti/login/{row.uuid}", query)
    assert answer.status_code == 200
    assert "<script>alert" not in answer.content.decode()
    assert "script-src 'self';" in answer["Content-Security-Policy"]
    assert re.search(r"frame-ancestors .*moodle\.example\.edu", answer["Content-Security-Policy"])
    assert Client().get(platform.open_frame(Client())["tab"]).status_code == 302


# --- our keys ---


def test_a_new_key_is_published_before_it_signs_and_an_old_one_stays_for_a_while() -> None:
    start = timezone.now()
    first = find_signing_key(start)
    later = start + datetime.timedelta(days=181)
    renew_keys(later)
    second = Key.objects.order_by("pk").last()
    Key.objects.filter(pk=second.pk).update(datetime_created=later)
    renew_keys(later)
    assert Key.objects.count() == 2
    assert find_signing_key(later + datetime.timedelta(hours=23)) == first
    assert find_signing_key(later + datetime.timedelta(hours=25)) == second
    names = [key["kid"] for key in Client().get("/lti/keys").json()["keys"]]
    assert len(set(names)) == 2
    renew_keys(later + datetime.timedelta(days=15))
    assert [key.pk for key in Key.objects.active()] == [second.pk]
    assert "PRIVATE" not in Client().get("/lti/keys").content.decode()
    assert all("d" not in key for key in Client().get("/lti/keys").json()["keys"])


# --- registering ---


def test_a_platform_registers_itself_once_at_the_address_that_was_printed(platform: Platform) -> None:
    LtiRegistration.objects.all().delete()
    row = begin_registration("moodle", platform.site)
    assert f"/lti/register/{row.uuid}" in describe_registration_steps("moodle", row, "")
    query = {"openid_configuration": f"{platform.site}/openid", "registration_token": "once"}
    assert Client().get("/lti/register/00000000-0000-4000-8000-000000000000", query).status_code == 404
    assert Client().get(f"/lti/register/{row.uuid}", {"openid_configuration": "file:///etc/passwd"}).status_code == 400
    answer = Client().get(f"/lti/register/{row.uuid}", query)
    assert answer.status_code == 200
    assert "org.imsglobal.lti.close" in answer.content.decode()
    assert Client().get(f"/lti/register/{row.uuid}", query).status_code == 404
    assert platform.registered["initiate_login_uri"] == f"{TOOL}/lti/login/{row.uuid}"
    assert platform.launch(Client(), user="grace", role="Instructor").status_code == 302


def test_a_registration_asks_only_the_server_that_the_operator_named(platform: Platform) -> None:
    LtiRegistration.objects.all().delete()
    row = begin_registration("moodle", platform.site)
    internal = "http://169.254.169.254/latest"
    for address in (internal, f"{platform.site}.evil.example/openid", f"{platform.site}@evil.example/openid"):
        query = {"openid_configuration": address, "registration_token": "once"}
        assert Client().get(f"/lti/register/{row.uuid}", query).status_code == 400
    assert platform.asked == []
    answer = platform.answer
    changes: list[dict[str, Any]] = [{"status_code": 302, "headers": {"Location": internal}, "_content": b""}]
    changes.append({"_content": json.dumps({"registration_endpoint": internal}).encode()})
    for change in changes:
        platform.answer = lambda request, change=change: _change(answer(request), change)  # type: ignore[method-assign,misc]
        query = {"openid_configuration": f"{platform.site}/openid", "registration_token": "once"}
        assert Client().get(f"/lti/register/{row.uuid}", query).status_code == 400
    assert platform.asked == ["GET /openid"] * len(changes)


def _change(response: requests.Response, attributes: dict[str, Any]) -> requests.Response:
    vars(response).update(attributes)
    return response


def test_a_platform_adds_nothing_to_our_headers(platform: Platform) -> None:
    LtiRegistration.objects.update(issuer="https://x; report-uri https://evil.example")
    policy = Client().get("/")["Content-Security-Policy"]
    assert "evil" not in policy and platform.site in policy


def test_a_platform_that_doesn_t_answer_holds_up_few_launches(platform: Platform) -> None:
    platform.launch(Client(), user="grace", role="Instructor")
    cache.clear()
    with ExitStack() as stack:
        for _ in range(4):
            stack.enter_context(launch._fetches)
        assert platform.launch(Client(), user="grace", role="Instructor").status_code == 400
    assert platform.launch(Client(), user="grace", role="Instructor").status_code == 302


def test_an_address_of_registration_works_for_a_week(platform: Platform) -> None:
    row = begin_registration("moodle", "https://other.example.edu")
    LtiRegistration.objects.filter(pk=row.pk).update(datetime_created=timezone.now() - datetime.timedelta(days=8))
    query = {"openid_configuration": f"{platform.site}/openid", "registration_token": "once"}
    assert Client().get(f"/lti/register/{row.uuid}", query).status_code == 404


@pytest.mark.parametrize("kind", ["canvas", "moodle", "brightspace", "blackboard", "sakai"])
def test_every_kind_of_platform_is_registered_by_hand(kind: str) -> None:
    site = "https://lms.example.edu"
    row = begin_registration(kind, site + "/")
    words = describe_registration_steps(kind, row, "qdot serve register hw")
    assert f"{TOOL}/lti/login/{row.uuid}" in words and f"{TOOL}/lti/keys" in words
    assert ("/lti/register/" in words) == (kind != "blackboard")
    finished = finish_registration(kind, CopiedValues(site, "abc"))
    assert finished.is_active and finished.pk == row.pk and "{" not in finished.keyset_url + finished.auth_url
    with pytest.raises(QdotError, match="must not be registered yet"):
        begin_registration(kind, "https://second.example.edu")
        finish_registration(kind, CopiedValues("https://second.example.edu", "abc", issuer=finished.issuer))
    with pytest.raises(QdotError, match="whole address"):
        begin_registration(kind, "lms.example.edu")


# --- deep linking ---


def _choose(platform: Platform, browser: Client, choice: str, role: str = "Instructor") -> Any:
    dl = "https://purl.imsglobal.org/spec/lti-dl/claim/"
    wishes = {
        "deep_link_return_url": f"{platform.site}/return?a=1&b=2", "accept_types": ["ltiResourceLink"],
        "accept_presentation_document_targets": ["iframe"], "data": "as it was",
    }  # fmt: skip
    more: dict[str, Any] = {"message_type": "LtiDeepLinkingRequest", "resource_link": None}
    more[f"{dl}deep_linking_settings"] = wishes
    answer = platform.launch(browser, user="grace", role=role, **more)
    return browser.post("/lti/choose", {"choice": choice}) if answer.status_code == 302 else answer


@pytest.mark.parametrize(("choice", "points"), [("velocity", 4), ("velocity/p1.jacobian", 3)])
def test_a_teacher_chooses_an_assignment_or_a_question(platform: Platform, choice: str, points: float) -> None:
    browser = Client()
    answer = _choose(platform, browser, choice)
    html = answer.content.decode()
    assert f'action="{platform.site}/return?a=1&amp;b=2"' in html
    token = re.search(r'name="JWT" value="([^"]+)"', html)
    assert token is not None
    key = jwt.PyJWK(Client().get("/lti/keys").json()["keys"][0])
    claims = jwt.decode(token[1], key.key, algorithms=["RS256"], audience=platform.site)
    (item,) = claims["https://purl.imsglobal.org/spec/lti-dl/claim/content_items"]
    assert claims["https://purl.imsglobal.org/spec/lti-dl/claim/data"] == "as it was"
    assert item["lineItem"]["scoreMaximum"] == points
    assert item["lineItem"]["resourceId"] == choice
    launched = platform.launch(Client(), user="ada", target_link_uri=item["url"])
    assert TOOL + launched["Location"] == item["url"]
    assert browser.post("/lti/choose", {"choice": choice}).status_code == 400  # answered once


def test_only_a_teacher_chooses_and_only_what_there_is(platform: Platform) -> None:
    browser = Client()
    assert _choose(platform, browser, "velocity/../../x").status_code == 400
    assert _choose(platform, browser, "velocity", role="Learner").status_code == 403
    assert browser.get("/lti/choose").status_code == 404


# --- class lists ---


def _make_member(user: str, role: str = "Learner", **more: Any) -> dict[str, Any]:
    return {"user_id": user, "roles": [MEMBERSHIP + role], "name": user.title(), "email": f"{user}@example.edu", **more}


def _work_off(seconds: float = 0) -> None:
    """Send what is to be sent, as if some seconds had passed."""
    now = timezone.now() + datetime.timedelta(seconds=seconds)
    outbox.send_scores(outbox._connections, now)
    outbox.read_class_lists(outbox._connections, now)


@pytest.mark.parametrize("page_size", [1, 100])
def test_the_class_list_becomes_the_class_and_people_who_left_become_inactive(
    platform: Platform, page_size: int
) -> None:
    platform.page_size = page_size
    platform.members = [
        _make_member("grace", "Instructor"), _make_member("ada", email="ada@example.edu"),
        _make_member("u2", email="other@example.edu", lis_person_sourcedid="henri"), _make_member("u3"),
        _make_member("gone", status="Inactive"), _make_member("parent", "Mentor"),
    ]  # fmt: skip
    platform.launch(Client(), user="grace", role="Instructor")
    _work_off()
    people = _find_people()
    assert {user: person[1:] for user, person in people.items()} == {
        "grace": ("staff", True), "ada": ("student", True), "u2": ("student", True), "u3": ("student", True),
    }  # fmt: skip
    assert (people["ada"][0], people["u2"][0]) == ("ada", "henri")
    platform.members = [_make_member("grace", "Learner"), _make_member("u3")]
    _work_off(60)
    assert _find_people()["ada"][2]  # the list is read again after a day
    _work_off(90_000)
    people = _find_people()
    assert [people[user][2] for user in ("grace", "ada", "u2", "u3")] == [True, False, False, True]
    assert people["grace"][1] == "student"
    assert people["ada"][0] == "ada"


def test_a_class_list_that_can_t_be_read_changes_nothing(platform: Platform) -> None:
    platform.members = [_make_member("grace", "Instructor"), _make_member("ada")]
    platform.launch(Client(), user="grace", role="Instructor")
    _work_off()
    before = _find_people()
    for trouble in (500, 403, requests.ConnectionError("down")):
        platform.launch(Client(), user="grace", role="Instructor")
        platform.failures = [trouble]
        _work_off()
        assert _find_people() == before
    platform.members = []
    _work_off(90_000)
    assert _find_people() == before


# --- scores ---


def _set_points(user: str, points: float, part: str = "") -> None:
    person = Person.objects.get(lti_user__sub=user)
    row: dict[str, Any] = {"classroom": person.classroom, "assignment": "velocity", "person": person, "part": part}
    PointsOverride.objects.update_or_create(**row, defaults={"points": points})
    update_scores(person, "velocity")


@pytest.fixture
def course(platform: Platform) -> Platform:
    platform.launch(Client(), user="grace", role="Instructor")
    for user in ("ada", "henri"):
        platform.launch(Client(), user=user)
    return platform


def test_scores_arrive_at_once_and_again_when_they_change(course: Platform) -> None:
    _work_off()
    assert course.scores == []  # nobody has submitted anything
    _set_points("ada", 3)
    _work_off()
    _work_off(3600)
    assert course.list_points() == [("ada", 3)]
    assert course.scores[0]["scoreMaximum"] == 4
    assert course.scores[0]["column"] == "/c1/columns/1"
    _set_points("ada", 2)
    _set_points("ada", 2)
    _work_off(1.1)
    assert course.list_points() == [("ada", 3), ("ada", 2)]
    _set_points("ada", 2)
    _work_off(3600)
    assert course.list_points() == [("ada", 3), ("ada", 2)]


@pytest.mark.parametrize(
    "trouble", sample_for_suite([requests.ConnectionError("down"), requests.Timeout(), 500, 503, 429], 1)
)
def test_a_platform_that_is_down_loses_nothing_and_is_asked_ever_more_rarely(
    course: Platform, trouble: int | Exception
) -> None:
    for user in ("ada", "henri"):
        _set_points(user, 2)
    course.failures = [trouble] * 100_000
    start, tries = timezone.now(), [0.0]
    while tries[-1] < 20_000:
        _work_off(tries[-1])
        next_try = ScoreDelivery.objects.earliest("next_try").next_try
        assert next_try is not None
        tries.append((next_try - start).total_seconds())
    assert course.scores == []
    assert len(tries) < 90
    assert tries[1] < 60 and tries[-1] - tries[-2] > 2_000
    assert all(row.last_error for row in ScoreDelivery.objects.all())
    course.failures = []
    _work_off(90_000)
    _work_off(90_001)
    assert sorted(course.list_points()) == [("ada", 2), ("henri", 2)]


@pytest.mark.parametrize("trouble", sample_for_suite([404, 403, 400, 401, 409, 422], 1))
def test_a_score_that_the_platform_keeps_refusing_is_left_to_the_staff(course: Platform, trouble: int) -> None:
    for user in ("ada", "henri"):
        _set_points(user, 2)
    course.refusal = trouble
    for step in range(outbox.MAX_REFUSALS - 1):
        _work_off(30 * 2**step)
        assert not ScoreDelivery.objects.filter(next_try=None).exists()
    _work_off(30 * 2**outbox.MAX_REFUSALS)
    assert not ScoreDelivery.objects.exclude(next_try=None).exists()
    staff = Client()
    course.launch(staff, user="grace", role="Instructor")
    refused = staff.get("/a/velocity/class/results").json()["refused"]
    assert len(refused) == 2 and str(trouble) in refused[0]["error"]
    course.refusal = 0
    _set_points("henri", 1)  # a new score is tried
    assert staff.post("/a/velocity/class/scores").status_code == 200
    assert staff.get("/a/velocity/class/results").json()["refused"] == []
    _work_off(100_000)
    assert sorted(course.list_points()) == [("ada", 2), ("henri", 1)]


def test_the_first_score_that_arrives_after_a_failure_brings_the_others(course: Platform) -> None:
    _set_points("ada", 2)
    course.failures = [requests.ConnectionError("down")] * 20
    for hours in range(8):
        _work_off(3600 * hours)
        course.failures = course.failures or [requests.ConnectionError("down")]
    course.failures = []
    _set_points("henri", 1)
    _work_off(2)
    _work_off(3)
    assert sorted(course.list_points()) == [("ada", 2), ("henri", 1)]


def test_an_access_token_that_has_ended_is_replaced(course: Platform) -> None:
    _set_points("ada", 2)
    _work_off()
    course.tokens.clear()
    _set_points("henri", 1)
    _work_off()
    assert course.list_points() == [("ada", 2), ("henri", 1)]


def test_a_score_that_arrived_without_our_knowing_is_not_stuck(course: Platform) -> None:
    _set_points("ada", 2)
    _work_off()
    row = ScoreDelivery.objects.get(person__lti_user__sub="ada")
    ScoreDelivery.objects.filter(pk=row.pk).update(next_try=row.timestamp, sent=None)  # killed before it was noted
    _work_off()
    assert course.list_points() == [("ada", 2)]
    _work_off(60)
    assert course.list_points() == [("ada", 2), ("ada", 2)]
    assert ScoreDelivery.objects.get(pk=row.pk).next_try is None


def test_nothing_is_sent_for_a_person_who_has_left_the_course(course: Platform) -> None:
    Person.objects.filter(lti_user__sub="ada").update(is_active=False)
    _set_points("ada", 2)
    _work_off()
    assert course.scores == []
    course.launch(Client(), user="ada")
    _work_off()
    assert course.list_points() == [("ada", 2)]


def test_a_score_that_changes_while_it_is_being_sent_is_sent_again(course: Platform) -> None:
    answer = course.answer

    def change_meanwhile(request: requests.PreparedRequest) -> requests.Response:
        response = answer(request)
        if str(request.url).split("?")[0].endswith("/scores") and len(course.scores) == 1:
            _set_points("ada", 4)
        return response

    course.answer = change_meanwhile  # type: ignore[method-assign]
    _set_points("ada", 3)
    _work_off()
    _work_off(5)
    assert course.list_points() == [("ada", 3), ("ada", 4)]


def test_another_process_doesn_t_send_the_same_score(course: Platform) -> None:
    answer = course.answer

    def send_twice(request: requests.PreparedRequest) -> requests.Response:
        if str(request.url).split("?")[0].endswith("/scores") and not course.scores:
            course.answer = answer  # type: ignore[method-assign]
            _work_off()
        return answer(request)

    course.answer = send_twice  # type: ignore[method-assign]
    _set_points("ada", 3)
    _work_off()
    assert course.list_points() == [("ada", 3)]


def test_nothing_is_sent_for_people_or_courses_that_the_platform_never_introduced(platform: Platform) -> None:
    platform.launch(Client(), user="grace", role="Instructor")
    for person in update_folder_class().people.all():
        update_scores(person, "velocity")
    assert not ScoreDelivery.objects.exists()


def test_a_column_of_one_question_gets_the_points_of_the_question(platform: Platform) -> None:
    target = f"{TOOL}/a/velocity/?part=p1.jacobian"
    platform.launch(Client(), user="grace", role="Instructor", target_link_uri=target)
    platform.launch(Client(), user="ada", target_link_uri=target)
    _set_points("ada", 1.5, "p1.jacobian")
    _set_points("ada", 1, "p1.position")
    _work_off(5)
    assert [(score["scoreGiven"], score["scoreMaximum"]) for score in platform.scores] == [(1.5, 3)]


def test_a_column_is_made_where_the_platform_made_none_and_gets_earlier_scores(platform: Platform) -> None:
    endpoint = {
        "scope": [f"{AGS}scope/score", f"{AGS}scope/lineitem"], "lineitems": f"{platform.site}/c1/columns",
    }  # fmt: skip
    claims: dict[str, Any] = {f"{AGS}claim/endpoint": endpoint, "target_link_uri": f"{TOOL}/"}
    for user, role in (("grace", "Instructor"), ("ada", "Learner"), ("grace", "Instructor")):
        platform.launch(Client(), user=user, role=role, **claims)
    assert [column["resourceLinkId"] for column in platform.columns] == ["c1-link"]
    _set_points("ada", 2)
    _work_off()
    assert [score["column"] for score in platform.scores] == ["/c1/columns/made1"]


def test_messages_of_the_form_that_canvas_documents(platform: Platform) -> None:
    platform.site, platform.issuer = "https://canvas.example.edu", "https://canvas.instructure.com"
    LtiRegistration.objects.all().delete()
    platform.register()
    claims = json.loads((DATA / "canvas_launch.json").read_text(encoding="utf-8"))
    vocabulary = "http://purl.imsglobal.org/vocab/lis/v2/"

    def launch_as(name: str, role: str) -> Any:
        roles = [f"{vocabulary}{kind}#{role}" for kind in ("institution/person", "membership")]
        email, azp = f"{name}@example.edu", platform.client_id
        return platform.launch(Client(), user=f"535fa085-{name}", email=email, azp=azp, roles=roles, **claims)

    assert launch_as("grace", "Instructor")["Location"] == "/a/velocity/class/"
    assert launch_as("ada", "Learner")["Location"] == "/a/velocity/"
    more: dict[str, Any] = {"picture": f"{platform.site}/p.png", "given_name": "A", "family_name": "B"}
    more["status"] = "Active"
    platform.members = [
        _make_member("535fa085-grace", "Instructor", **more),
        _make_member("535fa085-henri", **{**more, "email": "henri@example.edu", "lis_person_sourcedid": None}),
        _make_member("535fa085-ada", **{**more, "email": "ada@example.edu"}),
    ]
    _work_off()
    assert {person[:2] for person in _find_people("4dde").values()} >= {("ada", "student"), ("henri", "student")}
    _set_points("535fa085-ada", 3)
    _work_off()
    sent = [(score["column"], score["scoreGiven"]) for score in platform.scores]
    assert sent == [("/api/lti/courses/1/line_items/5", 3)]


def test_a_submission_review_opens_the_student_s_work(course: Platform) -> None:
    ada = Person.objects.get(lti_user__sub="ada")
    review: dict[str, Any] = {"message_type": "LtiSubmissionReviewRequest", "for_user": {"user_id": "ada"}}
    assert course.launch(Client(), user="grace", role="Instructor", **review)["Location"].endswith(
        f"/a/velocity/class/?student={ada.pk}"
    )
    assert course.launch(Client(), user="henri", **review)["Location"] == "/a/velocity/"
