"""`qdot families`: every family once, and what is said of its questions is what can be asked, in every form."""

import json
import re
from dataclasses import replace
from pathlib import Path

import pytest

from exercises.arm.library import robot_path
from exercises.arm.robot_file import read_robot_file
from exercises.errors import QdotError
from exercises.families import FAMILIES
from exercises.families.own import own_family
from exercises.generation import check_questions, listed, sample_chain
from exercises.overview import TOPICS, WIDTH, asked_in_topics, kinds, overview
from exercises.problem import ProblemId
from exercises.questions import QUESTIONS
from grader.cli import app
from tests.support.command import fails, run, runner


def test_every_question_has_one_topic() -> None:
    assert sorted(name for names in TOPICS.values() for name in names) == sorted(QUESTIONS)
    assert not set(TOPICS) & set(QUESTIONS), "a topic would be taken for a question"


@pytest.mark.parametrize("name", FAMILIES)
def test_the_topics_of_a_family_are_what_can_be_asked_of_it(name: str) -> None:
    asked: list[str] = []
    for told in re.split(r", (?![^(]*\))", asked_in_topics(listed(name).questions)):
        topic, _, without = told.partition(" (without ")
        asked += [q for q in TOPICS.get(topic, (topic,)) if q not in without.rstrip(")").split(", ")]
    assert sorted(asked) == sorted(listed(name).questions)


def test_the_overview_has_every_family_once_among_its_kind() -> None:
    text = overview()
    shown = re.findall(r"(?m)^  ([a-z0-9-]+) +(?:[RP]+|varied) ", text)
    assert sorted(shown) == sorted(FAMILIES)
    assert shown == [family.name for families in kinds().values() for family in families]
    assert max(map(len, text.splitlines())) <= WIDTH
    assert len(text.splitlines()) < 3 * len(FAMILIES) + 30
    kind_of = {family.name: kind for kind, families in kinds().items() for family in families}
    assert kind_of["planar-pr"] == "Planar arms"  # in a vertical plane
    assert (kind_of["scara"], kind_of["stanford-6r"]) == ("Spatial arms with slides", "Arms of five to seven joints")
    assert (kind_of["wrist-zyz"], kind_of["random-2"]) == ("Wrists", "Arms whose structure is drawn, too")


@pytest.mark.parametrize("name", ["planar-rpr", "pan-tilt", "lbr-7r", "random-4"])
def test_one_family_tells_of_every_question_whether_it_can_be_asked_and_why_not(name: str) -> None:
    row = json.loads(run("families", name, "--json"))
    assert row["questions"] == list(listed(name).questions)
    assert sorted(row["questions"] + list(row["refused"])) == sorted(QUESTIONS)
    chain = sample_chain(ProblemId(name, 0))
    assert all(why == QUESTIONS[question].refusal(chain) for question, why in row["refused"].items())
    text = " ".join(run("families", name).split())
    can, _, cant = text.partition("can't be asked")
    assert all(re.search(rf"[ ,]{question}[, ]", can) for question in row["questions"])
    assert all(re.search(rf"[ ,]{question}[,:]", cant) and why in cant for question, why in row["refused"].items())


def test_a_robot_is_told_as_a_family_is(tmp_path: Path) -> None:
    """One of the library, by any spelling of its name, and one of a file, with what is odd about it."""
    for name, file in (("UR-5", robot_path("ur5")), (str(tmp_path / "my arm.csv"), tmp_path / "my arm.csv")):
        if not file.exists():
            file.write_text("kind,theta,d,a,alpha\nR,q1,0,400,0\nR,q2,0,a2,0\n")
        row = json.loads(run("families", name, "--json"))
        chain = read_robot_file(file).chain
        assert row["questions"] == [one for one, question in QUESTIONS.items() if question.refusal(chain) is None]
        assert row["refused"] == {one: why for one, q in QUESTIONS.items() if (why := q.refusal(chain)) is not None}
        assert row["joints"] == "".join(joint.kind for joint in chain.joints)
    told = runner.invoke(app, ["families", str(tmp_path / "my arm.csv")])
    assert "is this in millimetres?" in told.stderr
    assert f"qdot solve '{tmp_path / 'my arm.csv'}'" in told.stdout and "qdot show" not in told.stdout


def test_a_robot_that_is_taken_for_a_family_is_told_as_what_it_is() -> None:
    assert 'ur5 is no family but a real robot: robot = "ur5" in assignment.toml' in fails("show", "ur5/3")
    assert "there is no file none.toml" in fails("families", "none.toml")


def test_what_a_robot_can_not_be_asked_points_to_what_it_can() -> None:
    said = "`qdot families {}` lists what can"
    for path, named in ((robot_path("scorbot"), "scorbot"), (robot_path("scorbot", Path("x/..")), "scorbot")):
        with pytest.raises(QdotError, match=re.escape(said.format(named))):
            check_questions(own_family(path), ["determinant"])
    with pytest.raises(QdotError, match=re.escape(said.format("planar-3r"))):
        check_questions("planar-3r", ["determinant"])


def test_what_can_be_asked_is_told_of_a_convention() -> None:
    """And a refusal in a convention points to what can be asked in it."""
    for name, chain in (
        ("planar-2r", sample_chain(ProblemId("planar-2r", 0, convention="screws"))),
        ("scorbot", replace(read_robot_file(robot_path("scorbot")).chain, convention="screws")),
    ):
        row = json.loads(run("families", name, "--convention", "screws", "--json"))
        assert row["questions"] == [one for one, question in QUESTIONS.items() if question.refusal(chain) is None]
        assert "home-screws" in row["questions"] and "transform" in row["refused"]
    assert "qdot show planar-2r/1@screws" in run("families", "planar-2r", "--convention", "screws")
    assert "did you mean 'modified-dh'" in fails("families", "planar-2r", "--convention", "craig")
    assert "--convention is for one family or robot" in fails("families", "--convention", "screws")
    with pytest.raises(QdotError, match="`qdot families scorbot --convention screws` lists what can"):
        check_questions(own_family(robot_path("scorbot")), ["determinant"], convention="screws")


def test_a_family_that_is_none_is_told() -> None:
    assert "unknown family 'planer-2r' (did you mean 'planar-2r'?)" in fails("families", "planer-2r")


def test_how_far_it_is_is_told_of_a_robot(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of one whose questions take long; where standard error is no terminal, by a line a minute."""
    monkeypatch.setattr("exercises.console.EVERY", 0.0)
    told = runner.invoke(app, ["families", "scorbot"])
    count = len(QUESTIONS)
    assert f"looking at what scorbot can be asked: {count} of {count}\n" in told.stderr
    assert "looking" not in told.stdout
    assert "looking" not in runner.invoke(app, ["families", "planar-2r"]).stderr
