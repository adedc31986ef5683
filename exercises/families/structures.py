"""Every structure that an arm of 2, 3 or 4 joints can have, and which of them make a clean problem.

A structure says of each joint: revolute or prismatic; whether its axis is parallel or square to the next (twist 0 or
90 degrees); whether the length a_i is zero; and, for a revolute joint, whether the offset d_i is zero, for a prismatic
one, whether its angle theta_i is 0 or 90 degrees. Its code is one word a joint, as in "Rdx Ra Pt": a, d (or t) and x
stand for what is not zero.

Two tables are the same problem, and have one normal form, if they differ only in what leaves J what it is but for
signs and names:
  - the sense of axes (signs of twists) and mirror images;
  - where the base stands: d_1 of a revolute first joint, theta_1 and a_1 of a prismatic one;
  - offsets along one line: d_i behind a parallel axis adds to d_(i-1), or to the zero of the slide there;
  - the last twist, which no axis follows.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import lru_cache
from itertools import combinations, product
from pathlib import Path

import numpy as np
import sympy as sp

from qdot.exercises.arm.chain import TASK_ROWS, Chain, Joint
from qdot.exercises.arm.derivation import derive
from qdot.exercises.arm.difficulty import step
from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.arm.singularity import singular_set
from qdot.exercises.common.files import write_atomically
from qdot.exercises.common.stream import Stream
from qdot.exercises.families.classes import Key, class_key

TABLE = Path(__file__).with_name("structures.txt")
MOST_TERMS, MOST_TERMS_OF_A_CONDITION = 15, 4
RIGHT = sp.pi / 2


@dataclass(frozen=True)
class StructureRow:
    """One joint of a structure: kind, and whether a, d (or the fixed angle of a slide) and the twist are not zero."""

    kind: str
    a: bool
    d: bool
    twist: bool

    def __str__(self) -> str:
        second = "d" if self.kind == "R" else "t"
        return self.kind + "a" * self.a + second * self.d + "x" * self.twist


@dataclass(frozen=True)
class Structure:
    """A clean structure: its rows, the task, and the step of difficulty of its arms."""

    rows: tuple[StructureRow, ...]
    task: tuple[str, ...]
    step: int

    def line(self) -> str:
        """Return its line in the table."""
        return f"{' '.join(map(str, self.rows))} | {' '.join(self.task)} | {self.step}"


def tables(n: int, angles: bool) -> Iterator[tuple[StructureRow, ...]]:
    """Yield every DH table of n joints with twists 0, 90 and -90 counted thrice; `angles` of slides 0 or 90 degrees.

    A row stands for as many tables as its twist has signs; `count_tables` counts them.
    """
    kinds = [StructureRow("R", a, d, x) for a, d, x in product((False, True), repeat=3)]
    kinds += [StructureRow("P", a, d, x) for a, d, x in product((False, True), repeat=3) if angles or not d]
    last = [row for row in kinds if not row.twist]
    yield from product(*[kinds] * (n - 1), last)


def count_tables(n: int, angles: bool) -> int:
    """Return the number of DH tables with twists in {0, 90, -90} degrees.

    >>> count_tables(2, False), count_tables(3, False), count_tables(3, True)
    (108, 1944, 4608)
    """
    return sum(2 ** sum(row.twist for row in rows) for rows in tables(n, angles))


def normal_form(rows: tuple[StructureRow, ...]) -> tuple[StructureRow, ...]:
    """Return the normal form of a structure (see above).

    >>> " ".join(map(str, normal_form((StructureRow("R", False, True, False), StructureRow("R", True, True, False)))))
    'R Ra'
    """
    first = rows[0]
    normal_rows = [
        StructureRow("R", first.a, False, first.twist)
        if first.kind == "R"
        else StructureRow("P", False, False, first.twist)
    ]
    for row in rows[1:]:
        before = normal_rows[-1]
        if row.kind == "R" and row.d and not before.twist:
            normal_rows[-1] = (
                StructureRow("R", before.a, len(normal_rows) > 1, before.twist) if before.kind == "R" else before
            )
            normal_rows.append(StructureRow("R", row.a, False, row.twist))
        else:
            normal_rows.append(row)
    result = tuple(normal_rows)
    return result if result == rows else normal_form(result)


def chain_of(
    rows: tuple[StructureRow, ...], task: tuple[str, ...], name: str = "structure", senses: tuple[int, ...] = ()
) -> Chain:
    """Return the arm of a structure, all lengths open, in the world's origin; `senses` are the signs of its twists."""
    joints = []
    for i, (row, sense) in enumerate(zip(rows, senses or (1,) * len(rows), strict=True), 1):
        a, twist = sp.Symbol(f"a{i}") if row.a else sp.S.Zero, sense * RIGHT if row.twist else sp.S.Zero
        if row.kind == "R":
            joints.append(Joint("R", sp.Symbol(f"theta{i}"), sp.Symbol(f"d{i}") if row.d else sp.S.Zero, a, twist))
        else:
            joints.append(Joint("P", RIGHT if row.d else sp.S.Zero, sp.Symbol(f"d{i}"), a, twist))
    kinds = "".join(row.kind for row in rows)
    return Chain(name, tuple(joints), task, title=f"{kinds} arm")


