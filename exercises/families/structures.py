"""Read the *clean* structures of 2, 3 or 4 joints, those that can be solved by hand, from structures.txt.

A *structure* says which entries of an arm's DH table are zero. For each joint i, it states:

- whether the joint is revolute or prismatic;
- whether the joint's axis is parallel or perpendicular to the next axis (twist alpha_i of 0 or 90 degrees);
- whether the length a_i is zero;
- for a revolute joint, whether d_i is zero; for a prismatic joint, whether theta_i is 0 or 90 degrees.

The code of a structure has one word for each joint, such as "Rdx Ra Pt". Each word begins with the joint's kind. The
other letters mark what is not zero: a_i, d_i, t for theta_i of a prismatic joint, x for the twist.

Structures of one *class* lead to the same problem: their Jacobians differ only in signs and names of symbols. A program
found all clean structures and their classes. The first line of structures.txt names it, and the revision that has it.
"""

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import sympy as sp

from qdot.exercises.arm.chain import Chain, HasKind, Joint
from qdot.exercises.arm.trigonometry import count_terms
from qdot.exercises.derivation.derivation import derive
from qdot.exercises.singularities.singular_set import find_singular_set

STRUCTURES_FILE = Path(__file__).with_name("structures.txt")
MAX_TERMS, MAX_TERMS_PER_CONDITION = 15, 4
"""Maximum number of terms in the entries of J, and in a condition of the singular set, of a clean structure."""
RIGHT_ANGLE = sp.pi / 2


@dataclass(frozen=True)
class StructureRow(HasKind):
    """One joint of a structure: its kind, and whether a, the fixed one of d and theta, and the twist are nonzero."""

    has_a: bool
    has_fixed_entry: bool
    has_twist: bool

    def __str__(self) -> str:
        fixed_entry = "d" if self.is_revolute else "t"
        return self.kind + "a" * self.has_a + fixed_entry * self.has_fixed_entry + "x" * self.has_twist


@dataclass(frozen=True)
class Structure:
    """A clean structure: its joints, its task, the level of difficulty of its arm, and the number of its class."""

    rows: tuple[StructureRow, ...]
    task: tuple[str, ...]
    level: int
    class_number: int

    def __str__(self) -> str:
        return f"{' '.join(map(str, self.rows))} | {' '.join(self.task)} | {self.level} | {self.class_number}"


def build_arm(
    rows: tuple[StructureRow, ...], task: tuple[str, ...], name: str = "structure", senses: tuple[int, ...] = ()
) -> Chain:
    """Return the arm of a structure with symbolic lengths; its base frame is the world frame.

    `senses` are the signs (1 or -1) of the twists, by default all positive.
    """
    joints = []
    for i, (row, sense) in enumerate(zip(rows, senses or (1,) * len(rows), strict=True), 1):
        a, twist = sp.Symbol(f"a{i}") if row.has_a else sp.S.Zero, sense * RIGHT_ANGLE if row.has_twist else sp.S.Zero
        theta, d = sp.Symbol(f"theta{i}"), sp.Symbol(f"d{i}")
        if row.is_revolute:
            joints.append(Joint(row.kind, theta, d if row.has_fixed_entry else sp.S.Zero, a, twist))
        else:
            joints.append(Joint(row.kind, RIGHT_ANGLE if row.has_fixed_entry else sp.S.Zero, d, a, twist))
    kinds = "".join(row.kind for row in rows)
    return Chain(name, tuple(joints), task, title=f"{kinds} arm")


def is_clean(chain: Chain) -> bool:
    """Return whether an arm can be solved by hand: J and the conditions of the singular set have few terms."""
    if count_terms(derive(chain).jacobian) > MAX_TERMS:
        return False
    components = find_singular_set(chain)
    if components is None:
        return False
    conditions = [condition for component in components for condition in component.conditions]
    return all(len(sp.Add.make_args(sp.expand(condition))) <= MAX_TERMS_PER_CONDITION for condition in conditions)


@lru_cache(maxsize=1)
def read_clean_structures() -> dict[int, tuple[Structure, ...]]:
    """Return the clean structures in structures.txt by their number of joints."""
    structures: dict[int, list[Structure]] = {2: [], 3: [], 4: []}
    for line in STRUCTURES_FILE.read_text(encoding="utf-8").splitlines()[1:]:
        rows, task, level, class_number = line.split(" | ")
        structure = Structure(parse_rows(rows), tuple(task.split()), int(level), int(class_number))
        structures[len(structure.rows)].append(structure)
    return {n: tuple(structures_of_n) for n, structures_of_n in structures.items()}


def parse_rows(code: str) -> tuple[StructureRow, ...]:
    """Return the joints that a code such as "Rdx Ra Pt" describes."""
    return tuple(StructureRow(word[0], "a" in word, "d" in word or "t" in word, "x" in word) for word in code.split())


def group_clean_structures(n: int) -> tuple[tuple[Structure, ...], ...]:
    """Return the clean structures with n joints, grouped by class."""
    classes: dict[int, list[Structure]] = {}
    for structure in read_clean_structures()[n]:
        classes.setdefault(structure.class_number, []).append(structure)
    return tuple(map(tuple, classes.values()))
