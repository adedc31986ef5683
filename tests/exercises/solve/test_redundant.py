"""Arms of seven joints are solved in seconds; what is told of them and of special lengths holds in numbers."""

import itertools
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import sympy as sp

from qdot.exercises.arm.chain import Chain, Joint, Point
from qdot.exercises.arm.conventions.base import VELOCITY_NAMES
from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.common.time_limit import DEFAULT_SECONDS, time_limit
from qdot.exercises.derivation import derivation
from qdot.exercises.families import FAMILIES
from qdot.exercises.generation import sample_chain
from qdot.exercises.problem.problem import ProblemId
from qdot.exercises.robots.library import find_robot_path
from qdot.exercises.robots.robot_file import read_robot_file
from qdot.exercises.singularities.classification import Classification
from qdot.exercises.singularities.existence_conditions import find_existence_condition
from qdot.exercises.singularities.reciprocal import elimination_applies, find_reciprocal_set, make_polynomial_arm
from qdot.exercises.singularities.singular_set import find_singular_set
from qdot.exercises.solve.certified_singularities import certify_statement
from qdot.exercises.solve.numeric_rank_check import check_rank_loss
from qdot.exercises.solve.solver import Solution, solve
from qdot.exercises.verify.singularity_statements import sample_component
from qdot.exercises.writing import solution_steps as steps_module
from qdot.exercises.writing.problem_texts import get_solution_steps
from tests.repository.test_schemas import find_schema_errors
from tests.support.solving import solve_to_json, solve_to_text
from tests.support.suites import on_families

Rows = list[tuple[object, object, object, int]]
IIWA: Rows = [
    (0, ".34", 0, -90), (0, 0, 0, 90), (0, ".4", 0, 90), (0, 0, 0, -90), (0, ".4", 0, -90), (0, 0, 0, 90),
    (0, ".126", 0, 0),
]  # fmt: skip
IIWA_OPEN: Rows = [(turn, f"d{i}" if d else 0, a, alpha) for i, (turn, d, a, alpha) in enumerate(IIWA, 1)]
OBLIQUE: Rows = [
    (0, ".34", 0, -90), (0, 0, 0, 90), (0, ".4", 0, 60), (0, 0, 0, -60), (0, ".4", 0, -90), (0, 0, 0, 90),
    (0, ".126", 0, 0),
]  # fmt: skip
EIGHT: Rows = [*IIWA[:6], (0, ".126", 0, -90), (0, 0, ".1", 0)]
ARMS = {"iiwa": IIWA, "iiwa-open": IIWA_OPEN, "eight": EIGHT, "oblique": OBLIQUE}
"""Others are robots of the library."""


def _length(text: object) -> sp.Expr:
    return sp.Symbol(text) if isinstance(text, str) and text[0].isalpha() else sp.Rational(str(text))


def _joints(rows: Rows) -> tuple[Joint, ...]:
    return tuple(
        Joint("R", sp.Symbol(f"theta{i}") + sp.Integer(turn) * sp.pi / 180, _length(d), _length(a), alpha * sp.pi / 180)
        for i, (turn, d, a, alpha) in enumerate(rows, 1)
    )


@cache
def _arm(name: str) -> Chain:
    if name in ARMS:
        return Chain(name, _joints(ARMS[name]), VELOCITY_NAMES, title=name)
    return read_robot_file(find_robot_path(name)).chain


@cache
def _solved(name: str) -> Solution:
    with time_limit(DEFAULT_SECONDS):  # ten seconds on an idle machine; what `qdot solve` has if nothing else is said
        return solve(_arm(name))


def _conditions(solution: Solution) -> set[frozenset[str]]:
    assert solution.singular is not None
    return {frozenset(map(str, part.conditions)) for part in solution.singular}


@pytest.mark.whole
def test_a_panda_has_the_singularities_that_its_offsets_leave() -> None:
    solution = _solved("panda")
    assert solution.singular is not None
    elbow, wrist, shoulder_wrist, shoulder = solution.singular
    t4, t5, t6 = sp.symbols("theta4 theta5 theta6")
    # The arm is straight: link 4's offset and link 5's cancel, and axis 5 goes through the shoulder.
    assert elbow.solutions is not None and dict(elbow.solutions)[t4] == (0,)
    assert sp.simplify(sp.sin(dict(elbow.solutions)[t6][0])) == sp.Rational(-22, 175)
    assert wrist.solutions is not None and dict(wrist.solutions)[t5] == (0, sp.pi)
    assert str(shoulder_wrist.conditions[0]) == "cos(theta5)"
    assert shoulder_wrist.conditions[1].free_symbols == {t4, t6}
    assert str(shoulder.conditions[0]) == "sin(theta2)"
    assert solution.redundant is not None and solution.redundant.doubtful_conditions == ()
    assert solution.redundant.search_counts == {"searches": 60, "ended": 60, "unexplained": 0}
    # Away from the conditions of three of them, a condition alone leaves J with its full rank.
    q = np.array([0.3, 0.8, -0.4, 0.0, 1.1, 0.5, 0.2])
    assert np.linalg.matrix_rank(NumericChain(_arm("panda"), {}).compute_jacobian(q)) == 6


