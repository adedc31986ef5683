"""The PrairieLearn course, run as its documentation says: generate, render, parse, grade, with JSON between all steps.

With QDOT_PRAIRIELEARN=FOLDER, a checkout of PrairieLearn, info.json and infoCourse.json are validated against its
published JSON Schemas (they are under the AGPL, and no part of qdot); without it against what its pages document.
"""

import importlib.util
import json
import os
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
from tests.support.prairielearn_forms import fill_form
from tests.support.submitting import make_class

TOML = """title = "Velocity \\"kinematics\\""
key = "Hw"
hints = true
[[problem]]
family = "planar-2r"
questions = ["position", "jacobian", "determinant", "joint-rates", "singular-angles", "singularity-type"]
points = [1, 2, 1, 1.5, 2, 1]
[[problem]]
family = "scara"
questions = ["jacobian", "lost-motion", "dependence"]
[[problem]]
robot = "arm.toml"
questions = ["velocity", "rank"]
[[problem]]
family = "elbow-3r"
questions = ["singular-configurations", "match-columns", "true-or-false", "singular-drawing", "jacobian-size", "speed"]
"""
ROBOT = """name = "Slide"
task = ["vx", "vz"]
joint = [
    {kind = "P", theta = 0, d = "d1", a = 0, alpha = "pi/2"}, {kind = "R", theta = "theta2", d = 0, a = "a2", alpha = 0}
]
"""
Data = dict[str, Any]


@pytest.fixture(scope="module")
def order(tmp_path_factory: pytest.TempPathFactory) -> ExportRequest:
    folder = tmp_path_factory.mktemp("pl") / "hw"
    make_class(folder, [Student("ada")])
    (folder / "assignment.toml").write_text(TOML)
    (folder / "arm.toml").write_text(ROBOT)
    return ExportRequest(load_assignment(folder), lambda _: [], variant_count=2)


