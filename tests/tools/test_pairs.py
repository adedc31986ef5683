"""A part of `make pairs`: right answers rewritten, wrong ones made, and no wrong verdict on any."""

from collections import Counter

import pytest

from qdot.exercises.common.stream import Stream
from qdot.exercises.formula.equality import Domain
from qdot.exercises.formula.parser import parse_formula
from qdot.exercises.formula.trees import node_text
from tests.support.suites import select_for_suite
from tests.tools.pairs import MUTATIONS, REWRITINGS, Rule, at, changed, differs, put, verdicts

DOMAIN = Domain({"theta1": "angle", "theta2": "angle", "a1": "length", "a2": "length"})
POSITION = parse_formula("3*a1*cos(theta1) + cos(theta1 + theta2)*sin(theta2)*(a1 - a2)")


def test_no_verdict_is_wrong() -> None:
    seen: Counter[tuple[str, bool]] = Counter()
    for source, kind, due, verdict, answer in verdicts(select_for_suite(350, 1500)):
        assert verdict == due, (source, kind, answer)
        seen[kind, due] += 1
    assert seen["rewritten", True] > select_for_suite(110, 500)
    assert seen["changed", False] > select_for_suite(80, 400)


def name_of(rule: Rule) -> str:
    return str(getattr(rule, "__name__", rule))


@pytest.mark.parametrize("rule", dict.fromkeys(REWRITINGS), ids=name_of)
def test_every_rewriting_applies_and_is_an_identity(rule: Rule) -> None:
    texts = set()
    for k in range(12):
        tree = changed(POSITION, (rule,), Stream(f"rewriting/{k}"), 1)
        assert differs(tree, POSITION, DOMAIN, Stream("points")) is False
        texts.add(node_text(tree))
    assert texts - {node_text(POSITION)}


@pytest.mark.parametrize("rule", MUTATIONS, ids=name_of)
def test_every_mutation_changes_the_function(rule: Rule) -> None:
    found = [changed(POSITION, (rule,), Stream(f"mutation/{k}"), 1) for k in range(12)]
    assert any(differs(tree, POSITION, DOMAIN, Stream("points")) for tree in found)


def test_a_tree_is_changed_where_it_is_said() -> None:
    assert node_text(at(POSITION, (0, 1))) == "cos(theta1)"
    assert node_text(put(parse_formula("a1 + a2"), (1,), parse_formula("a3"))) == "(a1+a3)"


@pytest.mark.parametrize("text", ["(a1*0.05)", "(-12.5)", "((3/4)+a1)", "(a1^(-2))", "7.0", "atan2(a1, 2)"])
def test_a_tree_as_text_reads_as_the_same_tree(text: str) -> None:
    assert node_text(parse_formula(text)) == text
    assert parse_formula(node_text(parse_formula(text))) == parse_formula(text)
