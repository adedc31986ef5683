"""Short runs of the programs that look for errors, their former finds, and the files that they write for the site."""

import json
from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import sympy as sp

from qdot.exercises.arm.chain import Chain, Joint
from qdot.exercises.common.stream import Stream
from qdot.exercises.robots.robot_file import Robot
from qdot.exercises.singularities.singular_set import Component
from tests.support.suites import sample_for_suite, select_for_suite
from tests.tools import arms as tool
from tests.tools.arms import check_arm, generate_arm
from tests.tools.fuzz import SYMBOL_SETS, TARGETS, TOKENS, Find, check_text, load_seed_texts, mutate
from tests.tools.pairs import generate_verdicts
from tests.tools.readers import find_differences, judge_answer, make_query, make_stored_query, write_tree
from tests.tools.site_arms import TARGET as ARMS
from tests.tools.site_arms import make_arms_text
from tests.tools.site_corpus import (
    FORMS,
    NOTEBOOK,
    READINGS,
    SLIPS,
    TARGET,
    load_corpus_records,
    make_corpus_case,
    make_forms_text,
    make_notebook_text,
    make_slips_text,
)

FORMER_FINDS = [
    "Matrix(0,0,[])", "atan2a1", "Lambda(x, " + "1+" * 1500 + "x)", "theta2 = a1" + "+a1" * 1500,
    "1e-400+" * 1400 + "1", "a1-a1+" * 700 + "a1", "sin(9e399" + "*9e399" * 1500 + ")", "{" + "pi*(k+n)," * 1000 + "0}",
]  # fmt: skip
"""Former finds of `make fuzz`, shortened."""


@pytest.mark.parametrize("target", dict.fromkeys(TARGETS))
@pytest.mark.parametrize("text", sample_for_suite(FORMER_FINDS, 3), ids=lambda text: text[:12])
def test_former_finds_are_fixed(target: str, text: str) -> None:
    check_text(target, text, slack=5)


@pytest.mark.parametrize("target", ["printing", "judging"])
def test_students_texts_are_handled(target: str) -> None:
    for text in load_seed_texts()[::8]:
        check_text(target, text, slack=5)


@pytest.mark.parametrize("target", ["reading", "printing", "judging"])
def test_mutated_texts_are_handled(target: str) -> None:
    rng, texts = Stream(f"test/{target}"), [text for text in load_seed_texts() if len(text) < 300]
    for _ in range(select_for_suite(75, 150)):
        text = rng.choice(texts)
        for _ in range(3):
            text = mutate(text, rng, TOKENS, max_length=600)
        check_text(target, text, slack=5)


def test_slow_handling_is_a_find() -> None:
    with pytest.raises(Find, match="takes"):
        check_text("judging", "a1*cos(theta1) + a2*cos(theta1 + theta2)", slack=1e-9)


def test_every_verdict_is_right() -> None:
    counts: Counter[tuple[str, bool]] = Counter()
    for source, kind, is_right, verdict, answer in generate_verdicts(select_for_suite(350, 1500)):
        assert verdict == is_right, (source, kind, answer)
        counts[kind, is_right] += 1
    assert counts["rewritten", True] > select_for_suite(110, 500)
    assert counts["changed", False] > select_for_suite(80, 400)


def test_both_parsers_agree() -> None:
    """Compare trees, refusals and verdicts; `python -m tests.tools.readers --count 20000 --seed x` tries more."""
    assert list(find_differences(make_query(select_for_suite(15, 6000), "a"))) == []


SECONDS = 6.0


@pytest.mark.parametrize("number", select_for_suite((9,), range(0, 300, 15)))
def test_solutions_of_random_arms_hold(number: int) -> None:
    robot = generate_arm(number, "a")
    assert check_arm(robot, SECONDS).false == (), robot


TWO_R = Chain("two", (Joint("R", "theta1", 0, "a1", 0), Joint("R", "theta2", 0, sp.Rational(3, 10), 0)), ("vx", "vy"))


