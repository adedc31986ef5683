"""The PrairieLearn course, run as documented: generate, render, parse, grade, with JSON between all steps.

Its files are validated against what PrairieLearn's pages document; tests/platforms/prairielearn.py runs PrairieLearn.
"""

import importlib.util
import json
import re
import uuid
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any

import chevron
import jsonschema
import pytest

from qdot.exercises.assignment.assignment import Student, load_assignment
from qdot.exercises.assignment.attempt_policy import AttemptPolicy
from qdot.exercises.common.errors import QdotError
from qdot.exercises.exports.bank import iterate_bank
from qdot.exercises.exports.export_format import DEFAULT_ATTEMPTS, ExportRequest
from qdot.exercises.exports.prairielearn import find_assignment_number, list_input_names
from qdot.exercises.exports.registry import EXPORT_FORMATS
from qdot.exercises.mistakes.catalogue import CATALOGUE
from qdot.exercises.problem.problem import Problem
from qdot.exercises.reference_answers import LETTERS, Expression, Matrix
from qdot.grader.integrations.prairielearn import MAX_ANSWER_LENGTH
from tests.support import read_data
from tests.support.prairielearn_forms import fill_form
from tests.support.submitting import make_class

TOML = read_data("assignments/prairielearn.toml")
ROBOT = read_data("slide.toml")
Data = dict[str, Any]


@pytest.fixture(scope="module")
def export_request(tmp_path_factory: pytest.TempPathFactory) -> ExportRequest:
    folder = tmp_path_factory.mktemp("pl") / "hw"
    make_class(folder, [Student("ada")])
    (folder / "assignment.toml").write_text(TOML)
    (folder / "arm.toml").write_text(ROBOT)
    return ExportRequest(load_assignment(folder), lambda _: [], variant_count=2)


