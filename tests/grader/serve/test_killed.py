"""Processes of a running service are killed at random moments; nothing that was acknowledged is lost."""

import csv
import json
import os
import random
import signal
import socket
import subprocess
import sys
import threading
import time
import uuid
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from http.client import HTTPException
from pathlib import Path
from typing import Any
from urllib.error import HTTPError

import psutil  # type: ignore[import-untyped]
import pytest

from qdot.exercises.assignment.assignment import load_assignment
from qdot.exercises.writing.problem_texts import write_answer_code
from tests.bench.serve_load import Browser
from tests.support.serving import STUDENTS
from tests.support.submitting import make_class, make_correct_notebook
from tests.support.suites import select_for_suite

QDOT = [sys.executable, "-m", "qdot.grader.cli.main"]


def find_free_port() -> int:
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port: int = free.getsockname()[1]
        return port


class RunningService:
    """`qdot serve` in processes of its own, which is started again after it was killed."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.port = folder, find_free_port()
        self.url = f"http://127.0.0.1:{self.port}"
        links = folder.parent / "links.csv"
        command = [*QDOT, "serve", "links", str(folder), "--port", str(self.port), "--out", str(links)]
        subprocess.run(command, check=True)
        with links.open(encoding="utf-8-sig") as table:
            self.links = {row["student"]: row["link"] for row in csv.DictReader(table)}

        self._log = (folder.parent / "log.txt").open("w")
        self.close = self._log.close

    def start(self) -> None:
        command = [*QDOT, "serve", str(self.folder), "--port", str(self.port), "--jobs", "1"]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=self._log, text=True)
        assert self.process.stdout is not None
        assert f"qdot is at {self.url}; stop it with Ctrl-C" in self.process.stdout.readline()

    def list_workers(self) -> list[psutil.Process]:
        """Return the processes that judge or grade, but not those that only start others."""
        processes = psutil.Process(self.process.pid).children(recursive=True)
        return [process for process in processes if "resource_tracker" not in " ".join(process.cmdline())]

    def kill(self) -> None:
        self.process.send_signal(signal.SIGKILL)
        self.wait()

    def wait(self) -> None:
        """Wait until the process has ended, and close its output."""
        self.process.wait(20)
        if self.process.stdout is not None:
            self.process.stdout.close()


@contextmanager
def run_service(folder: Path) -> Iterator[RunningService]:
    service = RunningService(folder)
    service.start()
    try:
        yield service
    finally:
        service.process.terminate()
        service.wait()
        service.close()


def retry(action: Any) -> Any:
    """Return the result of an action, which is repeated while the service doesn't answer, as the pages do."""
    for _ in range(300):
        try:
            return action()
        except (OSError, HTTPException) as error:  # the connection broke
            if isinstance(error, HTTPError) and error.code < 500:
                raise AssertionError(error.read()) from None
            last_error = error
            time.sleep(0.2)
    raise AssertionError(f"the service doesn't answer: {last_error}")


@pytest.mark.integration
def test_nothing_acknowledged_is_lost_when_processes_are_killed(tmp_path: Path) -> None:
    assignment = make_class(tmp_path / "hw", STUDENTS)
    rng, acknowledged = random.Random(3), dict[str, list[int]]()
    problem = assignment.generate_problems("s001")[0][1]
    texts = [write_answer_code(problem, problem["determinant"]) + f" + {number}" for number in range(12)]
    with run_service(assignment.folder) as service:

        def work_as(student: str) -> None:
            browser = retry(lambda: Browser(service.links[student]))
            numbers = acknowledged.setdefault(student, [])
            for text in texts:
                content = {"request": str(uuid.uuid4()), "part": "p1.determinant", "text": text}
                replies = [retry(lambda: browser.call("/a/hw/answers", content))["submission"] for _ in range(2)]  # noqa: B023
                assert replies[0] == replies[1]  # a repeated request is stored once
                numbers.append(replies[0])
                time.sleep(rng.random() / 2)

        notebook = make_correct_notebook(assignment, "s003").encode()
        browser = Browser(service.links["s003"])
        browser.upload("hw", notebook)
        second = subprocess.run([*QDOT, "serve", str(assignment.folder)], capture_output=True, text=True, check=False)
        assert (second.returncode, "another `qdot serve`" in second.stderr) == (2, True), second.stderr
        threads = [threading.Thread(target=work_as, args=(student,)) for student in ("s001", "s002")]
        for thread in threads:
            thread.start()
        for _ in range(select_for_suite(3, 10)):
            time.sleep(rng.uniform(0.1, 2.5))
            if rng.random() < 0.5:
                service.kill()
                service.start()
            else:
                with suppress(psutil.NoSuchProcess, IndexError):
                    os.kill(rng.choice(service.list_workers()).pid, signal.SIGKILL)
        for thread in threads:
            thread.join()
        for student in ("s001", "s002", "s003"):
            browser = retry(lambda: Browser(service.links[student]))  # noqa: B023
            for _ in range(200):
                work = retry(lambda: browser.call("/a/hw/work"))  # noqa: B023
                if all(row["state"] == "marked" for row in work["submissions"]):
                    break
                time.sleep(1)
            assert all(row["state"] == "marked" for row in work["submissions"])
            stored = [row["id"] for row in work["submissions"]]
            assert sorted(stored, reverse=True) == stored
            assert set(acknowledged.get(student, [])) <= set(stored)
            if student != "s003":
                assert (len(stored), work["answers"]["p1.determinant"]) == (len(texts), texts[-1])
            else:
                assert work["score"] == work["max_score"]
    out = tmp_path / "out"
    subprocess.run([*QDOT, "serve", "export", str(assignment.folder), "--out", str(out)], check=True)
    subprocess.run([*QDOT, "grade", str(out)], check=True)
    lines = [json.loads(line) for line in (out / "graded" / "results.jsonl").read_text().splitlines()]
    assert [line["score"] for line in lines][2] == 4
    assert load_assignment(out).roster[2].id == "s003"
