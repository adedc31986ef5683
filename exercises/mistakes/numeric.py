"""Mistakes that occur only in numeric answers, such as degrees, wrong units and missing square roots."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from itertools import islice

import numpy as np
import sympy as sp

from qdot.exercises.answer_types import Number
from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.arm.derivation_graph import RESULT, Table, Working
from qdot.exercises.arm.path import StraightPath
from qdot.exercises.mistakes.base import (
    AnswerGenerator,
    AnswerShape,
    Mistake,
    MistakenAnswer,
    MistakeVariant,
    VariantGenerator,
    restrict_to_tables,
    single_variant,
)
from qdot.exercises.mistakes.table import scale_angles
from qdot.exercises.problem.problem import Part
from qdot.exercises.questions.path import DistanceDetails


def _use_degrees(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    revolute_joints = [i for i, joint in enumerate(chain.joints) if joint.kind == "R"]
    if revolute_joints:
        yield MistakeVariant({"table": scale_angles(180 / sp.pi)})
    if any(chain.offsets[i] != 0 for i in revolute_joints):
        yield MistakeVariant({"table": _scale_variables})
    base = convention_of(chain).base
    if (base.yaw, base.tilt) != (0, 0):
        yield MistakeVariant({"table": _scale_base})


def _scale_base(w: Working, table: Table) -> Table:
    """Return the table with the angles of the base in degrees."""
    position, yaw, tilt = table.base
    degrees_per_radian = w.arithmetic.table_entry(180 / sp.pi)
    return replace(
        table,
        base=(
            position,
            yaw * degrees_per_radian,
            tilt * degrees_per_radian if convention_of(w.chain).base.tilt != 0 else tilt,
        ),
    )


def _scale_variables(w: Working, table: Table) -> Table:
    """Return the table with joint variables in degrees and constants in radians."""
    for i, (joint, q) in enumerate(zip(w.chain.joints, w.chain.q, strict=True)):
        if joint.kind == "R":
            table = table.with_row(i, theta=table.rows[i].theta + w.arithmetic.table_entry((180 / sp.pi - 1) * q))
    return table


def _flip_value(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    """Yield variants with the value of one joint variable negated, without the constant that the table adds."""

    def flip(w: Working, table: Table, i: int) -> Table:
        entry = "theta" if chain.joints[i].kind == "R" else "d"
        value = getattr(table.rows[i], entry) - w.arithmetic.table_entry(2 * chain.q[i])
        return table.with_row(i, **{entry: value})

    for i, q in enumerate(chain.q):
        yield MistakeVariant({"table": partial(flip, i=i)}, {"variable": q})


def _scale_result(factor: float) -> VariantGenerator:
    return single_variant({RESULT: lambda w, values: values * factor})


def _scale_revolute_entries(factor: float) -> VariantGenerator:
    """Return a function that yields the variant with the entries of revolute joints scaled.

    It yields nothing if the result does not have one entry for each joint.
    """

    def variants(chain: Chain, shape: AnswerShape) -> Iterator[MistakeVariant]:
        if shape == (chain.n, 1):
            factors = np.array([factor if joint.kind == "R" else 1.0 for joint in chain.joints])
            yield MistakeVariant({RESULT: lambda w, values: values * factors[:, None, None]})

    return variants


# --- rates along a path ---

RatesWithWords = Iterator[tuple[np.ndarray, str]]
"""Yields wrong joint rates, each with additional words for the message."""


def _answers_with_path_rates(mistaken_rates: Callable[[Chain, DistanceDetails], RatesWithWords]) -> AnswerGenerator:
    """Return a function that yields answers with wrong joint rates along a path, computed in floating point."""

    def answers(chain: Chain, part: Part) -> Iterator[MistakenAnswer]:
        if part.kind == "path-rates" and isinstance(part.answer, Number):
            for rates, extra_words in mistaken_rates(chain, part.details_as(DistanceDetails)):
                if np.isfinite(rates).all():
                    reference = sp.Matrix([sp.Float(float(rate)) for rate in rates])
                    yield MistakenAnswer(replace(part.answer, reference=reference), {"more": extra_words})

    return answers


def _compute_rates(line: StraightPath, distance: float, path_speed: float) -> np.ndarray:
    """Return the joint rates at a distance (m) from the start A, or nan if the arm can't follow the line that far."""
    samples = list(line.follow(distance / max(1, round(distance / 0.02)) if distance else 1.0, 1e-3, distance))
    is_reached = bool(samples) and abs(samples[-1].s - distance) < 1e-9
    return np.array(samples[-1].slopes) * path_speed if is_reached else np.array([np.nan])


def _rates_at_start(chain: Chain, details: DistanceDetails) -> RatesWithWords:
    yield _compute_rates(details.seam.make_line(chain), 0.0, float(details.seam.speed)), ""


def _skip_normalization(chain: Chain, details: DistanceDetails) -> RatesWithWords:
    for line, joint in _lines_without_offsets(chain, details):
        extra_words = ", and to have left out the constant of a joint" if joint else ""
        yield _compute_rates(line, float(details.distance), float(details.seam.speed) * float(line.length)), extra_words


def _drop_offset(chain: Chain, details: DistanceDetails) -> RatesWithWords:
    for line, joint in islice(_lines_without_offsets(chain, details), 1, None):
        yield _compute_rates(line, float(details.distance), float(details.seam.speed)), str(joint)


