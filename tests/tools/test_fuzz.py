"""A part of `make fuzz`: its checks on students' texts and on some mutations."""

import pytest

from qdot.exercises.common.stream import Stream
from tests.support.suites import sample_for_suite, select_for_suite
from tests.tools.fuzz import TARGETS, TOKENS, Find, check_text, load_seed_texts, mutate

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
