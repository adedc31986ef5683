"""Generating: an id is enough, students do not depend on each other, and their answers differ."""

import hashlib
import json
import os
import re
import subprocess
import sys
from collections import Counter
from collections.abc import Callable, Iterator

import pytest
import sympy as sp

from exercises.answers import Choice
from exercises.arm.chain import CONVENTIONS
from exercises.arm.derivation import derive
from exercises.difficulty import BANDS, HARDEST, _is_multiplied_out, _terms, difficulty, step
from exercises.errors import QdotError
from exercises.families import FAMILIES
from exercises.generation import check_questions, generate, questions_of, sample_chain, student_problem_id
from exercises.problem import ENGINE, LARGEST_SEED, Part, Problem, ProblemId
from exercises.questions import QUESTIONS, recursion, screws
from exercises.record import digests
from tests.support.suites import of_families, several

STUDENTS = several(6, 30)
CHAPTER = ("planar-2r", "elbow-3r", "polar-rp", "planar-3r")
FIXED = [name for name, family in FAMILIES.items() if not family.varied]
SECRET = "a secret for tests only"

OF_CONVENTIONS = {question.name for module in (recursion, screws) for question in module.QUESTIONS}
"""Questions that are asked of arms told in one convention only."""

FEW = {
    "joint-axes", "link-velocity", "singularity-type", "rank", "jacobian-size", "invertibility", "lost-motion",
    "singularity-meaning", "lost-direction",
}  # fmt: skip
"""Questions whose answers are few by nature: axes in the plane, an inner frame's velocity, three options."""

LEAST_DISTINCT = 0.4
"""Part of a class (up to 40) that has different answers, for all other questions."""


def fingerprint(problem: Problem) -> str:
    told = repr((problem.chain.joints, problem.chain.base, problem.chain.tool, problem.chain.task, digests(problem)))
    return hashlib.sha256(told.encode()).hexdigest()


ELSEWHERE = """
import json, sys
from exercises.generation import generate
from exercises.record import digests
from tests.exercises.test_generation import fingerprint
for line in sys.stdin:
    problem = generate(json.loads(line))
    print(json.dumps([fingerprint(problem), digests(problem)["parts"]]), flush=True)
"""


FOUND_ELSEWHERE = several(("wrist-zyz", "random-3"), tuple(FAMILIES))
"""Families generated in another process; snapshots, which other processes wrote, hold all of them in `make test`."""
FOUND_WITH_LARGE_SEEDS = several(("planar-2r", "random-3"), (*CHAPTER, "scara", "puma-560", "random-3"))
ASKED_ALONE = several(("planar-2r", "planar-3r", "polar-rp", "wrist-zyz", "stanford-6r"), tuple(FIXED))
"""In `make test`, families that can be asked every question between them."""
ASKED_OF_A_CLASS = several(("polar-rp", "cylindrical"),
                           (*CHAPTER, "elbow", "spherical-offset", "cylindrical"))  # fmt: skip


@pytest.fixture(scope="session")
def elsewhere() -> Iterator[Callable[[ProblemId], list[object]]]:
    """Ask another process, with other hashes and other arithmetic, for a problem's fingerprint and digests.

    OpenBLAS rounds differently on different processors; there it takes the processor for an older one.
    """
    environment = {**os.environ, "PYTHONHASHSEED": "4242", "OPENBLAS_CORETYPE": "Haswell"}
    command = [sys.executable, "-c", ELSEWHERE]
    with subprocess.Popen(
        command, env=environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, bufsize=1
    ) as process:
        assert process.stdin is not None and process.stdout is not None
        ask, answers = process.stdin, process.stdout

        def asked(identity: ProblemId) -> list[object]:
            ask.write(json.dumps(str(identity)) + "\n")
            return list(json.loads(answers.readline()))

        yield asked
        ask.close()


@of_families(FOUND_ELSEWHERE)
def test_an_id_gives_the_same_problem_in_another_process_and_on_another_machine(
    family: str, drawn: Callable[[str, int], Problem], elsewhere: Callable[[ProblemId], list[object]]
) -> None:
    problem = drawn(family, 0)
    assert elsewhere(problem.id) == [fingerprint(problem), digests(problem)["parts"]]


