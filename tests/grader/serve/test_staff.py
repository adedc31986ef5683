"""The staff see the class, decide points and due dates, mark the class again, and can take everything out and back."""

import csv
import io
import json
import zipfile
from collections import defaultdict, deque
from functools import partial
from pathlib import Path

import pytest
from typer.testing import CliRunner

from qdot.exercises.assignment.assignment import load_assignment
from qdot.exercises.assignment.release import init_assignment
from qdot.exercises.common.errors import QdotError
from qdot.exercises.short_questions import ALL_QUESTIONS
from qdot.grader.serve.backup_files import restore_files
from qdot.grader.serve.class_list import update_folder_class
from qdot.grader.serve.exchange import back_up, restore
from qdot.grader.serve.forgetting_online import describe_people, find_people, forget_people
from qdot.grader.serve.models import Draft, Person, PointsOverride, StaffAction, Submission
from qdot.grader.serve.settings import DATABASE_FILE, find_options
from tests.grader.serve.test_submitting import find_right_answer
from tests.support.serving import HEAD, NOTEBOOK, PROBLEMS, Service, serve_class, write_settings


def test_equal_wrong_answers_form_a_group_that_gets_points_together(service: Service) -> None:
    for student in ("s001", "s002"):
        browser = service.open_browser(student)
        browser.answer("p2.determinant", find_right_answer(service, student, "p2.determinant") + " + 1")
    staff = service.open_browser("staff:Grace")
    results = staff.get("/a/hw/class/results").json()
    (group,) = results["groups"]
    assert sorted(group["students"]) == sorted(service.people[name].pk for name in ("s001", "s002"))
    assert staff.get(f"/a/hw/class/results?since={results['version']}").status_code == 204
    content = {"group": group["group"], "points": 0.75, "comment": "a metre too much"}
    too_much = {**content, "points": results["max_score"]}  # more than this part has
    assert staff.send("POST", "/a/hw/class/overrides", too_much).status_code == 400
    assert staff.send("POST", "/a/hw/class/overrides", content).status_code == 200
    work = service.open_browser("s002").get("/a/hw/work").json()
    assert work["results"]["p2.determinant"]["points"] == 0.75
    assert work["results"]["p2.determinant"]["comment"] == "a metre too much"
    results = staff.get(f"/a/hw/class/results?since={results['version']}").json()
    assert [row["score"] for row in results["students"]] == [0.75, 0.75, None]
    assert results["actions"][0]["by"] == "Grace"
    for _ in range(2):  # the second time, there is nothing to take back
        staff.send("POST", "/a/hw/class/overrides", {"group": group["group"], "points": None, "comment": ""})
    assert not PointsOverride.objects.exists()
    summaries = [action["summary"] for action in staff.get("/a/hw/class/results").json()["actions"]]
    decisions = ["points and comment removed", "points: 0.75, comment “a metre too much”"]
    assert [summary.partition(": ")[2] for summary in summaries] == decisions


def test_answers_in_words_wait_for_a_person(service: Service) -> None:
    browser = service.open_browser("s001")
    assert browser.answer("p1.why", "it is stretched").json()["results"]["p1.why"]["outcome"] == "ungraded"
    staff = service.open_browser("staff:Grace")
    results = staff.get("/a/hw/class/results").json()
    titles = {part["name"]: part["title"] for part in results["parts"]}
    assert (titles["p1.why"], titles["p2.determinant"]) == ("The lost motion", ALL_QUESTIONS["determinant"].title)
    (row,) = results["to_mark"]
    assert row == {"student": service.people["s001"].pk, "part": "p1.why", "text": "it is stretched"}
    decision = {**row, "points": 2, "comment": "why?", "answer": row["text"]}
    assert staff.send("POST", "/a/hw/class/overrides", decision).status_code == 200
    assert staff.get("/a/hw/class/results").json()["to_mark"] == []
    assert browser.get("/a/hw/work").json()["results"]["p1.why"]["points"] == 2
    browser.answer("p1.why", "it is folded")  # the points belong to the other answer
    assert len(staff.get("/a/hw/class/results").json()["to_mark"]) == 1


