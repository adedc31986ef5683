"""The numbers of docs/structures.md, counted by the code that samples structures."""

import re
from collections import Counter

import pytest

from qdot.exercises.arm.difficulty import HARDEST
from qdot.exercises.families.structures import (
    MOST_TERMS,
    MOST_TERMS_OF_A_CONDITION,
    clean_classes,
    clean_structures,
    count_tables,
    normal_form,
    regular_forms,
    singular_sets,
    tables,
)
from tests.support import ROOT

PAGE = (ROOT / "docs" / "structures.md").read_text(encoding="utf-8")
ROWS = {
    int(row[0]): row[1:] for row in re.findall(r"(?m)^\| (\d) \| (\d+) \| (\d+) \| (\d+) \| (\d+) \| (\d+) \|$", PAGE)
}


@pytest.mark.parametrize("n", [2, 3, pytest.param(4, marks=pytest.mark.whole)])
def test_counts_of_forms_structures_and_classes(n: int) -> None:
    forms = {normal_form(rows) for rows in tables(n, True)}
    counts = count_tables(n, True), len(forms), len(regular_forms(n)), len(clean_structures()[n]), len(clean_classes(n))
    assert tuple(map(int, ROWS[n])) == counts


@pytest.mark.parametrize("n", [2, 3, 4])
def test_counts_by_difficulty_and_kinds(n: int) -> None:
    steps = Counter(structure.step for structure in clean_structures()[n])
    assert f"| {n} joints | {' | '.join(str(steps[step]) for step in range(HARDEST + 1))} |" in PAGE
    for kinds, count in Counter("".join(row.kind for row in s.rows) for s in clean_structures()[n]).items():
        assert re.search(rf"\| {kinds} \| {count} \|", PAGE)


@pytest.mark.whole
def test_counts_of_singular_sets() -> None:
    three = clean_structures()[3]
    never = sum(not singular_sets([structure]) - {()} for structure in three)
    assert (
        f"have {len(singular_sets(three))} different singular sets (as conditions, offsets left out); {never} of"
        in PAGE
    )


def test_limits_and_tables() -> None:
    """How many tables are regular is counted in test_random_structures.py."""
    assert f"at most {MOST_TERMS} terms in $J$, at most {MOST_TERMS_OF_A_CONDITION} terms in each singularity" in PAGE
    assert f"Of the {count_tables(3, True)} tables of three joints, 2504 are regular" in PAGE
    assert f"(1024 of {count_tables(3, False)} with" in PAGE
