"""Commands on the machine and on everything there is: the demonstration, doctor, families, questions and robots."""

import json
import re
import shutil
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import pytest

from qdot.exercises.assignment.assignment import Assignment, Student, load_assignment
from qdot.exercises.assignment.release import init_assignment
from qdot.exercises.assignment.sets import DEFAULT_SET, SETS
from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.variation import list_variation_axes
from qdot.exercises.families import FAMILIES
from qdot.exercises.families.robot_family import read_robot_family
from qdot.exercises.generation import check_questions, find_listing, sample_chain
from qdot.exercises.problem.problem import Problem, ProblemId
from qdot.exercises.questions import QUESTIONS
from qdot.exercises.robots.library import find_robot_path
from qdot.exercises.robots.robot_file import read_robot_file
from qdot.exercises.singularities.difficulty import rate_difficulty
from qdot.grader.cli.demo import EDITS, SECRET
from qdot.grader.cli.main import app
from qdot.grader.cli.overview import LINE_WIDTH, describe_families, group_families_by_heading
from qdot.grader.marking.marking import mark
from qdot.grader.sandbox import guarantees
from qdot.grader.sandbox.sandbox import Sandbox
from tests.support.command import run, run_and_fail, runner
from tests.support.suites import sample_for_suite, select_for_suite


def test_the_overview_lists_every_family_once_under_its_kind() -> None:
    text = describe_families()
    shown = re.findall(r"(?m)^  ([a-z0-9-]+) +(?:[RP]+|varied) ", text)
    assert sorted(shown) == sorted(FAMILIES)
    assert shown == [family.name for families in group_families_by_heading().values() for family in families]
    assert max(map(len, text.splitlines())) <= LINE_WIDTH
    assert len(text.splitlines()) < 3 * len(FAMILIES) + 30
    kind_of = {family.name: kind for kind, families in group_families_by_heading().items() for family in families}
    assert kind_of["planar-pr"] == "Planar arms"  # in a vertical plane
    assert kind_of["scara"] == "Spatial arms with prismatic joints"
    assert kind_of["stanford-6r"] == "Arms of five to seven joints"
    assert (kind_of["wrist-zyz"], kind_of["random-2"]) == ("Wrists", "Arms with a random structure")


@pytest.mark.parametrize("name", ["planar-rpr", "pan-tilt", "lbr-7r", "random-4"])
def test_a_family_lists_its_questions_and_why_others_are_refused(name: str) -> None:
    row = json.loads(run("families", name, "--json"))
    assert row["questions"] == list(find_listing(name).questions)
    assert sorted(row["questions"] + list(row["refused"])) == sorted(QUESTIONS)
    chain = sample_chain(ProblemId(name, 0))
    assert all(reason == QUESTIONS[question].find_obstacle(chain) for question, reason in row["refused"].items())
    text = " ".join(run("families", name).split())
    asked, _, refused = text.partition("not applicable")
    assert all(re.search(rf"[ ,]{question}[, ]", asked) for question in row["questions"])
    assert all(re.search(rf"[ ,]{question}[,:]", refused) for question in row["refused"])
    assert all(reason in refused for reason in row["refused"].values())


def test_a_robot_is_described_like_a_family(tmp_path: Path) -> None:
    """Try a robot of the library, by any spelling of its name, and a robot file with an odd length."""
    for name, path in (("UR-5", find_robot_path("ur5")), (str(tmp_path / "my arm.toml"), tmp_path / "my arm.toml")):
        if not path.exists():
            row = '[[joint]]\nkind = "R"\ntheta = "q%d"\nd = 0\na = %s\nalpha = 0\n'
            path.write_text('name = "mine"\n' + row % (1, 400) + row % (2, '"a2"'))
        row = json.loads(run("families", name, "--json"))
        chain = read_robot_file(path).chain
        reasons = {question: QUESTIONS[question].find_obstacle(chain) for question in QUESTIONS}
        assert row["questions"] == [question for question, reason in reasons.items() if reason is None]
        assert row["refused"] == {question: reason for question, reason in reasons.items() if reason is not None}
        assert row["joints"] == "".join(joint.kind for joint in chain.joints)
    result = runner.invoke(app, ["families", str(tmp_path / "my arm.toml")])
    assert "is this in millimetres?" in result.stderr
    assert f"qdot solve '{tmp_path / 'my arm.toml'}'" in result.stdout and "qdot show" not in result.stdout