def _lines_without_offsets(chain: Chain, details: DistanceDetails) -> Iterator[tuple[StraightPath, int]]:
    """Yield the line with 0, then for each joint the line of the arm without its offset, with the joint's number."""
    yield details.seam.make_line(chain), 0
    for i, (joint, offset, q) in enumerate(zip(chain.joints, chain.offsets, chain.q, strict=True)):
        if offset != 0:
            new_joint = replace(joint, theta=q) if joint.kind == "R" else replace(joint, d=q)
            yield (
                details.seam.make_line(replace(chain, joints=(*chain.joints[:i], new_joint, *chain.joints[i + 1 :]))),
                i + 1,
            )


def _reverse_path(chain: Chain, details: DistanceDetails) -> RatesWithWords:
    line, distance, speed = details.seam.make_line(chain), float(details.distance), float(details.seam.speed)
    opposite_target = [
        2 * a - b for a, b in zip(line.start_point, map(float, details.seam.target.values()), strict=True)
    ]
    yield (
        _compute_rates(
            StraightPath(
                chain, details.seam.lengths, details.seam.joints, [sp.Float(value) for value in opposite_target]
            ),
            distance,
            speed,
        ),
        "",
    )
    yield -_compute_rates(line, distance, speed), _SIGN_ALTERNATIVE
    yield -_compute_rates(line, float(line.length) - distance, speed), ""


_SIGN_ALTERNATIVE = ", or all rates have the wrong sign, as with a wrong sign of the determinant"


_ALL_MISTAKES = (
    Mistake("rates-at-start", "Joint rates at the start of the path",
            "You seem to have used the Jacobian at A. Use the joint values at the position that P has reached by then.",
            "6.7",
            answers=_answers_with_path_rates(_rates_at_start), rare=True),
    Mistake("direction-not-unit", "Direction of the path not normalized",
            "You seem to have multiplied B - A by the speed{more}. First divide B - A by its length.", "6.7",
            answers=_answers_with_path_rates(_skip_normalization), rare=True),
    Mistake("path-turned-round", "Path in the wrong direction",
            "You seem to have moved P from B to A instead of from A to B{more}.", "6.7",
            answers=_answers_with_path_rates(_reverse_path), rare=True),
    Mistake("offset-forgotten-on-path", "Joint offset left out along the path",
            "You seem to have left out the constant that the table adds to the variable of joint {more}.", "6.1",
            answers=_answers_with_path_rates(_drop_offset), rare=True),
    Mistake("degrees-as-radians", "Degrees used as radians",
            "You seem to have used angles in degrees as if they were radians. Convert them before you take sines and "
            "cosines.", "6.1",
            _use_degrees),
    Mistake("rates-in-degrees", "Rates in degrees per second",
            "The rates of revolute joints seem to be in degrees per second. Give them in rad/s.", "6.5",
            _scale_revolute_entries(float(180 / np.pi))),
    Mistake("rates-in-turns", "Rates in revolutions",
            "The rates of revolute joints seem to be in revolutions per second. Give them in rad/s.", "6.5",
            _scale_revolute_entries(float(0.5 / np.pi))),
    Mistake("millimetres", "Millimetres instead of metres",
            "Your result is a thousand times too large. Did you use lengths in millimetres?",
            "6.4", _scale_result(1000.0)),
    Mistake("thousandth", "A thousandth of the result",
            "Your result is a thousand times too small. Did you use lengths in millimetres?",
            "6.4", _scale_result(0.001)),
    Mistake("centimetres", "Centimetres instead of metres",
            "Your result is a hundred times too large. Did you use lengths in centimetres?",
            "6.4", _scale_result(100.0)),
    Mistake("root-forgotten", "Root forgotten", "You seem to have forgotten the square root of det(J J^T).",
            "below 6.8",
            single_variant({"manipulability": lambda w, _: w["gram determinant"]})),
    Mistake("components-added", "Components added instead of the speed",
            "You seem to have added the components of the velocity. The speed is the square root of the sum of their "
            "squares.",
            "6.4"),
    Mistake("component-alone", "One component instead of the speed",
            "You seem to have given one component of the velocity. The speed depends on all components.", "6.4"),
    Mistake("speed-squared", "Square of the speed",
            "You seem to have forgotten the square root. The speed is the square root of the sum of the squares of "
            "the components.",
            "6.4"),
    Mistake("value-sign", "Value of a joint with the wrong sign",
            "You seem to have substituted the value of {variable} with the wrong sign.", "6.1", _flip_value, rare=True),
    Mistake("ratio-turned-over", "Inverted ratio",
            "You seem to have inverted the ratio. The condition number is the largest singular value divided by the "
            "smallest one, so it is at least 1.", "below 6.8",
            single_variant({"condition number": lambda w, value: 1 / value})),
    Mistake("eigenvalues-for-singular-values", "Eigenvalues of J J^T instead of singular values",
            "You seem to have used the eigenvalues of J J^T. They are the squares of the singular values of J.",
            "below 6.8", single_variant({"condition number": lambda w, value: value**2})),
)  # fmt: skip

MISTAKES = restrict_to_tables(_ALL_MISTAKES, {"offset-forgotten-on-path"})
