"""The parsers of Python and of the site agree on generated texts."""

import pytest

from tests.support.suites import select_for_suite
from tests.tools.readers import Query, find_differences, make_query


def test_both_parsers_agree() -> None:
    """Compare trees, refusals and verdicts; `python -m tests.tools.readers --count 20000 --seed x` tries more."""
    assert list(find_differences(make_query(select_for_suite(15, 6000), "a"))) == []


@pytest.mark.whole
def test_a_difference_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tests.tools.readers.tree_text", lambda text, known: "(else)")
    monkeypatch.setattr("tests.tools.readers.judge_answer", lambda problem, name, text: ("partial", 0.5))
    lines = list(find_differences(Query([("a1", 0)], [(0, "rank", "2")])))
    assert [line.partition(":")[0] for line in lines] == ["'a1' with symbols 0", "textbook/1 rank '2'"]
