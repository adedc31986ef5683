"""A part of `make pairs`: rewritten right answers and generated wrong ones all get the right verdict."""

from collections import Counter

import pytest

from qdot.exercises.common.stream import Stream
from qdot.exercises.formula.equality import Domain
from qdot.exercises.formula.parser import parse_formula
from qdot.exercises.formula.trees import format_tree
from tests.support.suites import select_for_suite
from tests.tools.pairs import MUTATIONS, REWRITINGS, Rule, apply_rules, is_different, verdicts

DOMAIN = Domain({"theta1": "angle", "theta2": "angle", "a1": "length", "a2": "length"})
POSITION = parse_formula("3*a1*cos(theta1) + cos(theta1 + theta2)*sin(theta2)*(a1 - a2)")


def test_every_verdict_is_right() -> None:
    counts: Counter[tuple[str, bool]] = Counter()
    for source, kind, is_right, verdict, answer in verdicts(select_for_suite(350, 1500)):
        assert verdict == is_right, (source, kind, answer)
        counts[kind, is_right] += 1
    assert counts["rewritten", True] > select_for_suite(110, 500)
    assert counts["changed", False] > select_for_suite(80, 400)


def get_name(rule: Rule) -> str:
    return str(getattr(rule, "__name__", rule))


@pytest.mark.parametrize("rule", dict.fromkeys(REWRITINGS), ids=get_name)
def test_every_rewriting_applies_and_is_an_identity(rule: Rule) -> None:
    texts = set()
    for k in range(12):
        tree = apply_rules(POSITION, (rule,), Stream(f"rewriting/{k}"), 1)
        assert is_different(tree, POSITION, DOMAIN, Stream("points")) is False
        texts.add(format_tree(tree))
    assert texts - {format_tree(POSITION)}


@pytest.mark.parametrize("rule", MUTATIONS, ids=get_name)
def test_every_mutation_changes_the_function(rule: Rule) -> None:
    trees = [apply_rules(POSITION, (rule,), Stream(f"mutation/{k}"), 1) for k in range(12)]
    assert any(is_different(tree, POSITION, DOMAIN, Stream("points")) for tree in trees)
