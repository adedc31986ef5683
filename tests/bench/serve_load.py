"""Measure how fast `qdot serve` answers when a class submits: run `python -m tests.bench.serve_load HOMEWORK LINKS`.

HOMEWORK is the folder that a running service serves, and LINKS the table of `qdot serve links`. Half of the answers are
wrong. The answers come at random times, as from people who don't know of each other. At the end, the program asks for
the submissions of every student, and reports those that were acknowledged but are missing.
"""

import argparse
import csv
import json
import random
import statistics
import threading
import time
import urllib.request
import uuid
from concurrent.futures import ThreadPoolExecutor
from http.cookiejar import CookieJar
from pathlib import Path
from typing import Any

from qdot.exercises.assignment.assignment import Assignment, load_assignment
from qdot.exercises.assignment.store import load_stored_problems
from qdot.exercises.writing.problem_texts import write_answer_code
from qdot.grader.serve.judge_process import write_answers_notebook


class Browser:
    """A student's browser: it has signed in by the personal link."""

    def __init__(self, link: str) -> None:
        self.url = link.partition("/in/")[0]
        self._cookies = CookieJar()
        self.open = urllib.request.build_opener(urllib.request.HTTPCookieProcessor(self._cookies)).open
        self.open(link).read()

    def find_token(self) -> str:
        return next((str(cookie.value) for cookie in self._cookies if cookie.name == "csrftoken"), "")

    def call(self, path: str, content: object = None) -> Any:
        headers = {"Content-Type": "application/json", "X-CSRFToken": self.find_token()}
        data = None if content is None else json.dumps(content).encode()
        with self.open(urllib.request.Request(self.url + path, data, headers)) as response:
            return json.loads(response.read())

    def upload(self, key: str, content: bytes) -> int:
        """Upload a notebook, and return the number of the submission."""
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
    parser.add_argument("homework", type=Path)
    parser.add_argument("links", type=Path)
    parser.add_argument("--per-minute", type=float, default=300)
    parser.add_argument("--count", type=int, default=300)
    parser.add_argument("--notebooks", type=int, default=0)
    options = parser.parse_args()
    assignment, rng = load_assignment(options.homework), random.Random(1)
    with options.links.open() as table:
        links = {row["student"]: row["link"] for row in csv.DictReader(table) if ":" not in row["student"]}
    plans = {student: iter(list_answers(load_stored_problems(assignment, student).problems)) for student in links}
    browsers = {student: Browser(link) for student, link in links.items()}
    acknowledged: dict[str, set[int]] = {student: set() for student in links}
    seconds, failures = list[float](), list[str]()
    locks = {student: threading.Lock() for student in links}

    def submit(student: str) -> None:
        with locks[student]:
            part, text = next(plans[student], ("", ""))
            if not part:
                return
            start = time.monotonic()
            try:
                content = {"request": str(uuid.uuid4()), "part": part, "text": text}
                reply = browsers[student].call(f"/a/{assignment.key}/answers", content)
                acknowledged[student].add(reply["submission"])
                seconds.append(time.monotonic() - start)
                if reply["state"] != "marked":
                    failures.append(f"{part}: {reply['state']}")
            except OSError as error:
                failures.append(str(error))

    with ThreadPoolExecutor(100) as pool:
        for index in range(options.count):
            pool.submit(submit, list(links)[index % len(links)])
            time.sleep(rng.expovariate(options.per_minute / 60))
    if options.notebooks:
        measure_notebooks(assignment, browsers, options.notebooks, acknowledged)
    lost = 0
    for student, numbers in acknowledged.items():
        rows = browsers[student].call(f"/a/{assignment.key}/work")["submissions"]
        lost += len(numbers - {row["id"] for row in rows})
    quantiles = statistics.quantiles(seconds, n=100)
    print(f"{len(seconds)} answers, {options.per_minute:g} a minute; failed: {failures or 'none'}; {lost} lost")
    print(f"seconds: half within {quantiles[49]:.2f}, 95 % within {quantiles[94]:.2f}, all within {max(seconds):.2f}")


def measure_notebooks(
    assignment: Assignment, browsers: dict[str, Browser], count: int, acknowledged: dict[str, set[int]]
) -> None:
    """Upload notebooks as fast as possible, and print how long it takes until all are graded."""
    start, waiting = time.monotonic(), list[tuple[str, int]]()
    for index in range(count):
        student = list(browsers)[index % len(browsers)]
        answers = dict(list_answers(load_stored_problems(assignment, student).problems))
        notebook = write_answers_notebook(assignment, student, answers)
        waiting.append((student, browsers[student].upload(assignment.key, notebook.encode())))
        acknowledged[student].add(waiting[-1][1])
    for student, number in waiting:
        while browsers[student].call(f"/a/{assignment.key}/submissions/{number}")["state"] != "marked":
            time.sleep(0.5)
    print(f"{count} notebooks are graded after {time.monotonic() - start:.0f} s")


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