SLOW = ("panda", "gen3", "iiwa-open", "baxter", "sawyer", "eight", "oblique")


@pytest.mark.parametrize("name", ["iiwa", *(pytest.param(name, marks=pytest.mark.whole) for name in SLOW)])
@pytest.mark.whole
def test_an_arm_is_solved_in_seconds_and_all_that_is_told_holds(name: str) -> None:
    solution = _solved(name)
    content = solve_to_json(solution.chain)
    assert find_schema_errors("solve", content) == []
    assert content["singular"] and content["tested"]["unexplained"] == 0
    assert content["tested"]["ended"] > 0.9 * content["tested"]["searches"]
    text = " ".join(solve_to_text(solution.chain, "text").split())
    assert "not a proof" in text
    assert ("The rank of N₁ is below" in text) == (name in ("baxter", "gen3", "sawyer"))
    assert ("holds for general lengths" in text) == bool(solution.chain.parameters)
    # Other lengths and starts than those that it was tested with.
    assert solution.redundant is not None and solution.redundant.check is not None
    out = check_rank_loss(solution.chain, [c.conditions for c in solution.singular or ()], seed="other starts")
    assert out.full_rank_branches == () and out.unexplained_configurations == ()
    first, other = solution.redundant.check.samples[0], out.samples[0]
    assert not any(np.allclose(a.q, b.q) for a in first for b in other)


