"""Ask GitHub or GitLab, in a grading job, when students pushed to their repositories.

The time of a commit comes from a student's machine, so qdot does not trust it. The time of a push comes from the
server's clock: GitHub lists pushes as the activity of a repository, GitLab as the events of a project.
"""

import base64
import datetime
import json
import os
import re
import time
import urllib.error
import urllib.request
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any
from urllib.parse import quote

from qdot.exercises.common.errors import QdotError

TOKEN_VARIABLE = "QDOT_TOKEN"  # noqa: S105 - a variable's name
"""The environment variable with the token for students' repositories."""
REQUEST_TIMEOUT = 60
"""Timeout for a response of a server, in seconds."""
RETRY_PAUSES = (2, 10)
"""Pauses, in seconds, before a failed request is repeated."""


@dataclass(frozen=True)
class Push:
    """A push to a branch: the branch's new commit, and the time when the server received it."""

    commit: str
    received: datetime.datetime


@dataclass(frozen=True)
class Host:
    """A server with repositories, with the login and the token for git and for the server's API.

    `owner` is the owner of the repositories if repositories.csv does not name one. `list_pushes(host, repository,
    branch)` yields the pushes to a branch of a repository OWNER/NAME; the latest push comes first.
    """

    server_url: str
    api_url: str
    owner: str
    login: str
    list_pushes: Callable[["Host", str, str], Iterator[Push]]
    token: str = field(repr=False)

    def make_repository_url(self, repository: str) -> str:
        """Return the address of a repository for git."""
        return f"{self.server_url}/{repository}.git"

    def make_git_environment(self) -> dict[str, str]:
        """Return the environment variables that pass the token to git, so that no argument and no file contains it.

        Git is set not to prompt for a password, and not to fetch large files (LFS).
        """
        variables = {name: value for name, value in os.environ.items() if not name.startswith("QDOT_")}
        count = int(variables.get("GIT_CONFIG_COUNT") or 0)
        credentials = base64.b64encode(f"{self.login}:{self.token}".encode()).decode()
        variables |= {"GIT_TERMINAL_PROMPT": "0", "GIT_LFS_SKIP_SMUDGE": "1", "GIT_CONFIG_COUNT": str(count + 1)}
        variables[f"GIT_CONFIG_KEY_{count}"] = f"http.{self.server_url}/.extraheader"
        variables[f"GIT_CONFIG_VALUE_{count}"] = f"Authorization: Basic {credentials}"
        return variables


def find_host(name: str, environment: Mapping[str, str]) -> Host:
    """Return the host "github" or "gitlab", as the environment variables of its jobs describe it. Raises QdotError."""
    token = environment.get(TOKEN_VARIABLE, "").strip()
    if not token:
        raise QdotError(f"{TOKEN_VARIABLE} is not set; set it to a token that may read the repositories (docs/ci.md)")

    def read_setting(variable: str, default: str = "") -> str:
        return (environment.get(variable) or default).rstrip("/")

    if name == "github":
        server = read_setting("GITHUB_SERVER_URL", "https://github.com")
        api = read_setting("GITHUB_API_URL", "https://api.github.com")
        return Host(server, api, read_setting("GITHUB_REPOSITORY_OWNER"), "x-access-token", _list_github_pushes, token)
    server = read_setting("CI_SERVER_URL", "https://gitlab.com")
    api = read_setting("CI_API_V4_URL", f"{server}/api/v4")
    return Host(server, api, read_setting("CI_PROJECT_NAMESPACE"), "oauth2", _list_gitlab_pushes, token)


def _list_github_pushes(host: Host, repository: str, branch: str) -> Iterator[Push]:
    path = f"repos/{quote(repository)}/activity?ref={quote(f'refs/heads/{branch}', safe='')}&per_page=100"
    for activity in _list_pages(host, path):
        if activity["after"].strip("0"):  # zeros mean that the branch was deleted
            yield Push(activity["after"], datetime.datetime.fromisoformat(activity["timestamp"]))


def _list_gitlab_pushes(host: Host, repository: str, branch: str) -> Iterator[Push]:
    path = f"projects/{quote(repository, safe='')}/events?action=pushed&per_page=100"
    for event in _list_pages(host, path):
        push_data = event["push_data"]
        if push_data["ref"] == branch and push_data.get("ref_type", "branch") == "branch" and push_data["commit_to"]:
            yield Push(push_data["commit_to"], datetime.datetime.fromisoformat(event["created_at"]))


def _list_pages(host: Host, path: str) -> Iterator[Any]:
    """Yield the items of a list that the API returns in pages."""
    url = f"{host.api_url}/{path}"
    while url:
        page, links = _send_request(host, url)
        yield from page
        next_link = re.search(r'<([^>]+)>;\s*rel="next"', links)
        url = next_link[1] if next_link and next_link[1].startswith(f"{host.api_url}/") else ""


def _send_request(host: Host, url: str) -> tuple[Any, str]:
    """Return the API's response and its header with links to other pages; repeat a failed request up to twice."""
    request = urllib.request.Request(url, headers={"Authorization": f"Bearer {host.token}"})  # noqa: S310 - the CI's
    for pause in (*RETRY_PAUSES, None):
        try:
            with urllib.request.urlopen(request, timeout=REQUEST_TIMEOUT) as response:  # noqa: S310
                return json.loads(response.read()), response.headers.get("Link") or ""
        except OSError as error:
            if pause is None or (isinstance(error, urllib.error.HTTPError) and error.code < 500):
                raise
        time.sleep(pause)
    raise AssertionError("the last attempt returns or raises")
