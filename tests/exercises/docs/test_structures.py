"""Structures of random arms: how many there are, by enumeration of all DH tables."""

from collections import Counter

import pytest

from qdot.exercises.families.structures import group_clean_structures, read_clean_structures
from qdot.exercises.singularities.difficulty import HARDEST_BAND
from tests.tools.structures import count_tables, normal_form, regular_forms, tables

COUNTS = {2: (192, 42, 26, 41, 16), 3: (4608, 588, 290, 259, 63), 4: (110592, 8232, 754, 667, 46)}
"""The DH tables, normal forms, forms that are regular for a task, clean structures with a task, and classes, by number
of joints."""
BY_DIFFICULTY = {2: [23, 11, 7, 0, 0], 3: [51, 110, 65, 33, 0], 4: [80, 445, 142, 0, 0]}


@pytest.mark.parametrize("n", [2, 3, pytest.param(4, marks=pytest.mark.whole)])
def test_tables_forms_structures_and_classes_are_counted(n: int) -> None:
    forms = {normal_form(rows) for rows in tables(n, True)}
    clean, classes = read_clean_structures()[n], group_clean_structures(n)
    counts = count_tables(n, True), len(forms), len(regular_forms(n)), len(clean), len(classes)
    assert counts == COUNTS[n]


@pytest.mark.parametrize("n", [2, 3, 4])
def test_structures_of_every_difficulty_are_counted(n: int) -> None:
    clean = read_clean_structures()[n]
    steps = Counter(structure.band for structure in clean)
    assert [steps[step] for step in range(HARDEST_BAND + 1)] == BY_DIFFICULTY[n]
