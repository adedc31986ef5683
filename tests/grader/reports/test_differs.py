"""The table of a counterexample: of sets with a column for each way in which they differ, and none without values."""

import pytest

from exercises.generation import generate
from exercises.problem import ProblemId
from grader.reports.differs import Table, table_of

PROBLEM = generate(ProblemId("planar-2r", 7, ("singular-angles",)))
AT = {"theta1": 0.5, "theta2": 1.25}


def table(**counterexample: object) -> Table | None:
    return table_of(PROBLEM, PROBLEM.parts[0], {"counterexample": counterexample})


def test_sets_have_a_column_for_each_way_in_which_they_differ() -> None:
    one = table(missing=AT, surplus=None)
    assert one is not None
    assert one.columns == ("Quantity", "Singular, and not in your answer")
    assert [len(row.cells) for row in one.symbols] == [1, 1]
    both = table(missing=AT, surplus={**AT, "theta2": 0.0})
    assert both is not None
    assert len(both.columns) == 3
    assert both.symbols[1].cells[1].startswith("0 rad")


@pytest.mark.parametrize(("missing", "surplus"), [(None, None), ({}, None), ({"x": 1.0}, None)])
def test_without_values_of_the_problems_symbols_there_is_no_table(missing: object, surplus: object) -> None:
    assert table(missing=missing, surplus=surplus) is None
