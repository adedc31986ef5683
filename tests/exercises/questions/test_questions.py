"""The reference answers of every question of every family agree with tests/snapshots; whom questions are refused; rank.

If a reference changes, an id regenerates another problem: raise exercises.ENGINE, then update the snapshots:

    QDOT_UPDATE_SNAPSHOTS=1 python -m pytest tests/exercises/questions/test_questions.py
"""

import hashlib
import json
import os
import re
from collections import Counter
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import sympy as sp

from qdot.exercises.arm.chain import Chain, Joint
from qdot.exercises.arm.conventions.base import VELOCITY_NAMES
from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.arm.mpmath_kinematics import FLOAT_CONTEXT, MpmathArm
from qdot.exercises.common.stream import Stream
from qdot.exercises.common.variation import VARIATION_STEPS
from qdot.exercises.derivation.derivation import make_symbolic_arm
from qdot.exercises.families import FAMILIES
from qdot.exercises.formula.parser import parse_formula
from qdot.exercises.generation import generate, sample_chain
from qdot.exercises.problem.problem import ENGINE, Part, Problem, ProblemId
from qdot.exercises.problem.record import to_plain_data
from qdot.exercises.questions import QUESTIONS
from qdot.exercises.questions.exact_configurations import (
    _find_zeros,
    evaluate_jacobian,
    match_branches,
    round_to_integer,
    sample_regular_configuration,
    sample_singular_configuration,
)
from qdot.exercises.questions.inversion import sample_lengths
from qdot.exercises.questions.rank import RankDetails
from qdot.exercises.questions.redundancy import MinorDetails
from qdot.exercises.reference_answers import Choice, ConditionSet, Direction, Expression, Matrix, Number
from qdot.exercises.singularities.directions import find_clear_rank
from qdot.exercises.singularities.singular_set import find_singular_set
from qdot.exercises.verify.certificate import certify
from qdot.exercises.writing.problem_texts import write_prompt, write_solution
from qdot.grader.grading.certify import find_failures
from tests.support import DATA, SNAPSHOTS
from tests.support.problems import ask_question, get_problem, replace_answer
from tests.support.suites import on_families, sample_for_suite, select_for_suite

RECORDS = json.loads((DATA / "ground_truth.json").read_text(encoding="utf-8"))
EACH = select_for_suite(1, len(RECORDS))
"""The number of textbook arms per question; `make test` prefers short arms and takes them in turn."""


def describe_answer(part: Part) -> Any:
    answer = part.answer
    if isinstance(answer, ConditionSet):
        return answer.list_pieces()
    if isinstance(answer, Choice):
        return {"options": list(answer.options), "correct": answer.letters}
    if isinstance(answer, Expression):
        return str(answer.reference)
    assert isinstance(answer, (Matrix, Number, Direction))
    return [[str(entry) for entry in row] for row in answer.reference.tolist()]


def describe_arm(problem: Problem) -> Any:
    chain = problem.chain
    rows = [[j.kind, str(j.theta), str(j.d), str(j.a), str(j.alpha)] for j in chain.joints]
    base, point = map(to_plain_data, (chain.base, chain.point))
    return {"rows": rows, "base": base, "point": point, "task": list(chain.task)}


def make_snapshot(problems: list[Problem]) -> dict[str, Any]:
    problem_data: dict[str, Any] = {
        str(problem.id): {
            "arm": describe_arm(problem),
            "parts": {
                part.name: {"answer": describe_answer(part), "details": to_plain_data(part.details)}
                for part in problem.parts
            },
        }
        for problem in problems
    }
    text = json.dumps(problem_data, sort_keys=True, ensure_ascii=False)
    return {"engine": ENGINE, "sha256": hashlib.sha256(text.encode()).hexdigest(), "problems": problem_data}


