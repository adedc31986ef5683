"""docs/structures.md: how many arms there are, counted by the code that draws them."""

from collections import Counter
from dataclasses import dataclass

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
from qdot.exercises.writing.render import render


@dataclass(frozen=True)
class Count:
    """One line of the table: for n joints, tables, normal forms, those regular, the clean ones and their classes."""

    n: int
    tables: int
    forms: int
    regular: int
    clean: int
    classes: int
    by_step: tuple[int, ...]


def _count(n: int) -> Count:
    clean = clean_structures()[n]
    steps = Counter(structure.step for structure in clean)
    forms = len({normal_form(rows) for rows in tables(n, True)})
    by_step = tuple(steps[step] for step in range(HARDEST + 1))
    classes = len(clean_classes(n))
    return Count(n, count_tables(n, True), forms, len(regular_forms(n)), len(clean), classes, by_step)


def regular_tables(angles: bool) -> int:
    """Return how many DH tables of three joints are regular in some task."""
    forms = regular_forms(3)
    return sum(2 ** sum(row.twist for row in rows) for rows in tables(3, angles) if normal_form(rows) in forms)


def structures_page() -> str:
    """Return docs/structures.md."""
    three = clean_structures()[3]
    kinds = Counter("".join(row.kind for row in s.rows) for n in (2, 3, 4) for s in clean_structures()[n])
    listed = sorted(kinds.items(), key=lambda item: (len(item[0]), item[0]))
    third = -(-len(listed) // 3)
    columns = [listed[i * third : (i + 1) * third] for i in range(3)]
    return render(
        "docs/structures.md.j2",
        counts=[_count(n) for n in (2, 3, 4)],
        three_regular=regular_tables(True),
        three_plain=regular_tables(False),
        three_plain_tables=count_tables(3, False),
        most_terms=MOST_TERMS,
        most_factor=MOST_TERMS_OF_A_CONDITION,
        sets=len(singular_sets(three)),
        never=sum(not singular_sets([structure]) - {()} for structure in three),
        steps=range(HARDEST + 1),
        kinds=[[column[i] if i < len(column) else ("", "") for column in columns] for i in range(third)],
    )
