"""Check short questions, such as choices: only the correct options may hold in numbers.

An option that is a formula is checked like the reference answer to the full question, such as "jacobian". No two
options may be the same.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np
import sympy as sp

from qdot.exercises.arm.conventions.base import VELOCITY_NAMES
from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.common.stream import Stream
from qdot.exercises.derivation.lengths import substitute_in_arm
from qdot.exercises.problem.problem import Part
from qdot.exercises.questions import QUESTIONS
from qdot.exercises.questions.exact_configurations import ConfigurationDetails
from qdot.exercises.reference_answers import Choice, ConditionSet, Expression, Matching, Matrix, Selection
from qdot.exercises.short_questions.choice import CHOICE_QUESTIONS, FormulaOptions
from qdot.exercises.short_questions.options import ConfigurationOptions, OfferedOption, Options
from qdot.exercises.short_questions.selections import EqualForms, Quantity, QuantityDetails
from qdot.exercises.short_questions.single_configuration import ConfigurationStatement, JointStatement, RateDetails
from qdot.exercises.short_questions.wrong_formulas import OptionSubject
from qdot.exercises.verify.formulas import CHECKS as FORMULA_CHECKS
from qdot.exercises.verify.formulas import EXACT_TOLERANCE, PartCheck, check_agreement
from qdot.exercises.verify.numbers import NUMBER_TOLERANCE, check_three_digits, list_reference_numbers
from qdot.exercises.verify.numeric_model import Check, Checks, NumericModel, compute_exponential_jacobian
from qdot.exercises.verify.rank import find_rank
from qdot.exercises.verify.screws import CHECKS as SCREW_CHECKS
from qdot.exercises.verify.singular import CHECKS as SET_CHECKS

BASE_CHECKS: Mapping[str, PartCheck] = {**FORMULA_CHECKS, **SCREW_CHECKS}
"""The check of each kind of full question. Choices offer the answers to these questions as options."""

JOINT_STEP = 0.7
"""The arbitrary amount by which a joint is moved, in rad or m."""
MIN_STATED_VELOCITY = 0.01
"""Minimum velocity component (m/s at unit joint rate) whose sign is clear."""
MIN_DIFFERENCE = 1e-5
"""Two options must differ, at some sample, by at least this fraction of their size."""


def _insert_option(model: NumericModel, subject: OptionSubject, option: sp.Matrix) -> Part:
    """Return the full question as a part whose answer, or one entry or column of it, is replaced by an option."""
    answer, details = QUESTIONS[subject.base_question].ask(model.chain, Stream("quiz"))
    part = Part(subject.base_question, subject.base_question, answer, details=details)
    if answer.shape is None:
        return replace(part, answer=Expression(option[0]))
    full_answer = answer.as_matrix().as_mutable()
    full_answer[subject.row or 0, subject.column or 0] = option
    return replace(part, answer=Matrix(sp.Matrix(full_answer)))


def _check_formula_choice(model: NumericModel, part: Part) -> Checks:
    """Check that only the correct formula passes the check of the full question."""
    subject = part.details_as(FormulaOptions).subject
    options = _list_offered_options(part)
    parts = [_insert_option(model, subject, option.content) for option in options]
    yield _check_one_correct(model, part, parts, BASE_CHECKS[subject.base_question])
    yield _check_values_differ(model, [sp.Matrix(option.content) for option in options])


def _list_offered_options(part: Part) -> tuple[OfferedOption, ...]:
    options = part.details_as(Options).offered_options
    assert part.answer.offered_options == tuple(option.text for option in options)
    return options


def _check_one_correct(model: NumericModel, part: Part, parts_with_option: Sequence[Part], check: PartCheck) -> Check:
    """Check that only the part that has the correct option as its answer passes a check."""
    passing_indices = [
        index
        for index, option_part in enumerate(parts_with_option)
        if all(result.passed for result in check(model, option_part))
    ]
    detail = f"options that pass (numbered from 0): {', '.join(map(str, passing_indices)) or 'none'}"
    return Check("one right option", passing_indices == [part.answer_as(Choice).correct], detail)


def _check_values_differ(model: NumericModel, options: Sequence[sp.Matrix]) -> Check:
    """Check that every option has finite values, and that no two options have the same values at all samples."""
    values = [model.evaluate_printed_formulas(option).reshape(model.sample_count, -1) for option in options]
    for (i, a), (j, b) in combinations(enumerate(values), 2):
        if a.shape == b.shape and not np.abs(a - b).max() > MIN_DIFFERENCE * (np.abs(a).max() + np.abs(b).max()):
            return Check("different options", False, f"options {i} and {j} (numbered from 0) are the same")
    return Check("different options", all(np.isfinite(value).all() for value in values), "no two have the same values")


def _check_set_choice(model: NumericModel, part: Part) -> Checks:
    """Check that only the correct singular set passes the check of singular sets."""
    kind, options = "singular-angles", _list_offered_options(part)
    parts = [Part(kind, kind, ConditionSet(option.content)) for option in options]
    yield _check_one_correct(model, part, parts, SET_CHECKS[kind])
    yield _check_texts_differ([option.text for option in options])


def _check_texts_differ(texts: Sequence[str]) -> Check:
    return Check("different options", len(set(texts)) == len(texts), "no two are the same")


# --- configurations ---


def _check_configurations(model: NumericModel, part: Part) -> Checks:
    """Check by the rank of J which of the offered configurations are singular."""
    details, full_rank = part.details_as(ConfigurationOptions), min(len(model.task_rows), model.chain.n)
    numeric_ranks = []
    for offered_configuration in details.offered_configurations:
        configuration = replace(offered_configuration, lengths={**details.lengths, **offered_configuration.lengths})
        numeric_ranks.append(find_rank(model.exponential_jacobian_at(configuration)[model.task_rows]))
    singular_indices = tuple(index for index, numeric_rank in enumerate(numeric_ranks) if numeric_rank.rank < full_rank)
    rank_text = ", ".join(str(numeric_rank.rank) for numeric_rank in numeric_ranks)
    yield Check("clear", all(numeric_rank.is_clear for numeric_rank in numeric_ranks), f"ranks {rank_text}")
    is_correct = singular_indices == tuple(part.answer.correct_indices)
    yield Check("singular ones", is_correct, f"of rank less than {full_rank} (numbered from 0): {singular_indices}")
    yield _check_texts_differ(part.answer.offered_options)
    arm = substitute_in_arm(model.chain, details.lengths)
    yield Check("lengths", not arm.parameters, "every length has a number")


# --- several correct options ---


def _compute_quantity(model: NumericModel, quantity: Quantity, moved_joint: int | None = None) -> np.ndarray:
    """Return the values of a quantity, (samples, entries), after moving one joint by JOINT_STEP if one is given.

    The quantity is a column or an entry of J, a coordinate of P, or det J.
    """
    configurations = model.configurations.copy()
    if moved_joint is not None:
        configurations[:, moved_joint] += JOINT_STEP
    jacobian = model.evaluate_for_each_arm(compute_exponential_jacobian, configurations)[:, model.task_rows]
    if quantity.column is not None:
        column = jacobian[:, :, quantity.column]
        return column if quantity.row is None else column[:, [quantity.row]]
    if quantity.row is not None:
        return model.evaluate_for_each_arm(NumericChain.compute_point, configurations)[:, [quantity.row]]
    return np.asarray(np.linalg.det(jacobian)[:, None])


def _check_equal_forms(model: NumericModel, part: Part) -> Checks:
    """Check by values which of the offered expressions are equal to the quantity."""
    answer, expected = part.answer_as(Selection), _compute_quantity(model, part.details_as(EqualForms).quantity)
    equal_indices = []
    for index, option in enumerate(_list_offered_options(part)):
        values = model.evaluate_printed_formulas(sp.Matrix([option.content]))
        if check_agreement("", values, expected[:, :, None], EXACT_TOLERANCE).passed:
            equal_indices.append(index)
        elif np.abs(values[:, :, 0] - expected).max() <= MIN_DIFFERENCE * np.abs(expected).max():
            yield Check("clearly different", False, f"option {index} (numbered from 0) is near the right value")
    yield Check(
        "right options", tuple(equal_indices) == answer.correct, f"equal in value (numbered from 0): {equal_indices}"
    )
    yield Check("different options", len(set(answer.options)) == len(answer.options), "no two are written the same")


def _check_dependence(model: NumericModel, part: Part) -> Checks:
    """Check by moving one joint at a time on which joints a quantity depends."""
    answer, quantity = part.answer_as(Selection), part.details_as(QuantityDetails).quantity
    values = _compute_quantity(model, quantity)
    changes = [np.abs(_compute_quantity(model, quantity, joint) - values).max() for joint in range(model.chain.n)]
    influential_joints = tuple(joint for joint, change in enumerate(changes) if change > EXACT_TOLERANCE)
    detail = f"it changes with joints (numbered from 0): {influential_joints}"
    yield Check("moving one joint", influential_joints == answer.correct, detail)


# --- columns to joints ---


def _check_columns(model: NumericModel, part: Part) -> Checks:
    """Check which of the offered columns belongs to each joint."""
    answer = part.answer_as(Matching)
    options = _list_offered_options(part)
    jacobian = model.exponential_jacobian[:, model.task_rows]
    option_values = [model.evaluate_printed_formulas(sp.Matrix(option.content)) for option in options]
    matching_options = []
    for joint in range(model.chain.n):
        column = jacobian[:, :, [joint]]
        is_equal = [check_agreement("", value, column, EXACT_TOLERANCE).passed for value in option_values]
        matching_options.append(is_equal.index(True) if sum(is_equal) == 1 else -1)  # -1: no option, or several
    yield Check(
        "columns",
        tuple(matching_options) == answer.correct,
        f"options of the joints (numbered from 0): {matching_options}",
    )
    yield _check_values_differ(model, [sp.Matrix(option.content) for option in options])


# --- numbers and statements ---


def _check_number(part: Part, expected: float) -> Checks:
    yield check_agreement("in numbers", list_reference_numbers(part), np.array([[[expected]]]), NUMBER_TOLERANCE)
    yield check_three_digits(part)


def _check_determinant_value(model: NumericModel, part: Part) -> Checks:
    jacobian = model.exponential_jacobian_at(part.details_as(ConfigurationDetails).configuration)[model.task_rows]
    yield from _check_number(part, float(np.linalg.det(jacobian)))


def _check_speed(model: NumericModel, part: Part) -> Checks:
    details = part.details_as(RateDetails)
    rates = np.array([float(rate) for rate in details.rates.values()])
    velocity = model.exponential_jacobian_at(details.configuration)[:3] @ rates
    yield from _check_number(part, float(np.linalg.norm(velocity)))


def _check_statement(model: NumericModel, part: Part) -> Checks:
    """Check whether a statement is clearly true or clearly false, as the answer says."""
    answer, statement = part.answer_as(Choice), part.details_as(ConfigurationStatement)
    jacobian = model.exponential_jacobian_at(statement.configuration)
    if isinstance(statement, JointStatement):
        component = float(jacobian[VELOCITY_NAMES.index(statement.row), statement.joint - 1])
        is_true, is_clear = (component > 0) == statement.is_positive, abs(component) > MIN_STATED_VELOCITY
    else:
        rank, is_clear = find_rank(jacobian[model.task_rows])
        is_true = rank < min(len(model.task_rows), model.chain.n)
    yield Check("clear", is_clear, "it is clearly true or clearly false")
    yield Check("statement", answer.options[answer.correct] == str(is_true).lower(), f"it is {is_true}")


_FORMULA_CHOICES = [q.name for q in CHOICE_QUESTIONS if q.template in ("formula-choice", "screw-choice")]
CHECKS: dict[str, PartCheck] = {
    **dict.fromkeys(_FORMULA_CHOICES, _check_formula_choice),
    "singular-angles-choice": _check_set_choice,
    "singular-configurations": _check_configurations,
    "singular-drawing": _check_configurations,
    "equal-forms": _check_equal_forms,
    "dependence": _check_dependence,
    "match-columns": _check_columns,
    "determinant-value": _check_determinant_value,
    "speed": _check_speed,
    "true-or-false": _check_statement,
}
