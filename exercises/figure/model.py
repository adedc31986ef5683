"""Replace each arm by a model, so that arms whose figures differ only in their labels share one figure.

A figure is not to scale. Each numeric length is replaced by one of eight standard lengths: longer lengths stay longer,
and equal lengths stay equal. Joint offsets appear only in labels. A figure is drawn once for all arms with the same
model, with space for the widest of their labels. Then each arm's labels are filled in.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import sympy as sp

from qdot.exercises.arm.chain import ANGLE_PREFIXES, Chain
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.figure.lettering import (
    FontRun,
    Lettering,
    make_font_runs,
    measure_width,
    write_joint_variable,
    write_length,
)
from qdot.exercises.figure.plane import scale_prismatic_entries
from qdot.exercises.figure.pose import compute_table_entries
from qdot.exercises.figure.shapes import Figure

_STANDARD_LENGTHS = (9, 24, 36, 48, 59, 72, 84, 96)
"""The lengths of models in centimetres. The longest length of an arm becomes the longest standard length."""
_MODEL_ANGLE_OFFSET, _MODEL_LENGTH_OFFSET = sp.pi / 6, sp.Rational(35, 100)
"""The joint offsets of models (rad, m); their labels are at least as wide as those of most arms."""

LetteringMap = dict[Lettering, Lettering]
"""Maps each label of the model to the arm's label."""


@dataclass(frozen=True)
class FigureModel:
    """An arm and its model, the arm `chain` that is drawn instead.

    `font_runs` maps the model's labels to the arm's labels. `size_ratio` is the size of the arm divided by the size of
    the model.
    """

    arm: Chain
    chain: Chain
    font_runs: Mapping[tuple[FontRun, ...], tuple[FontRun, ...]]
    size_ratio: float

    def convert_to_model_pose(self, arm_pose: Mapping[str, float]) -> tuple[tuple[str, float], ...]:
        """Return the model's joint values (rad, m) in a pose of the arm. Raises QdotError if the pose lacks a joint."""
        entries = scale_prismatic_entries(self.arm, compute_table_entries(self.arm, arm_pose), 1 / self.size_ratio)
        home_entries = compute_table_entries(self.chain, {q.name: 0.0 for q in self.chain.q})
        values = [round(float(entry - home_entry), 9) for entry, home_entry in zip(entries, home_entries, strict=True)]
        return tuple(zip([q.name for q in self.arm.q], values, strict=True))

    def convert_to_arm_entries(self, model_entries: Sequence[float] | np.ndarray) -> tuple[float, ...]:
        """Return the entries of the arm's table in a pose of the model."""
        return tuple(map(float, scale_prismatic_entries(self.arm, np.array(model_entries), self.size_ratio)))

    def relabel(self, figure: Figure) -> Figure:
        """Return the model's figure with the arm's labels."""
        texts = (replace(text, runs=self.font_runs.get(text.runs, text.runs)) for text in figure.texts)
        return replace(figure, texts=tuple(texts))


def make_model(chain: Chain) -> FigureModel:
    """Return an arm with its model. An arm described by its axes is its own model, because it is drawn at home."""
    if convention_of(chain).is_drawn_at_home:
        return FigureModel(chain, chain, {}, 1.0)
    label_map: LetteringMap = {}
    map_length, size_ratio = _map_lengths(chain, label_map)
    offsets = dict(zip(chain.q, chain.offsets, strict=True))
    variables = {q.name: q for q in chain.q}

    def replace_entry(name: str, entry: sp.Expr) -> sp.Expr:
        if name in variables:
            q = variables[name]
            return q + _map_offset(q, offsets[q], name.startswith("theta"), label_map)
        return entry if name.startswith((*ANGLE_PREFIXES, "base")) else map_length(entry)

    mapped_chain = chain.map_entries(replace_entry)
    model_chain = Chain(
        "model", mapped_chain.joints, chain.task, chain.base, mapped_chain.point, convention=chain.convention
    )
    font_runs = {
        make_font_runs(model_letters): make_font_runs(arm_letters) for model_letters, arm_letters in label_map.items()
    }
    return FigureModel(chain, model_chain, font_runs, size_ratio)


def _map_lengths(chain: Chain, label_map: LetteringMap) -> tuple[Callable[[sp.Expr], sp.Expr], float]:
    """Return a function from the arm's lengths to the model's lengths, and the arm's size relative to the model.

    The labels of the lengths are added to `label_map`. The lengths are unchanged if the base position has numbers,
    because link lengths and base position must stay in proportion. The lengths are also unchanged if there are too many
    of them, or if the arm's labels are wider than the model's.
    """
    identity = (lambda length: length), 1.0
    values = [value for joint in chain.joints for value in (joint.a, joint.d)] + list(chain.point.offset)
    sizes = sorted({abs(value) for value in values if value.is_number and value != 0}, reverse=True)
    if not sizes or any(value.is_number and value != 0 for value in chain.base.position):
        return identity
    model_lengths: dict[sp.Expr, sp.Rational] = {}
    max_rank = len(_STANDARD_LENGTHS)
    for size in sizes:
        rank = min(max_rank, max(1, round(len(_STANDARD_LENGTHS) * float(size / sizes[0]))))
        if rank < 1:
            return identity
        model_lengths[size] = sp.Rational(_STANDARD_LENGTHS[rank - 1], 100)
        max_rank = rank - 1
    length_labels = {write_length(length): write_length(size) for size, length in model_lengths.items()}
    if any(_is_wider(arm_letters, model_letters) for model_letters, arm_letters in length_labels.items()):
        return identity
    label_map.update(length_labels)

    def map_length(value: sp.Expr) -> sp.Expr:
        if not value.is_number or value == 0:
            return value
        return model_lengths[abs(value)] * (1 if value > 0 else -1)

    return map_length, float(sizes[0]) * 100 / _STANDARD_LENGTHS[-1]


def _map_offset(q: sp.Symbol, offset: sp.Expr, is_revolute: bool, label_map: LetteringMap) -> sp.Expr:
    """Return the model's offset of a joint, and add its label to `label_map`.

    An offset that is zero or symbolic, or whose label is wider than the model's, is returned unchanged.
    """
    model_offset = _MODEL_ANGLE_OFFSET if is_revolute else _MODEL_LENGTH_OFFSET
    if offset == 0 or not offset.is_number:
        return offset
    model_letters, arm_letters = (write_joint_variable(q, value, is_revolute) for value in (model_offset, offset))
    if _is_wider(arm_letters, model_letters):
        return offset
    label_map[model_letters] = arm_letters
    return model_offset


def _is_wider(lettering: Lettering, other_lettering: Lettering) -> bool:
    return measure_width(lettering) > measure_width(other_lettering)
