"""What `qdot solve` says of singular configurations: nothing that fails the test of a problem's certificate."""

import pytest
import sympy as sp

from exercises.arm.chain import Chain, Joint
from exercises.arm.classification import Kind
from exercises.solving import solution_data, solution_text, solve
from exercises.sound import sound_words
from exercises.verify.appearance import places_on
from exercises.writing import worked
from exercises.writing.statement import worked_steps

T1, T2, D3 = sp.symbols("theta1 theta2 d3")
A1, A2 = sp.symbols("a1 a2")
PLANAR = (Joint("R", T1, 0, A1, 0), Joint("R", T2, 0, A2, 0))

PARTS_OF_A_TASK = {
    "one row": (Chain("one row", PLANAR, ("vy",)), "no joint moves the point along y"),
    "P moves along y and z, and only x and z count": (
        Chain(
            "two of three",
            (Joint("R", T1, 0, 0, sp.pi), Joint("R", T2, -0.7, 0, sp.pi), Joint("P", sp.pi / 2, D3, 0.5, -sp.pi / 2)),
            ("vx", "vz"),
        ),
        "no joint moves the point along x",
    ),
    "an angle": (
        Chain("an angle", (Joint("R", T1, 0, 0, sp.pi / 2), Joint("R", T2, 0, A2, 0)), ("wx",)),
        "no joint turns link 2 about x",
    ),
    "a swing seen from the side": (
        Chain(
            "seen from the side",
            (Joint("R", T1, 0, 0, sp.pi / 2), Joint("R", T2, 0, A1, 0), Joint("R", sp.Symbol("theta3"), 0, A2, 0)),
            ("vx", "vz"),
        ),
        "seen along y, all joints move the point along one line",
    ),
}


@pytest.mark.parametrize("name", PARTS_OF_A_TASK)
def test_what_is_said_of_a_part_of_a_task_is_so_of_that_part(name: str) -> None:
    """P may move along other axes all the same, so that it does not move along one line."""
    chain, words = PARTS_OF_A_TASK[name]
    said = {part["meaning"] for part in solution_data(solve(chain))["singular"]}
    assert words in said


def _falsely(kind: Kind, chain: Chain, monkeypatch: pytest.MonkeyPatch) -> Chain:
    monkeypatch.setattr(worked, "classify", lambda *_: kind)
    worked_steps.cache_clear()
    return chain


def test_a_false_look_is_not_told(monkeypatch: pytest.MonkeyPatch) -> None:
    chain = _falsely(Kind("boundary", True, "arm folded back"), Chain("mine", PLANAR, ("vx", "vy")), monkeypatch)
    text = " ".join(solution_text(solve(chain)).split())
    assert "folded back" not in text
    assert "The columns of J are linearly dependent. This is a boundary singularity." in text
    worked_steps.cache_clear()


def test_a_false_kind_is_told_of_none(monkeypatch: pytest.MonkeyPatch) -> None:
    looks = "arm stretched out or folded back"
    chain = _falsely(Kind("internal", True, looks), Chain("mine", PLANAR, ("vx", "vy")), monkeypatch)
    (found,) = solution_data(solve(chain))["singular"]
    assert (found["meaning"], found["uniform"]) == (looks, False)
    worked_steps.cache_clear()


def test_words_are_sound_where_they_are_so_of_every_configuration() -> None:
    chain = Chain("mine", PLANAR, ("vx", "vy"))
    (component,) = worked_steps(chain).components
    samples = places_on(chain, component)
    assert sound_words(chain, "arm stretched out or folded back", samples)
    assert sound_words(chain, "arm stretched out", samples) == ""
    assert sound_words(chain, "arm stretched out or folded back", []) == ""
