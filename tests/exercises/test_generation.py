"""Generating: an id is enough, students do not depend on each other, their answers differ, and draws are fair."""

import hashlib
import json
import os
import re
import subprocess
import sys
from collections import Counter

import pytest
import sympy as sp
from hypothesis import given
from hypothesis import strategies as st

from qdot.exercises.arm.chain import CONVENTIONS
from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.stream import Stream, derive_seed
from qdot.exercises.derivation.derivation import derive
from qdot.exercises.families import FAMILIES
from qdot.exercises.generation import (
    check_questions,
    generate,
    list_questions_of_family,
    make_student_problem_id,
    sample_chain,
)
from qdot.exercises.problem.problem import ENGINE, MAX_SEED, Part, Problem, ProblemId
from qdot.exercises.problem.record import compute_digests
from qdot.exercises.questions import QUESTIONS, screws
from qdot.exercises.reference_answers import Choice
from qdot.exercises.singularities.difficulty import (
    HARDEST_LEVEL,
    LEVEL_MINIMUMS,
    _count_jacobian_terms,
    _is_multiplied_out,
    rate_difficulty,
    rate_difficulty_level,
)
from tests.support import read_cases
from tests.support.problems import get_problem, sample_parts
from tests.support.suites import on_families, select_for_suite

STUDENTS = select_for_suite(6, 30)
CHAPTER = ("planar-2r", "elbow-3r", "polar-rp", "planar-3r")
FIXED = [name for name, family in FAMILIES.items() if not family.has_varied_structure]
SECRET = "a secret for tests only"
OF_CONVENTIONS = {"own-frame-velocity", *(question.name for question in screws.QUESTIONS)}
"""Questions that are asked of arms told in one convention only."""
FEW = {
    "joint-axes", "link-velocity", "singularity-type", "rank", "jacobian-size", "invertibility",
    "singularity-meaning", "lost-direction",
}  # fmt: skip
"""Questions whose answers are few by nature: axes in the plane, an inner frame's velocity, three options."""
LEAST_DISTINCT = 0.4
"""Part of a class (up to 40) that has different answers, for all other questions."""


def fingerprint(problem: Problem) -> str:
    chain = problem.chain
    told = repr((chain.joints, chain.base, chain.tool, chain.task, compute_digests(problem)))
    return hashlib.sha256(told.encode()).hexdigest()


ELSEWHERE = """
import json, sys
from qdot.exercises.generation import generate
from tests.exercises.test_generation import fingerprint
print(json.dumps([fingerprint(generate(identity)) for identity in sys.argv[1:]]))
"""
ASKED_ALONE = select_for_suite(("planar-3r", "polar-rp", "wrist-zyz"), tuple(FIXED))
"""In `make test`, families that can be asked every question between them."""
ASKED_OF_A_CLASS = select_for_suite(("polar-rp", "cylindrical"), ("planar-2r", "elbow-3r", "polar-rp", "cylindrical"))


def test_an_id_gives_the_same_problem_in_another_process_and_on_another_machine() -> None:
    """With other hashes and other arithmetic: OpenBLAS rounds differently where it believes in an older processor.

    Snapshots, which other processes wrote, hold all families in `make test`.
    """
    large = select_for_suite(("planar-2r",), (*CHAPTER, "scara", "puma-560", "random-3"))
    identities = [ProblemId(family, 0) for family in select_for_suite(("wrist-zyz", "random-3"), tuple(FAMILIES))]
    identities += [ProblemId(family, 1 << 62) for family in large]
    environment = {**os.environ, "PYTHONHASHSEED": "4242", "OPENBLAS_CORETYPE": "Haswell"}
    command = [sys.executable, "-c", ELSEWHERE, *map(str, identities)]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    here = [fingerprint(generate(identity)) for identity in identities]
    assert dict(zip(identities, json.loads(done.stdout), strict=True)) == dict(zip(identities, here, strict=True))


@on_families(ASKED_ALONE)
def test_a_part_is_the_same_whatever_else_is_asked(family: str) -> None:
    def asked(part: Part) -> tuple[object, ...]:
        return part.answer, part.details, part.points

    problem = get_problem(family, 0)
    whole = {part.name: asked(part) for part in problem.parts}
    for part in sample_parts(problem):
        (alone,) = generate(problem.id, (part.name,)).parts
        assert asked(alone) == whole[part.name]
        assert alone.prerequisites == ()
    backwards = generate(problem.id, tuple(reversed(whole)))
    assert {part.name: asked(part) for part in backwards.parts} == whole


