"""Check the answers to questions on rank, lost directions and the geometric meaning of a singularity.

The checks use the product of exponentials and finite differences, at configurations that the question didn't use.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np
import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.problem.problem import Part
from qdot.exercises.questions.exact_configurations import ConfigurationDetails
from qdot.exercises.questions.rank import JacobianOnBranch, LostDirectionDetails, MeaningDetails
from qdot.exercises.reference_answers import Choice, Direction, Number
from qdot.exercises.singularities.axes import Sample
from qdot.exercises.singularities.meanings import Meaning
from qdot.exercises.singularities.singularity_kinds import classify_samples
from qdot.exercises.verify.formulas import EXACT_TOLERANCE, PartCheck, check_agreement
from qdot.exercises.verify.numbers import list_reference_numbers
from qdot.exercises.verify.numeric_model import (
    Check,
    Checks,
    NumericModel,
    choose_random_configurations,
    compute_exponential_jacobian,
    sample_distinct_lengths,
)
from qdot.exercises.verify.singularity_statements import check_side_of_lost_direction, statement_holds

ZERO_RATIO, NONZERO_RATIO = 1e-9, 0.02
"""Fractions of the largest singular value.

A singular value below `ZERO_RATIO` of the largest counts as zero. If a singular value is between `ZERO_RATIO` and
`NONZERO_RATIO`, the rank is unclear and the check fails.
"""


class NumericRank(NamedTuple):
    """The rank of a matrix, and whether every singular value is either clearly zero or clearly not zero."""

    rank: int
    is_clear: bool


def find_rank(jacobian: np.ndarray) -> NumericRank:
    """Return the rank of a matrix, determined by its singular values."""
    sigma = np.linalg.svd(jacobian, compute_uv=False)
    ratios = sigma / max(float(sigma[0]), 1e-12)
    is_unclear = np.any((ratios > ZERO_RATIO) & (ratios < NONZERO_RATIO))
    return NumericRank(int(np.sum(ratios > ZERO_RATIO)), not is_unclear)


def _check_rank(model: NumericModel, part: Part) -> Checks:
    """Check a rank by the singular values of J; each must be either clearly zero or clearly not zero."""
    part.answer_as(Number)  # raises TypeError for an answer of another type
    configuration = part.details_as(ConfigurationDetails).configuration
    rank, is_clear = find_rank(model.exponential_jacobian_at(configuration)[model.task_rows])
    yield check_agreement("rank", list_reference_numbers(part), np.array([[[float(rank)]]]), EXACT_TOLERANCE)
    yield Check("clear", is_clear, "every singular value is clearly zero or clearly not")


# --- lost direction ---


def _check_direction(model: NumericModel, part: Part) -> Checks:
    """Check that a lost direction u, given by formulas or as a numeric unit vector, satisfies u^T J = 0."""
    answer = part.answer_as(Direction)
    m = len(model.task_rows)
    if answer.reference.shape != (m, 1):
        yield Check("shape", False, f"the reference is {answer.reference.shape}, expected ({m}, 1)")
        return
    yield _check_written_form(part)
    if isinstance(part.details, LostDirectionDetails):
        yield from _check_direction_formula(model, part, part.details.jacobian_on_branch)
        return
    jacobian = model.exponential_jacobian_at(part.details_as(ConfigurationDetails).configuration)[model.task_rows]
    direction = list_reference_numbers(part)
    length = np.linalg.norm(direction)
    yield Check("unit length", bool(abs(length - 1) < 1e-8), f"length {length:.10f}")
    yield _check_perpendicular(direction, jacobian[None])


def _check_written_form(part: Part) -> Check:
    """Check that not all entries begin with a minus sign, and that their coefficients have at most five digits."""
    entries = [entry for entry in part.answer.as_matrix() if entry != 0]
    are_all_negative = bool(entries) and all(entry.could_extract_minus_sign() for entry in entries)
    terms = [term for entry in entries for term in sp.Add.make_args(sp.expand(entry))]
    numbers = [term.as_coeff_Mul()[0] for term in terms]
    is_unwieldy = any(number.is_Rational and max(abs(number.p), number.q) > 99_999 for number in numbers)
    is_short = bool(entries) and not are_all_negative and not is_unwieldy
    return Check("short", is_short, f"{len(entries)} entries, {len(terms)} terms")


def _check_direction_formula(model: NumericModel, part: Part, branch: JacobianOnBranch) -> Checks:
    """Check that a formula for the lost direction u satisfies u^T J = 0 at random singular configurations."""
    given_joints = part.answer.as_matrix().free_symbols & {q for q, _ in branch.values}
    detail = f"{', '.join(sorted(map(str, given_joints)))} occurs" if given_joints else "no other"
    yield Check("free joints only", not given_joints, detail)
    q = model.configurations.copy()
    for symbol, value in branch.values:
        q[:, model.chain.q.index(symbol)] = model.evaluate_constants(sp.Matrix([value]))[:, 0]
    jacobians = model.evaluate_for_each_arm(compute_exponential_jacobian, q)[:, model.task_rows]
    yield _check_perpendicular(model.evaluate_printed_formulas(part.answer.as_matrix()), jacobians)


def _check_perpendicular(vectors: np.ndarray, jacobians: np.ndarray) -> Check:
    """Check that u^T J = 0, that u is not zero, and that J has exactly one less than full rank."""
    norms = np.linalg.norm(vectors, axis=1, keepdims=True)
    ranks = {find_rank(jacobian).rank for jacobian in jacobians}
    if np.any(norms < 1e-9) or not np.all(np.isfinite(vectors)) or np.iscomplexobj(vectors):
        return Check("u J = 0", False, "the vector is zero or no real number somewhere")
    scale = np.abs(jacobians).max(axis=(1, 2), keepdims=True)
    largest_product = float(np.abs((vectors / norms).swapaxes(1, 2) @ (jacobians / scale)).max())
    detail = f"{len(vectors)} places, at most {largest_product:.1e}, rank {sorted(ranks)}"
    return Check("u J = 0", largest_product < 1e-8 and ranks == {jacobians.shape[1] - 1}, detail)


# --- configurations that the question did not use ---


def _sample_at_values(
    model: NumericModel, values: Sequence[tuple[sp.Symbol, sp.Expr]], condition: sp.Expr | None
) -> Sequence[Sample]:
    """Return configurations at which some joints have the given values, or at which the condition, if any, is zero.

    There are SAMPLES_PER_ARM configurations for each of several choices of the symbolic lengths.
    """
    if condition is not None:
        return model.sample_on_condition(condition, arm_count=4, samples_per_arm=SAMPLES_PER_ARM)
    samples: list[Sample] = []
    for arm_index, (arm, lengths) in enumerate(_generate_arms(model)):
        if arm_index >= MIN_ARMS_TRIED and samples:
            break
        substitutions = {sp.Symbol(name): sp.Float(value) for name, value in lengths.items()}
        fixed_values = {model.chain.q.index(q): complex(sp.N(value.xreplace(substitutions))) for q, value in values}
        if any(abs(value.imag) > 1e-12 for value in fixed_values.values()):
            continue
        for q in choose_random_configurations(model.chain, model.rng, SAMPLES_PER_ARM):
            q[list(fixed_values)] = [value.real for value in fixed_values.values()]
            samples.append(Sample(arm, q))
    return samples


MIN_ARMS_TRIED, MAX_ARMS_TRIED, SAMPLES_PER_ARM = 6, 100, 2
"""Number of choices of the symbolic lengths, the maximum number if few choices give real joint values, and number of
configurations for each choice."""


def _generate_arms(model: NumericModel) -> Iterator[tuple[NumericChain, Mapping[str, float]]]:
    """Yield the numeric arms of the reference with their lengths, and then arms with other lengths."""
    yield from zip(model.arms, model.lengths, strict=True)
    for _ in range(MAX_ARMS_TRIED):
        lengths = sample_distinct_lengths(  # from a third to three times the reference's lengths
            model.chain, lambda: {n: v * 3 ** model.rng.uniform(-1, 1) for n, v in model.lengths[0].items()}
        )
        yield NumericChain(model.chain, lengths), lengths


# --- meaning ---


def _check_meaning(model: NumericModel, part: Part) -> Checks:
    """Check that only the correct one of the offered statements on the meaning of a singularity is true."""
    answer, details = part.answer_as(Choice), part.details_as(MeaningDetails)
    samples = _sample_at_values(model, details.values, details.condition)
    options = zip(answer.options, details.options, strict=True)
    has_same_texts = all(text.startswith(option.meaning.words) for text, option in options)
    yield Check("options", has_same_texts and len(set(answer.options)) == len(answer.options), "as offered")
    kinds = set(map(str, classify_samples(model.chain, samples)))

    def holds_everywhere(meaning: Meaning, kind: str | None) -> bool:
        is_true = bool(samples) and all(_meaning_holds(model.chain, meaning, sample) for sample in samples)
        return is_true and (kind is None or kinds == {kind})

    are_true = [holds_everywhere(meaning, kind) for meaning, kind in details.options]
    expected = [index == answer.correct for index in range(len(are_true))]
    detail = f"{', '.join(sorted(kinds))} at {len(samples)} configurations; options that hold: {are_true}"
    yield Check("only the right one holds", are_true == expected, detail)
    if details.options[answer.correct].kind == "boundary":
        yield check_side_of_lost_direction(model.chain, details.condition, details.values, samples)
    concerns_directions = {option.meaning.kind for option in details.options} <= _AXIS_DIRECTION_KINDS
    has_reason = concerns_directions or bool(model.chain.linear_axes)
    yield Check("a reason", has_reason, "in a task without linear rows, only the directions of axes can be a reason")


_AXIS_DIRECTION_KINDS = {"in line", "parallel", "one plane", "square"}
"""The kinds of statements about directions of axes. Only these can explain a lost rotation."""


def _meaning_holds(chain: Chain, meaning: Meaning, sample: Sample) -> bool:
    """Return whether a geometric statement is true at a configuration."""
    frames, first_joint = sample.frames, meaning.joints[0] - 1
    if meaning.kind == "square":  # the axes are perpendicular to each other, so all singular values are 1
        sigma = np.linalg.svd(frames[[joint - 1 for joint in meaning.joints], :3, 2], compute_uv=False)
        return bool(sigma[0] - sigma[-1] < 1e-6)
    if meaning.kind == "level":  # all axes are parallel, and P lies in their plane
        points = np.vstack([frames[: meaning.joints[-1], :3, 3], sample.arm.compute_point(sample.q)])
        return bool(np.linalg.svd(np.vstack([points[1:] - points[0], frames[0, :3, 2]]), compute_uv=False)[-1] < 1e-6)
    if meaning.kind in ("straight", "doubled"):  # three collinear origins; if straight, b is between a and c
        a, b, c = frames[first_joint : first_joint + 3, :3, 3]
        leg_1, leg_2 = np.linalg.norm(a - b), np.linalg.norm(b - c)
        expected = leg_1 + leg_2 if meaning.kind == "straight" else abs(leg_1 - leg_2)
        return bool(abs(np.linalg.norm(a - c) - expected) < 1e-7)
    statement = meaning.words.rpartition(": ")[2]  # without an introduction such as "the arm is stretched out"
    return statement_holds(chain, statement.replace("$P$", "the point"), sample)


CHECKS: dict[str, PartCheck] = {
    "rank": _check_rank,
    "lost-direction": _check_direction,
    "singularity-meaning": _check_meaning,
}