def test_staff_see_a_students_work_with_the_solutions(service: Service) -> None:
    service.open_browser("s001").answer("p1.position", "theta1")
    staff = service.open_browser("staff:Grace")
    work = staff.get(f"/a/hw/class/students/{service.people['s001'].pk}").json()
    assert work["answers"] == {"p1.position": "theta1"}
    right = find_right_answer(service, "s001", "p1.determinant")
    assert work["solutions"]["p1.determinant"]["typed"] == right


def test_marking_again_shows_what_changes_before_it_counts(service: Service) -> None:
    browser = service.open_browser("s001")
    browser.answer("p1.position", find_right_answer(service, "s001", "p1.position").replace("sin", "cos"))
    before = browser.answer("p1.jacobian", find_right_answer(service, "s001", "p1.jacobian")).json()["score"]
    staff = service.open_browser("staff:Grace")
    state = staff.send("POST", "/a/hw/class/regrade", {}).json()
    assert (state["waiting"], state["changes"]) == (0, [])
    write_settings("", PROBLEMS.replace("points = [1, 2, 1, 3]", "points = [1, 4, 1, 3]"))
    assert staff.get("/a/hw/class/results").json()["outdated"] == 1
    assert staff.send("POST", "/a/hw/class/regrade", {}).json()["waiting"] == 1
    assert service.process_queue() == 1
    state = staff.send("POST", "/a/hw/class/regrade", {}).json()
    changes = {change["part"]: (change["before"], change["after"]) for change in state["changes"]}
    assert changes == {"p1.jacobian": (2, 4), "": (before, before + 2)}
    assert browser.get("/a/hw/work").json()["score"] == before
    assert staff.send("POST", "/a/hw/class/regrade", {"token": "other"}).status_code == 409
    assert staff.send("POST", "/a/hw/class/regrade", {"token": state["token"]}).status_code == 200
    assert browser.get("/a/hw/work").json()["score"] == before + 2
    assert staff.get("/a/hw/class/results").json()["outdated"] == 0


def test_the_changes_have_numbers_and_no_equal_marks(service: Service) -> None:
    service.open_browser("s001").answer("p2.determinant", find_right_answer(service, "s001", "p2.determinant"))
    staff = service.open_browser("staff:Grace")
    write_settings("", f'{PROBLEMS.replace(", points = [1, 2, 1, 3]", "")}[[problem]]\nfamily = "planar-2r"\n')
    staff.send("POST", "/a/hw/class/regrade", {})
    service.process_queue()
    changes = staff.send("POST", "/a/hw/class/regrade", {}).json()["changes"]
    assert changes and {change["part"][:3] for change in changes} == {"p3."}
    assert {(change["before"], change["after"]) for change in changes} == {(None, 0)}


def test_an_error_in_a_file_is_shown_and_nothing_is_graded_again(
    service: Service, caplog: pytest.LogCaptureFixture
) -> None:
    staff = service.open_browser("staff:Grace")
    results = staff.get("/a/hw/class/results").json()
    assert results["file_error"] == ""
    write_settings("variation = zeros")
    try:
        results = staff.get(f"/a/hw/class/results?since={results['version']}").json()
        assert "assignment.toml: line 3" in results["file_error"] and "is in use." in results["file_error"]
        reply = staff.send("POST", "/a/hw/class/regrade", {})
        assert (reply.status_code, reply.json()["error"]) == (409, results["file_error"])
        assert ["assignment.toml: line 3" in line for line in caplog.messages] == [True]
    finally:
        write_settings("")
    assert staff.get(f"/a/hw/class/results?since={results['version']}").json()["file_error"] == ""


def test_export_has_the_tables_of_the_class(service: Service) -> None:
    service.open_browser("s001").answer("p1.position", "theta1")
    content = service.open_browser("staff:Grace").get("/a/hw/class/export.zip").content
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        names = {"results.jsonl", "grades.csv", "overrides.csv", "roster.csv"}
        assert set(archive.namelist()) == {f"hw/{name}" for name in names}
        lines = [json.loads(line) for line in archive.read("hw/results.jsonl").splitlines()]
    assert [line["student"] for line in lines] == ["s001", "s002", "s003"]


