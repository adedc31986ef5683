"""The numbers of docs/structures.md agree with the code that finds and samples structures."""

import re
from collections import Counter

import pytest

from qdot.exercises.families.structures import group_clean_structures, read_clean_structures
from qdot.exercises.singularities.difficulty import HARDEST_BAND
from tests.support import ROOT
from tests.tools.structures import count_tables, normal_form, regular_forms, tables

PAGE = (ROOT / "docs" / "structures.md").read_text(encoding="utf-8")
ROWS = {int(row[0]): row[1:] for row in re.findall(r"(?m)^\| (\d)" + 5 * r" \| (\d+)" + r" \|$", PAGE)}


@pytest.mark.parametrize("n", [2, 3, pytest.param(4, marks=pytest.mark.whole)])
def test_page_counts_forms_structures_and_classes(n: int) -> None:
    forms = {normal_form(rows) for rows in tables(n, True)}
    clean, classes = read_clean_structures()[n], group_clean_structures(n)
    counts = count_tables(n, True), len(forms), len(regular_forms(n)), len(clean), len(classes)
    assert tuple(map(int, ROWS[n])) == counts


@pytest.mark.parametrize("n", [2, 3, 4])
def test_page_counts_structures_by_difficulty(n: int) -> None:
    clean = read_clean_structures()[n]
    steps = Counter(structure.band for structure in clean)
    assert f"| {n} joints | {' | '.join(str(steps[step]) for step in range(HARDEST_BAND + 1))} |" in PAGE
