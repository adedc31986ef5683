"""Imitate GitHub's API on a local socket, and record the repositories, settings and invitations that the real gh sends.

gh talks to the host github.localhost over plain HTTP through the socket in its configuration. Repositories are real
Git repositories.
"""

import base64
import json
import re
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from http.server import BaseHTTPRequestHandler
from pathlib import Path
from socketserver import ThreadingUnixStreamServer
from typing import Any

from tests.support.ci import git

Answer = tuple[int, Any]
NOT_FOUND: Answer = (404, {"message": "Not Found"})


@dataclass
class GitHub:
    """An organisation and the existing logins. `scopes` are the scopes of gh's token.

    `sealed` has the names of each repository's secrets. Their values are missing, because gh encrypts them.
    """

    folder: Path
    organisation: str
    logins: tuple[str, ...]
    scopes: str = "gist, read:org, repo, workflow"
    private: set[str] = field(default_factory=set)
    invited: dict[str, tuple[str, str]] = field(default_factory=dict)
    sealed: dict[str, set[str]] = field(default_factory=dict)
    variables: dict[str, dict[str, str]] = field(default_factory=dict)
    issues: dict[str, list[str]] = field(default_factory=dict)
    changes: list[str] = field(default_factory=list)

    @property
    def environment(self) -> dict[str, str]:
        return {
            "GH_CONFIG_DIR": str(self.folder / "config"), "GH_HOST": "github.localhost", "GH_TOKEN": "of-the-staff",
            "GH_NO_UPDATE_NOTIFIER": "1", "GH_PROMPT_DISABLED": "1",
        }  # fmt: skip

    def bare(self, name: str) -> Path:
        return self.folder / "repositories" / f"{name}.git"

    def answer(self, method: str, path: str, sent: Mapping[str, Any]) -> Answer:
        """Answer a request as GitHub's documentation specifies, and record the changes that the request makes."""
        if path == "/graphql":
            return 200, self._graphql(str(sent["query"]), sent["variables"] if sent.get("variables") else {})
        if method != "GET":
            self.changes.append(f"{method} {path}")
        for pattern, handle in self._routes.items():
            match = re.fullmatch(pattern, f"{method} {path}")
            if match is not None:
                exists = "/" not in match[1] or self.bare(match[1]).exists()
                return handle(sent, *match.groups()) if exists else NOT_FOUND
        return (200, {}) if path == "/" else NOT_FOUND

    @property
    def _routes(self) -> dict[str, Callable[..., Answer]]:
        repository = r"/repos/([\w.-]+/[\w.-]+)"
        return {
            r"GET /users/([\w-]+)": self._get_owner,
            rf"PUT {repository}/collaborators/([\w-]+)": self._invite,
            rf"GET {repository}/actions/secrets/public-key": lambda *_: (200, {"key_id": "1", "key": PUBLIC_KEY}),
            rf"PUT {repository}/actions/secrets/(\w+)": self._store_secret,
            rf"PATCH {repository}/actions/variables/(\w+)": self._change_variable,
            rf"POST {repository}/actions/variables": self._create_variable,
            rf"GET {repository}/issues\?.*": lambda _, name: (200, self._list_issues(name)),
            rf"POST {repository}/issues": self._open_issue,
        }

    def _graphql(self, query: str, arguments: Mapping[str, Any]) -> Any:
        if "createRepository(" in query:
            wanted = arguments["input"]
            name = f"{self.organisation}/{wanted['name']}"
            self.changes.append(f"create {name}")
            git("init", "--quiet", "--bare", self.bare(name))
            if wanted["visibility"] == "PRIVATE" and wanted["ownerId"] == f"O_{self.organisation}":
                self.private.add(name)
            return {"data": {"createRepository": {"repository": self._describe_repository(name)}}}
        if "viewer{" in query:
            return {"data": {"viewer": {"login": "staff"}}}
        name = f"{arguments['owner']}/{arguments['name']}"
        if self.bare(name).exists():
            return {"data": {"repository": self._describe_repository(name)}}
        message = f"Could not resolve to a Repository with the name '{name}'."
        return {
            "data": {"repository": None}, "errors": [{"type": "NOT_FOUND", "path": ["repository"], "message": message}]
        }  # fmt: skip

    def _describe_repository(self, name: str) -> Any:
        owner, _, short_name = name.partition("/")
        url = f"file://{self.folder}/repositories/{name}"
        return {"id": "R", "name": short_name, "owner": {"login": owner}, "url": url}

    def _get_owner(self, _: object, login: str) -> Answer:
        if login != self.organisation:
            return NOT_FOUND
        return 200, {"login": login, "node_id": f"O_{login}", "type": "Organization"}

    def _invite(self, sent: Mapping[str, Any], name: str, login: str) -> Answer:
        if login not in self.logins:
            return NOT_FOUND
        self.invited[name] = (login, sent["permission"])
        return 201, {}

    def _store_secret(self, sent: Mapping[str, Any], name: str, secret: str) -> Answer:
        # A libsodium sealed box is 48 bytes longer than its content.
        if sent["key_id"] != "1" or len(base64.b64decode(sent["encrypted_value"])) <= SEAL:
            return 422, {"message": "not sealed"}
        self.sealed.setdefault(name, set()).add(secret)
        return 201, {}

    def _change_variable(self, sent: Mapping[str, Any], name: str, variable: str) -> Answer:
        if variable not in self.variables.get(name, {}):
            return NOT_FOUND
        self.variables[name][variable] = sent["value"]
        return 204, None

    def _create_variable(self, sent: Mapping[str, Any], name: str) -> Answer:
        variables = self.variables.setdefault(name, {})
        if sent["name"] in variables:
            return 409, {"message": "Already exists"}
        variables[sent["name"]] = sent["value"]
        return 201, {}

    def _list_issues(self, name: str) -> Any:
        return [{"title": title, "number": number} for number, title in enumerate(self.issues.get(name, []), start=1)]

    def _open_issue(self, sent: Mapping[str, Any], name: str) -> Answer:
        self.issues.setdefault(name, []).append(sent["title"])
        return 201, self._list_issues(name)[-1]


SEAL = 48
PUBLIC_KEY = base64.b64encode(bytes([9, *[0] * 31])).decode()


@contextmanager
def github(folder: Path, organisation: str, *logins: str) -> Iterator[GitHub]:
    """Serve an organisation's repositories to gh. A socket needs a short path, so `folder` must be near the root."""
    socket = folder / "socket"
    (folder / "config").mkdir(parents=True)
    (folder / "config" / "config.yml").write_text(f"http_unix_socket: {socket}\n")
    organisation_server = GitHub(folder, organisation, logins)

    class Handler(BaseHTTPRequestHandler):
        def answer(self) -> None:
            sent = self.rfile.read(int(self.headers.get("Content-Length") or 0))
            status, body = organisation_server.answer(self.command, self.path, json.loads(sent or b"{}"))
            content = b"" if body is None else json.dumps(body).encode()
            self.send_response(status)
            self.send_header("Content-Type", "application/json; charset=utf-8")
            self.send_header("X-Oauth-Scopes", organisation_server.scopes)
            self.send_header("Content-Length", str(len(content)))
            self.end_headers()
            self.wfile.write(content)

        do_GET = do_POST = do_PUT = do_PATCH = answer

        def address_string(self) -> str:
            return "gh"  # the client of a Unix socket has no address

        def log_message(self, *_: object) -> None:
            pass

    class Server(ThreadingUnixStreamServer):
        daemon_threads = True

    with Server(str(socket), Handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        try:
            yield organisation_server
        finally:
            server.shutdown()