@pytest.fixture(scope="module")
def course(export_request: ExportRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    root = tmp_path_factory.mktemp("course")
    for file in EXPORT_FORMATS["prairielearn"].export(export_request):
        path = root / file.path
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(file.content if isinstance(file.content, str) else file.content.decode())
        assert file.is_private == (file.path.startswith("serverFilesCourse") and not file.path.endswith("README.md"))
    return root


@pytest.fixture(scope="module")
def problems(export_request: ExportRequest) -> dict[str, list[Problem]]:
    problems_by_slot: dict[str, list[Problem]] = {}
    for variant in iterate_bank(export_request):
        problems_by_slot.setdefault(variant.slot.name, []).append(variant.problem)
    return problems_by_slot


class Question:
    """Runs a question's folder like the platform: every step gets and returns plain JSON."""

    def __init__(self, course: Path, qid: str, seed: int) -> None:
        self.folder = course / "questions" / qid
        self.server = load_module(self.folder / "server.py")
        self.data: Data = {
            "params": {}, "correct_answers": {}, "submitted_answers": {}, "raw_submitted_answers": {},
            "format_errors": {}, "partial_scores": {}, "score": 0, "feedback": {}, "variant_seed": seed,
            "options": {"server_files_course_path": str(course / "serverFilesCourse")},
        }  # fmt: skip
        self.step("generate")
        for name, offered in self.data["correct_answers"]["options"].items():
            if isinstance(offered, list):  # as the elements write them, in a fixed order
                shown = [{"key": "abcdefgh"[k], "html": option["html"]} for k, option in enumerate(offered)]
                self.data["params"][name] = shown

    def step(self, name: str) -> None:
        data = json.loads(json.dumps(self.data))
        assert getattr(self.server, name)(data) is None
        self.data = json.loads(json.dumps(data))

    def page(self, panel: str) -> str:
        """Render a panel: Mustache first, then the elements for this panel only."""
        text = chevron.render((self.folder / "question.html").read_text(), self.data)
        for hidden in {"question", "submission", "answer"} - {panel}:
            text = re.sub(rf"<pl-{hidden}-panel>.*?</pl-{hidden}-panel>", "", text, flags=re.DOTALL)
        return text

    def submit(self, answers: Data) -> None:
        submitted = {"submitted_answers": dict(answers), "raw_submitted_answers": dict(answers)}
        self.data |= submitted | {"format_errors": {}, "partial_scores": {}, "feedback": {}}
        self.step("parse")
        if not self.data["format_errors"]:
            self.step("grade")


def load_module(path: Path) -> ModuleType:
    spec = importlib.util.spec_from_file_location("server", path)
    assert spec is not None and spec.loader is not None
    loaded = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(loaded)
    return loaded


def fill_in_form(question: Question, problem: Problem, answers: dict[str, str]) -> Data:
    sent: Data = {}
    for name, text in answers.items():
        sent |= fill_form(problem[name], text, question.data["params"])
    return sent


def find_problem(question: Question, problems: list[Problem]) -> Problem:
    (problem,) = [problem for problem in problems if str(problem.id.seed) == question.data["params"]["seed"]]
    return problem


UUID, TEXT = {"pattern": "^[0-9a-f]{8}(-[0-9a-f]{4}){3}-[0-9a-f]{12}$"}, {"type": "string", "minLength": 1}


def make_schema(required: Data, **others: Data) -> Data:
    properties = required | others
    return {"type": "object", "required": [*required], "additionalProperties": False, "properties": properties}


QUESTION_SCHEMA = make_schema(
    {"uuid": UUID, "type": {"const": "v3"}, "title": TEXT, "topic": TEXT}, tags={"items": TEXT}
)
ASSESSMENT_SCHEMA = make_schema(
    {"uuid": UUID, "type": {"enum": ["Homework", "Exam"]}, "title": TEXT, "set": TEXT, "number": TEXT, "zones": {}},
    shuffleQuestions={"type": "boolean"}, requireHonorCode={"type": "boolean"},
)  # fmt: skip
INSTANCE_SCHEMA: Data = {"type": "object", "required": ["uuid", "longName"]}
COURSE_SCHEMA: Data = {"type": "object", "required": ["name", "title", "topics"]}


def read_json(path: Path) -> Data:
    content: Data = json.loads(path.read_text())
    return content


def test_files_satisfy_the_platforms_schemas(course: Path) -> None:
    infos = {path.parent.name: read_json(path) for path in sorted(course.glob("questions/*/info.json"))}
    assert list(infos) == sorted(path.name for path in course.glob("questions/*")) == [f"hw-p{k}" for k in range(1, 5)]
    info = read_json(course / "infoCourse.json")
    jsonschema.validate(info, COURSE_SCHEMA)
    jsonschema.validate(read_json(course / "courseInstances/qdot/infoCourseInstance.json"), INSTANCE_SCHEMA)
    for path in course.glob("courseInstances/qdot/assessments/*/infoAssessment.json"):
        jsonschema.validate(read_json(path), ASSESSMENT_SCHEMA)
    for question_info in infos.values():
        jsonschema.validate(question_info, QUESTION_SCHEMA)
    assert {question_info["topic"] for question_info in infos.values()} == {topic["name"] for topic in info["topics"]}
    used = {tag for question_info in infos.values() for tag in question_info["tags"]}
    assert used == {tag["name"] for tag in info["tags"]}


def test_assessments_list_every_question_with_its_points(course: Path, export_request: ExportRequest) -> None:
    folder = course / "courseInstances/qdot/assessments"
    homework, exam = (read_json(folder / f"hw-{kind}/infoAssessment.json") for kind in ("homework", "exam"))
    worth = {f"hw-{slot.name}": sum(slot.max_points) for slot in export_request.assignment.slots}
    (practice,), (once,) = homework["zones"], exam["zones"]
    assert {entry["id"]: entry["autoPoints"] for entry in practice["questions"]} == worth
    assert {entry["triesPerVariant"] for entry in practice["questions"]} == {DEFAULT_ATTEMPTS}
    for_attempts = {name: [points] * DEFAULT_ATTEMPTS for name, points in worth.items()}
    assert {entry["id"]: entry["autoPoints"] for entry in once["questions"]} == for_attempts
    assert exam["shuffleQuestions"] is False and homework["uuid"] != exam["uuid"]
    few = replace(export_request.assignment, attempt_policy=AttemptPolicy(best_of=2))
    made = list(EXPORT_FORMATS["prairielearn"].export(replace(export_request, assignment=few, variant_count=1)))
    (changed,) = [json.loads(file.content) for file in made if file.path.endswith("hw-exam/infoAssessment.json")]
    assert {len(entry["autoPoints"]) for entry in changed["zones"][0]["questions"]} == {2}


def test_assessment_number_comes_from_title_or_key(export_request: ExportRequest) -> None:
    for title, key, number in (
        ("Homework 6", "robots", "6"), ("Robots, 2nd part", "hw12", "12"), ("Arms of 2R", "velocity-3r", "1"),
    ):  # fmt: skip
        assert find_assignment_number(replace(export_request.assignment, title=title, key=key)) == number


def test_uuids_are_stable_and_depend_on_the_secret(course: Path, export_request: ExportRequest) -> None:
    ids = [read_json(path)["uuid"] for path in sorted(course.glob("questions/*/info.json"))]
    assert len({uuid.UUID(text) for text in ids}) == 4
    for secret, is_same in ((export_request.assignment.secret, True), ("another", False)):
        assignment = replace(export_request.assignment, secret=secret, slots=export_request.assignment.slots[2:3])
        files = EXPORT_FORMATS["prairielearn"].export(replace(export_request, assignment=assignment, variant_count=1))
        again = [json.loads(file.content)["uuid"] for file in files if "info.json" in file.path]
        assert (again == ids[2:3]) == is_same and bool(set(again) & set(ids)) == is_same


def test_course_does_not_contain_the_secret(course: Path, export_request: ExportRequest) -> None:
    texts = [path.read_text() for path in course.rglob("*") if path.is_file()]
    assert texts and not [text for text in texts if export_request.assignment.secret in text]


def test_variant_depends_on_its_seed_and_shows_no_solution(course: Path, problems: dict[str, list[Problem]]) -> None:
    question, repeated, different = (Question(course, "hw-p1", seed) for seed in (4, 4, 7))
    assert question.data == repeated.data
    assert question.data["params"]["seed"] != different.data["params"]["seed"]
    problem = find_problem(question, problems["p1"])
    page = question.page("question")
    names = [name for part in problem.parts for name in list_input_names(part)]
    assert names == re.findall(r'answers-name="([^"]+)"', page)
    # With a margin to the box above.
    assert "{{" not in page and page.count('<details class="mb-2">') == 3 * len(problem.parts)
    assert re.search(r"<svg[^>]*>\s*<title", page) and "<desc" in page  # the figure's description
    tables = re.findall('<table class="([^"]*)"', page)
    assert tables and all({"table", "table-bordered"} <= set(table.split()) for table in tables)  # Bootstrap's classes
    assert page.count("<h4") == page.count('<h4 class="mt-3">') > 0  # with a margin to the figure above
    solutions = [question["solution"] for question in question.data["correct_answers"]["solutions"].values()]
    for panel in ("question", "submission"):
        assert not [solution for solution in solutions if solution in question.page(panel)]
    assert all(solution in question.page("answer") for solution in solutions)
    shown = json.dumps(question.data["params"])
    for part in problem.parts:
        if isinstance(part.answer, (Expression, Matrix)) and part.name != "position":
            assert part.answer.as_typed() not in shown


def test_options_matching_and_numbers_use_the_platforms_elements(
    course: Path, problems: dict[str, list[Problem]]
) -> None:
    question = Question(course, "hw-p4", 1)
    page = question.page("question")
    tags = re.findall(r"<(pl-(?!question|answer|hide)[a-z-]+)", page.replace("pl-answer ", ""))
    inputs = [tag for tag in tags if tag.endswith(("-input", "-choice", "-checkbox", "-matching"))]
    assert inputs == [
        "pl-checkbox", "pl-matching", "pl-multiple-choice", "pl-multiple-choice", "pl-integer-input",
        "pl-integer-input", "pl-number-input",
    ]  # fmt: skip
    for tag in ("pl-checkbox", "pl-multiple-choice"):  # wide formulas scroll separately
        assert len(re.findall(rf"<{tag} ", page)) == len(re.findall(rf"overflow-x: auto[^<>]*>\s*<{tag} ", page))
    for part in find_problem(question, problems["p4"]).parts:
        offered = question.data["correct_answers"]["options"].get(part.name)
        if isinstance(offered, list):
            right = [k for k, option in enumerate(offered) if option["right"] == "true"]
            assert right == list(part.answer.correct_indices)
            assert all(option["html"] in page for option in offered)
    everything = "".join(Question(course, f"hw-p{k}", 1).page(p) for k in (1, 2, 4) for p in ("question", "answer"))
    assert not [word for word in ("in quotes", "?:", "**Answer", "the letter, ") if word in everything]


@pytest.mark.parametrize("slot", ["p1", "p2", "p3", "p4"])
def test_reference_answers_earn_full_points(course: Path, problems: dict[str, list[Problem]], slot: str) -> None:
    question = Question(course, f"hw-{slot}", 1)
    problem = find_problem(question, problems[slot])
    question.submit(fill_in_form(question, problem, {part.name: part.answer.as_typed() for part in problem.parts}))
    assert question.data["format_errors"] == {} and question.data["score"] == 1
    scores = {name: result["score"] for name, result in question.data["partial_scores"].items()}
    assert set(scores.values()) == {1} and set(scores) >= {part.name for part in problem.parts}
    assert {result["said"] for result in question.data["feedback"].values()} == {"Right."}


def test_partly_filled_answer_is_a_format_error(course: Path) -> None:
    question = Question(course, "hw-p4", 1)
    names = [f"match-columns-dropdown-{k}" for k in range(3)]
    question.submit({**dict.fromkeys(names, "-1"), names[1]: "0", "jacobian-size-2": "3", "jacobian-size-1": ""})
    errors = question.data["format_errors"]
    assert set(errors) == {names[0], "jacobian-size-1"}
    assert "joint 1, joint 3" in errors[names[0]] and "joint 2" not in errors[names[0]]
    for sent in ("8", "9" * 5000, "\N{SUPERSCRIPT TWO}", "0x1"):  # none is an option
        question.submit({**dict.fromkeys(names, "0"), names[2]: sent})
        errors = question.data["format_errors"]
        assert list(errors) == [names[0]] and "joint 3" in errors[names[0]]


def test_wrong_options_cancel_right_ones(course: Path, problems: dict[str, list[Problem]]) -> None:
    question = Question(course, "hw-p4", 1)
    problem = find_problem(question, problems["p4"])
    selection, match, judged, *_ = problem.parts
    wrong = {
        selection.name: "".join(LETTERS[k] for k in range(len(selection.answer.offered_options))),
        match.name: "".join(LETTERS[k] for k in (*match.answer.correct_indices[1:], match.answer.correct_indices[0])),
        judged.name: ("true", "false")[1 - judged.answer.correct_indices[0]],
    }
    question.submit(fill_in_form(question, problem, wrong))
    assert [question.data["partial_scores"][name]["score"] for name in wrong] == [0, 0, 0]
    assert question.data["score"] == 0
    assert "Right." not in {feedback["said"] for feedback in question.data["feedback"].values()}


def test_feedback_names_the_mistake_and_no_number(course: Path, problems: dict[str, list[Problem]]) -> None:
    """A variant may be tried again, so feedback must not reveal values."""
    question = Question(course, "hw-p1", 1)
    problem = find_problem(question, problems["p1"])
    jacobian, determinant = problem.parts[1].answer, problem.parts[2].answer
    assert isinstance(jacobian, Matrix) and isinstance(determinant, Expression)
    spoiled = jacobian.reference.copy()
    spoiled[0, 0] = -spoiled[0, 0]
    question.submit({"jacobian": str(spoiled.tolist()), "determinant": str(-determinant.reference), "position": ""})
    scores = {name: result["score"] for name, result in question.data["partial_scores"].items()}
    assert scores["position"] == scores["joint-rates"] == 0
    assert 0 < scores["jacobian"] < 1
    assert 0 < question.data["score"] < 0.5
    feedback = question.data["feedback"]
    assert "(1, 1)" in feedback["jacobian"]["said"]
    sentences = [CATALOGUE[name].message[:30] for name in ("determinant-sign", "sign") if name in CATALOGUE]
    assert any(feedback["determinant"]["advice"].startswith(sentence) for sentence in sentences)
    page = question.page("submission")
    assert feedback["determinant"]["advice"] in page and feedback["position"]["said"] in page
    question.submit({"joint-rates-1": "17", "joint-rates-2": "23", "singular-angles": "{theta1: [0]}"})
    feedback_text = json.dumps(question.data["feedback"])
    right = problem.parts[3].answer.as_matrix()
    assert "theta2" not in feedback_text and not [value for value in right if f"{float(value):.2f}" in feedback_text]
    assert [question.data["partial_scores"][f"joint-rates-{k}"]["score"] for k in (1, 2)] == [0, 0]


HOSTILE = {
    "[[1, 2], [3": "couldn't parse", "__import__('os').system('x')": "couldn't parse", "{{params.seed}}": "",
    "(" * 5000: "couldn't parse", "1+" * MAX_ANSWER_LENGTH + "1": str(MAX_ANSWER_LENGTH), "9^9^9^9^9": "",
    "<script>alert(1)</script>": "",
}  # fmt: skip


@pytest.mark.parametrize("typed", HOSTILE, ids=range(len(HOSTILE)))
def test_unparsable_and_hostile_answers_earn_nothing(course: Path, typed: str) -> None:
    question = Question(course, "hw-p1", 1)
    question.submit({"jacobian": typed})
    if HOSTILE[typed]:
        assert HOSTILE[typed] in question.data["format_errors"]["jacobian"]
        assert question.data["partial_scores"] == {}
    else:
        assert question.data["format_errors"] or question.data["score"] == 0
    assert typed not in question.page("submission")


def test_blank_answers_and_qdots_own_failures_cost_no_attempt(course: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def raise_error(*_: object) -> None:
        raise RuntimeError("ours")

    question = Question(course, "hw-p1", 1)
    for answers in ({}, {"position": "  "}, {"position": None}):
        question.submit(answers)
        assert list(question.data["format_errors"]) == ["position"]
    question = Question(course, "hw-p3", 1)
    monkeypatch.setattr("qdot.grader.marking.marking.judge_parsed", raise_error)
    question.submit({"rank": "2"})
    assert "qdot failed" in question.data["format_errors"]["rank"] and "rank" not in question.data["partial_scores"]
    question.data["params"]["engine"] += 1
    with pytest.raises(QdotError, match="engine"):
        question.submit({"rank": "2"})
