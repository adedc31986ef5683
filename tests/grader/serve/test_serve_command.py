"""The commands of `qdot serve` lose no links, start only one service, and report wrong options in one sentence."""

import codecs
import csv
import os
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace

import pytest
from django.core.cache import cache
from django.db import InterfaceError, OperationalError
from typer.testing import CliRunner

from qdot.exercises.assignment.release import init_assignment
from qdot.exercises.common.errors import QdotError
from qdot.grader.cli.main import make_program
from qdot.grader.cli.serve_command import _write_command
from qdot.grader.serve import server
from qdot.grader.serve.class_list import update_folder_class
from qdot.grader.serve.errors import find_refusal
from qdot.grader.serve.models import Person
from qdot.grader.serve.personal_links import COLUMNS, WrittenLinks, write_links
from qdot.grader.serve.server import claim_database
from qdot.grader.serve.settings import ServiceOptions, configure
from tests.support import read_cases
from tests.support.serving import Browser, Service


def read_links(path: Path) -> dict[str, str]:
    assert path.read_bytes().startswith(codecs.BOM_UTF8), "Word and Excel read accented names"
    with path.open(encoding="utf-8-sig") as file:
        return {row["student"]: row["link"] for row in csv.DictReader(file)}


def write(path: Path, *renewed: str, url: str = "") -> WrittenLinks:
    people = Person.objects.filter(is_active=True)
    return write_links(path, list(people), lambda person, _: person.student_id in renewed, url)


def can_enter(link: str) -> bool:
    return bool(Browser().client.get("/in/" + link.rpartition("/in/")[2]).status_code == 302)


def test_links_in_the_table_stay_and_new_people_get_one(service: Service, tmp_path: Path) -> None:
    path = tmp_path / "links.csv"
    assert (write(path).total, len(service.people)) == (4, 4)
    first = read_links(path)
    assert set(first) == {"s001", "s002", "s003", "staff:Grace"}
    Person.objects.create(classroom=service.classroom, role="student", student_id="s004")
    written = write(path, url="https://qdot.example.edu")
    assert [person.student_id for person in written.new] == ["s004"]
    second = read_links(path)
    assert {name: link.rpartition("/in/")[2] for name, link in first.items()} == {
        name: link.rpartition("/in/")[2] for name, link in second.items() if name != "s004"
    }
    assert all(link.startswith("https://qdot.example.edu/in/") for link in second.values())
    assert all(map(can_enter, second.values()))
    written = write(path, "s001")
    third = read_links(path)
    assert [person.student_id for person in written.replaced] == ["s001"]
    assert {name for name in third if third[name] != second[name]} == {"s001"}  # --url is remembered, too
    assert can_enter(third["s001"]) and not can_enter(second["s001"])


def test_a_lost_table_changes_no_link_unless_it_is_renewed(service: Service, tmp_path: Path) -> None:
    path, other = tmp_path / "links.csv", tmp_path / "other.csv"
    write(path)
    with pytest.raises(QdotError, match="find the earlier table, or make new links"):
        write(other)
    assert not other.exists()
    assert all(map(can_enter, read_links(path).values()))
    written = write(other, *service.people)
    assert len(written.replaced) == 4 and all(map(can_enter, read_links(other).values()))
    assert not any(map(can_enter, read_links(path).values()))


@pytest.mark.parametrize(
    "content", ["student,name,email\ns001,Ada,a@x\n", f"{','.join(COLUMNS)}\ns001,A,a@x,http://h/in/of-another-class\n"]
)
def test_another_table_is_not_overwritten(service: Service, tmp_path: Path, content: str) -> None:
    path = tmp_path / "links.csv"
    path.write_text(content, encoding="utf-8")
    with pytest.raises(QdotError, match="--out"):
        write(path, *service.people)
    assert path.read_text(encoding="utf-8") == content
    assert not Person.objects.filter(link_digest__isnull=False).exists()


def test_links_that_could_not_be_written_replace_none(service: Service, tmp_path: Path) -> None:
    write(tmp_path / "links.csv")
    with pytest.raises(QdotError):
        write(tmp_path / "links.csv" / "links.csv", *service.people)
    assert all(map(can_enter, read_links(tmp_path / "links.csv").values()))


def test_a_student_who_returns_has_the_old_link(service: Service, tmp_path: Path) -> None:
    path, roster = tmp_path / "links.csv", service.folder / "roster.csv"
    write(path)
    link, content = read_links(path)["s002"], roster.read_text(encoding="utf-8")
    try:
        roster.write_text(content.replace("s002", "s009"), encoding="utf-8")
        update_folder_class()
        assert not can_enter(link)
        write(path)
        assert "s002" not in read_links(path)
    finally:
        roster.write_text(content, encoding="utf-8")
    update_folder_class()
    assert can_enter(link)
    assert [person.student_id for person in write(path).unknown] == ["s002"]


