"""Measure how many students of a class would share an answer, for docs/variation.md (`make sharing`, minutes).

An answer in formulas depends only on the arm. So the arms of a class are sampled and grouped by the values of their
formulas at fixed values of symbols and joints. Parts with numbers, or with other sampled data, are generated for a
smaller class.
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
from qdot.exercises.arm.derivation import symbolic_arm_of
from qdot.exercises.arm.derivation_graph import StageResults, compute_numeric_stages
from qdot.exercises.common.console import say
from qdot.exercises.common.files import write_atomically
from qdot.exercises.common.stream import Stream
from qdot.exercises.common.variation import DEFAULT_VARIATION, VARIATION_STEPS
from qdot.exercises.families import FAMILIES
from qdot.exercises.generation import questions_of_family, sample_chain
from qdot.exercises.problem.problem import Part, Problem, ProblemId
from qdot.exercises.problem.record import compute_digests
from qdot.exercises.questions import QUESTIONS

MEASURED = Path(__file__).with_name("sharing.json")

CLASS, ASKED_CLASS = 500, 30
"""Students of the class whose arms are drawn, and of the smaller one that is asked."""

ASKED_FAMILIES, ASKED_STEPS = ("planar-2r", "elbow-3r"), ("chapter", DEFAULT_VARIATION)
"""The families whose parts are asked of the smaller class, and at which steps."""

CLASS_OF_VARIED = 100
"""Students of the class where structures are drawn, which takes half a second each."""

ALIKE = {"jacobian-size"}
"""Questions whose answer is no secret: the same for a family's every arm, or chosen out of a few."""

DIGITS = 9
POSES = 3
"""Where formulas are evaluated: they are the same where these many digits are, in so many configurations."""

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
"""Questions that are shared alike, as their formulas are results of one stage, by the heading of their column."""

READ: dict[str, Read] = {
    "position": lambda w: w["point"],
    "J": lambda w: w["jacobian"],
    "axes": lambda w: w["axes"][: w.n],
    "vectors": lambda w: w["p*"][: w.n],
    "6 x n": lambda w: w["geometric"],
    "det": lambda w: _determinant(w)[None],
    "blocks": lambda w: w["arm block"],
    "wrist": lambda w: w["wrist block"],
    "singular": lambda w: _determinant(w)[None],
}
"""The stage from which a group's answers follow."""


def _determinant(w: StageResults) -> np.ndarray:
    return np.asarray(w["determinant"] if len(w.chain.task) == w.n else w["gram determinant"])


def keys_in_formulas(arms: Sequence[Chain], groups: Sequence[str]) -> dict[str, list[Key]]:
    """Return keys of each arm's answers by group: values of formulas at fixed values of symbols and joints.

    Arms of one structure are evaluated together. Conditions on joints are equal if determinants differ by a constant
    factor.
    """
    keys: dict[str, list[Key]] = {group: [()] * len(arms) for group in groups}
    known = [symbolic_arm_of(arm) for arm in arms]
    alike: dict[Chain, list[int]] = {}
    for index, its in enumerate(known):
        alike.setdefault(its.chain, []).append(index)
    for generic, members in alike.items():
        stages = _evaluate(generic, [dict(known[index].values) for index in members])
        for group in groups:
            outcome = READ[group](stages).reshape(-1, len(members), POSES)
            if group == "singular":
                outcome = outcome / outcome[..., :1]
            rows = np.round(np.moveaxis(outcome, 1, 0).reshape(len(members), -1), DIGITS) + 0.0
            for index, row in zip(members, rows, strict=True):
                keys[group][index] = (len(row), row.tobytes())
    return keys


def _evaluate(generic: Chain, stand_for: Sequence[dict[sp.Symbol, sp.Expr]]) -> StageResults:
    """Return the stages for arms of one structure, each in the same configurations."""
    values = {
        symbol.name: np.array(
            [_value(its.get(symbol, symbol), pose, generic.q) for its in stand_for for pose in range(POSES)]
        )
        for symbol in (*generic.q, *generic.parameters)
    }
    return compute_numeric_stages(generic, values)


