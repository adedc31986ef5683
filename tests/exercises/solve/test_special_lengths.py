"""Statements about singular configurations and special lengths hold numerically."""

import itertools

import numpy as np
import pytest
import sympy as sp

from qdot.exercises.arm.chain import Chain, Joint
from qdot.exercises.families import FAMILIES
from qdot.exercises.generation import sample_chain
from qdot.exercises.problem.problem import ProblemId
from qdot.exercises.singularities.classification import Classification
from qdot.exercises.singularities.existence_conditions import find_existence_condition
from qdot.exercises.singularities.singular_set import find_singular_set
from qdot.exercises.solve.certified_singularities import certify_statement
from qdot.exercises.solve.solver import solve
from qdot.exercises.verify.singularity_statements import sample_component
from qdot.exercises.writing import solution_steps as steps_module
from qdot.exercises.writing.problem_texts import get_solution_steps
from tests.support.solving import solve_to_json, solve_to_text
from tests.support.suites import on_families

A1, A2, A3, D4 = sp.symbols("a1 a2 a3 d4")
T1, T2, T3, T4, D3 = sp.symbols("theta1 theta2 theta3 theta4 d3")
TURNING = Chain("turning", tuple(Joint("R", f"theta{i}", 0, f"a{i}", 0) for i in range(1, 5)), ("vx", "vy"))
SLIDING = Chain("sliding", (TURNING.joints[0], TURNING.joints[1], Joint("P", 0, "d3", 0, 0)), ("vx", "vy"))
s, c = sp.sin, sp.cos

NEEDS = (
    (A1 + A2 * c(T2), "a1 <= a2"),
    (-A1 - A2 * s(T2), "a1 <= a2"),
    (A1 + A2 * c(T2) + A3 * c(T2 + T3), "a1 <= a2 + a3"),
    (2 * A1 - A2 * c(T2) + A1 * c(T3), "a1 <= a2"),
    (A1 + D4 - A2 * s(T2 - T3), "a1 + d4 <= a2"),
    (A1 + A2 * c(T2) + A3 * s(T2), "a1 <= sqrt(a2**2 + a3**2)"),
    (A1 * A2 + A2 * A3 * c(T2) * c(T3), "a1*a2 <= a2*a3"),  # the difference of both angles, and the sum
    (A1 - sp.Rational(2, 5) + A2 * c(T2), None),
    (A2 * c(T2) + A3 * c(T2 + T3), None),
    (A1 + A2 * c(T2) + A1 * c(T3), None),
    (A1 + A2 * c(T2) + A2 * c(T3) + A2 * c(T2 + T3), None),
)  # fmt: skip


def reach(condition: sp.Expr, lengths: dict[sp.Symbol, float]) -> tuple[float, float]:
    """Return the least and the greatest value of a condition over all angles, by trying them."""
    angles = sorted(condition.free_symbols - set(lengths), key=str)
    grid = np.meshgrid(*(np.linspace(-np.pi, np.pi, 241) for _ in angles))
    values = sp.lambdify(angles, condition.xreplace(lengths), "numpy")(*grid)
    return float(np.min(values)), float(np.max(values))


@pytest.mark.parametrize(("condition", "wanted"), NEEDS, ids=str)
def test_a_condition_holds_somewhere_for_the_lengths_that_are_told(condition: sp.Expr, wanted: str | None) -> None:
    need = find_existence_condition(condition, TURNING)
    if wanted is None or need is None:
        assert need is None or wanted is not None
        return
    assert f"{need.smaller} <= {need.larger}" == wanted
    holds = {True: 0, False: 0}
    symbols = sorted((need.smaller + need.larger).free_symbols, key=str)
    for values in itertools.product((0.3, 0.55, 0.8, 1.3), repeat=len(symbols)):
        lengths = dict(zip(symbols, values, strict=True))
        least, most = (float(sp.sympify(side).xreplace(lengths)) for side in (need.smaller, need.larger))
        others = condition.free_symbols & {A1, A2, A3, D4} - {*symbols}
        low, high = reach(condition, lengths | dict.fromkeys(others, 0.5))
        if abs(least - most) > 1e-3:
            assert (low <= 1e-3 and high >= -1e-3) == (least < most), lengths
            holds[least < most] += 1
    assert all(holds.values())


def test_where_a_slide_moves_in_a_condition_nothing_is_told() -> None:
    assert find_existence_condition(A1 + D3 * c(T2), SLIDING) is None
    assert find_existence_condition(A1 + A2 * c(T2), SLIDING) is not None


@on_families([name for name, each in FAMILIES.items() if not each.has_varied_structure])
def test_what_is_told_of_a_family_is_so_in_numbers(family: str) -> None:
    chain = sample_chain(ProblemId(family, 0, variation="chapter"), FAMILIES[family])
    for component in find_singular_set(chain) or ():
        for condition in component.conditions:
            need = find_existence_condition(condition, chain)
            if need is None or len(condition.free_symbols & set(chain.q)) > 3:
                continue
            symbols = sorted(condition.free_symbols - set(chain.q), key=str)
            for lengths in (
                dict(zip(symbols, v, strict=True)) for v in itertools.product((0.2, 1.1), repeat=len(symbols))
            ):
                least, most = (float(sp.sympify(side).xreplace(lengths)) for side in (need.smaller, need.larger))
                low, high = reach(condition, lengths)
                if abs(least - most) > 1e-2:
                    assert (low <= 0 <= high) == (least < most), (condition, lengths)


PLANAR = (Joint("R", T1, 0, A1, 0), Joint("R", T2, 0, A2, 0))


@pytest.mark.parametrize(
    "false",
    [
        Classification("boundary", True, "arm folded back"),
        Classification("internal", True, "arm stretched out or folded back"),
    ],
)
def test_a_false_look_or_kind_is_not_told(false: Classification, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(steps_module, "classify", lambda *_: false)
    get_solution_steps.cache_clear()
    solution = solve(Chain("mine", PLANAR, ("vx", "vy")))
    (found,) = solve_to_json(solution.chain)["singular"]
    get_solution_steps.cache_clear()
    if false.kind == "internal":
        assert (found["meaning"], found["uniform"]) == (false.meaning, False)
    else:
        assert found["type"] == "boundary" and "folded back" not in found["meaning"] + solve_to_text(
            solution.chain, "text"
        )


def test_words_are_sound_where_they_are_so_of_every_configuration() -> None:
    chain = Chain("mine", PLANAR, ("vx", "vy"))
    (component,) = get_solution_steps(chain).components
    samples = sample_component(chain, component)
    assert certify_statement(chain, "arm stretched out or folded back", samples)
    assert certify_statement(chain, "arm stretched out", samples) == ""
    assert certify_statement(chain, "arm stretched out or folded back", []) == ""