@pytest.mark.usefixtures("service")
def test_a_second_service_on_the_same_database_is_refused() -> None:
    with claim_database(), pytest.raises(QdotError, match="another `qdot serve`"), claim_database():
        pass
    with claim_database():
        pass


class RestartedDatabase:
    """Stands for a connection to PostgreSQL, whose lock another service may have taken after a restart."""

    def __init__(self) -> None:
        self.is_open, self.is_free, self.claims, self.vendor = False, True, 0, "postgresql"
        self.inc_thread_sharing = self.close = lambda: None

    def is_usable(self) -> bool:
        return self.is_open

    @contextmanager
    def cursor(self) -> Iterator["RestartedDatabase"]:
        self.is_open = True
        yield self

    def execute(self, *_: object) -> None:
        self.claims += 1

    def fetchone(self) -> tuple[bool]:
        return (self.is_free,)


def test_a_service_claims_a_restarted_database_again_or_ends(monkeypatch: pytest.MonkeyPatch) -> None:
    database, signals = RestartedDatabase(), list[int]()
    monkeypatch.setattr(server, "connection", database)
    monkeypatch.setattr(server, "connections", SimpleNamespace(create_connection=lambda _: database))
    monkeypatch.setattr(os, "kill", lambda _, number: signals.append(number))
    with claim_database() as keep_claim:
        keep_claim()
        assert database.claims == 1
        database.is_open = False
        keep_claim()
        assert (database.claims, signals) == (2, [])
        database.is_open = database.is_free = False
        keep_claim()
        assert signals == [signal.SIGINT]


def test_a_database_that_does_not_answer_is_logged_once_a_minute(caplog: pytest.LogCaptureFixture) -> None:
    cache.clear()
    for error in (OperationalError("connection\nrefused"), InterfaceError("closed"), ValueError("x")):
        assert find_refusal(error).status == 500
    assert caplog.messages == ["a request failed: the database can't be used: connection refused", "a request failed"]
    assert [record.exc_info is not None for record in caplog.records] == [False, True]


@pytest.mark.parametrize(("arguments", "sentence"), read_cases("refused")["serve"])
def test_a_mistake_in_a_command_is_named(
    arguments: list[str], sentence: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "homework").mkdir()
    (tmp_path / "homework" / "assignment.toml").touch()
    (tmp_path / "taken.zip").touch()
    result = CliRunner().invoke(make_program("serve"), ["serve", *arguments])
    assert (result.exit_code, sentence in result.output) == (2, True), result.output
    assert (tmp_path / "taken.zip").read_bytes() == b""


@pytest.mark.parametrize(
    ("database", "url", "port", "expected"),
    [
        ("", "", 8000, ""), ("", "", 8123, " --port 8123"), ("", "https://q.edu", 8123, " --url https://q.edu"),
        ("postgresql://me:abc@h/q", "http://set", 80, " --database postgresql://me:PASSWORD@h/q"),
    ],
)  # fmt: skip
def test_a_printed_command_is_for_the_same_service(
    database: str, url: str, port: int, expected: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("QDOT_URL", "http://set")
    command = _write_command("links", [Path("hw 1"), Path("hw2")], database, url, port)
    assert command == f"qdot serve links 'hw 1' hw2{expected}"


def test_missing_pages_are_reported_before_links_are_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    init_assignment(tmp_path / "hw", "T", "hw")
    monkeypatch.setattr("qdot.exercises.site.pages.find_folder", lambda *_: None)
    result = CliRunner().invoke(make_program("serve"), ["serve", "links", "hw"])
    assert (result.exit_code, "make site-scripts" in result.output) == (2, True), result.output
    assert not (tmp_path / "links.csv").exists() and not (tmp_path / "hw" / "online").exists()


def test_the_help_says_how_the_service_is_started() -> None:
    output = CliRunner().invoke(make_program("serve"), ["serve", "--help"]).output
    assert all(words in output for words in ("qdot serve start", "--port", "--url"))


@pytest.mark.parametrize("url", read_cases("refused")["urls"])
def test_an_address_at_which_the_pages_would_not_work_is_refused(url: str, tmp_path: Path) -> None:
    with pytest.raises(QdotError, match="--url"):
        configure(ServiceOptions((tmp_path,), url=url))
