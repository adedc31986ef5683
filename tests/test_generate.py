"""Generating: an id is enough, students do not depend on each other, and their answers differ.

QDOT_STUDENTS (default 30) is the size of the class whose answers are counted.
"""

import hashlib
import json
import os
import subprocess
import sys
from collections import Counter

import pytest

from exercises import ENGINE
from exercises.errors import QdotError
from exercises.families import FAMILIES
from exercises.generate import applicable, check_questions, generate, questions_of, sample_chain, student_problem_id
from exercises.problem import LARGEST_SEED, Choice, Part, Problem, ProblemId
from exercises.questions import QUESTIONS

STUDENTS = int(os.environ.get("QDOT_STUDENTS", "30"))
CHAPTER = ("planar-2r", "elbow-3r", "polar-rp", "planar-3r")
FIXED = [name for name, family in FAMILIES.items() if not family.varied]
SECRET = "a secret for tests only"

FEW = {
    "joint-axes", "link-velocity", "singularity-type", "rank", "jacobian-size", "invertibility", "lost-motion",
    "singularity-meaning", "lost-direction",
}  # fmt: skip
"""Questions whose answers are few by nature: axes in the plane, an inner frame's velocity, three options."""

LEAST_DISTINCT = 0.4
"""Part of a class (up to 40) that has different answers, for all other questions."""


def fingerprint(problem: Problem) -> str:
    return hashlib.sha256(repr(problem).encode()).hexdigest()


PROGRAM = """
import hashlib, sys
from exercises.generate import generate
from exercises.problem import ProblemId
for family in sys.argv[1:]:
    for seed in (3, 1 << 62):
        print(hashlib.sha256(repr(generate(ProblemId(family, seed))).encode()).hexdigest())
"""


@pytest.mark.parametrize("hash_seed", ["1", "4242"])
def test_an_id_gives_the_same_problem_in_another_process(hash_seed: str) -> None:
    environment = {**os.environ, "PYTHONHASHSEED": hash_seed}
    some = [*CHAPTER, "scara", "puma-560", "random-3"]
    command = [sys.executable, "-c", PROGRAM, *some]
    found = subprocess.run(command, env=environment, capture_output=True, text=True, check=True, timeout=100)
    here = [fingerprint(generate(ProblemId(family, seed))) for family in some for seed in (3, 1 << 62)]
    assert found.stdout.split() == here


@pytest.mark.parametrize("family", FIXED)
def test_a_part_is_the_same_whatever_else_is_asked(family: str, seeds: range) -> None:
    def asked(part: Part) -> tuple[object, ...]:
        return part.answer, dict(part.details), part.points

    for seed in seeds[:3] if family in CHAPTER else seeds[:1]:
        whole = {part.name: asked(part) for part in generate(ProblemId(family, seed)).parts}
        for name, part in whole.items():
            (alone,) = generate(ProblemId(family, seed, (name,))).parts
            assert asked(alone) == part
            assert alone.needs == ()
        backwards = generate(ProblemId(family, seed, tuple(reversed(whole))))
        assert {part.name: asked(part) for part in backwards.parts} == whole


@pytest.mark.parametrize("family", FIXED)
def test_parts_need_parts_of_the_same_problem(family: str) -> None:
    problem = generate(ProblemId(family, 0))
    names = [part.name for part in problem.parts]
    assert names == list(questions_of(family))
    assert all(need in names for part in problem.parts for need in part.needs)
    assert problem.max_points == sum(part.points for part in problem.parts)


def test_points_may_be_given() -> None:
    identity = ProblemId("planar-2r", 1, ("position", "jacobian"))
    assert [part.points for part in generate(identity, (3, 0.5)).parts] == [3, 0.5]


def test_ids_are_read_and_written() -> None:
    assert ProblemId.parse("planar-2r/7") == ProblemId("planar-2r", 7)
    assert ProblemId.parse("planar-2r/" + "0" * 5000 + "7") == ProblemId("planar-2r", 7)
    assert ProblemId.parse("planar-2r/0") == ProblemId("planar-2r", 0)
    assert ProblemId.parse(f"planar-2r/{LARGEST_SEED}").seed == LARGEST_SEED
    for much in (LARGEST_SEED + 1, 10**25):
        with pytest.raises(QdotError, match=rf"^planar-2r/{str(much)[:25]}…?: the largest seed is {LARGEST_SEED}$"):
            ProblemId.parse(f"planar-2r/{much}")
    with pytest.raises(QdotError, match="the largest seed"):
        ProblemId.parse("planar-2r/" + "9" * 5000)
    assert str(ProblemId.parse("planar-2r/7")) == "planar-2r/7"
    for wrong in (
        "planar-2r",
        "planar-2r/-1",
        "planar-2r/x",
        "/7",
        "planar-2r/7/8",
        "Planar/7",
    ):
        with pytest.raises(QdotError, match="FAMILY/SEED"):
            ProblemId.parse(wrong)


