"""A part of `make pairs`: rewritten right answers and generated wrong ones all get the right verdict."""

from collections import Counter

import pytest

from qdot.exercises.common.stream import Stream
from qdot.exercises.formula.equality import Domain
from qdot.exercises.formula.parser import parse_formula
from qdot.exercises.formula.trees import format_tree
from tests.support.suites import select_for_suite
from tests.tools.pairs import MUTATIONS, REWRITINGS, Rule, apply_rules, is_different, verdicts

def test_every_verdict_is_right() -> None:
    counts: Counter[tuple[str, bool]] = Counter()
    for source, kind, is_right, verdict, answer in verdicts(select_for_suite(350, 1500)):
        assert verdict == is_right, (source, kind, answer)
        counts[kind, is_right] += 1
    assert counts["rewritten", True] > select_for_suite(110, 500)
    assert counts["changed", False] > select_for_suite(80, 400)
