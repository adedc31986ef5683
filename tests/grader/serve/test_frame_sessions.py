"""Sessions in a frame without cookies: who may send their key, and when they end."""

import re
from collections.abc import Callable
from typing import Any
from urllib.parse import urlencode

import pytest
from django.conf import settings
from django.test import Client

from qdot.grader.serve.forgetting_online import forget_people
from qdot.grader.serve.frame_requests import FORM_TYPE
from qdot.grader.serve.personal_links import make_link
from tests.grader.serve.test_access import METHODS, ROUTES, fill_route
from tests.support.serving import Browser, Service

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