@on_families(FIXED)
def test_parts_need_parts_of_the_same_problem(family: str) -> None:
    problem = get_problem(family, 0)
    names = [part.name for part in problem.parts]
    assert names == list(list_questions_of_family(family))
    assert all(need in names for part in problem.parts for need in part.prerequisites)
    assert problem.max_points == sum(part.points for part in problem.parts)


def test_ids_are_read_and_written() -> None:
    assert str(ProblemId.parse("planar-2r/7")) == "planar-2r/7"
    assert ProblemId.parse("planar-2r/7") == ProblemId("planar-2r", 7)
    for text, seed in (("0" * 5000 + "7", 7), ("0", 0), (str(MAX_SEED), MAX_SEED)):
        assert ProblemId.parse(f"planar-2r/{text}").seed == seed
    for text in (str(MAX_SEED + 1), "1" + "0" * 25, "9" * 5000):
        with pytest.raises(QdotError, match=rf"^planar-2r/{text[:25]}…?: .* {MAX_SEED}$"):
            ProblemId.parse(f"planar-2r/{text}")
    for wrong in ("planar-2r", "planar-2r/-1", "planar-2r/x", "/7", "planar-2r/7/8", "planar-2r/7@@zeros", "Planär/7"):
        with pytest.raises(QdotError, match="FAMILY/SEED"):
            ProblemId.parse(wrong)


@pytest.mark.parametrize(("identity", "said"), read_cases("refused")["ids"])
def test_what_is_wrong_in_an_id_is_told_with_what_is_meant(identity: str, said: str) -> None:
    with pytest.raises(QdotError, match=re.escape(said)):
        ProblemId.parse(identity)


def test_a_convention_is_known_by_what_others_call_it() -> None:
    for called, meant in (("Craig", "modified-dh"), ("Standard", "dh"), ("PoE", "screws"), ("screw", "screws")):
        with pytest.raises(QdotError, match=f"'{called}'.*'{meant}'"):
            ProblemId("planar-2r", 1).with_convention(called)