def test_backup_restores_everything(service: Service, tmp_path: Path) -> None:
    service.open_browser("s001").answer("p1.position", "theta1")
    service.open_browser("s001").upload("a.ipynb", NOTEBOOK)
    Submission.objects.filter(answers=None).update(content=b"\x00\xff")
    before = list(Submission.objects.values())
    back_up(tmp_path / "backup.zip")
    Submission.objects.all().delete()
    Draft.objects.create(person=service.people["s001"], assignment="hw", part="p1.position", text="later")
    restore(tmp_path / "backup.zip")
    assert list(Submission.objects.values()) == before
    assert not Draft.objects.exists()
    assert service.process_queue() == 1  # the queue is in the backup, too


def test_files_are_restored_into_any_folder_but_not_beside_another_secret(service: Service, tmp_path: Path) -> None:
    path, new = tmp_path / "backup.zip", tmp_path / "deep" / "moved"
    back_up(path)
    restore_files(path, [new])
    assert load_assignment(new).problems_digest == service.assignment.problems_digest
    assert (new / "secret.txt").stat().st_mode & 0o77 == 0
    (new / "roster.csv").unlink()
    (new / "assignment.toml").write_text(f"{HEAD}due = 2027-01-10T12:00:00+00:00\n{PROBLEMS}")
    restore_files(path, [new])  # a missing file, and settings that may have changed since
    assert load_assignment(new).due_date is not None and len(load_assignment(new).roster) == 3
    other, before = tmp_path / "other", {}
    init_assignment(other, "T", "other")
    (other / "roster.csv").unlink()
    before = {file.name: file.read_bytes() for file in other.iterdir() if file.is_file()}
    with pytest.raises(QdotError, match=r"the secret, key or problems in .*other differ"):
        restore_files(path, [new, other][1:])
    assert before == {file.name: file.read_bytes() for file in other.iterdir() if file.is_file()}
    with pytest.raises(QdotError, match="the backup has hw; name each folder after its assignment"):
        restore_files(path, [tmp_path / "a", tmp_path / "b"])
    assert not (tmp_path / "a").exists()


def test_forgetting_leaves_nothing_of_a_student_in_the_database(service: Service) -> None:
    name = "Zephyrine Unforgettable"
    Person.objects.filter(student_id="s002").update(name=name)
    browser, staff = service.open_browser("s002"), service.open_browser("staff:Grace")
    browser.answer("p1.why", "unforgettable words")
    browser.send("PUT", "/a/hw/drafts", {"part": "p1.position", "text": "unforgettable draft"})
    person = service.people["s002"].pk
    decision = {"student": person, "part": "p1.why", "points": 1, "comment": "unforgettable comment"}
    staff.send("POST", "/a/hw/class/overrides", decision)
    service.open_browser("s001").answer("p1.position", "theta1")
    path = find_options().online_folder / DATABASE_FILE
    assert b"nforgettable" in path.read_bytes() + path.with_name(f"{path.name}-wal").read_bytes()
    people = find_people(name)
    assert "1 submission, 1 draft, 1 override" in next(describe_people(people))
    forget_people(people)
    files = [file for file in path.parent.rglob("*") if file.is_file()]
    assert not [file for file in files if b"nforgettable" in file.read_bytes()]
    assert (Submission.objects.count(), StaffAction.objects.count()) == (1, 0)
    assert browser.get("/a/hw/work").status_code == 401


def test_a_student_who_left_the_roster_may_not_enter(service: Service) -> None:
    browser = service.open_browser("s002")
    roster = service.folder / "roster.csv"
    content = roster.read_text()
    try:
        roster.write_text(content.replace("s002", "s009"))
        update_folder_class()
        assert browser.get("/a/hw/work").status_code == 401
    finally:
        roster.write_text(content)


@pytest.mark.parametrize("command", ["start", "links", "export", "import", "backup", "restore"])
def test_wrong_folders_get_one_line(command: str, tmp_path: Path) -> None:
    from qdot.grader.cli.main import make_program

    arguments = [str(tmp_path / "none"), "--out", str(tmp_path / "o")][: 1 if command in ("start", "import") else 3]
    arguments = [str(tmp_path / "none.zip"), *arguments[:1]] if command == "restore" else arguments
    result = CliRunner().invoke(make_program("serve"), ["serve", command, *arguments])
    assert result.exit_code == 2
    assert "none" in result.output and "Traceback" not in result.output