def test_a_robot_given_as_a_family_is_recognised() -> None:
    assert 'robot = "ur5"' in run_and_fail("show", "ur5/3")
    assert "none.toml" in run_and_fail("families", "none.toml")
    assert "'planer-2r' (did you mean 'planar-2r'?)" in run_and_fail("families", "planer-2r")


def test_a_refused_question_points_to_the_list_of_questions() -> None:
    scorbot = read_robot_family(find_robot_path("scorbot"))
    scorbot_elsewhere = read_robot_family(find_robot_path("scorbot", Path("x/..")))
    for family, command in ((scorbot, "scorbot"), (scorbot_elsewhere, "scorbot"),
                            ("planar-3r", "planar-3r")):  # fmt: skip
        with pytest.raises(QdotError, match=f"`qdot families {command}`"):
            check_questions(family, ["determinant"])
    with pytest.raises(QdotError, match="`qdot families scorbot --convention screws`"):
        check_questions(scorbot, ["determinant"], convention="screws")


@pytest.mark.parametrize("name", ["planar-2r", pytest.param("scorbot", marks=pytest.mark.whole)])
def test_a_convention_decides_which_questions_apply(name: str) -> None:
    chain = (
        sample_chain(ProblemId(name, 0, convention="screws")) if name in FAMILIES
        else replace(read_robot_file(find_robot_path(name)).chain, convention="screws")
    )  # fmt: skip
    row = json.loads(run("families", name, "--convention", "screws", "--json"))
    assert row["questions"] == [key for key, question in QUESTIONS.items() if question.find_obstacle(chain) is None]
    assert "home-screws" in row["questions"] and "transform" in row["refused"]
    assert f"{name}/1@screws" in run("families", name, "--convention", "screws") or name not in FAMILIES
    assert "'modified-dh'" in run_and_fail("families", name, "--convention", "craig")
    assert "--convention" in run_and_fail("families", "--convention", "screws")


@pytest.mark.parametrize("name", sample_for_suite(SETS, 4))
def test_a_set_gets_harder_and_states_its_size(name: str, tmp_path: Path) -> None:
    """No problem varies less than the one before it, and the last is harder than the first."""
    run("init", tmp_path / "hw", "--set", name)
    slots, chosen = load_assignment(tmp_path / "hw").slots, SETS[name]
    varied = [set(list_variation_axes(slot.variation)) for slot in slots]
    assert all(before <= after for before, after in pairwise(varied))
    arms = [sample_chain(ProblemId(slot.family.name, 0, variation=slot.variation)) for slot in slots]
    assert rate_difficulty(arms[-1]) > rate_difficulty(arms[0]) or len({slot.family.name for slot in slots}) < len(
        slots
    )
    assert chosen.total_points == sum(sum(slot.max_points) for slot in slots)
    first, *_ = (tmp_path / "hw" / "assignment.toml").read_text(encoding="utf-8").splitlines()
    assert all(f"{number:g} {unit}" in first for number, unit in (
        (chosen.problem_count, "problems"), (chosen.total_points, "points"), (chosen.minutes, "minutes"),
    ))  # fmt: skip
    assert 1 <= chosen.minutes / chosen.total_points <= 6


