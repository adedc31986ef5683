"""Draw a counterexample: the arm at the configuration, to scale, with P and the point that the answer gives.

If the answer is a set of singular configurations, the figure shows a configuration that the answer lacks beside one
that is not singular.
"""

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.derivation.lengths import substitute_in_arm
from qdot.exercises.figure.arm_figure import Example, draw_examples_svg
from qdot.exercises.formula.equality import Counterexample, SetDifference
from qdot.exercises.formula.program import compile_program, evaluate
from qdot.exercises.formula.trees import ParseError, as_matrix
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.questions.inversion import list_table_lengths
from qdot.exercises.reference_answers import ConditionSet
from qdot.grader.judging.expected_form import read_answer
from qdot.grader.judging.functions import FUNCTION_TEXT

DEFAULT_JOINT_VALUES = {"R": 0.7, "P": 0.4}
"""Values, in rad or m, of revolute (R) and prismatic (P) joints whose value the counterexample leaves open."""
DEFAULT_LENGTHS = [sp.Rational(twentieths, 20) for twentieths in (12, 9, 7, 11, 8, 10, 6, 13, 14, 15, 16, 17)]
"""Values for symbolic lengths, in m, all different."""
MAX_RELATIVE_DISTANCE = 3.0
"""Maximum distance of a drawn point from the base, relative to P's; a farther point would make the arm too small."""
MIN_REFERENCE_DISTANCE = 0.3
"""The distance of P from the base, in m, that is assumed for this limit if P is nearer."""
MAX_ANSWER_LENGTH = 2_000
"""Maximum number of characters of an answer whose point is computed."""

CROSS_CAPTION = "Dot: P. Cross: P according to your answer."


def draw_example(problem: Problem, part: Part, example: Counterexample, answer: str | None) -> str:
    """Return the counterexample of a wrong answer as an SVG element, empty if there is nothing to draw."""
    name = f"{part.name}-example"
    if isinstance(example, SetDifference):
        configurations = caption_configurations(part, example)
        arms = [_pose_arm(problem.chain, caption, configuration) for caption, configuration in configurations]
        return draw_examples_svg([arm for arm in arms if arm], name) if arms and all(arms) else ""
    if part.kind != "position" or answer is None or answer == FUNCTION_TEXT or len(answer) > MAX_ANSWER_LENGTH:
        return ""
    arm_with_answer = _mark_answer_point(problem, part, example.at, answer)
    return "" if arm_with_answer is None else draw_examples_svg([arm_with_answer], name, CROSS_CAPTION)


def caption_configurations(part: Part, example: SetDifference) -> list[tuple[str, Mapping[str, float]]]:
    """Return the configurations at which an answer is wrong, each after its caption."""
    if part.answer_as(ConditionSet).is_singular_set:
        captions = ("singular, but not in your answer", "in your answer, but not singular")
    else:
        captions = ("missing from your answer", "in your answer, but wrong")
    candidates = zip(captions, (example.missing, example.surplus), strict=True)
    return [(caption, configuration) for caption, configuration in candidates if configuration is not None]


def _pose_arm(chain: Chain, caption: str, values: Mapping[str, float]) -> Example | None:
    """Return an arm to be drawn at a configuration; `values` maps the names of symbols to values in rad and m.

    Lengths and joints without a value get default values. Return None if a joint value is not finite or a length is not
    positive.
    """
    default_lengths = iter([length for length in DEFAULT_LENGTHS if length not in list_table_lengths(chain)])
    lengths = {
        symbol: sp.Rational(str(round(values[symbol.name], 4))) if symbol.name in values else next(default_lengths)
        for symbol in chain.parameters
    }
    joints = zip(chain.q, chain.joints, strict=True)
    configuration = {q.name: values.get(q.name, DEFAULT_JOINT_VALUES[joint.kind]) for q, joint in joints}
    if not all(map(math.isfinite, configuration.values())) or any(length <= 0 for length in lengths.values()):
        return None
    return Example(caption, substitute_in_arm(chain, lengths), configuration)


def _mark_answer_point(problem: Problem, part: Part, symbol_values: Mapping[str, float], answer: str) -> Example | None:
    """Return the arm with a mark at the point that the answer gives; None if the point is missing or too far."""
    posed_arm = _pose_arm(problem.chain, "the arm in this configuration", symbol_values)
    tree = read_answer(problem, part, answer).tree
    if posed_arm is None or tree is None:
        return None
    axis_indices = ["xyz".index(axis) for axis in part.details.axes]  # type: ignore[attr-defined]  # of a position
    try:
        entries = [entry for row in as_matrix(tree) for entry in row]
        point = {name: np.array([value]) for name, value in symbol_values.items()}
        values, _ = evaluate(compile_program(entries), point, 1)
    except (KeyError, ParseError):
        return None
    if len(entries) != len(axis_indices) or not np.isfinite(values).all() or np.abs(values.imag).max() > 1e-9:
        return None
    arm = NumericChain(posed_arm.chain, {})
    correct_point = arm.compute_point(np.array([posed_arm.pose[q.name] for q in posed_arm.chain.q]))
    answer_point = correct_point.copy()
    answer_point[axis_indices] = values[:, 0].real
    base = arm.base[:3, 3]
    max_distance = MAX_RELATIVE_DISTANCE * max(float(np.linalg.norm(correct_point - base)), MIN_REFERENCE_DISTANCE)
    if np.linalg.norm(answer_point - base) > max_distance:
        return None
    return replace(posed_arm, mark_offset=answer_point - correct_point)