def test_id_regenerates_the_stored_problem(family: str) -> None:
    """Compare a problem of each family at each variation step; `make test` checks the last step."""
    path, updated = SNAPSHOTS / f"{family}.json", os.environ.get("QDOT_UPDATE_SNAPSHOTS") == "1"
    few = ("full",)
    steps = tuple(VARIATION_STEPS) if updated else select_for_suite(few, tuple(VARIATION_STEPS))
    current = make_snapshot([get_problem(family, 0, step) for step in steps])
    if updated:
        SNAPSHOTS.mkdir(exist_ok=True)
        path.write_text(json.dumps(current, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    assert path.exists(), f"no snapshot of {family} yet: QDOT_UPDATE_SNAPSHOTS=1 python -m pytest {__file__}"
    stored = json.loads(path.read_text(encoding="utf-8"))
    assert list(stored["problems"]) == [str(ProblemId(family, 0, variation=step)) for step in VARIATION_STEPS]
    stored["problems"] = {name: stored["problems"][name] for name in current["problems"]}
    for identity, problem in stored["problems"].items():
        for name, part in problem["parts"].items():
            assert current["problems"][identity]["parts"].get(name) == part, f"{identity}: {name} has changed"
    if steps == tuple(VARIATION_STEPS):
        assert current == stored
    assert current["engine"] == stored["engine"] and current["problems"] == stored["problems"]


def test_every_snapshot_belongs_to_a_family() -> None:
    assert {path.stem for path in SNAPSHOTS.glob("*.json")} <= set(FAMILIES)


def test_questions_are_registered_under_their_names_with_valid_prerequisites() -> None:
    for name, question in QUESTIONS.items():
        assert question.name == name and question.title and question.source and question.points > 0, name
        assert all(need in QUESTIONS for need in question.prerequisites), name


@pytest.mark.parametrize("name", sample_for_suite(QUESTIONS, 6))
def test_textbook_arms_pass_certificate_and_grader(name: str, textbook_arms: dict[str, Any]) -> None:
    """These arms belong to no family, and their tables use the books' symbols."""
    question, taken = QUESTIONS[name], 0
    turn = EACH * list(QUESTIONS).index(name) % len(RECORDS)
    in_turn = [textbook_arms[record["name"]] for record in (*RECORDS[turn:], *RECORDS[:turn])]
    for arm in sorted(in_turn, key=lambda arm: arm.chain.n > 4):
        chain = replace(arm.chain, convention=question.conventions[0])
        if taken < EACH and question.find_obstacle(chain) is None:
            answer, details = question.ask(chain, Stream(f"{chain.name}/{name}"))
            part = Part(name, name, answer, question.points, (), details)
            problem = Problem(ProblemId("textbook", 1, (name,)), chain, (part,))
            assert find_failures(problem) == [], chain.name
            texts = write_prompt(problem, part) + write_solution(problem, part)
            assert not re.search(r"\bNone\b(?! of)", texts), chain.name
            taken += 1
    assert taken


def test_answers_are_well_formed(family: str) -> None:
    problem = get_problem(family, select_for_suite(0, 1))
    for part in problem.parts:
        _check_answer(part, set(problem.symbols))


def _check_answer(part: Part, known: set[str]) -> None:
    answer = part.answer
    if isinstance(answer, (Expression, Matrix, Number, Direction)):
        assert {symbol.name for symbol in answer.reference.free_symbols} <= known, part.name
        assert not answer.reference.has(sp.nan, sp.oo, sp.zoo), part.name
    if isinstance(answer, (Matrix, Number, Direction)):
        assert part.shape == answer.reference.shape, part.name
    if isinstance(answer, Number):
        assert len(answer.units) == len(answer.reference), part.name
        assert 0 < answer.tolerance < 0.05 and answer.floor > 0, part.name
    if isinstance(answer, ConditionSet):
        assert answer.list_pieces(), part.name
        assert all(parse_formula(text, known) for text in answer.list_pieces()), part.name
    if isinstance(answer, Choice):
        assert len(set(answer.options)) == len(answer.options) >= 2, part.name
        assert 0 <= answer.correct < len(answer.options), part.name


RANK = ("rank", "lost-direction", "singularity-meaning")
PATH = ("path-rates",)
PERFORMANCE = ("manipulability", "condition-number")
REDUNDANT = ("gram-determinant", "least-norm-rates", "self-motion")
BLOCKS = ("arm-block", "wrist-block", "block-determinants")
TEXTBOOK_CASES = [
    (RANK, "elbow_RRR", ""), (RANK, "cartesian_PPP", "no singular configuration"),
    (RANK[1:2], "pan_tilt_2R", "its 2 joints can never"), (RANK[1:2], "PUMA560", "6 rows"),
    (PATH, "planar_3R_pose", "only linear velocities"), (PATH, "SCARA_RRRP", "only linear velocities"),
    (PATH, "planar_3R_position", "not square"), (PATH, "pan_tilt_2R", "not square"),
    (PATH, "cartesian_PPP", "its Jacobian is constant"),
    (PERFORMANCE, "planar_3R_pose", "different units"), (PERFORMANCE, "PUMA560", "different units"),
    (PERFORMANCE, "pan_tilt_2R", "singular everywhere"), (PERFORMANCE, "cartesian_PPP", "the same in every"),
    (PERFORMANCE[:1], "planar_RP", ""), (PERFORMANCE[1:], "planar_RP", "different units"),
    (REDUNDANT, "planar_2R", "more joints than rows"), (REDUNDANT, "pan_tilt_2R", "more joints than rows"),
    (REDUNDANT, "Scorbot_5R_task_xyz_pitch_roll_at_P", "does not move"),
]  # fmt: skip
FAMILY_CASES = [
    (("joint-torques",), "puma-560", "too many"), (("joint-torques",), "lbr-7r", "too many"),
    (("joint-torques",), "ur-6r", "too many"), (("transform",), "puma-560", "6 joints"),
    (("tool-jacobian",), "ur-6r", "6 joints"), (("tool-jacobian",), "scorbot-tip", "terms"),
    (("tool-jacobian",), "scorbot-wrist", "frame 4"), (BLOCKS, "planar-2r", ""), (BLOCKS, "ur-6r", ""),
    (BLOCKS, "lbr-7r", ""), (BLOCKS, "wrist-zyz", ""), (BLOCKS, "scorbot-tip", ""),
]  # fmt: skip


@pytest.mark.parametrize(("names", "arm", "why"), TEXTBOOK_CASES)
def test_textbook_arm_is_refused_with_a_reason(
    names: tuple[str, ...], arm: str, why: str, textbook_arms: dict[str, Any]
) -> None:
    for name in names:
        refusal = QUESTIONS[name].find_obstacle(textbook_arms[arm].chain)
        assert (refusal is not None and why in refusal) if why else refusal is None, (name, refusal)


@pytest.mark.parametrize(("names", "family", "why"), sample_for_suite(FAMILY_CASES, 6))
def test_every_arm_of_the_family_is_refused(names: tuple[str, ...], family: str, why: str) -> None:
    for name in names:
        refusals = [QUESTIONS[name].find_obstacle(sample_chain(ProblemId(family, seed))) for seed in range(3)]
        assert all(refusals) and any(why in str(refusal) for refusal in refusals), (name, refusals)


def test_sampled_lengths_are_positive_and_distinct(family: str) -> None:
    """With equal links, a folded arm would be inside its workspace, not at the boundary."""
    for step in ("chapter", "lengths", "full"):
        chain = sample_chain(ProblemId(family, 0, variation=step))
        fixed_lengths = [
            length for joint in chain.joints for length in (joint.a, joint.d) if length.is_number and length != 0
        ]
        for number in range(20):
            lengths = sample_lengths(chain, Stream(f"lengths {number}"))
            assert set(lengths) == set(chain.parameters)
            assert len(set(lengths.values())) == len(lengths) and not set(lengths.values()) & set(fixed_lengths)
            assert all(0.3 <= length <= 0.8 for length in lengths.values())


def test_unit_of_manipulability_follows_from_the_joints(textbook_arms: dict[str, Any]) -> None:
    for name, unit in (("planar_RP", "m"), ("spherical_RRP", "m^2"), ("ZYZ_wrist", ""), ("planar_3R_position", "m^2")):
        (part,) = ask_question("manipulability", textbook_arms[name].chain).parts
        assert part.answer_as(Number).units == (unit,), name


def test_certificate_detects_wrong_unit(textbook_arms: dict[str, Any]) -> None:
    problem = ask_question("manipulability", textbook_arms["spherical_RRP"].chain)
    (part,) = problem.parts
    broken = replace(part, answer=replace(part.answer_as(Number), units=("m^3",)))
    assert not certify(replace(problem, parts=(broken,))).passed


T1, T2, T3, T4 = sp.symbols("theta1:5")
A1, A2, A3, A4 = sp.symbols("a1:5")
NAMES = ("gram-determinant", "least-norm-rates", "self-motion")


def make_joints(*rows: tuple[sp.Expr, sp.Expr, sp.Expr]) -> tuple[Joint, ...]:
    return tuple(Joint("R", sp.Symbol(f"theta{i}"), *row) for i, row in enumerate(rows, 1))


H, ALPHA2 = sp.pi / 2, sp.Symbol("alpha2")
ARM_4R = Chain(
    "elbow with a fourth link", make_joints((0, 0, H), (0, A2, 0), (0, A3, 0), (0, A4, 0)), ("vx", "vy", "vz")
)
LBR = Chain(
    "seven joints",
    make_joints(
        *((d, 0, twist) for d, twist in zip((0.34, 0, 0.4, 0, 0.4, 0, 0), (-H, H, H, -H, -H, H, 0), strict=True))
    ),
    VELOCITY_NAMES,
)
RPR = Chain(
    "RPR", (Joint("R", T1, 0, 0, H), Joint("P", 0, sp.Symbol("d2"), 0, -H), Joint("R", T3, 0, A3, 0)), ("vx", "vy")
)


def test_precise_and_float_arm_agree(textbook_arms: dict[str, Any]) -> None:
    for chain in (LBR, RPR, *(arm.chain for arm in textbook_arms.values())):
        values = {symbol: sp.Rational(3 + i, 7) for i, symbol in enumerate(chain.parameters)}
        q = [0.4 + 0.3 * i for i in range(chain.n)]
        arm = NumericChain(chain, {symbol.name: float(value) for symbol, value in values.items()})
        point, jacobian = MpmathArm(chain, values, FLOAT_CONTEXT).compute_point_and_jacobian(q)
        assert np.allclose(np.array(point, dtype=float), arm.compute_point(np.array(q)), atol=1e-12)
        assert np.allclose(np.array(jacobian, dtype=float), arm.compute_jacobian(np.array(q)), atol=1e-12)


def test_common_factor_of_all_minors_is_factored_out() -> None:
    (part,) = ask_question("gram-determinant", ARM_4R).parts
    reach = A2 * sp.cos(T2) + A3 * sp.cos(T2 + T3) + A4 * sp.cos(T2 + T3 + T4)
    assert part.details_as(MinorDetails).shared_factors == reach
    assert part.answer_as(Expression).reference.is_Mul
    assert reach**2 in part.answer_as(Expression).reference.args


@pytest.mark.parametrize(
    ("name", "chain", "why"),
    [
        *((name, Chain("flat", make_joints(*[(0, A1, 0)] * 4), ("vx", "vy", "vz")), "full rank") for name in NAMES),
        ("gram-determinant", RPR, "different units"), ("least-norm-rates", RPR, "different units"),
        ("self-motion", RPR, ""),
        ("gram-determinant", LBR, "too long"),
        ("self-motion", Chain("4R", make_joints(*((0, a, 0) for a in (A1, A2, A3, A4))), ("vx", "vy")), "2 dimensions"),
        ("self-motion", Chain("idle", make_joints((0, A1, ALPHA2), (0, A2, H), (0, A2, H)), ("wy", "wz")), "alpha2"),
    ],
)  # fmt: skip
def test_unsuitable_redundant_arm_is_refused_with_a_reason(name: str, chain: Chain, why: str) -> None:
    refusal = QUESTIONS[name].find_obstacle(chain) or ""
    assert why in refusal and bool(why) == bool(refusal)


def test_rank_varies_between_seeds(textbook_arms: dict[str, Any]) -> None:
    """Poses are regular, on one component, or where two meet: the stretched elbow with P above the shoulder.

    Components that meet only in poses without exact values, as a PUMA's, are not used.
    """
    for name, ranks, draws in (("planar_2R", {1, 2}, 20), ("elbow_RRR", {1, 2, 3}, 20), ("PUMA560", {5, 6}, 4)):
        problems = [
            ask_question("rank", textbook_arms[name].chain, seed) for seed in range(select_for_suite(draws, 30))
        ]
        counts = Counter(int(problem.parts[0].answer.as_matrix()[0]) for problem in problems)
        assert ranks <= set(counts), (name, counts)
        assert max(counts.values()) <= 0.8 * len(problems)


def test_arm_with_bent_tool_loses_the_direction_from_joint_1() -> None:
    """P is on the line O_0 O_1 at both singular angles of planar-2r, although they contain an arctangent."""
    for seed in range(4):
        (part,) = generate(ProblemId("planar-2r", seed, ("lost-direction",))).parts
        assert part.answer_as(Direction).tolerance is None
        assert {symbol.name for symbol in part.answer_as(Direction).reference.free_symbols} == {"theta1"}


def test_lost_direction_is_numeric_without_a_short_formula(textbook_arms: dict[str, Any]) -> None:
    problem = ask_question("lost-direction", textbook_arms["orthogonal_3R"].chain, 3)
    answer = problem.parts[0].answer_as(Direction)
    assert answer.tolerance == 0.005
    assert not answer.reference.free_symbols
    for wrong in (sp.Matrix([1, 2, 3]).normalized(), 2 * answer.reference):
        numbers = wrong.applyfunc(lambda value: sp.N(value, 10))
        assert not certify(replace_answer(problem, replace(answer, reference=numbers))).passed


def test_sampled_poses_are_regular_or_singular_as_requested(textbook_arms: dict[str, Any]) -> None:
    for name in ("elbow_RRR", "orthogonal_3R", "PUMA560", "spherical_RRP", "Scorbot_5R_full_6x5"):
        chain = textbook_arms[name].chain
        full = min(len(chain.task), chain.n)
        regular = sample_regular_configuration(chain, Stream(name))
        assert regular is not None
        assert find_clear_rank(evaluate_jacobian(chain, regular)) == full
        for component in find_singular_set(chain) or ():
            if len(component.conditions) == 1:
                pose = sample_singular_configuration(chain, (component,), Stream(name))
                assert pose is not None
                assert find_clear_rank(evaluate_jacobian(chain, pose)) in range(full)
                assert len(set(pose.lengths.values())) == len(pose.lengths)


def test_branches_of_arm_and_structure_match() -> None:
    """An offset of 180 degrees exchanges the stretched and the folded arm."""
    for seed in range(12):
        chain = generate(ProblemId("planar-2r", seed, ("rank",))).chain
        offset = chain.offsets[1]
        for branch in match_branches(chain):
            ((_, arm_value),) = branch.component.list_value_combinations()[0]
            ((_, structure_value),) = branch.structure_component.list_value_combinations()[0]
            numbers = dict(make_symbolic_arm(chain).values)
            turns = sp.N((arm_value + offset - structure_value.xreplace(numbers)) / (2 * sp.pi))
            assert abs(turns - round(turns)) < 1e-9


@pytest.mark.whole
def test_kind_that_varies_is_left_out_of_the_meaning(textbook_arms: dict[str, Any]) -> None:
    """With a shoulder offset the stretched arm is on the boundary in front, but inside behind the column."""
    chain = textbook_arms["elbow_RRR_shoulder_offset_(Scorbot_point_P)"].chain
    texts = [
        ask_question("singularity-meaning", chain, seed).parts[0].answer for seed in range(select_for_suite(6, 10))
    ]
    meaning = "as far from the axis of joint 2 as joint 3 can bring it"
    stretched = [a for a in texts if isinstance(a, Choice) and meaning in a.options[a.correct]]
    assert stretched
    assert not any("singularity" in option for answer in stretched for option in answer.options)


def test_meaning_that_fails_in_some_configurations_is_not_correct() -> None:
    problem = generate(ProblemId("random-3", 10085, ("singularity-meaning",)).with_variation("full"))
    answer = problem.parts[0].answer_as(Choice)
    assert "folded" not in answer.options[answer.correct]
    assert certify(problem).passed


@on_families(("planar-3r", "elbow-3r", "elbow-lateral", "scorbot-wrist"))
def test_rank_is_asked_at_an_exact_pose(family: str) -> None:
    """The stated pose gives the rank of the reference; a rounded one would give full rank."""
    chain, ranks = get_problem(family, 0).chain, set()
    for seed in range(9):
        (part,) = ask_question("rank", chain, seed).parts
        place, rank = part.details_as(RankDetails).configuration, int(part.answer_as(Number).reference[0])
        assert not place.rounded_values
        exact_joints = {q: sp.N(value, 14) for q, value in place.joints.items()}
        assert np.linalg.matrix_rank(evaluate_jacobian(chain, replace(place, joints=exact_joints)), 1e-10) == rank
        ranks.add(rank)
    assert len(ranks) > 1


@pytest.mark.parametrize("digits", [15, 20, 30, 40])
def test_rounding_to_integers_agrees_with_sympy(digits: int) -> None:
    """It rounds decimal digits, and halves to even: test near halves, at halves, and elsewhere."""
    stream = Stream(f"rounding/{digits}")
    near = [sp.Float(10, digits) ** -stream.integer_below(36) * side for side in (1, -1) for _ in range(60)]
    halves = [sp.Float(f"{stream.integer_below(8001) - 4000}.5", digits) + off for off in (*near, sp.S.Zero)]
    others = [
        sp.Float(str(stream.integer_below(10**9) - 5 * 10**8), digits) / 7 ** stream.integer_below(9) for _ in range(60)
    ]
    for value in (*halves, *others, sp.S.Zero, sp.Integer(-3), sp.Rational(-7, 2), sp.pi):
        assert round_to_integer(value) == round(value)


def test_factor_keeps_its_sign_throughout_a_solution() -> None:
    questions = ("determinant", "singularity-type")
    problem = generate(replace(ProblemId.parse("elbow-lateral/607@zeros"), questions=questions))
    for part in problem.parts:
        assert r"0.45 c_{2} - a_{3} \cos \varphi_{23}" in write_solution(problem, part)


@pytest.mark.parametrize("turn", range(8))
def test_zeros_of_condition_on_one_angle_lie_within_one_turn(turn: int) -> None:
    """They do even if the middle angle and the half width add up to more than 180 degrees."""
    q, middle = sp.Symbol("theta1"), turn * sp.pi / 4 - sp.pi
    for value in (sp.Rational(-9, 10), sp.Rational(1, 3), sp.Rational(4, 5)):
        zeros = _find_zeros(sp.cos(q - middle) + value, q, is_revolute=True)
        assert len(zeros) == 2
        assert all(abs(sp.cos(zero - sp.N(middle, 40)) + value) < 1e-15 for zero in zeros)
        assert all(abs(zero) <= 3.1416 for zero in zeros)