@pytest.fixture(scope="module")
def course(order: ExportRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    root = tmp_path_factory.mktemp("course")
    for file in EXPORT_FORMATS["prairielearn"].export(order):
        path = root / file.path
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(file.content if isinstance(file.content, str) else file.content.decode())
        assert file.is_private == (file.path.startswith("serverFilesCourse") and not file.path.endswith("README.md"))
    return root


@pytest.fixture(scope="module")
def problems(order: ExportRequest) -> dict[str, list[Problem]]:
    found: dict[str, list[Problem]] = {}
    for variant in iterate_bank(order):
        found.setdefault(variant.slot.name, []).append(variant.problem)
    return found


class Question:
    """A question's folder as the platform runs it: every step gets and returns plain JSON."""

    def __init__(self, course: Path, qid: str, seed: int) -> None:
        self.folder = course / "questions" / qid
        self.server = module(self.folder / "server.py")
        self.data: Data = {
            "params": {}, "correct_answers": {}, "submitted_answers": {}, "raw_submitted_answers": {},
            "format_errors": {}, "partial_scores": {}, "score": 0, "feedback": {}, "variant_seed": seed,
            "options": {"server_files_course_path": str(course / "serverFilesCourse")},
        }  # fmt: skip
        self.step("generate")
        for name, offered in self.data["correct_answers"]["options"].items():
            if isinstance(offered, list):  # as the elements put them, in a fixed order
                shown = [{"key": "abcdefgh"[k], "html": one["html"]} for k, one in enumerate(offered)]
                self.data["params"][name] = shown

    def step(self, name: str) -> None:
        data = json.loads(json.dumps(self.data))
        assert getattr(self.server, name)(data) is None
        self.data = json.loads(json.dumps(data))

    def page(self, panel: str) -> str:
        """Return what a panel shows: Mustache first, then the elements that are for this panel only."""
        text = chevron.render((self.folder / "question.html").read_text(), self.data)
        for other in {"question", "submission", "answer"} - {panel}:
            text = re.sub(rf"<pl-{other}-panel>.*?</pl-{other}-panel>", "", text, flags=re.DOTALL)
        return text

    def submit(self, answers: Data) -> None:
        """Parse and, if there is no format error, grade."""
        given = {"submitted_answers": dict(answers), "raw_submitted_answers": dict(answers)}
        self.data |= given | {"format_errors": {}, "partial_scores": {}, "feedback": {}}
        self.step("parse")
        if not self.data["format_errors"]:
            self.step("grade")


def module(path: Path) -> ModuleType:
    spec = importlib.util.spec_from_file_location("server", path)
    assert spec is not None and spec.loader is not None
    found = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(found)
    return found


def form(question: Question, problem: Problem, answers: dict[str, str]) -> Data:
    """Return what a browser sends for the answers to some parts, by their names."""
    sent: Data = {}
    for name, text in answers.items():
        sent |= fill_form(problem[name], text, question.data["params"])
    return sent


def problem_of(question: Question, problems: list[Problem]) -> Problem:
    (found,) = [problem for problem in problems if str(problem.id.seed) == question.data["params"]["seed"]]
    return found


# --- files ---

UUID, TEXT = {"pattern": "^[0-9a-f]{8}(-[0-9a-f]{4}){3}-[0-9a-f]{12}$"}, {"type": "string", "minLength": 1}


def holding(required: Data, **others: Data) -> Data:
    properties = required | others
    return {"type": "object", "required": [*required], "additionalProperties": False, "properties": properties}


DOCUMENTED = holding({"uuid": UUID, "type": {"const": "v3"}, "title": TEXT, "topic": TEXT}, tags={"items": TEXT})
ASSESSED = holding(
    {"uuid": UUID, "type": {"enum": ["Homework", "Exam"]}, "title": TEXT, "set": TEXT, "number": TEXT, "zones": {}},
    shuffleQuestions={"type": "boolean"}, requireHonorCode={"type": "boolean"},
)  # fmt: skip
NAMED: Data = {"type": "object", "required": ["uuid", "longName"]}
SCHEMAS = "apps/prairielearn/src/schemas/schemas"


def schemas() -> list[Data]:
    if "QDOT_PRAIRIELEARN" not in os.environ:
        return [DOCUMENTED, {"type": "object", "required": ["name", "title", "topics"]}, NAMED, ASSESSED]
    folder = Path(os.environ["QDOT_PRAIRIELEARN"]) / SCHEMAS
    names = ("Question", "Course", "CourseInstance", "Assessment")
    return [json.loads((folder / f"info{name}.json").read_text()) for name in names]


def loaded(path: Path) -> Data:
    content: Data = json.loads(path.read_text())
    return content


def test_files_are_those_that_the_platform_reads(course: Path) -> None:
    question, whole, instance, assessment = schemas()
    infos = {path.parent.name: loaded(path) for path in sorted(course.glob("questions/*/info.json"))}
    assert (
        list(infos) == sorted(path.name for path in course.glob("questions/*")) == ["hw-p1", "hw-p2", "hw-p3", "hw-p4"]
    )
    info = loaded(course / "infoCourse.json")
    jsonschema.validate(info, whole)
    jsonschema.validate(loaded(course / "courseInstances/qdot/infoCourseInstance.json"), instance)
    for path in course.glob("courseInstances/qdot/assessments/*/infoAssessment.json"):
        jsonschema.validate(loaded(path), assessment)
    for one in infos.values():
        jsonschema.validate(one, question)
    assert {one["topic"] for one in infos.values()} == {topic["name"] for topic in info["topics"]}
    assert {tag for one in infos.values() for tag in one["tags"]} == {tag["name"] for tag in info["tags"]}


def test_assessments_ask_every_question_in_order_for_its_points(course: Path, order: ExportRequest) -> None:
    folder = course / "courseInstances/qdot/assessments"
    homework, exam = (loaded(folder / f"hw-{kind}/infoAssessment.json") for kind in ("homework", "exam"))
    worth = {f"hw-{slot.name}": sum(slot.max_points) for slot in order.assignment.slots}
    (practice,), (once,) = homework["zones"], exam["zones"]
    assert {one["id"]: one["autoPoints"] for one in practice["questions"]} == worth
    assert {one["triesPerVariant"] for one in practice["questions"]} == {DEFAULT_ATTEMPTS}
    assert {one["id"]: one["autoPoints"] for one in once["questions"]} == {
        k: [v] * DEFAULT_ATTEMPTS for k, v in worth.items()
    }
    assert exam["shuffleQuestions"] is False and homework["uuid"] != exam["uuid"]
    few = replace(order.assignment, attempts=AttemptPolicy(best_of=2))
    made = list(EXPORT_FORMATS["prairielearn"].export(replace(order, assignment=few, variant_count=1)))
    (again,) = [json.loads(file.content) for file in made if file.path.endswith("hw-exam/infoAssessment.json")]
    assert {len(one["autoPoints"]) for one in again["zones"][0]["questions"]} == {2}


def test_an_assessment_is_called_by_the_number_of_its_title_or_key(order: ExportRequest) -> None:
    for title, key, number in (
        ("Homework 6", "robots", "6"), ("Robots, 2nd part", "hw12", "12"), ("Arms of 2R", "velocity-3r", "1"),
    ):  # fmt: skip
        assert find_assignment_number(replace(order.assignment, title=title, key=key)) == number


def test_uuids_stay_and_belong_to_one_question(course: Path, order: ExportRequest) -> None:
    found = [loaded(path)["uuid"] for path in sorted(course.glob("questions/*/info.json"))]
    assert len({uuid.UUID(text) for text in found}) == 4
    for secret, is_same in ((order.assignment.secret, True), ("another", False)):
        given = replace(order.assignment, secret=secret, slots=order.assignment.slots[2:3])
        files = EXPORT_FORMATS["prairielearn"].export(replace(order, assignment=given, variant_count=1))
        again = [json.loads(file.content)["uuid"] for file in files if "info.json" in file.path]
        assert (again == found[2:3]) == is_same and bool(set(again) & set(found)) == is_same


def test_the_secret_stays_at_home(course: Path, order: ExportRequest) -> None:
    assert not [path for path in course.rglob("*") if path.is_file() and order.assignment.secret in path.read_text()]


# --- the cycle ---


def test_a_variant_is_one_of_the_bank_by_its_seed_and_shows_no_solution(
    course: Path, problems: dict[str, list[Problem]]
) -> None:
    one, again, other = (Question(course, "hw-p1", seed) for seed in (4, 4, 7))
    assert one.data == again.data
    assert one.data["params"]["seed"] != other.data["params"]["seed"]
    problem = problem_of(one, problems["p1"])
    page = one.page("question")
    names = [name for part in problem.parts for name in list_input_names(part)]
    assert names == re.findall(r'answers-name="([^"]+)"', page)
    assert "{{" not in page and page.count('<details class="mb-2">') == 3 * len(problem.parts)  # none sticks to a box
    assert re.search(r"<svg[^>]*>\s*<title", page) and "<desc" in page  # what the figure shows, in words
    tables = re.findall('<table class="([^"]*)"', page)
    assert tables and all({"table", "table-bordered"} <= set(table.split()) for table in tables)  # of Bootstrap
    assert page.count("<h4") == page.count('<h4 class="mt-3">') > 0  # else it sticks to the figure above it
    solutions = [one["solution"] for one in one.data["correct_answers"]["solutions"].values()]
    for panel in ("question", "submission"):
        assert not [solution for solution in solutions if solution in one.page(panel)]
    assert all(solution in one.page("answer") for solution in solutions)
    shown = json.dumps(one.data["params"])
    for part in problem.parts:
        if isinstance(part.answer, (Expression, Matrix)) and part.name != "position":
            assert part.answer.as_typed() not in shown


def test_options_matches_and_numbers_have_elements_of_their_own(
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
    for tag in ("pl-checkbox", "pl-multiple-choice"):  # wide formulas move by themselves
        assert len(re.findall(rf"<{tag} ", page)) == len(re.findall(rf"overflow-x: auto[^<>]*>\s*<{tag} ", page))
    for part in problem_of(question, problems["p4"]).parts:
        offered = question.data["correct_answers"]["options"].get(part.name)
        if isinstance(offered, list):
            assert [k for k, one in enumerate(offered) if one["right"] == "true"] == list(part.answer.correct_indices)
            assert all(one["html"] in page for one in offered)
    everything = "".join(Question(course, f"hw-p{k}", 1).page(p) for k in (1, 2, 4) for p in ("question", "answer"))
    assert not [word for word in ("in quotes", "?:", "**Answer", "the letter, ") if word in everything]


@pytest.mark.parametrize("slot", ["p1", "p2", "p3", "p4"])
def test_references_earn_everything(course: Path, problems: dict[str, list[Problem]], slot: str) -> None:
    question = Question(course, f"hw-{slot}", 1)
    problem = problem_of(question, problems[slot])
    question.submit(form(question, problem, {part.name: part.answer.as_typed() for part in problem.parts}))
    assert question.data["format_errors"] == {} and question.data["score"] == 1
    scores = {name: one["score"] for name, one in question.data["partial_scores"].items()}
    assert set(scores.values()) == {1} and set(scores) >= {part.name for part in problem.parts}
    assert {one["said"] for one in question.data["feedback"].values()} == {"Right."}


def test_some_of_a_match_or_of_several_numbers_is_no_answer(course: Path) -> None:
    question = Question(course, "hw-p4", 1)
    names = [f"match-columns-dropdown-{k}" for k in range(3)]
    question.submit({**dict.fromkeys(names, "-1"), names[1]: "0", "jacobian-size-2": "3", "jacobian-size-1": ""})
    errors = question.data["format_errors"]
    assert set(errors) == {names[0], "jacobian-size-1"}
    assert "joint 1, joint 3" in errors[names[0]] and "joint 2" not in errors[names[0]]
    for sent in ("8", "9" * 5000, "\N{SUPERSCRIPT TWO}", "0x1"):  # none of which is an option
        question.submit({**dict.fromkeys(names, "0"), names[2]: sent})
        assert (
            list(question.data["format_errors"]) == [names[0]] and "joint 3" in question.data["format_errors"][names[0]]
        )


def test_options_that_are_wrong_take_off_what_right_ones_earn(course: Path, problems: dict[str, list[Problem]]) -> None:
    question = Question(course, "hw-p4", 1)
    problem = problem_of(question, problems["p4"])
    several, match, judged, *_ = problem.parts
    wrong = {
        several.name: "".join(LETTERS[k] for k in range(len(several.answer.offered_options))),
        match.name: "".join(LETTERS[k] for k in (*match.answer.correct_indices[1:], match.answer.correct_indices[0])),
        judged.name: ("true", "false")[1 - judged.answer.correct_indices[0]],
    }
    question.submit(form(question, problem, wrong))
    assert [question.data["partial_scores"][name]["score"] for name in wrong] == [0, 0, 0]
    assert question.data["score"] == 0
    assert "Right." not in {one["said"] for one in question.data["feedback"].values()}


def test_a_mistake_is_named_and_no_number_is(course: Path, problems: dict[str, list[Problem]]) -> None:
    """A variant may be tried again, so that feedback gives no value away."""
    question = Question(course, "hw-p1", 1)
    problem = problem_of(question, problems["p1"])
    jacobian, determinant = problem.parts[1].answer, problem.parts[2].answer
    assert isinstance(jacobian, Matrix) and isinstance(determinant, Expression)
    spoiled = jacobian.reference.copy()
    spoiled[0, 0] = -spoiled[0, 0]
    question.submit({"jacobian": str(spoiled.tolist()), "determinant": str(-determinant.reference), "position": ""})
    scores = {name: one["score"] for name, one in question.data["partial_scores"].items()}
    assert scores["position"] == scores["joint-rates"] == 0
    assert 0 < scores["jacobian"] < 1
    assert 0 < question.data["score"] < 0.5
    said = question.data["feedback"]
    assert "(1, 1)" in said["jacobian"]["said"]
    sentences = [CATALOGUE[name].message[:30] for name in ("determinant-sign", "sign") if name in CATALOGUE]
    assert any(said["determinant"]["advice"].startswith(sentence) for sentence in sentences)
    page = question.page("submission")
    assert said["determinant"]["advice"] in page and said["position"]["said"] in page
    question.submit({"joint-rates-1": "17", "joint-rates-2": "23", "singular-angles": "{theta1: [0]}"})
    told = json.dumps(question.data["feedback"])
    right = problem.parts[3].answer.as_matrix()
    assert "theta2" not in told and not [value for value in right if f"{float(value):.2f}" in told]
    assert [question.data["partial_scores"][f"joint-rates-{k}"]["score"] for k in (1, 2)] == [0, 0]


HOSTILE = {
    "[[1, 2], [3": "couldn't parse", "__import__('os').system('x')": "couldn't parse", "{{params.seed}}": "",
    "(" * 5000: "couldn't parse", "1+" * MAX_ANSWER_LENGTH + "1": str(MAX_ANSWER_LENGTH), "9^9^9^9^9": "",
    "<script>alert(1)</script>": "",
}  # fmt: skip


@pytest.mark.parametrize("typed", HOSTILE, ids=range(len(HOSTILE)))
def test_unreadable_and_hostile_answers(course: Path, typed: str) -> None:
    question = Question(course, "hw-p1", 1)
    question.submit({"jacobian": typed})
    if HOSTILE[typed]:
        assert HOSTILE[typed] in question.data["format_errors"]["jacobian"]
        assert question.data["partial_scores"] == {}
    else:
        assert question.data["format_errors"] or question.data["score"] == 0
    assert typed not in question.page("submission")


def test_what_is_blank_or_fails_in_qdot_or_is_of_another_engine_costs_no_attempt(
    course: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fails(*_: object) -> None:
        raise RuntimeError("ours")

    question = Question(course, "hw-p1", 1)
    for answers in ({}, {"position": "  "}, {"position": None}):
        question.submit(answers)
        assert list(question.data["format_errors"]) == ["position"]
    question = Question(course, "hw-p3", 1)
    monkeypatch.setattr("qdot.grader.marking.marking.judge_parsed", fails)
    question.submit({"rank": "2"})
    assert "qdot failed" in question.data["format_errors"]["rank"] and "rank" not in question.data["partial_scores"]
    question.data["params"]["engine"] += 1
    with pytest.raises(QdotError, match="engine"):
        question.submit({"rank": "2"})