@cache
def _value(expression: sp.Expr, pose: int, joints: tuple[sp.Symbol, ...]) -> float:
    """Return a value where each symbol has one that no arm is given; in another pose, joints have others."""
    fixed = {}
    for symbol in expression.free_symbols:
        stream = Stream(f"sharing/{symbol.name}/{pose if symbol in joints else 0}")
        fixed[symbol] = 0.25 + stream.integer_below(10**9) / 10**9
    return float(expression.subs(fixed))


@cache
def load_measured() -> dict[str, Any]:
    """Return the stored measurements."""
    content: dict[str, Any] = json.loads(MEASURED.read_text(encoding="utf-8"))
    return content


def count_sharing(keys: Iterable[Hashable]) -> int:
    """Return the number of keys that occur more than once, with multiplicity.

    >>> count_sharing("abcab")
    4
    """
    return sum(count for count in Counter(keys).values() if count > 1)


# --- measured ---


def arms_of(family: str, step: str, size: int) -> list[Chain]:
    """Return the arms of a class."""
    return [sample_chain(ProblemId(family, seed, variation=step)) for seed in range(size)]


def measure_formulas(family: str, size: int = CLASS) -> dict[str, dict[str, int]]:
    """Return how many of a class share the answers of each group, by step."""
    asked = set(questions_of_family(family))
    plain = FAMILIES[family].textbook_arm
    square = plain is None or len(plain.task) == plain.n
    groups = [group for group, names in GROUPS.items() if asked & set(names) and (square or group != "singular")]
    return {
        step: {
            group: count_sharing(keys) for group, keys in keys_in_formulas(arms_of(family, step, size), groups).items()
        }
        for step in VARIATION_STEPS
    }


def measure_asked(family: str, step: str, questions: Sequence[str], size: int = ASKED_CLASS) -> dict[str, int]:
    """Return how many students of a small class share a part, counted as in `qdot generate`."""
    shared = {}
    arms = arms_of(family, step, size)
    for name in questions:
        asked = []
        for seed, arm in enumerate(arms):
            identity = ProblemId(family, seed, (name,), variation=step)
            asked.append(digest_of_asked(identity, arm, name))
        shared[name] = count_sharing(asked)
    return shared


def digest_of_asked(identity: ProblemId, arm: Chain, name: str) -> str:
    """Return the digest of a part for a given arm."""
    answer, details = QUESTIONS[name].ask(arm, Stream(f"qdot/{identity.engine}/{identity.family_and_seed}/{name}"))
    problem = Problem(identity, arm, (Part(name, name, answer, details=details),))
    return compute_digests(problem).parts[name]


def questions_beyond_arm(family: str) -> list[str]:
    """Return the questions of a family whose answers do not depend on the arm alone."""
    in_formulas = {name for names in GROUPS.values() for name in names} | ALIKE
    return [name for name in questions_of_family(family) if name not in in_formulas]


def measure_family(family: str) -> dict[str, Any]:
    """Measure one family."""
    size = CLASS_OF_VARIED if FAMILIES[family].has_varied_structure else CLASS
    return {"students": size, "steps": measure_formulas(family, size)}


def measure() -> dict[str, Any]:
    """Measure all families, and return the content of sharing.json."""
    formulas = {family: measure_family(family) for family in FAMILIES}
    asked = {
        family: {step: measure_asked(family, step, questions_beyond_arm(family)) for step in ASKED_STEPS}
        for family in ASKED_FAMILIES
    }
    return {"formulas": formulas, "asked": {"students": ASKED_CLASS, "families": asked}}


def measurement_text(content: dict[str, Any]) -> str:
    """Return the file that the page reads."""
    return json.dumps(content, indent=1) + "\n"


if __name__ == "__main__":
    write_atomically(MEASURED, measurement_text(measure()))
    say(f"wrote {MEASURED.name}")
