"""A learning platform of our own: it signs launches, and answers our requests without a network.

Requests that qdot sends are answered by `Platform.answer`, in place of the transport of the library `requests`.
"""

import html
import json
import re
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache
from typing import Any
from urllib.parse import parse_qs, urlsplit

import jwt
import requests
from django.test import Client
from jwcrypto.jwk import JWK
from lti_tool.models import LtiRegistration

CLAIM = "https://purl.imsglobal.org/spec/lti/claim/"
AGS = "https://purl.imsglobal.org/spec/lti-ags/"
MEMBERSHIP = "http://purl.imsglobal.org/vocab/lis/v2/membership#"
TOOL = "http://testserver"
Json = dict[str, Any]


@dataclass
class Platform:
    """A platform with courses, people and gradebooks; `failures` are the answers to the next requests for services."""

    site: str = "https://moodle.example.edu"
    issuer: str = "https://moodle.example.edu"
    client_id: str = "client-1"
    keys: list[JWK] = field(default_factory=lambda: [find_key("first")])
    members: list[Json] = field(default_factory=list)
    failures: list[int | Exception] = field(default_factory=list)
    refusal: int = 0
    """The status with which the gradebook refuses every score, if it does."""
    columns: list[Json] = field(default_factory=list)
    scores: list[Json] = field(default_factory=list)
    asked: list[str] = field(default_factory=list)
    tokens: set[str] = field(default_factory=set)
    page_size: int = 100
    registered: Json = field(default_factory=dict)

    def make_claims(self, user: str = "ada", role: str = "Learner", course: str = "c1", **more: Any) -> Json:
        """Return what a launch says, but for its nonce. Names in `more` that begin with no scheme are LTI's."""
        now = int(time.time())
        claims = {
            "iss": self.issuer, "aud": self.client_id, "sub": user, "iat": now, "exp": now + 600,
            "name": user.title(), "email": f"{user}@example.edu",
            f"{CLAIM}message_type": "LtiResourceLinkRequest", f"{CLAIM}version": "1.3.0",
            f"{CLAIM}deployment_id": "d1", f"{CLAIM}target_link_uri": f"{TOOL}/a/velocity/",
            f"{CLAIM}resource_link": {"id": f"{course}-link", "title": "Homework"},
            f"{CLAIM}roles": [MEMBERSHIP + role] if role else [],
            f"{CLAIM}context": {"id": course, "title": f"Course {course}"},
            f"{AGS}claim/endpoint": {
                "scope": [f"{AGS}scope/score", f"{AGS}scope/lineitem"],
                "lineitems": f"{self.site}/{course}/columns", "lineitem": f"{self.site}/{course}/columns/1?type=2",
            },
            "https://purl.imsglobal.org/spec/lti-nrps/claim/namesroleservice": {
                "context_memberships_url": f"{self.site}/{course}/members", "service_versions": ["2.0"],
            },
        }  # fmt: skip
        claims.update({name if ":" in name or name in claims else f"{CLAIM}{name}": more[name] for name in more})
        return {name: value for name, value in claims.items() if value is not None}

    def begin(self, client: Client, **more: str) -> dict[str, str]:
        """Begin a login in a browser; return the parameters with which qdot sends it back."""
        registration = LtiRegistration.objects.get(client_id=self.client_id)
        query = {"iss": self.issuer, "login_hint": "1", "target_link_uri": TOOL, "lti1p3_new_window": "1", **more}
        answer = client.get(f"/lti/login/{registration.uuid}", query)
        assert answer.status_code == 302, answer.content
        assert answer["Location"].startswith(f"{self.site}/auth?")
        return {name: values[0] for name, values in parse_qs(urlsplit(answer["Location"]).query).items()}

    def open_frame(self, client: Client, **more: str) -> dict[str, str]:
        """Begin a login in a frame; return what the page that qdot answers with has for its script, and its nonce."""
        registration = LtiRegistration.objects.get(client_id=self.client_id)
        query = {"iss": self.issuer, "login_hint": "1", "target_link_uri": TOOL, **more}
        page = client.get(f"/lti/login/{registration.uuid}", query).content.decode()
        data = {name: html.unescape(text) for name, text in re.findall(r'data-(\w+)="([^"]*)"', page)}
        (data["tab"],) = map(html.unescape, re.findall('href="(/lti/[^"]*)"', page))
        return {**data, "nonce": parse_qs(urlsplit(data["url"]).query)["nonce"][0]}

    def sign(self, claims: Json, key: JWK | None = None, **header: str) -> str:
        key = key or self.keys[-1]
        return jwt.encode(claims, key.get_op_key("sign"), algorithm="RS256", headers={"kid": key.get("kid"), **header})

    def launch(self, client: Client, sign: Callable[[Json], str] | None = None, **claims: Any) -> Any:
        """Launch in a browser; `sign` makes the message of the claims."""
        login = self.begin(client)
        message = {**self.make_claims(**claims), "nonce": login["nonce"]}
        return client.post("/lti/launch", {"state": login["state"], "id_token": (sign or self.sign)(message)})

    def register(self) -> None:
        urls = {"auth_url": f"{self.site}/auth", "token_url": f"{self.site}/token", "keyset_url": f"{self.site}/keys"}
        LtiRegistration.objects.create(name=self.site, issuer=self.issuer, client_id=self.client_id, **urls)

    def answer(self, request: requests.PreparedRequest) -> requests.Response:
        """Answer a request of qdot's, as an HTTPAdapter does."""
        assert request.url is not None
        path, query = urlsplit(request.url).path, parse_qs(urlsplit(request.url).query)
        self.asked.append(f"{request.method} {path}")
        if path == "/keys":
            return _respond(request, 200, {"keys": [make_public(key) for key in self.keys]})
        if path == "/openid":
            endpoints = {"authorization_endpoint": "auth", "token_endpoint": "token", "jwks_uri": "keys"}
            urls = {
                name: f"{self.site}/{path}" for name, path in {**endpoints, "registration_endpoint": "tools"}.items()
            }
            return _respond(request, 200, {"issuer": self.site, **urls})
        if path == "/tools":
            self.registered = _read(request)
            assert request.headers["Authorization"] == "Bearer once"
            return _respond(request, 200, {**self.registered, "client_id": self.client_id})
        if self.failures:
            failure = self.failures.pop(0)
            if isinstance(failure, Exception):
                raise failure
            return _respond(request, failure, {"error": "as the test wants it"})
        if path == "/token":
            self._check_assertion(str(request.body))
            self.tokens.add(f"token{len(self.asked)}")
            return _respond(request, 200, {"access_token": f"token{len(self.asked)}", "expires_in": 3600})
        if str(request.headers.get("Authorization", "")).removeprefix("Bearer ") not in self.tokens:
            return _respond(request, 401, {"error": "unknown token"})
        if path.endswith(("/members", "/names_and_roles")):
            start = int(query.get("From", ["0"])[0])
            page, rest = self.members[start : start + self.page_size], self.members[start + self.page_size :]
            link = f'<{self.site}{path}?From={start + self.page_size}>; rel="next"' if rest else ""
            return _respond(request, 200, {"members": page}, Link=link)
        if path.endswith("/columns"):
            if request.method == "POST":
                number = len(self.columns) + 1
                self.columns.append({**_read(request), "id": f"{self.site}{path}/made{number}"})
                return _respond(request, 201, self.columns[-1])
            return _respond(request, 200, self.columns)
        return self._store_score(request, path)

    def _store_score(self, request: requests.PreparedRequest, path: str) -> requests.Response:
        """Store a score unless the one stored is as new, in whole seconds, as Moodle does."""
        if self.refusal:
            return _respond(request, self.refusal, {"error": "as the test wants it"})
        score = {**_read(request), "column": path.removesuffix("/scores")}
        same = [old for old in self.scores if (old["userId"], old["column"]) == (score["userId"], score["column"])]
        if any(old["timestamp"][:19] >= score["timestamp"][:19] for old in same):
            return _respond(request, 409, {"error": "an earlier timestamp"})
        self.scores.append(score)
        return _respond(request, 200, [])

    def _check_assertion(self, body: str) -> None:
        """Check that qdot signed its request for an access token with a key that it publishes."""
        assertion = parse_qs(body)["client_assertion"][0]
        keys = {key["kid"]: key for key in Client().get("/lti/keys").json()["keys"]}
        key = jwt.PyJWK(keys[jwt.get_unverified_header(assertion)["kid"]])
        claims = jwt.decode(assertion, key.key, algorithms=["RS256"], audience=f"{self.site}/token")
        assert claims["iss"] == self.client_id

    def list_points(self) -> list[tuple[str, float | None]]:
        return [(score["userId"], score.get("scoreGiven")) for score in self.scores]


def find_key(name: str) -> JWK:
    return make_keys()[name]


@cache
def make_keys() -> dict[str, JWK]:
    """Make all keys at once, before a test replaces the function that makes them."""
    return {
        name: JWK.generate(kty="RSA", size=2048, kid=name) for name in ("first", "second", "foreign", "own", "own next")
    }


def make_public(key: JWK) -> Json:
    public: Json = {**json.loads(key.export_public()), "alg": "RS256", "use": "sig"}
    return public


def _read(request: requests.PreparedRequest) -> Json:
    body = request.body
    content: Json = json.loads(body if isinstance(body, (str, bytes)) else "")
    return content


def _respond(request: requests.PreparedRequest, status: int, body: object, **headers: str) -> requests.Response:
    response = requests.Response()
    response.status_code, response.url, response.request = status, str(request.url), request
    response.headers.update(headers)
    response._content = json.dumps(body).encode()
    return response