@pytest.mark.parametrize(
    ("components", "message"),
    [
        ((), "of 90 searches ended elsewhere"),
        ((Component((sp.cos(sp.Symbol("theta2")),), None),), "J keeps its rank where cos(theta2) = 0"),
        (
            (Component((sp.sin(sp.Symbol("theta2")),), ((sp.Symbol("theta2"), (sp.S.Zero, sp.pi / 2)),)),),
            "is given for sin(theta2) = 0, but is no solution",
        ),
    ],
)
def test_a_wrong_singular_set_is_found(
    monkeypatch: pytest.MonkeyPatch, components: tuple[Component, ...], message: str
) -> None:
    """Replace the singular set of an arm without stored results."""
    monkeypatch.setattr("qdot.exercises.solve.solver.find_singular_set", lambda _: components)
    monkeypatch.setattr("qdot.exercises.writing.solution_steps.find_singular_set", lambda _: components)
    monkeypatch.setattr("qdot.exercises.solve.solver._describe_doubts", lambda *_: "")  # the solver would notice
    chain = replace(TWO_R, name=f"two {message[:9]}", title=message[:9])
    assert any(message in statement for statement in check_arm(Robot(chain), SECONDS).false)


def test_a_wrong_formula_is_found() -> None:
    values = {"theta1": 0.3, "theta2": 0.4, "a1": 0.5}
    right = [0.5 * 0.9553364891, 0.0]
    assert list(tool._compare("p", ["a1*cos(theta1)", "0"], right, values)) == []
    assert len(list(tool._compare("p", ["a1*sin(theta1)", "0"], right, values))) == 1


STEP = select_for_suite(9, 1)
"""One of this many cases is checked."""
REWRITE_HINT = "run: python -m tests.tools.site_corpus"


def test_the_corpus_of_the_site_is_up_to_date() -> None:
    cases = json.loads(TARGET.read_text(encoding="utf-8"))
    assert len(cases) == len(load_corpus_records()), REWRITE_HINT
    for case, record in list(zip(cases, load_corpus_records(), strict=True))[::STEP]:
        assert case == make_corpus_case(record), REWRITE_HINT


def test_trees_and_verdicts_for_the_site_are_up_to_date() -> None:
    stored, query = json.loads(READINGS.read_text(encoding="utf-8")), make_stored_query()
    assert [[text, k] for text, k, _ in stored["readings"]] == [list(item) for item in query.readings], REWRITE_HINT
    assert [answer[:3] for answer in stored["answers"]] == [list(item) for item in query.answers], REWRITE_HINT
    for text, k, tree in stored["readings"][::STEP]:
        assert tree == write_tree(text, SYMBOL_SETS[k]), REWRITE_HINT
    for problem, name, text, *outcome in stored["answers"][::STEP]:
        assert outcome == list(judge_answer(problem, name, text)), REWRITE_HINT


@pytest.mark.parametrize(
    ("path", "make_text"),
    [
        (NOTEBOOK, make_notebook_text),
        pytest.param(FORMS, make_forms_text, marks=pytest.mark.whole),
        pytest.param(SLIPS, make_slips_text, marks=pytest.mark.whole),
    ],
)
def test_a_file_for_the_site_is_up_to_date(path: Path, make_text: Callable[[], str]) -> None:
    assert path.read_text(encoding="utf-8") == make_text(), REWRITE_HINT


@pytest.mark.whole
def test_arms_for_the_site_are_up_to_date() -> None:
    stored, current = (json.loads(text) for text in (ARMS.read_text(encoding="utf-8"), make_arms_text()))
    numbers = ("jacobian", "det", "sigma")  # the last digit depends on the machine
    assert [_without(case, numbers) for case in stored] == [_without(case, numbers) for case in current]
    for before, after in zip(stored, current, strict=True):
        np.testing.assert_allclose(before["jacobian"], after["jacobian"], rtol=0, atol=1e-12)


def _without(case: dict[str, object], names: tuple[str, ...]) -> dict[str, object]:
    return {name: value for name, value in case.items() if name not in names}
