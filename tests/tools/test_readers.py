"""Python's reader and the site's say the same of texts that nobody has thought of."""

import pytest

from tests.support.suites import select_for_suite
from tests.tools.readers import Asked, differences, question_of


def test_both_readers_say_the_same() -> None:
    """Trees, refusals and verdicts; `python -m tests.tools.readers --count 20000 --seed x` asks for more."""
    assert list(differences(question_of(select_for_suite(15, 6000), "a"))) == []


@pytest.mark.whole
def test_a_difference_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tests.tools.readers.tree_text", lambda text, known: "(else)")
    monkeypatch.setattr("tests.tools.readers.verdict", lambda problem, name, text: ("partial", 0.5))
    told = list(differences(Asked([("a1", 0)], [(0, "rank", "2")])))
    assert [line.partition(":")[0] for line in told] == ["'a1' with symbols 0", "textbook/1 rank '2'"]
