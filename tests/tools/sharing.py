"""Measure how many students of a class would share an answer, for docs/variation.md (`make sharing`, minutes).

An answer in formulas depends only on the arm. So the arms of a class are sampled and grouped by the values of their
formulas at fixed values of symbols and joints.
"""

import json
from collections import Counter
from collections.abc import Callable, Hashable, Iterable, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.derivation import make_symbolic_arm
from qdot.exercises.arm.derivation_graph import StageResults, compute_numeric_stages
from qdot.exercises.common.console import print_result
from qdot.exercises.common.files import write_atomically
from qdot.exercises.common.stream import Stream
from qdot.exercises.common.variation import VARIATION_STEPS
from qdot.exercises.families import FAMILIES
from qdot.exercises.generation import list_questions_of_family, sample_chain
from qdot.exercises.problem.problem import ProblemId

MEASUREMENTS_FILE = Path(__file__).with_name("sharing.json")

CLASS_SIZE = 500
"""Students of a class whose arms are compared."""

VARIED_CLASS_SIZE = 100
"""Students of a class with random structures, which take half a second each."""

DIGITS = 9
POSES = 3
"""Formulas are the same if this many digits agree in this many configurations."""

Key = tuple[Hashable, ...]
Read = Callable[[StageResults], np.ndarray]

GROUPS: dict[str, tuple[str, ...]] = {
    "position": ("position",),
    "J": ("velocity", "jacobian", "inverse-jacobian", "inverse-velocity", "joint-torques", "self-motion"),
    "axes": ("joint-axes",),
    "vectors": ("position-vectors",),
    "6 x n": ("geometric-jacobian", "twist"),
    "det": ("determinant", "block-determinants", "gram-determinant"),
    "blocks": ("arm-block",),
    "wrist": ("wrist-block",),
    "singular": ("singular-angles",),
}
"""Questions that are shared equally, because their formulas come from one stage, by column heading."""

READ: dict[str, Read] = {
    "position": lambda w: w["point"],
    "J": lambda w: w["jacobian"],
    "axes": lambda w: w["axes"][: w.n],
    "vectors": lambda w: w["vectors to point"][: w.n],
    "6 x n": lambda w: w["geometric jacobian"],
    "det": lambda w: _determinant(w)[None],
    "blocks": lambda w: w["arm block"],
    "wrist": lambda w: w["wrist block"],
    "singular": lambda w: _determinant(w)[None],
}
"""The stage from which a group's answers follow."""


def _determinant(w: StageResults) -> np.ndarray:
    return np.asarray(w["determinant"] if len(w.chain.task) == w.n else w["gram determinant"])


def make_formula_keys(arms: Sequence[Chain], groups: Sequence[str]) -> dict[str, list[Key]]:
    """Return keys of each arm's answers by group: values of formulas at fixed values of symbols and joints.

    Arms of one structure are evaluated together. Conditions on joints are equal if determinants differ by a constant
    factor.
    """
    keys: dict[str, list[Key]] = {group: [()] * len(arms) for group in groups}
    symbolic_arms = [make_symbolic_arm(arm) for arm in arms]
    by_structure: dict[Chain, list[int]] = {}
    for index, arm in enumerate(symbolic_arms):
        by_structure.setdefault(arm.chain, []).append(index)
    for generic, members in by_structure.items():
        stages = _evaluate(generic, [dict(symbolic_arms[index].values) for index in members])
        for group in groups:
            outcome = READ[group](stages).reshape(-1, len(members), POSES)
            if group == "singular":
                outcome = outcome / outcome[..., :1]
            rows = np.round(np.moveaxis(outcome, 1, 0).reshape(len(members), -1), DIGITS) + 0.0
            for index, row in zip(members, rows, strict=True):
                keys[group][index] = (len(row), row.tobytes())
    return keys


def _evaluate(generic: Chain, length_values: Sequence[dict[sp.Symbol, sp.Expr]]) -> StageResults:
    """Return the stages for arms of one structure, each in the same configurations."""
    values = {
        symbol.name: np.array(
            [_value(lengths.get(symbol, symbol), pose, generic.q) for lengths in length_values for pose in range(POSES)]
        )
        for symbol in (*generic.q, *generic.parameters)
    }
    return compute_numeric_stages(generic, values)


@cache
def _value(expression: sp.Expr, pose: int, joints: tuple[sp.Symbol, ...]) -> float:
    """Return the value of an expression at fixed values of its symbols; joint variables depend on the pose."""
    fixed = {}
    for symbol in expression.free_symbols:
        stream = Stream(f"sharing/{symbol.name}/{pose if symbol in joints else 0}")
        fixed[symbol] = 0.25 + stream.integer_below(10**9) / 10**9
    return float(expression.subs(fixed))


@cache
def load_measurements() -> dict[str, Any]:
    """Return the stored measurements."""
    content: dict[str, Any] = json.loads(MEASUREMENTS_FILE.read_text(encoding="utf-8"))
    return content


def count_sharing(keys: Iterable[Hashable]) -> int:
    """Return the number of keys that occur more than once, with multiplicity.

    >>> count_sharing("abcab")
    4
    """
    return sum(count for count in Counter(keys).values() if count > 1)


# --- measured ---


def sample_arms(family: str, step: str, size: int) -> list[Chain]:
    """Return the arms of a class."""
    return [sample_chain(ProblemId(family, seed, variation=step)) for seed in range(size)]


def measure_formulas(family: str, size: int = CLASS_SIZE) -> dict[str, dict[str, int]]:
    """Return how many of a class share the answers of each group, by step."""
    questions = set(list_questions_of_family(family))
    textbook_arm = FAMILIES[family].textbook_arm
    is_square = textbook_arm is None or len(textbook_arm.task) == textbook_arm.n
    groups = [group for group, names in GROUPS.items() if questions & set(names) and (is_square or group != "singular")]
    return {
        step: {
            group: count_sharing(keys)
            for group, keys in make_formula_keys(sample_arms(family, step, size), groups).items()
        }
        for step in VARIATION_STEPS
    }


def measure_family(family: str) -> dict[str, Any]:
    """Measure one family."""
    size = VARIED_CLASS_SIZE if FAMILIES[family].has_varied_structure else CLASS_SIZE
    return {"students": size, "steps": measure_formulas(family, size)}


def measure() -> dict[str, Any]:
    """Measure all families, and return the content of sharing.json."""
    return {family: measure_family(family) for family in FAMILIES}


def measurement_text(content: dict[str, Any]) -> str:
    """Return the file that the page reads."""
    return json.dumps(content, indent=1) + "\n"


if __name__ == "__main__":
    write_atomically(MEASUREMENTS_FILE, measurement_text(measure()))
    print_result(f"wrote {MEASUREMENTS_FILE.name}")