@lru_cache(maxsize=8192)
def _rows_that_move(rows: tuple[StructureRow, ...]) -> tuple[np.ndarray, tuple[str, ...]]:
    """Return Jacobians of the structure at random (k x 6 x n), and the rows that are not zero everywhere."""
    chain, stream = chain_of(rows, ("vx",)), Stream("structures")
    arm = NumericChain(chain, {symbol.name: stream.uniform(0.4, 1.2) for symbol in chain.parameters})
    jacobians = arm.jacobian(np.array([[stream.uniform(-3, 3) for _ in rows] for _ in range(6)]))
    moving = np.abs(jacobians).max(axis=(0, 2)) > 1e-9
    return jacobians, tuple(row for row, moves in zip(TASK_ROWS, moving, strict=True) if moves)


def regular_tasks(rows: tuple[StructureRow, ...]) -> list[tuple[str, ...]]:
    """Return the tasks in which a structure is asked, those in which J is square and regular in general.

    Two joints: two of vx, vy, vz. Three joints: all three; two of them and the turn about the third axis, where the arm
    stays in that plane; or wx, wy, wz for a wrist. Four joints: vx, vy, vz and one turn, where the arm turns about one
    axis of the world only.
    """
    jacobians, moving = _rows_that_move(rows)
    linear, turns = [row for row in moving if row[0] == "v"], [row for row in moving if row[0] == "w"]
    tasks: list[tuple[str, ...]] = []
    if len(rows) == 2:
        tasks = list(combinations(linear, 2))
    elif len(rows) == 4:
        tasks = [moving] if len(linear) == 3 and len(turns) == 1 else []
    elif len(linear) == 3 or moving == TASK_ROWS[3:]:
        tasks = [moving[:3]]
    elif {row[1] for row in moving} == set("xyz") and (len(linear), len(turns)) == (2, 1):
        tasks = [moving]
    return [task for task in tasks if _is_regular(jacobians[:, [TASK_ROWS.index(row) for row in task]])]


def _is_regular(jacobians: np.ndarray) -> bool:
    sigma = np.linalg.svd(jacobians, compute_uv=False)
    return bool((sigma[:, -1] > 1e-6).any())


def is_clean(chain: Chain) -> bool:
    """Tell whether an arm makes a problem for a person: short J, conditions of few terms that all can hold."""
    entries = [sp.expand(entry) for entry in derive(chain).jacobian]
    if sum(len(sp.Add.make_args(entry)) for entry in entries if entry != 0) > MOST_TERMS:
        return False
    components = singular_set(chain)
    if components is None:
        return False
    conditions = [condition for component in components for condition in component.conditions]
    return all(len(sp.Add.make_args(sp.expand(condition))) <= MOST_TERMS_OF_A_CONDITION for condition in conditions)


def regular_forms(n: int) -> dict[tuple[StructureRow, ...], list[tuple[str, ...]]]:
    """Return the normal forms of n joints that are regular in some task, with these tasks, sorted by code."""
    forms = sorted({normal_form(rows) for rows in tables(n, True)}, key=lambda rows: " ".join(map(str, rows)))
    return {rows: tasks for rows in forms if (tasks := regular_tasks(rows))}


def find_clean_structures(n: int) -> list[Structure]:
    """Go through all structures of n joints for those that are clean in a task."""
    chains = ((rows, task, chain_of(rows, task)) for rows, tasks in regular_forms(n).items() for task in tasks)
    return [Structure(rows, task, step(chain)) for rows, task, chain in chains if is_clean(chain)]


def singular_sets(structures: Iterable[Structure]) -> set[tuple[str, ...]]:
    """Return the different singular sets of structures, as text."""
    return {
        tuple(
            sorted(piece for component in singular_set(chain_of(s.rows, s.task)) or () for piece in component.pieces())
        )
        for s in structures
    }


def table_text() -> str:
    """Return the table of all clean structures of 2, 3 and 4 joints (half a minute)."""
    lines = (structure.line() for n in (2, 3, 4) for structure in find_clean_structures(n))
    return "# made by qdot.exercises.families.structures.write_table()\n" + "\n".join(lines) + "\n"


@lru_cache(maxsize=1)
def clean_structures() -> dict[int, tuple[Structure, ...]]:
    """Return the clean structures of the table by their number of joints."""
    clean: dict[int, list[Structure]] = {}
    for line in TABLE.read_text(encoding="utf-8").splitlines():
        if line and not line.startswith("#"):
            structure = _parse_line(line)
            clean.setdefault(len(structure.rows), []).append(structure)
    return {n: tuple(structures) for n, structures in clean.items()}


def _parse_line(line: str) -> Structure:
    rows, task, number = (part.strip() for part in line.split("|"))
    return Structure(read_rows(rows), tuple(task.split()), int(number))


def read_rows(code: str) -> tuple[StructureRow, ...]:
    """Return the rows of a code, as in "Rdx Ra Pt"."""
    return tuple(StructureRow(word[0], "a" in word, "d" in word or "t" in word, "x" in word) for word in code.split())


def clean_classes(n: int) -> tuple[tuple[Structure, ...], ...]:
    """Return the clean structures of n joints by class (see `classes`): those of one class are the same problem."""
    classes: dict[Key, list[Structure]] = {}
    for structure in clean_structures()[n]:
        classes.setdefault(class_key(structure.rows, structure.task), []).append(structure)
    return tuple(map(tuple, classes.values()))


def write_table() -> None:
    """Write the table anew."""
    write_atomically(TABLE, table_text())
