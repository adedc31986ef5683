"""Processes of a running service are killed at random moments; nothing that was acknowledged is lost."""

import json
import random
import subprocess
import threading
import time
import uuid
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from http.client import HTTPException
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from urllib.error import HTTPError
from urllib.parse import parse_qs, urlencode, urlsplit

import pytest

from qdot.exercises.assignment.assignment import Assignment, load_assignment
from qdot.exercises.writing.problem_texts import write_answer_code
from tests.bench.serve_load import Browser
from tests.support.running_service import QDOT, run_service
from tests.support.serving import STUDENTS, find_folder
from tests.support.submitting import make_class, make_correct_notebook
from tests.support.suites import select_for_suite

find_folder()  # configures Django before the platform imports its tables
from tests.grader.serve.platform import Platform  # noqa: E402


class RunningPlatform(Platform):
    """The learning platform as a server on this machine; `/auth` answers with the form of a launch as JSON."""

    tool = ""

    def start(self) -> None:
        platform = self

        class Handler(BaseHTTPRequestHandler):
            def do_GET(self) -> None:
                body = self.rfile.read(int(self.headers.get("Content-Length", 0)))
                address = f"{platform.site}{self.path}"
                request: Any = SimpleNamespace(url=address, method=self.command, body=body, headers=self.headers)
                if self.path.startswith("/auth?"):
                    status, content = 200, json.dumps(platform.make_form(address)).encode()
                else:
                    answer = platform.answer(request)
                    status, content = answer.status_code, answer.content
                self.send_response(status)
                self.send_header("Content-Length", str(len(content)))
                self.end_headers()
                self.wfile.write(content)

            do_POST = do_GET

            def log_message(self, *_: Any) -> None:
                pass

        self.server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self.site = self.issuer = f"http://127.0.0.1:{self.server.server_port}"
        threading.Thread(target=self.server.serve_forever, daemon=True).start()

    def stop(self) -> None:
        self.server.shutdown()
        self.server.server_close()

    def make_form(self, address: str) -> dict[str, str]:
        query = {name: values[0] for name, values in parse_qs(urlsplit(address).query).items()}
        user, role = query["login_hint"].split("/")
        claims = self.make_claims(user, role, target_link_uri=f"{self.tool}/a/hw/", email=None)
        return {"state": query["state"], "id_token": self.sign({**claims, "nonce": query["nonce"]})}

    def _check_assertion(self, body: str) -> None:
        """Give everybody an access token: the keys of the service may be unreachable just now."""


class LaunchedBrowser(Browser):
    """The browser of a person who has opened the assignment on the platform."""

    def __init__(self, platform: RunningPlatform, login: str, hint: str) -> None:
        self.url = platform.tool
        self.start_session()
        query = {"iss": platform.site, "login_hint": hint, "target_link_uri": self.url, "lti1p3_new_window": "1"}
        form = json.loads(self.open(f"{login}?{urlencode(query)}").read())
        self.open(f"{self.url}/lti/launch", urlencode(form).encode()).read()


def retry(action: Any) -> Any:
    """Return the result of an action, which is repeated, as on the pages, while the service is away or too busy."""
    deadline = time.monotonic() + 300
    while time.monotonic() < deadline:
        try:
            return action()
        except (OSError, HTTPException) as error:  # the connection broke
            if isinstance(error, HTTPError):
                with error:  # otherwise its socket stays open
                    if error.code < 500 and error.code != 429:
                        raise AssertionError(error.read()) from None
            last_error = repr(error)
            time.sleep(0.2)
    raise AssertionError(f"the service doesn't answer: {last_error}")


ANSWERS = 12