def test_what_no_database_can_store_is_refused(service: Service) -> None:
    staff, student = service.open_browser("staff:Grace"), service.people["s001"].pk
    decision = {"student": student, "part": "p1.jacobian", "points": 1, "comment": "\ud800"}
    assert staff.send("POST", "/a/hw/class/overrides", decision).status_code == 400
    long_group = {"group": f"p1.jacobian/{'k' * 500}", "points": 1, "comment": ""}
    for group in (long_group, {"group": "p1.jacobian/none", "points": 1, "comment": ""}):
        reply = staff.send("POST", "/a/hw/class/overrides", group)
        assert (reply.status_code, reply.json()["error"]) == (404, "There is no such group of equal answers.")
    assert not PointsOverride.objects.exists()


@pytest.mark.parametrize(
    ("due", "status", "sentence"),
    [
        ("2027-01-12T12:00:00+00:00", 200, ""), ("2027-01-08T12:00:00+00:00", 200, ""),
        ("0001-01-01T00:00:00+00:00", 400, "2027-01-15T23:59:00"), ("9999-12-31T23:59:59-12:00", 400, "2027-01-15T"),
        ("tomorrow", 400, "2027-01-15T23:59:00"), (True, 400, "2027-01-15T23:59:00"),
    ],
)  # fmt: skip
def test_impossible_due_dates_are_refused_with_an_example(due: object, status: int, sentence: str) -> None:
    with serve_class("due = 2027-01-10T12:00:00+00:00") as service:
        staff = service.open_browser("staff:Grace")
        reply = staff.send("POST", "/a/hw/class/extensions", {"student": service.people["s001"].pk, "due": due})
        assert reply.status_code == status and sentence in reply.json().get("error", "")
        unknown = staff.send("POST", "/a/hw/class/extensions", {"student": 99_999, "due": None})
        assert (unknown.status_code, unknown.json()["error"]) == (404, "Your class has no such student.")


def test_extensions_of_the_roster_and_of_the_page_are_shown(service: Service) -> None:
    path, own, online = service.folder / "roster.csv", "2027-01-12T12:00:00+00:00", "2027-01-13T12:00:00+00:00"
    content = path.read_text()
    write_settings("due = 2027-01-10T12:00:00+00:00")
    try:
        path.write_text(f"student,name,due\ns001,Ada,{own}\ns002,Bo,\ns003,Cy,\n")
        staff, numbers = service.open_browser("staff:Grace"), [service.people[f"s00{i}"].pk for i in (1, 2)]
        send = partial(staff.send, "POST", "/a/hw/class/extensions")
        assert send({"student": numbers[1], "due": online}).status_code == 200
        assert [row["due"] for row in staff.get("/a/hw/class/results").json()["students"]] == [own, online, None]
        with zipfile.ZipFile(io.BytesIO(staff.get("/a/hw/class/export.zip").content)) as archive:
            table = csv.DictReader(archive.read("hw/grades.csv").decode("utf-8-sig").splitlines())
        assert [row["due"] for row in table] == [own, online, ""]
        reply = send({"student": numbers[0], "due": None})
        assert (reply.status_code, "roster.csv" in reply.json()["error"]) == (409, True)
        assert send({"student": numbers[1], "due": None}).status_code == 200
    finally:
        path.write_text(content)


def test_too_many_requests_say_when_to_come_back(service: Service, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("qdot.grader.serve.rates.SECONDS", 60.0)
    monkeypatch.setattr("qdot.grader.serve.rates._times", defaultdict(deque))
    monkeypatch.setattr("qdot.grader.serve.student_pages.READS_PER_MINUTE", 2)
    browser = service.open_browser("s001")
    replies = [browser.get("/a/hw/work") for _ in range(3)]
    assert [reply.status_code for reply in replies] == [200, 200, 429]
    assert int(replies[2]["Retry-After"]) > 0
