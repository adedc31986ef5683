"""Mistakes that occur only in numeric answers, such as degrees, wrong units and missing square roots."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from typing import SupportsFloat

import numpy as np
import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.arm.path import StraightPath
from qdot.exercises.derivation.graph import RESULT, StageResults, Table
from qdot.exercises.mistakes.base import (
    AnswerGenerator,
    AnswerShape,
    MistakenAnswer,
    MistakeVariant,
    VariantGenerator,
    vary_always,
)
from qdot.exercises.mistakes.table import scale_angles
from qdot.exercises.problem.problem import Part
from qdot.exercises.questions.path import NONSINGULAR_CONDITIONING, PathDetails, choose_step_length
from qdot.exercises.reference_answers import Number


def _use_degrees(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    """Yield variants with angles in degrees: all angles of the table, only joint variables, or only base angles."""
    revolute_joints = chain.revolute_joints
    if revolute_joints:
        yield MistakeVariant({"table": scale_angles(180 / sp.pi)})
    if any(chain.offsets[i] != 0 for i in revolute_joints):
        yield MistakeVariant({"table": _scale_variables})
    base = convention_of(chain).base
    if (base.yaw, base.tilt) != (0, 0):
        yield MistakeVariant({"table": _scale_base})


def _scale_base(stages: StageResults, table: Table) -> Table:
    """Return the table with the angles of the base in degrees."""
    degrees_per_radian = stages.arithmetic.convert_entry(180 / sp.pi)
    new_table = replace(table, base_yaw=table.base_yaw * degrees_per_radian)
    has_tilt = convention_of(stages.chain).base.tilt != 0
    return replace(new_table, base_tilt=table.base_tilt * degrees_per_radian) if has_tilt else new_table


def _scale_variables(stages: StageResults, table: Table) -> Table:
    """Return the table with joint variables in degrees and constants in radians."""
    new_table = table
    for i in stages.chain.revolute_joints:
        added_angle = stages.arithmetic.convert_entry((180 / sp.pi - 1) * stages.chain.q[i])
        new_table = new_table.with_row(i, theta=table.rows[i].theta + added_angle)
    return new_table


def _flip_value(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    """Yield variants with the value of one joint variable negated, but not the offset that the table adds."""

    def flip(stages: StageResults, table: Table, i: int) -> Table:
        entry = chain.joints[i].variable_key
        value = getattr(table.rows[i], entry) - stages.arithmetic.convert_entry(2 * chain.q[i])
        return table.with_row(i, **{entry: value})

    for i, q in enumerate(chain.q):
        yield MistakeVariant({"table": partial(flip, i=i)}, words={"variable": q})


def _scale_lengths(factor: sp.Expr) -> VariantGenerator:
    """Return a function that yields the variant with all lengths and the rates of prismatic joints scaled."""

    def scale_table(stages: StageResults, table: Table) -> Table:
        scale = stages.arithmetic.convert_entry(factor)

        def scale_displacement(d: np.ndarray) -> np.ndarray:
            """Return a scaled displacement with an unchanged imaginary step, so that its derivative stays 1."""
            return np.asarray(d + d.real * (scale - 1))

        return replace(
            table, rows=tuple(replace(row, a=row.a * scale, d=scale_displacement(row.d)) for row in table.rows),
            base_position=table.base_position * scale, point_offset=table.point_offset * scale,
        )  # fmt: skip

    def scale_rates(stages: StageResults, rates: np.ndarray) -> np.ndarray:
        factors = np.array([float(factor) if joint.is_prismatic else 1.0 for joint in stages.chain.joints])
        return np.asarray(rates * factors[:, None])

    def scale_unit(stages: StageResults, unit: np.ndarray) -> np.ndarray:
        return unit * float(factor)

    return vary_always({"length unit": scale_unit, "table": scale_table, "joint rates": scale_rates})


def _scale_revolute_entries(factor: float) -> VariantGenerator:
    """Return a function that yields the variant with the entries of revolute joints scaled.

    There is no variant unless the result has one entry for each joint.
    """

    def generate(chain: Chain, shape: AnswerShape) -> Iterator[MistakeVariant]:
        if shape == (chain.n, 1):
            factors = np.array([factor if joint.is_revolute else 1.0 for joint in chain.joints])
            yield MistakeVariant({RESULT: lambda stages, values: values * factors[:, None, None]})

    return generate


# --- rates along a path ---

RatesWithWords = Iterator[tuple[np.ndarray, str]]
"""Wrong joint rates, each with additional words for the message."""


def _change_path_rates(list_wrong_rates: Callable[[Chain, PathDetails], RatesWithWords]) -> AnswerGenerator:
    """Return a function that yields answers with the wrong joint rates along a path that `list_wrong_rates` gives."""

    def generate(chain: Chain, part: Part) -> Iterator[MistakenAnswer]:
        if part.kind == "path-rates" and isinstance(part.answer, Number):
            for rates, extra_words in list_wrong_rates(chain, part.details_as(PathDetails)):
                if np.isfinite(rates).all():
                    reference = sp.Matrix([sp.Float(float(rate)) for rate in rates])
                    yield MistakenAnswer(replace(part.answer, reference=reference), words={"more": extra_words})

    return generate


def _compute_rates(line: StraightPath, distance: SupportsFloat, path_speed: SupportsFloat) -> np.ndarray:
    """Return the joint rates at a distance (m) from the start A, or nan if the arm can't follow the line that far."""
    end = float(distance)
    samples = list(line.follow(choose_step_length(end), NONSINGULAR_CONDITIONING, end))
    is_reached = bool(samples) and abs(samples[-1].s - end) < 1e-9
    return np.array(samples[-1].derivatives) * float(path_speed) if is_reached else np.array([np.nan])