@pytest.mark.whole
def test_conditions_without_a_configuration_are_told_as_undecided(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each of these can hold, but not both: sin(theta2) would be 7/5."""
    s2, s4 = sp.sin(sp.Symbol("theta2")), sp.sin(sp.Symbol("theta4"))
    both = (s2 - s4 - sp.Rational(19, 10), s2 + s4 - sp.Rational(9, 10))

    def solved(*before: tuple[sp.Expr, ...]) -> Solution:
        monkeypatch.setattr(
            "qdot.exercises.solve.redundant.find_reciprocal_set",
            lambda *given: replace(find_reciprocal_set(*given), branches=(*before, both)),
        )
        return solve(replace(_arm("iiwa"), name=f"undecided beside {len(before)}"))

    usual = _solved("iiwa")
    solution = solved(*find_reciprocal_set(*make_polynomial_arm(_arm("iiwa"))[:1]).branches)
    assert solution.redundant is not None and solution.redundant.undecided_conditions == (both,)
    assert _conditions(solution) == _conditions(usual) and solution.redundant.doubtful_conditions == ()
    for said in (solution.note or "", " ".join(solve_to_text(solution.chain, "text").split())):
        assert "No configuration was found in which" in said
    assert "`sin(theta2) - sin(theta4) - 19/10 = 0`" in (solution.note or "")
    assert "No configuration was found in which" not in (usual.note or "")
    solution = solved()
    assert solution.singular == () and "full rank in every configuration" not in (solution.note or "")
    assert "No configuration is known in which it loses rank" in " ".join(solve_to_text(solution.chain, "text").split())


@pytest.mark.whole
@pytest.mark.parametrize("name", ["iiwa", pytest.param("iiwa-open", marks=pytest.mark.whole)])
def test_a_spherical_shoulder_and_wrist_give_what_the_minors_do(name: str) -> None:
    by_minors = {frozenset(map(str, part.conditions)) for part in find_singular_set(_arm(name)) or ()}
    assert _conditions(_solved(name)) == by_minors
    assert frozenset({"sin(theta4)"}) in by_minors and len(by_minors) == 4


def test_the_test_in_numbers_finds_what_is_missing_and_what_is_false() -> None:
    chain = _arm("iiwa")
    ways = [part.conditions for part in find_singular_set(chain) or ()]
    s2, c3 = sp.sin(sp.Symbol("theta2")), sp.cos(sp.Symbol("theta3"))
    for missing in range(len(ways)):
        out = check_rank_loss(chain, ways[:missing] + ways[missing + 1 :])
        assert out.full_rank_branches == () and (out.unexplained_configurations or len(ways[missing]) > 1)
    assert check_rank_loss(chain, [*ways, (s2,)]).full_rank_branches == (4,)
    assert check_rank_loss(chain, [*ways, (c3, s2 - 2)]).samples[4] == ()  # there is no such configuration
    assert len(check_rank_loss(chain, []).unexplained_configurations) > 50


def test_where_rank_is_lost_everywhere_it_is_said() -> None:
    """Four slides and three turns: of seven joints, one turn has no effect of its own."""
    slides = [Joint("P", 0, sp.Symbol(f"d{i}"), 0, sp.pi / 2) for i in (1, 2, 3, 4)]
    turns = [Joint("R", sp.Symbol(f"theta{i}"), 0, sp.Rational(1, 5), 0) for i in (5, 6, 7)]
    solution = solve(Chain("always", (*slides, *turns), VELOCITY_NAMES, title="always"))
    assert solution.singular is None and "every configuration" in (solution.note or "")
    assert "every configuration" in solve_to_text(solution.chain, "text")


@pytest.mark.whole
def test_twists_lengths_and_points_that_are_no_polynomials_are_taken() -> None:
    """A twist of 40 degrees, a length with a root, and a point before the last joint, on whose axis it lies or not."""
    joints = list(_arm("iiwa").joints)
    joints[2] = replace(joints[2], alpha=2 * sp.pi / 9)
    joints[4] = replace(joints[4], d=sp.sqrt(2) / 5)
    chain = Chain("odd", tuple(joints), VELOCITY_NAMES, tool=Point(6), title="odd")
    assert elimination_applies(chain)
    solution = solve(chain)
    assert solution.redundant is not None and solution.singular and solution.redundant.doubtful_conditions == ()
    assert solution.redundant.search_counts["unexplained"] == 0
    away = replace(chain, tool=Point(6, (sp.Rational(1, 5), sp.S.Zero, sp.S.Zero)))
    assert not elimination_applies(away)  # the last joint does not move it: it is no point of the last link


def _of_position(rows: Rows, point: tuple[object, ...] = (0, 0, 0)) -> Chain:
    tool = Point(len(rows), tuple(map(_length, point)))
    return Chain("of position", _joints(rows), VELOCITY_NAMES[:3], tool=tool, title="one")


LONG_MINORS: Rows = [(90, ".2", 0, 90), (0, 0, 0, -90), (30, 0, 0, -90), (90, 0, ".2", -90), (0, "-.3", "-.3", -90)]
SHORT_MINORS: Rows = [(0, 0, 0, 90), (0, 0, "a2", 0), (0, 0, 0, 90), (0, "h4", "a4", 0)]


@pytest.mark.whole
def test_a_position_whose_minors_are_long_is_solved_by_a_force_that_does_no_work() -> None:
    """An arm whose minors of 2,610 terms led to nothing in 20 seconds of a processor."""
    chain = _of_position(LONG_MINORS)
    assert elimination_applies(chain)
    solution = solve(chain)
    found = solution.redundant
    assert found is not None and found.reciprocal_set.start.reference_frame is None
    assert (found.doubtful_conditions, found.undecided_conditions) == ((), ())
    assert frozenset({"sin(theta5)"}) in _conditions(solution)
    out = check_rank_loss(chain, [one.conditions for one in found.components], start_count=150, seed="again")
    assert (out.full_rank_branches, out.unexplained_configurations) == ((), ()) and all(out.samples)
    text = " ".join(solve_to_text(solution.chain, "text").split())
    assert "some force at P" in text and "a boundary singularity" in text
    assert find_schema_errors("solve", solve_to_json(solution.chain)) == []


def test_the_minors_of_short_arms_are_kept() -> None:
    assert not elimination_applies(_of_position(SHORT_MINORS))


@pytest.mark.parametrize("point", [(0, 0, 0), (".1", 0, ".3")])
@pytest.mark.whole
def test_by_elimination_a_position_loses_rank_where_it_does_by_minors(
    monkeypatch: pytest.MonkeyPatch, point: tuple[object, ...]
) -> None:
    chain = _of_position(SHORT_MINORS, point)
    monkeypatch.setattr(derivation, "LONG_MINOR_TERMS", derivation.MAX_MINOR_TERMS)
    assert not elimination_applies(chain)
    by_minors = [one.conditions for one in find_singular_set(chain) or ()]
    monkeypatch.setattr(derivation, "LONG_MINOR_TERMS", 0)
    assert elimination_applies(chain)
    assert not elimination_applies(replace(chain, task=("vx", "vy")))
    found = solve(chain).redundant
    assert found is not None and found.components
    for ways in (by_minors, [one.conditions for one in found.components]):
        out = check_rank_loss(chain, ways)
        assert (out.full_rank_branches, out.unexplained_configurations) == ((), ())


def test_conditions_that_hold_for_few_lengths_are_found_with_these() -> None:
    """4 a = cos(theta2) where a is below 0.25 m, which none of the usual lengths is; searches are with these."""
    chain = _of_position([(0, 0, 0, 90), (0, 0, "a2", 0), (0, 0, ".3", 90), (0, 0, ".2", 0)])
    (a2,), t2 = chain.parameters, chain.q[1]
    out = check_rank_loss(chain, [(4 * a2 - sp.cos(t2),), (2 + a2 + sp.cos(t2),)])
    assert (out.searched_arm_count, out.search_count) == (3, 180)
    assert out.samples[0] and not out.samples[1] and out.full_rank_branches == (0,)
    assert all(sample.arm in out.arms[out.searched_arm_count :] for sample in out.samples[0])


A1, A2, A3, D4 = sp.symbols("a1 a2 a3 d4")
T1, T2, T3, T4, D3 = sp.symbols("theta1 theta2 theta3 theta4 d3")
TURNING = Chain("turning", tuple(Joint("R", f"theta{i}", 0, f"a{i}", 0) for i in range(1, 5)), ("vx", "vy"))
SLIDING = Chain("sliding", (TURNING.joints[0], TURNING.joints[1], Joint("P", 0, "d3", 0, 0)), ("vx", "vy"))
s, c = sp.sin, sp.cos
NEEDS = (
    (A1 + A2 * c(T2), "a1 <= a2"), (-A1 - A2 * s(T2), "a1 <= a2"),
    (A1 + A2 * c(T2) + A3 * c(T2 + T3), "a1 <= a2 + a3"), (2 * A1 - A2 * c(T2) + A1 * c(T3), "a1 <= a2"),
    (A1 + D4 - A2 * s(T2 - T3), "a1 + d4 <= a2"), (A1 + A2 * c(T2) + A3 * s(T2), "a1 <= sqrt(a2**2 + a3**2)"),
    (A1 * A2 + A2 * A3 * c(T2) * c(T3), "a1*a2 <= a2*a3"),  # the difference of both angles, and the sum
    (A1 - sp.Rational(2, 5) + A2 * c(T2), None), (A2 * c(T2) + A3 * c(T2 + T3), None),
    (A1 + A2 * c(T2) + A1 * c(T3), None), (A1 + A2 * c(T2) + A2 * c(T3) + A2 * c(T2 + T3), None),
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
            for values in itertools.product((0.2, 1.1), repeat=len(symbols)):
                lengths = dict(zip(symbols, values, strict=True))
                least, most = (float(sp.sympify(side).xreplace(lengths)) for side in (need.smaller, need.larger))
                low, high = reach(condition, lengths)
                if abs(least - most) > 1e-2:
                    assert (low <= 0 <= high) == (least < most), (condition, lengths)


PLANAR = (Joint("R", T1, 0, A1, 0), Joint("R", T2, 0, A2, 0))


@pytest.mark.parametrize(
    ("kind", "look"), [("boundary", "arm folded back"), ("internal", "arm stretched out or folded back")]
)
def test_a_false_look_or_kind_is_not_told(kind: str, look: str, monkeypatch: pytest.MonkeyPatch) -> None:
    false = Classification(kind, True, look)
    monkeypatch.setattr(steps_module, "classify", lambda *_: false)
    get_solution_steps.cache_clear()
    solution = solve(Chain("mine", PLANAR, ("vx", "vy")))
    (found,) = solve_to_json(solution.chain)["singular"]
    get_solution_steps.cache_clear()
    if false.kind == "internal":
        assert (found["meaning"], found["uniform"]) == (false.meaning, False)
    else:
        text = found["meaning"] + solve_to_text(solution.chain, "text")
        assert found["type"] == "boundary" and "folded back" not in text


def test_words_are_sound_where_they_are_so_of_every_configuration() -> None:
    chain = Chain("mine", PLANAR, ("vx", "vy"))
    (component,) = get_solution_steps(chain).components
    samples = sample_component(chain, component)
    assert certify_statement(chain, "arm stretched out or folded back", samples)
    assert certify_statement(chain, "arm stretched out", samples) == ""
    assert certify_statement(chain, "arm stretched out or folded back", []) == ""
