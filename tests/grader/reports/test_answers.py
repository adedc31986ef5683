"""Answers on a page: as they were typed and, where that can be done, as they were read."""

import xml.etree.ElementTree as ET

from exercises.generation import generate
from exercises.problem import ProblemId
from grader.reports.answers import answer_of

PROBLEM = generate(ProblemId("planar-2r", 7, ("determinant",)))


def test_a_formula_is_set_in_few_characters() -> None:
    """A page holds many: none has a namespace of its own, a row of one thing is that thing, and sin(theta2) is s2."""
    shown = answer_of(PROBLEM, PROBLEM.parts[0], "a1*sin(theta2)").shown
    assert "xmlns" not in shown and "&#x" not in shown
    tree = ET.fromstring(shown)
    assert tree.tag == "math"
    assert not [row for row in tree.iter("mrow") if len(row) == 1 and row[0].tag in ("mi", "mn", "mo")]
    assert "".join(tree.itertext()).replace("\u2061", "").replace(" ", "") == "a1s2"