def _use_rates_at_start(chain: Chain, details: PathDetails) -> RatesWithWords:
    yield _compute_rates(details.welding_line.make_path(chain), 0.0, details.welding_line.speed), ""


def _skip_normalization(chain: Chain, details: PathDetails) -> RatesWithWords:
    """Yield the rates for the velocity (B - A) v, in which B - A is not divided by the length of the line."""
    lines = [(details.welding_line.make_path(chain), "")]
    extra_words = ", and to have left out the constant that is added to a joint variable"
    lines += [(line, extra_words) for line, _ in _list_lines_without_offset(chain, details)]
    for line, words in lines:
        wrong_speed = float(details.welding_line.speed) * float(line.length)
        yield _compute_rates(line, details.distance, wrong_speed), words


def _drop_offset(chain: Chain, details: PathDetails) -> RatesWithWords:
    for line, joint_number in _list_lines_without_offset(chain, details):
        yield _compute_rates(line, details.distance, details.welding_line.speed), str(joint_number)


def _list_lines_without_offset(chain: Chain, details: PathDetails) -> Iterator[tuple[StraightPath, int]]:
    """Yield, for each joint offset, the line of an arm without this offset, and the number of the joint (from 1)."""
    for i, (joint, offset, q) in enumerate(zip(chain.joints, chain.offsets, chain.q, strict=True)):
        if offset != 0:
            new_joint = joint.with_variable_entry(q)
            new_arm = replace(chain, joints=(*chain.joints[:i], new_joint, *chain.joints[i + 1 :]))
            yield details.welding_line.make_path(new_arm), i + 1


def _reverse_path(chain: Chain, details: PathDetails) -> RatesWithWords:
    """Yield the rates on the line away from the target, the negative rates, and the rates on the way back."""
    welding_line, distance, speed = details.welding_line, details.distance, details.welding_line.speed
    line = welding_line.make_path(chain)
    target = [sp.Float(2 * a - float(b)) for a, b in zip(line.start_point, welding_line.target.values(), strict=True)]
    yield _compute_rates(StraightPath(chain, welding_line.lengths, welding_line.joints, target), distance, speed), ""
    extra_words = ", or all of your rates have the wrong sign, for example because of a sign error in the determinant"
    yield -_compute_rates(line, distance, speed), extra_words
    yield -_compute_rates(line, float(line.length) - float(distance), speed), ""


VARIANTS: dict[str, VariantGenerator] = {
    "degrees-as-radians": _use_degrees,
    "rates-in-degrees": _scale_revolute_entries(factor=float(180 / np.pi)),
    "rates-in-turns": _scale_revolute_entries(factor=float(0.5 / np.pi)),
    "result-in-degrees": vary_always({RESULT: lambda stages, values: values * float(180 / np.pi)}),
    "millimetres": _scale_lengths(sp.Integer(1000)),
    "thousandth": _scale_lengths(sp.Rational(1, 1000)),
    "centimetres": _scale_lengths(sp.Integer(100)),
    "root-forgotten": vary_always({"manipulability": lambda stages, _: stages["gram determinant"]}),
    "value-sign": _flip_value,
    "ratio-inverted": vary_always({"condition number": lambda stages, value: 1 / value}),
    "eigenvalues-for-singular-values": vary_always({"condition number": lambda stages, value: value**2}),
}
ANSWERS: dict[str, AnswerGenerator] = {
    "rates-at-start": _change_path_rates(_use_rates_at_start),
    "direction-not-unit": _change_path_rates(_skip_normalization),
    "path-reversed": _change_path_rates(_reverse_path),
    "offset-forgotten-on-path": _change_path_rates(_drop_offset),
}