@pytest.mark.integration
def test_nothing_acknowledged_is_lost_when_processes_are_killed(tmp_path: Path) -> None:
    """Let a class work while the server and its processes are killed."""
    assignment = make_class(tmp_path / "hw", STUDENTS)
    rng, acknowledged, platform = random.Random(3), dict[str, set[int]](), RunningPlatform()
    platform.start()
    problem, finished = assignment.generate_problems("s001")[0][1], threading.Event()
    right = write_answer_code(problem, problem["determinant"])
    with run_service(assignment.folder) as service:
        login = service.register(platform)
        LaunchedBrowser(platform, login, "grace/Instructor")

        def open_browser(student: str) -> Browser:
            if student in service.links:
                return Browser(service.links[student])
            return LaunchedBrowser(platform, login, f"{student}/Learner")

        def work_as(student: str) -> None:
            browser, number = retry(lambda: open_browser(student)), 0
            numbers, answer = acknowledged.setdefault(student, set()), right
            if student not in service.links:
                identifier = retry(lambda: browser.call("/a/hw/work"))["student"]["id"]
                own_problem = assignment.generate_problems(identifier)[0][1]
                answer = write_answer_code(own_problem, own_problem["determinant"])
            while number < ANSWERS or not finished.is_set():
                text = f"{answer} + {number}" if number % 2 else f"{answer} + {number} - {number}"
                content = {"request": str(uuid.uuid4()), "part": "p1.determinant", "text": text}
                replies = [retry(lambda: browser.call("/a/hw/answers", content))["submission"] for _ in range(2)]  # noqa: B023
                assert replies[0] == replies[1]  # a repeated request is stored once
                numbers.add(replies[0])
                number += 1
                time.sleep(rng.random())

        notebook = make_correct_notebook(assignment, "s003").encode()
        browser = Browser(service.links["s003"])
        acknowledged["s003"] = {browser.upload("hw", notebook)}
        students = ("s001", "s002", "ada")
        kinds: list[Callable[[], None]] = [service.kill_and_start, lambda: service.kill_worker(rng)]
        kills = (kinds * 5)[: select_for_suite(3, 10)]
        with ThreadPoolExecutor(len(students)) as pool:
            work = pool.map(work_as, students)
            try:
                for kill in rng.sample(kills, len(kills)):
                    time.sleep(rng.uniform(0.1, 2.5))
                    kill()
            finally:
                finished.set()
            list(work)
        for student in (*students, "s003"):
            work = _wait_for_marks(retry(lambda: open_browser(student)))  # noqa: B023
            stored = [row["id"] for row in work["submissions"]]
            assert (sorted(stored, reverse=True), set(stored)) == (stored, acknowledged[student])
            assert student != "s003" or work["score"] == work["max_score"], (work["submissions"], work["results"])
        _check_scores(platform, browser_score=_wait_for_marks(retry(lambda: open_browser("ada")))["score"])
        out = tmp_path / "out"
        service.call("export", str(assignment.folder), "--out", str(out))
    _check_export(assignment, out)
    platform.stop()


def _wait_for_marks(browser: Browser) -> Any:
    """Return a student's work when all of it is marked."""
    for _ in range(300):
        work = retry(lambda: browser.call("/a/hw/work"))
        if all(row["state"] == "marked" for row in work["submissions"]):
            return work
        time.sleep(1)
    raise AssertionError(f"not marked: {work['submissions']}")


def _check_scores(platform: RunningPlatform, browser_score: float) -> None:
    """Check that the gradebook shows the score of the page, and was never sent an older score after a newer one."""
    for _ in range(300):
        if platform.scores and platform.scores[-1].get("scoreGiven") == browser_score:
            break
        time.sleep(1)
    assert platform.scores[-1]["scoreGiven"] == browser_score
    times = [score["timestamp"] for score in platform.scores]
    assert times == sorted(set(times))


def _check_export(assignment: Assignment, out: Path) -> None:
    """Check that `qdot grade` gives the marks that the service gave."""
    subprocess.run([*QDOT, "grade", str(out)], check=True, capture_output=True)
    lines = [json.loads(line) for line in (out / "graded" / "results.jsonl").read_text().splitlines()]
    assert [line["score"] for line in lines][2] == 4
    assert load_assignment(out).roster[2].id == assignment.roster[2].id
