"""A server that looks like GitHub or GitLab to a grading job: it has repositories, and an API that lists pushes."""

import json
import threading
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any
from urllib.parse import parse_qs, unquote, urlsplit

from tests.support.ci import git

TOKEN = "token-of-the-staff"
PAGE = 100
"""The number of entries on a page of the API's lists."""


@dataclass
class Server:
    """Repositories by name (such as course/hw-ada), the pushes to each, and the edits of issues."""

    folder: Path
    pushes: dict[str, list[tuple[str, str, str]]] = field(default_factory=dict)
    edits: list[tuple[str, Any]] = field(default_factory=list)
    api: str = ""

    def bare(self, name: str) -> Path:
        return self.folder / f"{name}.git"

    def push(self, name: str, files: Mapping[str, str | bytes], moment: str, branch: str = "main") -> str:
        """Replace all files of a repository by these in a push at `moment`; return the commit."""
        bare, work = self.bare(name), self.folder / "work" / name
        if not bare.exists():
            git("init", "--quiet", "--bare", bare)
            git("config", "uploadpack.allowAnySHA1InWant", "true", cwd=bare)
        if not work.exists():
            git("init", "--quiet", work)
        git("rm", "-r", "--quiet", "--ignore-unmatch", ".", cwd=work)
        for path, content in files.items():
            (work / path).parent.mkdir(parents=True, exist_ok=True)
            (work / path).write_bytes(content if isinstance(content, bytes) else content.encode())
        git("add", "--all", "--force", cwd=work)
        git("commit", "--quiet", "--allow-empty", "--message", "work", cwd=work)
        git("push", "--quiet", "--force", bare, f"HEAD:refs/heads/{branch}", cwd=work)
        commit = git("rev-parse", "HEAD", cwd=work).strip()
        self.pushes.setdefault(name, []).append((branch, commit, moment))
        return commit

    def variables(self, platform: str) -> dict[str, str]:
        if platform == "github":
            return {
                "GITHUB_SERVER_URL": f"file://{self.folder}", "GITHUB_API_URL": self.api,
                "GITHUB_REPOSITORY_OWNER": "course", "QDOT_TOKEN": TOKEN,
            }  # fmt: skip
        return {
            "CI_SERVER_URL": f"file://{self.folder}", "CI_API_V4_URL": self.api, "CI_PROJECT_NAMESPACE": "course",
            "QDOT_TOKEN": TOKEN,
        }  # fmt: skip

    def answer(self, path: str, query: Mapping[str, list[str]]) -> list[Any] | None:
        collection, *parts = path.strip("/").split("/")
        if collection == "repos" and parts[2:] == ["activity"]:
            branch = query["ref"][0].removeprefix("refs/heads/")
            pushes = self.pushes.get("/".join(parts[:2]))
            return pushes and [
                {"after": commit, "timestamp": moment, "ref": f"refs/heads/{pushed_branch}", "activity_type": "push"}
                for pushed_branch, commit, moment in reversed(pushes)
                if pushed_branch == branch
            ]
        if collection == "projects" and parts[1:] == ["events"]:
            pushes = self.pushes.get(unquote(parts[0]))
            return pushes and [
                {"created_at": moment, "push_data": {"ref": pushed_branch, "ref_type": "branch", "commit_to": commit}}
                for pushed_branch, commit, moment in reversed(pushes)
            ]
        return None


@contextmanager
def serve_repositories(folder: Path) -> Iterator[Server]:
    server = Server(folder)
    web = ThreadingHTTPServer(("127.0.0.1", 0), lambda *arguments: _Api(server, *arguments))
    server.api = f"http://127.0.0.1:{web.server_port}"
    threading.Thread(target=web.serve_forever, daemon=True).start()
    try:
        yield server
    finally:
        web.shutdown()
        web.server_close()


class _Api(BaseHTTPRequestHandler):
    """Serve lists of pushes in pages to clients with the token; record edits of issues."""

    def __init__(self, server: Server, *arguments: Any) -> None:
        self.host = server
        super().__init__(*arguments)

    def do_GET(self) -> None:
        url = urlsplit(self.path)
        query = parse_qs(url.query)
        entries = self.host.answer(url.path, query)
        if self.headers["Authorization"] != f"Bearer {TOKEN}":
            self._respond(401)
        elif entries is None:
            self._respond(404)
        else:
            page = int(query.get("page", ["1"])[0])
            entries_on_page, later_entries = entries[PAGE * (page - 1) : PAGE * page], entries[PAGE * page :]
            following = f"{self.host.api}{url.path}?{url.query.split('&page=')[0]}&page={page + 1}"
            self._respond(200, entries_on_page, {"Link": f'<{following}>; rel="next"'} if later_entries else {})

    def do_PATCH(self) -> None:
        content = json.loads(self.rfile.read(int(self.headers["Content-Length"])))
        self.host.edits.append((self.path.strip("/"), {**content, "by": self.headers["Authorization"]}))
        self._respond(200, {})

    def _respond(self, code: int, content: Any = None, headers: Mapping[str, str] | None = None) -> None:
        self.send_response(code)
        for name, value in (headers or {}).items():
            self.send_header(name, value)
        self.end_headers()
        self.wfile.write(json.dumps(content).encode())

    def log_message(self, *_: Any) -> None:
        pass
