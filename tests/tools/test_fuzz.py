"""A part of `make fuzz`: its checks on the students' texts and on some that were made of them."""

import pytest

from qdot.exercises.common.stream import Stream
from tests.support.suites import sample_for_suite, select_for_suite
from tests.tools.fuzz import PLAIN, TARGETS, TOKENS, Find, changed, checked, seeds

FINDS = [
    "Matrix(0,0,[])", "atan2a1", "Lambda(x, " + "1+" * 1500 + "x)", "theta2 = a1" + "+a1" * 1500,
    "1e-400+" * 1400 + "1", "a1-a1+" * 700 + "a1", "sin(9e399" + "*9e399" * 1500 + ")", "{" + "pi*(k+n)," * 1000 + "0}",
]  # fmt: skip
"""What `make fuzz` found, as short as it could be made."""


@pytest.mark.parametrize("target", dict.fromkeys(TARGETS))
@pytest.mark.parametrize("text", sample_for_suite(FINDS, 3), ids=lambda text: text[:12])
def test_what_was_found_is_found_no_more(target: str, text: str) -> None:
    checked(target, text, slower=5)


@pytest.mark.parametrize("target", ["printing", "judging"])
def test_what_students_write_is_no_find(target: str) -> None:
    for text in seeds()[::8]:
        checked(target, text, slower=5)


@pytest.mark.parametrize("target", ["reading", "printing", "judging"])
def test_what_is_made_of_it_is_no_find(target: str) -> None:
    rng, texts = Stream(f"test/{target}"), [text for text in seeds() if len(text) < 300]
    for k in range(select_for_suite(75, 150)):
        text = rng.choice(texts)
        for _ in range(3):
            text = changed(text, rng, PLAIN if k % 2 else TOKENS, most=600)
        checked(target, text, slower=5)


def test_what_takes_long_is_a_find() -> None:
    with pytest.raises(Find, match="takes"):
        checked("judging", "a1*cos(theta1) + a2*cos(theta1 + theta2)", slower=1e-9)
