"""Measure how fast `qdot serve` answers when a class submits: run `python -m tests.bench.serve_load`.

Each student of a class submits an answer within a minute, and then some upload notebooks within five. Half of the
answers are wrong. They come at random times, as from people who don't know of each other. The program reports the
seconds until the verdicts, the processor time, submissions that were acknowledged but are missing, and students whose
marks aren't those of `qdot grade`.
"""

import argparse
import json
import random
import statistics
import subprocess
import tempfile
import time
import urllib.request
import uuid
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from http.cookiejar import CookieJar
from pathlib import Path
from typing import Any

from qdot.exercises.assignment.assignment import Assignment, Student
from qdot.exercises.assignment.store import load_stored_problems
from qdot.exercises.common.parallel import CORE_COUNT
from qdot.exercises.writing.problem_texts import write_answer_code
from qdot.grader.serve.judge_process import write_answers_notebook
from tests.support.running_service import QDOT, RunningService, run_service
from tests.support.submitting import make_class


class Browser:
    """A student's browser: it has signed in by the personal link."""

    def __init__(self, link: str) -> None:
        self.url = link.partition("/in/")[0]
        self.start_session()
        self.open(link).read()

    def start_session(self) -> None:
        self._cookies = CookieJar()
        self.open = urllib.request.build_opener(urllib.request.HTTPCookieProcessor(self._cookies)).open

    def find_token(self) -> str:
        return next((str(cookie.value) for cookie in self._cookies if cookie.name == "csrftoken"), "")

    def call(self, path: str, content: object = None) -> Any:
        headers = {"Content-Type": "application/json", "X-CSRFToken": self.find_token()}
        data = None if content is None else json.dumps(content).encode()
        with self.open(urllib.request.Request(self.url + path, data, headers)) as response:
            return json.loads(response.read())

    def upload(self, key: str, content: bytes) -> int:
        boundary, body = uuid.uuid4().hex, b""
        for name, data in (('"request"', str(uuid.uuid4()).encode()), ('"file"; filename="a.ipynb"', content)):
            head = f"--{boundary}\r\nContent-Disposition: form-data; name={name}\r\n\r\n"
            body += head.encode() + data + b"\r\n"
        request = urllib.request.Request(f"{self.url}/a/{key}/notebooks", body + f"--{boundary}--\r\n".encode())
        request.add_header("Content-Type", f"multipart/form-data; boundary={boundary}")
        request.add_header("X-CSRFToken", self.find_token())
        with self.open(request) as response:
            number: int = json.loads(response.read())["submission"]
            return number


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--students", type=int, default=300, help="each submits an answer within a minute")
    parser.add_argument("--notebooks", type=int, default=120, help="so many are uploaded within five minutes")
    options = parser.parse_args()
    students = [Student(f"s{number:03}", f"Student {number}") for number in range(options.students)]
    with tempfile.TemporaryDirectory() as name:
        assignment = make_class(Path(name) / "hw", students)
        with run_service(assignment.folder, jobs=CORE_COUNT) as service:
            measure(service, assignment, options.notebooks)


def measure(service: RunningService, assignment: Assignment, notebook_count: int) -> None:
    """Let the class work, and print how fast the service is and whether its marks are right."""
    rng, names = random.Random(1), [student.id for student in assignment.roster]
    browsers = {name: Browser(service.links[name]) for name in names}
    plans = {name: list_answers(load_stored_problems(assignment, name).problems) for name in names}
    acknowledged, failures = dict[str, set[int]](), list[str]()

    def submit(name: str, send: Callable[[], int]) -> float:
        start = time.monotonic()
        try:
            acknowledged.setdefault(name, set()).add(send())
        except OSError as error:
            failures.append(f"{name}: {error}")
        return time.monotonic() - start

    def answer(name: str) -> float:
        part, text = rng.choice(plans[name])
        content = {"request": str(uuid.uuid4()), "part": part, "text": text}
        return submit(
            name, lambda: _read_number(browsers[name].call(f"/a/{assignment.key}/answers", content), failures)
        )

    def upload(name: str) -> float:
        notebook = write_answers_notebook(assignment, name, dict(rng.sample(plans[name], len(plans[name]))))
        return submit(name, lambda: browsers[name].upload(assignment.key, notebook.encode()))

    for work, people, minutes in ((answer, names, 1), (upload, rng.sample(names, notebook_count), 5)):
        start, start_processor = time.monotonic(), service.measure_processor_time()
        with ThreadPoolExecutor(len(people)) as pool:
            moments = [start + rng.uniform(0, 60 * minutes) for _ in people]
            seconds = list(pool.map(_do_at, moments, [work] * len(people), people))
        for name in people:
            while any(row["state"] != "marked" for row in _list_rows(browsers[name], assignment)):
                time.sleep(0.5)
        total = time.monotonic() - start
        processor_time = (service.measure_processor_time() - start_processor) / len(people)
        half, most = (statistics.quantiles(seconds, n=20, method="inclusive")[index] for index in (9, 18))
        print(f"{work.__name__}: {len(people)} students within {minutes} min; all marked after {total:.0f} s")
        print(f"  seconds: half within {half:.2f}, 95 % within {most:.2f}, all within {max(seconds):.2f}")
        print(f"  processor time for each: {processor_time:.2f} s", flush=True)
    lost = sum(
        len(acknowledged[name] - {row["id"] for row in _list_rows(browsers[name], assignment)}) for name in names
    )
    print(f"failed: {failures or 'none'}; {lost} lost")
    print(f"marks that differ from those of `qdot grade`: {find_other_marks(service, assignment) or 'none'}")


def _do_at(moment: float, work: Callable[[str], float], name: str) -> float:
    time.sleep(max(0, moment - time.monotonic()))
    return work(name)


def _read_number(reply: Any, failures: list[str]) -> int:
    if reply["state"] != "marked":
        failures.append(f"submission {reply['submission']}: {reply['state']}")
    number: int = reply["submission"]
    return number


def _list_rows(browser: Browser, assignment: Assignment) -> Sequence[Any]:
    rows: Sequence[Any] = browser.call(f"/a/{assignment.key}/work")["submissions"]
    return rows


def find_other_marks(service: RunningService, assignment: Assignment) -> list[str]:
    """Return the students to whom `qdot grade` gives different scores from the service."""
    staff = Browser(service.links["staff:Grace"])
    rows = staff.call(f"/a/{assignment.key}/class/results")["students"]
    online = {row["student_id"]: row["score"] or 0 for row in rows}
    out = assignment.folder.parent / "out"
    service.call("export", str(assignment.folder), "--out", str(out))
    subprocess.run([*QDOT, "grade", str(out)], check=True, capture_output=True)
    results = map(json.loads, (out / "graded" / "results.jsonl").read_text().splitlines())
    return [row["student"] for row in results if abs(row["score"] - online[row["student"]]) > 1e-6]


def list_answers(problems: Any) -> list[tuple[str, str]]:
    """Return the answers that a student submits, one after the other: a wrong one and then the right one."""
    answers = list[tuple[str, str]]()
    for slot, problem in problems:
        for part in problem.parts:
            right = write_answer_code(problem, part)
            wrong = right.replace("+", "-").replace("sin", "cos")
            answers += [(f"{slot}.{part.name}", text) for text in dict.fromkeys((wrong, right))]
    return answers


if __name__ == "__main__":
    main()
