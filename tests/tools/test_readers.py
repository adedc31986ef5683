"""The parsers of Python and of the site agree on generated texts."""

import pytest

from tests.support.suites import select_for_suite
from tests.tools.readers import Query, find_differences, make_query


def test_both_parsers_agree() -> None:
    """Compare trees, refusals and verdicts; `python -m tests.tools.readers --count 20000 --seed x` tries more."""
    assert list(find_differences(make_query(select_for_suite(15, 6000), "a"))) == []
