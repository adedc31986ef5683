"""Wrong answers that somebody wrote who had not seen the catalogue: most are named, and each gets something true.

In `slips.jsonl`: a problem, a part, the answer as it was typed, and what the student did. Written on 24 November 2026
by a hand that saw worked solutions only, as edits of these, a quarter of them with two slips at once.
"""

import json
from collections import Counter
from functools import cache
from typing import Any

import pytest

from exercises.generation import generate
from exercises.problem import ProblemId
from grader.advice import advise
from grader.diagnosis import diagnose
from grader.parts import judge_given
from grader.reading import read_answer
from grader.verdict import Diagnosis, Outcome
from tests.support import DATA
from tests.support.suites import several

SLIPS: list[dict[str, Any]] = [
    json.loads(line) for line in (DATA / "slips.jsonl").read_text(encoding="utf-8").splitlines()
]
TAKEN = range(0, len(SLIPS), several(7, 1))
NAMED = {1: several(0.75, 0.87), 2: several(0.3, 0.6)}
"""The share of answers with one slip, and with two, behind which mistakes are named."""


@cache
def told(index: int) -> tuple[Diagnosis | None, Diagnosis | None]:
    """Return the mistake that is named, and what is said where there is none."""
    slip = SLIPS[index]
    problem = generate(ProblemId.parse(slip["problem"]), [slip["part"]])
    (part,) = problem.parts
    given = read_answer(problem, part, slip["answer"], "slips")
    assert judge_given(problem, part, given, "slips").outcome in (Outcome.WRONG, Outcome.PARTIAL), slip
    named = diagnose(problem, part, given, "slips")
    return named, None if named else advise(problem, part, given, "slips")


@pytest.mark.parametrize("index", TAKEN)
def test_something_is_said_of_every_wrong_answer(index: int) -> None:
    named, advice = told(index)
    said = named or advice
    assert said is not None and said.says.endswith((".", "?")), SLIPS[index]
    assert bool(named and named.mistakes) != bool(advice)


def test_most_are_named() -> None:
    made, named = Counter[int](), Counter[int]()
    for index in TAKEN:
        made[SLIPS[index]["slips"]] += 1
        named[SLIPS[index]["slips"]] += told(index)[0] is not None
    assert all(named[slips] >= NAMED[slips] * made[slips] for slips in made), (named, made)


@pytest.mark.parametrize(
    ("did", "mistakes"),
    [
        ("Typed the angles in degrees.", {"angles-in-degrees"}),
        ("Typed s12 as sin(theta1)*sin(theta2).", {"sum-of-angles-split"}),
        ("Typed pi/3 for the offset of 30 degrees.", {"wrong-radians"}),
        ("Typed the offset of 60 degrees in degrees.", {"offset-in-degrees"}),
        ("Multiplied F by J instead of by its transpose.", {"jacobian-for-transpose"}),
        ("Overlooked the offset of 45 degrees at theta3 in row 3 of the table.", {"offset-forgotten"}),
        ("Took O5, the tip, for P = O4.", {"other-point"}),
        ("Lost the term 0.75*sin(theta2 + theta3)*wz in the third row.", {"term-missing"}),
    ],
)
def test_by_their_true_names(did: str, mistakes: set[str]) -> None:
    index = next(index for index, slip in enumerate(SLIPS) if slip["did"] == did)
    named, _ = told(index)
    assert named is not None and set(named.mistakes) == mistakes