@pytest.mark.parametrize(
    ("identity", "said"),
    [
        (ProblemId("planar-2R", 1), "unknown family 'planar-2R' \\(did you mean 'planar-2r'"),
        (ProblemId("planar-2r", 1, ("jacobi",)), "unknown question 'jacobi' \\(did you mean 'jacobian'"),
        (ProblemId("planar-2r", 1, ("jacobian", "jacobian")), "asked twice"),
        (ProblemId("planar-3r", 1, ("determinant",)), "can't be asked of planar-3r: its Jacobian is 2 x 3"),
        (ProblemId("planar-2r", 1, (), ENGINE + 1), "this version of qdot has engine"),
    ],
)
def test_what_cannot_be_generated_is_said(identity: ProblemId, said: str) -> None:
    with pytest.raises(QdotError, match=said):
        generate(identity)


def test_questions_can_be_checked_without_generating() -> None:
    check_questions("planar-2r", ["position", "jacobian"])
    with pytest.raises(QdotError):
        check_questions("planar-3r", ["inverse-jacobian"])


def test_every_question_can_be_asked_of_some_family() -> None:
    assert set().union(*(questions_of(family) for family in FAMILIES)) == set(QUESTIONS)
    assert all(applicable(sample_chain(ProblemId(family, 1))) == questions_of(family) for family in FIXED)


def test_a_students_problem_depends_on_that_student_and_the_secret_alone() -> None:
    def seeds(secret: str, students: list[str], slot: str = "p1") -> dict[str, int]:
        return {name: student_problem_id(secret, name, slot, "planar-2r", ()).seed for name in students}

    names = [f"student{i}" for i in range(200)]
    before, after = seeds(SECRET, names), seeds(SECRET, ["new", *reversed(names)])
    assert {name: after[name] for name in names} == before
    assert len(set(before.values())) == 200
    assert not set(before.values()) & set(seeds(SECRET + "!", names).values())
    assert not set(before.values()) & set(seeds(SECRET, names, "p2").values())
    assert student_problem_id(SECRET, "a", "p1", "planar-2r", ["position"]).questions == ("position",)


@pytest.mark.parametrize("family", [*CHAPTER, "elbow", "spherical-offset", "cylindrical"])
def test_a_class_has_different_answers(family: str) -> None:
    """No two students share all answers; each question has many answers; the right option has any letter."""
    ids = (student_problem_id(SECRET, f"student{i}", "p1", family, ()) for i in range(STUDENTS))
    problems = [generate(identity) for identity in ids]
    whole = Counter(repr([part.answer for part in problem.parts]) for problem in problems)
    assert sum(count for count in whole.values() if count > 1) <= STUDENTS // 100
    for number, name in enumerate(questions_of(family)):
        parts = [problem.parts[number] for problem in problems]
        if name not in FEW:
            assert len({repr(part.answer) for part in parts}) >= LEAST_DISTINCT * min(STUDENTS, 40), name
        letters = Counter(part.answer.letter for part in parts if isinstance(part.answer, Choice))
        assert not letters or (len(letters) > 2 and max(letters.values()) < 0.7 * STUDENTS)


DIGESTS = """
import json
from exercises.families import FAMILIES
from exercises.generate import generate
from exercises.problem import ProblemId
from exercises.record import digests
print(json.dumps({name: digests(generate(ProblemId(name, 0)))["parts"] for name in FAMILIES}))
"""


def test_other_arithmetic_of_the_machine_makes_the_same_problems() -> None:
    """OpenBLAS rounds differently on different processors; here it is told to be an older one, and to be this one."""
    made, own = [], {name: value for name, value in os.environ.items() if name != "OPENBLAS_CORETYPE"}
    for environment in ({**own, "OPENBLAS_CORETYPE": "Haswell"}, own):
        done = subprocess.run([sys.executable, "-c", DIGESTS], env=environment, capture_output=True, check=True)
        made.append(json.loads(done.stdout))
    assert made[0] == made[1]