@of_families(FOUND_WITH_LARGE_SEEDS)
def test_a_large_seed_gives_the_same_problem_in_another_process(
    family: str, elsewhere: Callable[[ProblemId], list[object]]
) -> None:
    identity = ProblemId(family, 1 << 62)
    assert elsewhere(identity)[0] == fingerprint(generate(identity))


@of_families(ASKED_ALONE)
def test_a_part_is_the_same_whatever_else_is_asked(
    family: str, seeds: range, drawn: Callable[[str, int], Problem]
) -> None:
    def asked(part: Part) -> tuple[object, ...]:
        return part.answer, part.details, part.points

    for seed in seeds[: several(1, 3)] if family in CHAPTER else seeds[:1]:
        problem = drawn(family, seed)
        whole = {part.name: asked(part) for part in problem.parts}
        for name, part in whole.items():
            (alone,) = generate(problem.id, (name,)).parts
            assert asked(alone) == part
            assert alone.needs == ()
        backwards = generate(problem.id, tuple(reversed(whole)))
        assert {part.name: asked(part) for part in backwards.parts} == whole


@of_families(FIXED)
def test_parts_need_parts_of_the_same_problem(family: str, drawn: Callable[[str, int], Problem]) -> None:
    problem = drawn(family, 0)
    names = [part.name for part in problem.parts]
    assert names == list(questions_of(family))
    assert all(need in names for part in problem.parts for need in part.needs)
    assert problem.max_points == sum(part.points for part in problem.parts)


def test_points_may_be_given() -> None:
    identity = ProblemId("planar-2r", 1, ("position", "jacobian"))
    assert [part.points for part in generate(identity, points=(3, 0.5)).parts] == [3, 0.5]


def test_ids_are_read_and_written() -> None:
    assert str(ProblemId.parse("planar-2r/7")) == "planar-2r/7"
    assert ProblemId.parse("planar-2r/7") == ProblemId("planar-2r", 7)
    for text, seed in (("0" * 5000 + "7", 7), ("0", 0), (str(LARGEST_SEED), LARGEST_SEED)):
        assert ProblemId.parse(f"planar-2r/{text}").seed == seed
    for text in (str(LARGEST_SEED + 1), "1" + "0" * 25, "9" * 5000):
        with pytest.raises(QdotError, match=rf"^planar-2r/{text[:25]}…?: .* {LARGEST_SEED}$"):
            ProblemId.parse(f"planar-2r/{text}")
    for wrong in ("planar-2r", "planar-2r/-1", "planar-2r/x", "/7", "planar-2r/7/8", "planar-2r/7@@zeros", "Planär/7"):
        with pytest.raises(QdotError, match="FAMILY/SEED"):
            ProblemId.parse(wrong)


@pytest.mark.parametrize(
    ("identity", "said"),
    [
        ("planar-2r/7@modified", "convention 'modified-dh'"), ("planar-2r/7@craig", "convention 'modified-dh'"),
        ("planar-2r/7@zeros@modfied-dh", "convention 'modified-dh'"),
        ("planar-2r/7@modified_dh", "convention 'modified-dh'"), ("planar-2r/7@Scews", "convention 'screws'"),
        ("planar-2r/7@Screws", "'planar-2r/7@screws' is meant"), ("Planar-2R/7", "'planar-2r/7' is meant"),
        ("planar-2r/7@lenghts", "variation 'lengths'"),
        ("planar-2r/7@lengths+bse", "unknown variation 'bse' (did you mean 'base'?)"),
        ("planar-2r/7@x", "variations: chapter, lengths, zeros, frames, full"),
        ("planar-2r/7@x", "conventions: dh, modified-dh, screws; orders of twists: omega-v, v-omega"),
        ("planar-2r/7@lengths@frames", "two variations, lengths and frames"),
        ("planar-2r/7@dh@zeros@screws", "two conventions, dh and screws"),
    ],
)  # fmt: skip
def test_what_is_wrong_in_an_id_is_told_with_what_is_meant(identity: str, said: str) -> None:
    with pytest.raises(QdotError, match=re.escape(said)):
        ProblemId.parse(identity)


def test_a_convention_is_known_by_what_others_call_it() -> None:
    for called, meant in (("Craig", "modified-dh"), ("Standard", "dh"), ("PoE", "screws"), ("screw", "screws")):
        with pytest.raises(QdotError, match=f"'{called}'.*'{meant}'"):
            ProblemId("planar-2r", 1).told(called)