@pytest.mark.whole
@pytest.mark.parametrize("name", SETS)
def test_a_sets_solutions_get_full_marks(name: str, tmp_path: Path) -> None:
    run("init", tmp_path, "--set", name)
    (tmp_path / "roster.csv").write_text("student\ns001\n", encoding="utf-8")
    run("generate", tmp_path, "--jobs", "1")
    shutil.copytree(tmp_path / "solutions" / "s001", tmp_path / "submitted" / "s001")
    run("grade", tmp_path, "--jobs", "1")
    (result,) = map(json.loads, (tmp_path / "graded" / "results.jsonl").read_text(encoding="utf-8").splitlines())
    assert result["score"] == result["max_score"] == SETS[name].total_points


def test_sets_are_listed_and_an_unknown_set_is_an_error() -> None:
    listing = run("init", "--list")
    assert all(name in listing and preset.title in listing for name, preset in SETS.items())
    assert listing.startswith(DEFAULT_SET)
    assert "'quizz' (did you mean 'quiz'?)" in run_and_fail("init", "x", "--set", "quizz")
    assert "give the folder" in run_and_fail("init")


MISTAKES = {
    "wrong sign throughout": {
        "sign", "determinant-sign", "determinant-plus",  # may give the same joint rates for 2 × 2 matrices
        "singular-taken-for-regular", "regular-taken-for-singular",  # the student answers every choice with A
        "arm-reversed",  # the same
    },
    "relative for absolute angles": {"relative-angle", "all-relative-angles", "relative-throughout"},
    "matrices transposed": {"transposed"},
    "joint 2 forgotten": {"joint-left-out"},
    "degrees for radians": {"angles-in-degrees", "rates-in-degrees"},
    "only the first condition": {"one-root-only", "shoulder-missed", "condition-missed"},
}  # fmt: skip
STUDENTS = ("s003", "s004", "s005", "s006", "s007", "s008")


@pytest.fixture(scope="module")
def demonstration(tmp_path_factory: pytest.TempPathFactory) -> Assignment:
    folder = tmp_path_factory.mktemp("demo") / "hw"
    init_assignment(folder, "T", "velocity", [Student(name) for name in STUDENTS], SECRET)
    return load_assignment(folder)


def make_answers(sandbox: Sandbox, problem: Problem, kind: str) -> dict[str, str]:
    edit, names = EDITS[kind], sorted({*problem.symbols, "theta1", "theta2", "theta3", "qd2"})
    codes = {part.name.replace("-", "_"): edit(part.answer.write_code(), part) for part in problem.parts}
    setup = f"from sympy import *\n{', '.join(names)} = symbols('{' '.join(names)}')"
    run = sandbox.run([setup, *(f"{name} = {code}" for name, code in codes.items())], list(codes))
    assert not run.cell_errors, run.cell_errors
    return {part.name: run.answers[part.name.replace("-", "_")] for part in problem.parts}


@pytest.mark.parametrize("kind", select_for_suite(["degrees for radians", "joint 2 forgotten"], list(MISTAKES)))
def test_planted_mistakes_are_diagnosed(kind: str, demonstration: Assignment, sandbox: Sandbox, tmp_path: Path) -> None:
    named: set[str] = set()
    for student in STUDENTS[: select_for_suite(1, 3)]:
        for slot, problem in demonstration.generate_problems(student):
            verdicts = mark(problem, make_answers(sandbox, problem, kind), secret=SECRET, functions_seed=slot)
            diagnoses = [verdict.diagnosis for verdict in verdicts if verdict.diagnosis and verdict.diagnosis.mistakes]
            named |= {name for diagnosis in diagnoses for name in diagnosis.mistakes}
            wrong = [verdict for verdict in verdicts if verdict.judgement.share < 1]
            assert not wrong or diagnoses, (problem.id, [verdict.judgement.reason for verdict in wrong])
    assert named and named <= MISTAKES[kind], named


MISSING_MEASURES = ("namespaces", "landlock", "seccomp")
TOML = 'title = "T"\nkey = "hw"\n{}[[problem]]\nfamily = "polar-rp"\nquestions = ["position"]\n'


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    folder = tmp_path / "hw"
    run("init", folder, "--key", "hw")
    (folder / "assignment.toml").write_text(TOML.format(""))
    run("generate", folder, "--jobs", "1")
    return folder


