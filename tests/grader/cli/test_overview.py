"""The overviews of families and of ready-made sets; a set gets harder and its solutions get full marks."""

import json
import re
import shutil
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import pytest

from qdot.exercises.assignment.assignment import load_assignment
from qdot.exercises.assignment.sets import DEFAULT_SET, SETS
from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.variation import list_variation_axes
from qdot.exercises.families import FAMILIES
from qdot.exercises.families.robot_family import read_robot_family
from qdot.exercises.generation import check_questions, find_listing, sample_chain
from qdot.exercises.problem.problem import ProblemId
from qdot.exercises.questions import QUESTIONS
from qdot.exercises.robots.library import find_robot_path
from qdot.exercises.robots.robot_file import read_robot_file
from qdot.exercises.singularities.difficulty import rate_difficulty
from qdot.grader.cli.main import app
from qdot.grader.cli.overview import LINE_WIDTH, describe_families, group_families_by_heading
from tests.support.command import run, run_and_fail, runner
from tests.support.suites import select_for_suite


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


GRADED_SETS = select_for_suite(("mid-term",), tuple(SETS))
"""The sets that are generated and graded; `make test` only reads the others."""


@pytest.mark.parametrize("name", SETS)
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


@pytest.mark.parametrize("name", GRADED_SETS)
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