@pytest.mark.parametrize(
    ("identity", "said"),
    [
        (ProblemId("planar-2R", 1), "'planar-2R'.*'planar-2r'"),
        (ProblemId("planar-2r", 1, ("jacobi",)), "'jacobi'.*'jacobian'"),
        (ProblemId("planar-2r", 1, ("jacobian", "jacobian")), "twice"),
        (ProblemId("planar-3r", 1, ("determinant",)), "planar-3r: its Jacobian is 2 x 3"),
        (ProblemId("planar-2r", 1, (), ENGINE + 1), "has engine"),
    ],
)
def test_what_cannot_be_generated_is_said(identity: ProblemId, said: str) -> None:
    with pytest.raises(QdotError, match=said):
        generate(identity)


@pytest.mark.parametrize("family", ["planar-2r", "random-3"])
def test_a_question_of_another_convention_is_refused_with_the_convention_it_needs(family: str) -> None:
    for question, convention in (("home-screws", ""), ("own-frame-velocity", "screws")):
        with pytest.raises(QdotError, match=r'convention = "(screws|modified-dh)"'):
            check_questions(family, [question], convention=convention)
    check_questions(family, ["home-screws"], convention="screws")


def test_every_question_can_be_asked_of_some_family() -> None:
    told = {name: questions_of("planar-2r", name) for name in CONVENTIONS}
    assert set().union(*(questions_of(family) for family in FAMILIES), *told.values()) == set(QUESTIONS)
    assert set(told["screws"]) & OF_CONVENTIONS == {question.name for question in screws.QUESTIONS}


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


@of_families(ASKED_OF_A_CLASS)
def test_a_class_has_different_answers(family: str) -> None:
    """No two students share all answers; each question has many answers; the right option has any letter.

    In a small class letters are counted over all questions; test_concepts and test_rank count those of each.
    """
    ids = (student_problem_id(SECRET, f"student{i}", "p1", family, (), None, "full") for i in range(STUDENTS))
    problems = [generate(identity) for identity in ids]
    whole = Counter(repr([part.answer for part in problem.parts]) for problem in problems)
    assert sum(count for count in whole.values() if count > 1) <= STUDENTS // 100
    all_letters: Counter[str] = Counter()
    for number, name in enumerate(questions_of(family)):
        parts = [problem.parts[number] for problem in problems]
        if name not in FEW:
            assert len({repr(part.answer) for part in parts}) >= LEAST_DISTINCT * min(STUDENTS, 40), name
        letters = Counter(part.answer.letter for part in parts if isinstance(part.answer, Choice))
        all_letters += letters
        assert not letters or len(letters) > (2 if STUDENTS >= 30 else 1), name
        assert not letters or STUDENTS < 30 or max(letters.values()) < 0.7 * STUDENTS, name
    assert not all_letters or (len(all_letters) > 2 and max(all_letters.values()) < 0.7 * all_letters.total())


def test_the_step_of_an_arm_of_many_terms_needs_no_singular_set(monkeypatch: pytest.MonkeyPatch) -> None:
    """Which takes a minute for arms of seven joints with offsets, and could only raise the highest step."""
    arm = sample_chain(ProblemId("puma-560", 3, variation="full"))
    assert difficulty(arm) >= BANDS[-1]
    monkeypatch.setattr("exercises.difficulty.singular_set", None)  # called, it fails
    assert step(arm) == HARDEST


def test_terms_are_counted_as_if_all_were_multiplied_out(family: str) -> None:
    for seed in range(several(1, 4)):
        chain = sample_chain(ProblemId(family, seed, variation="full"))
        entries = [sp.expand(entry) for entry in derive(chain).jacobian]
        assert _terms(chain) == sum(len(sp.Add.make_args(entry)) for entry in entries if entry != 0)


def test_a_bracket_is_multiplied_out_before_its_terms_are_counted() -> None:
    x, y = sp.symbols("theta1 a1")
    assert _is_multiplied_out(2 * y * sp.sin(x + sp.pi / 3) - sp.cos(x))
    assert not any(map(_is_multiplied_out, (y * (y + sp.sin(x)), sp.sin(x * (x + y)), sp.sin(x) ** 2)))