@pytest.fixture
def weak_machine(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pretend that the machine has neither namespaces nor Landlock nor seccomp."""
    findings = guarantees.probe(MISSING_MEASURES, quick=True)
    monkeypatch.setattr(guarantees, "probe", lambda **_: findings)


def test_doctor_lists_every_guarantee() -> None:
    result = runner.invoke(app, ["doctor"])
    assert result.exit_code == 0
    for name in guarantees.PROMISES:
        assert f"\n{name} " in result.stdout
    report = json.loads(runner.invoke(app, ["doctor", "--json"]).stdout)
    assert {"python", "sympy", "numpy", "qdot", "cores", "strict", "guarantees", "lacking"} <= report.keys()
    assert [guarantee["name"] for guarantee in report["guarantees"]] == list(guarantees.PROMISES)
    assert report["strict"] == ({each["by"] for each in report["guarantees"]} == {guarantees.ENFORCED_BY_KERNEL})
    can = "can" if report["strict"] else "can't"
    assert f'this machine {can} use sandbox = "strict"' in result.stdout


def test_doctor_says_what_is_missing_and_how_to_get_it(weak_machine: None) -> None:
    result = runner.invoke(app, ["doctor"])
    assert result.exit_code == 0
    for words in (
        "watched in Python only", "namespaces: not available", "Allow user namespaces", "this machine can't use",
    ):  # fmt: skip
        assert words in result.stdout


def test_strict_runs_nothing_on_a_weak_machine(folder: Path, weak_machine: None) -> None:
    (folder / "assignment.toml").write_text(TOML.format('sandbox = "strict"\n'))
    result = runner.invoke(app, ["grade", str(folder), str(folder / "solutions"), "--jobs", "1"])
    assert result.exit_code == 2
    (line,) = result.stderr.splitlines()
    assert 'requires sandbox = "strict"' in line and "files: watched in Python only" in line
    assert "Allow user namespaces" in line and line.endswith("nothing was run")
    assert not (folder / "graded").exists()


def test_best_warns_in_one_line_and_grades(folder: Path, weak_machine: None) -> None:
    result = runner.invoke(app, ["grade", str(folder), str(folder / "solutions"), "--jobs", "1"])
    assert result.exit_code == 0
    lines = [line for line in result.stderr.splitlines() if "sandbox" in line]
    assert len(lines) == 1 and "network: watched in Python only" in lines[0]


@pytest.mark.whole
def test_strict_grades_if_the_machine_can_enforce_it(folder: Path) -> None:
    before = load_assignment(folder)
    (folder / "assignment.toml").write_text(TOML.format('sandbox = "strict"\n'))
    after = load_assignment(folder)
    assert (after.sandbox, before.sandbox) == ("strict", "best")
    assert (after.problems_digest, after.notebook_digest, after.marking_digest) == (
        before.problems_digest,
        before.notebook_digest,
        before.marking_digest,
    )
    result = runner.invoke(app, ["grade", str(folder), str(folder / "solutions"), "--jobs", "1"])
    if guarantees.probe().is_strict:
        assert result.exit_code == 0 and "2 graded; mean 100.0 %" in result.stdout
    else:
        assert result.exit_code == 2


def test_an_unknown_level_is_an_error_with_its_line(folder: Path) -> None:
    (folder / "assignment.toml").write_text(TOML.format('sandbox = "Strict"\n'))
    assert 'assignment.toml: line 3: sandbox = "Strict": ' in run_and_fail("grade", folder)


@pytest.mark.parametrize("without", [{"seccomp"}, {"limits"}, {"privileges"}, {"namespaces", "landlock"}])
def test_a_strict_sandbox_that_starts_with_less_runs_nothing(without: set[str]) -> None:
    with (
        Sandbox(disabled_measures=without, load_libraries=False, strict=True) as sandbox,
        pytest.raises(QdotError, match="isolated strictly"),
    ):
        sandbox.run(["a = 1"], ["a"])
