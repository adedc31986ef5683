"""Families of textbook arms: determinants, singular sets and kinds against the formulas of the books.

The formulas below are written by hand, in the entries of the DH table: t2 is theta2 with its offset, d3 the place of a
slide with its zero, h the offset of the point of interest along y, u4 the sine of alpha4 (the sense of an axis).
"""

from math import prod

import pytest
import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.common.stream import Stream
from qdot.exercises.derivation.derivation import derive
from qdot.exercises.generation import sample_chain
from qdot.exercises.problem.problem import ProblemId
from qdot.exercises.singularities.classification import classify_conditions
from qdot.exercises.singularities.singular_set import find_singular_set
from tests.exercises.arm.sets import assert_same_set, read_singular_set
from tests.support.problems import fold_tool_into_table
from tests.support.suites import on_families, sample_for_suite, select_for_suite

SHOULDER = "a1 + a2*cos(t2) + a3*cos(t2 + t3)"
ELBOW = ("a2", "a3", "sin(t3)", SHOULDER)
SLIDING = ("d3", "d3", "sin(t2)")
ELBOW_D4 = "a3*sin(t3) + d4*cos(t3)"
SHOULDER_D4 = "a1 + a2*cos(t2) + a3*cos(t2 + t3) - d4*sin(t2 + t3)"
SHOULDER_ANTHROPOMORPHIC = "a2*cos(t2) + u3*d4*sin(t2 + t3)"
SHOULDER_UR = "a2*cos(t2) + a3*cos(t2 + t3) + u4*d5*sin(t2 + t3 + t4)"

SCARA = ("a1", "a2", "sin(t2)")
INDUSTRIAL = ("a2", "sin(t5)", ELBOW_D4, SHOULDER_D4)
DETERMINANTS: dict[str, tuple[str, ...]] = {
    "planar-2r": ("a1", "a2*sin(t2) + h*cos(t2)"), "planar-pr": ("a2*sin(t2) + h*cos(t2)",), "planar-3r-pose": SCARA,
    "elbow-3r": ELBOW, "elbow": ELBOW, "elbow-lateral": ELBOW, "polar-rp": ("d2",), "planar-rpr": ("d2",),
    "planar-rrp": ("a1", "sin(t2)"), "planar-prr": ("a2", "sin(t2)"), "cartesian": (), "cylindrical": ("d3",),
    "spherical": SLIDING, "spherical-offset": SLIDING, "scara": SCARA, "scara-rrrp": SCARA,
    "scara-prrr": ("a2", "a3", "sin(t3)"), "wrist-zyz": ("sin(t2)",), "wrist-rpy": ("sin(t2)",),
    "orthogonal-3r": ("a3", "a2 + a3*cos(t3)", "a1 + a2*cos(t2)", "sin(t3)"),
    "stanford-6r": (*SLIDING, "sin(t5)"), "puma-560": INDUSTRIAL, "industrial-6r": INDUSTRIAL,
    "anthropomorphic-6r": ("a2", "d4", "cos(t3)", "sin(t5)", SHOULDER_ANTHROPOMORPHIC),
    "ur-6r": ("a2", "a3", "sin(t3)", "sin(t5)", SHOULDER_UR),
}  # fmt: skip
"""Factors of det J, up to its sign."""

SCORBOT = (("sin(t3)",), (SHOULDER, "sin(t2 + t3 + t4)"))
COMMON_ZEROS: dict[str, tuple[tuple[str, ...], ...]] = {
    "planar-3r": (("sin(t2)", "sin(t3)"),), "pan-tilt": (("cos(t2)",),), "scorbot-wrist": SCORBOT,
    "lbr-7r": (("sin(t4)",), ("sin(t2)", "sin(t6)"), ("sin(t2)", "cos(t3)"), ("sin(t6)", "cos(t5)")),
    "scorbot-tip": SCORBOT,
}  # fmt: skip
"""Singular sets of arms whose J is not square: conditions that hold together, in alternatives."""

B, I, N = "boundary", "internal", ""  # noqa: E741
KINDS: dict[str, tuple[str, ...]] = {
    "planar-2r": (B,), "planar-3r": (B,), "planar-pr": (B,), "planar-rpr": (B,), "planar-rrp": (B,), "planar-prr": (B,),
    "planar-3r-pose": (B,), "polar-rp": (B,), "cylindrical": (B,), "scara": (B,), "scara-rrrp": (B,),
    "scara-prrr": (B,), "elbow-3r": (B, I), "elbow": (B, I), "elbow-lateral": (B, B), "spherical": (I, I),
    "spherical-offset": (B, B), "wrist-zyz": (I,), "wrist-rpy": (I,), "stanford-6r": (B, B, I), "puma-560": (I, B, B),
    "anthropomorphic-6r": (B, I, I), "industrial-6r": (I, B, I), "pan-tilt": (N,), "scorbot-wrist": (N, N),
    "scorbot-tip": (N, N), "ur-6r": (N, N, N), "lbr-7r": (N, N, N, N),
}  # fmt: skip
"""Kinds of the alternatives, in the order above; boundary where some configurations are; N: it is not told."""

KNOWN = [*DETERMINANTS, *COMMON_ZEROS]


def filled(text: str, chain: Chain) -> sp.Expr:
    chain = fold_tool_into_table(chain)
    values: dict[str, sp.Expr] = {"h": chain.point.offset[1]}
    for i, joint in enumerate(chain.joints, 1):
        values |= {f"t{i}": joint.theta, f"d{i}": joint.d, f"a{i}": joint.a, f"u{i}": sp.sin(joint.alpha)}
    return sp.sympify(text, locals=values)


def alternatives(family: str, chain: Chain) -> list[tuple[sp.Expr, ...]]:
    """Return the conditions that the tables give for one arm, without factors that hold no joint."""
    if family in COMMON_ZEROS:
        return [tuple(filled(text, chain) for text in together) for together in COMMON_ZEROS[family]]
    factors = (filled(text, chain) for text in dict.fromkeys(DETERMINANTS[family]))
    return [(factor,) for factor in factors if factor.free_symbols & set(chain.q)]


def as_text(conditions: tuple[sp.Expr, ...]) -> str:
    return " and ".join(f"{condition} = 0" for condition in conditions)


@pytest.mark.parametrize("family", sample_for_suite(KNOWN, 15))
def test_determinant_and_singular_set_are_those_of_the_books(family: str) -> None:
    for seed in range(select_for_suite(1, 4)):
        chain = sample_chain(ProblemId(family, seed))
        book = [as_text(together) for together in alternatives(family, chain)]
        assert len(find_singular_set(chain) or ()) == len(book)
        if book:
            assert_same_set(chain, read_singular_set(chain), book)
        if family in DETERMINANTS:
            stream = Stream(f"{family}/{seed}")
            values = {symbol: stream.uniform(0.3, 1.0) for symbol in (*chain.q, *chain.parameters)}
            formula = prod((filled(text, chain) for text in DETERMINANTS[family]), start=sp.S.One)
            printed, ours = (abs(float(e.xreplace(values))) for e in (formula, derive(chain).determinant))
            assert ours == pytest.approx(printed, rel=1e-9, abs=1e-12)


@on_families([*KINDS])
def test_kinds_are_those_of_the_books(family: str) -> None:
    chain = sample_chain(ProblemId(family, 1))
    found = tuple(classify_conditions(chain, (as_text(together),)).kind for together in alternatives(family, chain))
    assert found == KINDS[family]