@pytest.mark.parametrize(
    ("identity", "said"),
    [
        (ProblemId("planar-2R", 1), "'planar-2R'.*'planar-2r'"),
        (ProblemId("planar-2r", 1, ("jacobi",)), "'jacobi'.*'jacobian'"),
        (ProblemId("planar-2r", 1, ("jacobian", "jacobian")), "twice"),
        (ProblemId("planar-3r", 1, ("determinant",)), "planar-3r: its Jacobian is 2 x 3"),
        (ProblemId("planar-2r", 1, (), ENGINE + 1), "this qdot has version"),
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
    told = {name: list_questions_of_family("planar-2r", name) for name in CONVENTIONS}
    assert set().union(*(list_questions_of_family(family) for family in FAMILIES), *told.values()) == set(QUESTIONS)
    assert set(told["screws"]) & OF_CONVENTIONS == {question.name for question in screws.QUESTIONS}


def test_a_students_problem_depends_on_that_student_and_the_secret_alone() -> None:
    def seeds(secret: str, students: list[str], slot: str = "p1") -> dict[str, int]:
        return {name: make_student_problem_id(secret, name, slot, ProblemId("planar-2r", 0)).seed for name in students}

    names = [f"student{i}" for i in range(200)]
    before, after = seeds(SECRET, names), seeds(SECRET, ["new", *reversed(names)])
    assert {name: after[name] for name in names} == before
    assert len(set(before.values())) == 200
    assert not set(before.values()) & set(seeds(SECRET + "!", names).values())
    assert not set(before.values()) & set(seeds(SECRET, names, "p2").values())
    asked = ProblemId("planar-2r", 0, ("position",))
    assert make_student_problem_id(SECRET, "a", "p1", asked).questions == ("position",)


@on_families(ASKED_OF_A_CLASS)
def test_a_class_has_different_answers(family: str) -> None:
    """No two students share all answers; each question has many answers; the right option has any letter.

    In a small class letters are counted over all questions; test_concepts and test_questions count those of each.
    """
    problem_id = ProblemId(family, 0, variation="full")
    ids = (make_student_problem_id(SECRET, f"student{i}", "p1", problem_id) for i in range(STUDENTS))
    problems = [generate(identity) for identity in ids]
    whole = Counter(repr([part.answer for part in problem.parts]) for problem in problems)
    assert sum(count for count in whole.values() if count > 1) <= STUDENTS // 100
    all_letters: Counter[str] = Counter()
    for number, name in enumerate(list_questions_of_family(family)):
        parts = [problem.parts[number] for problem in problems]
        if name not in FEW:
            assert len({repr(part.answer) for part in parts}) >= LEAST_DISTINCT * min(STUDENTS, 40), name
        letters = Counter(part.answer.letters for part in parts if isinstance(part.answer, Choice))
        all_letters += letters
        assert not letters or len(letters) > (2 if STUDENTS >= 30 else 1), name
        assert not letters or STUDENTS < 30 or max(letters.values()) < 0.7 * STUDENTS, name
    assert not all_letters or (len(all_letters) > 2 and max(all_letters.values()) < 0.7 * all_letters.total())


def test_the_step_of_an_arm_of_many_terms_needs_no_singular_set(monkeypatch: pytest.MonkeyPatch) -> None:
    """Which takes a minute for arms of seven joints with offsets, and could only raise the highest step."""
    arm = sample_chain(ProblemId("puma-560", 3, variation="full"))
    assert rate_difficulty(arm) >= LEVEL_MINIMUMS[-1]
    monkeypatch.setattr("qdot.exercises.singularities.difficulty.find_singular_set", None)  # called, it fails
    assert rate_difficulty_level(arm) == HARDEST_LEVEL


def test_terms_are_counted_as_if_all_were_multiplied_out(family: str) -> None:
    for seed in range(select_for_suite(1, 4)):
        chain = sample_chain(ProblemId(family, seed, variation="full"))
        entries = [sp.expand(entry) for entry in derive(chain).jacobian]
        assert _count_jacobian_terms(chain) == sum(len(sp.Add.make_args(entry)) for entry in entries if entry != 0)


def test_a_bracket_is_multiplied_out_before_its_terms_are_counted() -> None:
    x, y = sp.symbols("theta1 a1")
    assert _is_multiplied_out(2 * y * sp.sin(x + sp.pi / 3) - sp.cos(x))
    assert not any(map(_is_multiplied_out, (y * (y + sp.sin(x)), sp.sin(x * (x + y)), sp.sin(x) ** 2)))


def test_a_seed_gives_the_same_numbers_for_good() -> None:
    stream = Stream("qdot")
    assert [stream.integer_below(10) for _ in range(20)] == [5, 8, 1, 3, 5, 4, 0, 1, 0, 4, 6, 9, 0, 3, 7, 7, 3, 0, 1, 3]
    assert Stream("qdot").uniform(0, 1) == 0.2965712178569676
    assert Stream("qdot").permutation("abcdef") == list("abcedf")
    assert derive_seed("secret", "anna", "p1") == 1761065311792996335


def test_streams_of_other_seeds_are_others_and_long() -> None:
    assert len({Stream(f"planar-2r/{seed}").integer(0, 999) for seed in range(200)}) > 150
    stream = Stream("long")  # it outlasts its first block
    assert len({stream.integer_below(1 << 64) for _ in range(1000)}) == 1000
    with pytest.raises(ValueError, match="positive"):
        stream.integer_below(0)


@given(st.text(st.characters(codec="utf-8"), max_size=20), st.integers(min_value=1, max_value=1 << 64))
def test_below_stays_below(seed: str, n: int) -> None:
    assert 0 <= Stream(seed).integer_below(n) < n


def test_draws_are_fair() -> None:
    stream = Stream("fair")
    counts = Counter(stream.integer_below(6) for _ in range(6000))
    assert set(counts) == set(range(6))
    assert max(abs(count - 1000) for count in counts.values()) < 150


@given(st.lists(st.integers(), max_size=12), st.integers(min_value=0, max_value=99))
def test_shuffling_keeps_the_items(items: list[int], seed: int) -> None:
    assert sorted(Stream(str(seed)).permutation(items)) == sorted(items)


@given(st.floats(-1e6, 1e6), st.floats(0.001, 1e6))
def test_uniform_keeps_to_its_interval(low: float, width: float) -> None:
    assert low <= Stream("u").uniform(low, low + width) <= low + width


def test_a_derived_seed_depends_on_each_part_and_on_their_borders() -> None:
    parts = ("secret", "anna", "p1", "planar-2r")
    others = [("secreT", *parts[1:]), ("secret", "annb", *parts[2:]), (*parts[:2], "p2", parts[3])]
    seeds = {derive_seed(*each) for each in (parts, *others, ("secret", "ann", "ap1", "planar-2r"))}
    assert len(seeds) == 5 and all(0 <= seed < 1 << 63 for seed in seeds)
    assert derive_seed(*parts) in seeds
