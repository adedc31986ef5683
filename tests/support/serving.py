"""A service in this process, without a web server: students and staff of a class open its addresses."""

import datetime
import json
import tempfile
import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from unittest.mock import patch

from qdot.exercises.assignment.assignment import Assignment, Student, load_assignment
from qdot.exercises.assignment.release import init_assignment
from qdot.grader.sandbox.sandbox import Limits
from qdot.grader.serve.judge_process import Judge
from qdot.grader.serve.settings import ServiceOptions, configure
from tests.support.submitting import UNCERTIFIED, open_shared_sandbox

STUDENTS = [Student("s001", "Ada"), Student("s002", "Bolivar Quux"), Student("s003", "Cy")]
HEAD = 'title = "T"\nkey = "hw"\n'
PROBLEMS = """
[question.why]
title = "The lost motion"
prompt = "Why does the arm lose a motion?"
answer = "text"
[[problem]]
family = "planar-2r"
questions = ["position", "jacobian", "determinant", "why"]
points = [1, 2, 1, 3]
[[problem]]
family = "polar-rp"
questions = ["determinant"]
"""
ASSETS = SimpleNamespace(scripts={"serve": "serve.js"}, modules={"serve": []}, styles={"serve": []})
"""Replaces the site's scripts, which may not have been built."""
NOTEBOOK = json.dumps({
    "cells": [{"cell_type": "code", "id": "a", "metadata": {}, "outputs": [], "source": "p1_position = 1"}],
    "metadata": {}, "nbformat": 4, "nbformat_minor": 5,
}).encode()  # fmt: skip
"""A small notebook with a wrong answer."""
LIMITS = Limits(seconds=20, cell_seconds=4)


@cache
def find_folder() -> Path:
    """Return the folder of the class; the first call also configures Django, which is possible once in a process."""
    folder = Path(tempfile.mkdtemp()) / "hw"
    init_assignment(folder, "T", "hw", STUDENTS, secret="0123456789abcdef")
    (folder / "assignment.toml").write_text(f"{HEAD}{PROBLEMS}")
    configure(ServiceOptions((folder,), url="http://testserver"))
    return folder


@cache
def prepare_database() -> dict[str, Any]:
    """Make the tables of the database, and return the middleware, which each of Django's clients would load again."""
    from django.apps import apps
    from django.core.management import call_command
    from django.test.client import ClientHandler
    from django.test.utils import override_settings

    with override_settings(MIGRATION_MODULES={app.label: None for app in apps.get_app_configs()}):
        call_command("migrate", verbosity=0, run_syncdb=True)  # makes each table at once, without its history
    handler = ClientHandler()
    handler.load_middleware()
    return {name: value for name, value in vars(handler).items() if "middleware" in name}


def write_settings(lines: str, problems: str = PROBLEMS) -> None:
    (find_folder() / "assignment.toml").write_text(f"{HEAD}{lines}\n{problems}")


class InProcessJudges:
    """Judges in this process, because starting processes takes longer than the tests themselves."""

    def __init__(self, folders: tuple[Path, ...], jobs: int) -> None:
        self._judge = Judge(folders)

    def run(self, work: Any, item: Any) -> Any:
        return work(self._judge, item)


@contextmanager
def empty_database() -> Iterator[None]:
    from django.core.management import call_command
    from django.test.client import ClientHandler

    loaded = prepare_database()
    call_command("flush", verbosity=0, interactive=False, inhibit_post_migrate=True)
    with patch.object(ClientHandler, "load_middleware", lambda handler: handler.__dict__.update(loaded)):
        yield


@contextmanager
def serve_class(settings: str = "", problems: str = PROBLEMS) -> Iterator["Service"]:
    """Yield a service with an empty database and a class with personal links."""
    folder = find_folder()
    write_settings(settings, problems)
    from qdot.grader.serve import marking_online

    with (
        empty_database(),
        patch.object(marking_online, "JudgePool", InProcessJudges),
        patch.object(marking_online, "_open_sandbox", lambda strict: open_shared_sandbox(LIMITS, strict)),
        patch("qdot.grader.serve.judge_process.CERTIFIER", UNCERTIFIED),
        patch("qdot.grader.serve.rates.SECONDS", 0.0),
        patch("qdot.grader.serve.html_pages.load_assets", lambda: ASSETS),
    ):
        yield Service(folder)


class Service:
    def __init__(self, folder: Path) -> None:
        from qdot.grader.serve.class_list import update_folder_class
        from qdot.grader.serve.models import Person

        self.folder, self.classroom = folder, update_folder_class()
        Person.objects.create(classroom=self.classroom, role="staff", student_id="staff:Grace", name="Grace")
        self.people = {person.student_id: person for person in self.classroom.people.all()}

    @property
    def assignment(self) -> Assignment:
        return load_assignment(self.folder)

    def open_browser(self, identifier: str) -> "Browser":
        """Return the browser of a person who has signed in by a personal link."""
        from qdot.grader.serve.personal_links import make_link

        browser = Browser()
        assert browser.client.get(f"/in/{make_link(self.people[identifier])}").status_code == 302
        return browser

    def process_queue(self) -> int:
        """Do all tasks in the queue, and return their number."""
        from django_tasks_db.models import DBTaskResult

        rows = list(DBTaskResult.objects.ready())
        for row in rows:
            row.claim("test")
            row.task.call(*row.args_kwargs["args"])
            row.set_successful(None)
        return len(rows)


class Browser:
    """A browser that sends the token against forged requests, as the service's scripts do."""

    def __init__(self) -> None:
        from django.test import Client

        self.client = Client(enforce_csrf_checks=True)

    def get(self, path: str, **headers: Any) -> Any:
        return self.client.get(path, headers=headers)

    def _get_token_header(self) -> dict[str, str]:
        if "csrftoken" not in self.client.cookies:
            self.client.get("/")  # sets the token
        return {"X-CSRFToken": self.client.cookies["csrftoken"].value}

    def send(self, method: str, path: str, content: Any) -> Any:
        body, headers = json.dumps(content), self._get_token_header()
        return self.client.generic(method, path, body, "application/json", headers=headers)

    def answer(self, part: str, text: str, request: str = "") -> Any:
        content = {"request": request or str(uuid.uuid4()), "part": part, "text": text}
        return self.send("POST", "/a/hw/answers", content)

    def upload(self, name: str, content: bytes, request: str = "") -> Any:
        from django.core.files.uploadedfile import SimpleUploadedFile

        data = {"request": request or str(uuid.uuid4()), "file": SimpleUploadedFile(name, content)}
        return self.client.post("/a/hw/notebooks", data, headers=self._get_token_header())


@contextmanager
def set_clock(moment: datetime.datetime) -> Iterator[None]:
    with patch("django.utils.timezone.now", lambda: moment):
        yield
