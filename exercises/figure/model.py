"""Draw one model for many arms of a class, because their figures differ only in the labels.

A figure is not to scale: numeric lengths are rounded to a few steps that keep their order, and equal lengths stay
equal. Joint offsets appear only in labels. A figure is drawn once for all arms with the same model, with space for the
widest of their labels. Then each arm's labels are filled in.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import sympy as sp

from qdot.exercises.arm.chain import Chain, Point
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.figure.pose import entries_of_pose
from qdot.exercises.figure.shapes import Figure, Run, TextRun, extent, magnitude, runs, with_offset

_STEPS = (9, 24, 36, 48, 59, 72, 84, 96)
"""The possible lengths of models in centimetres; the longest length of an arm becomes the last one."""
_TURN, _SLIDE = sp.pi / 6, sp.Rational(35, 100)
"""The joint offsets of models (rad, m); their labels are at least as wide as most."""


@dataclass(frozen=True)
class Model:
    """An arm and its model (`chain`).

    `letters` maps the model's lettering to the arm's. `longer` is the arm's size divided by the model's.
    """

    arm: Chain
    chain: Chain
    letters: Mapping[tuple[Run, ...], tuple[Run, ...]]
    longer: float

    def pose(self, values: Mapping[str, float]) -> tuple[tuple[str, float], ...]:
        """Return the joint values of the model (rad, m) for those of the arm. Raises QdotError if one is missing."""
        entries = self._scale_slides(entries_of_pose(self.arm, values), 1 / self.longer)
        zeros = entries_of_pose(self.chain, {q.name: 0.0 for q in self.chain.q})
        return tuple(
            (q.name, round(float(entry - zero), 9)) for q, entry, zero in zip(self.arm.q, entries, zeros, strict=True)
        )

    def entries(self, drawn: Sequence[float] | np.ndarray) -> tuple[float, ...]:
        """Return the entries of the arm's table in a pose of the model."""
        return tuple(map(float, self._scale_slides(np.array(drawn), self.longer)))

    def _scale_slides(self, entries: np.ndarray, by: float) -> np.ndarray:
        is_prismatic = np.array([joint.kind == "P" for joint in self.arm.joints])
        return np.where(is_prismatic, entries * by, entries)

    def relabel(self, figure: Figure) -> Figure:
        """Return the model's figure with the arm's own lettering."""
        if not self.letters:
            return figure
        texts = (replace(text, runs=self.letters.get(text.runs, text.runs)) for text in figure.texts)
        return replace(figure, texts=tuple(texts))


def model_of(chain: Chain) -> Model:
    """Return the model of an arm. An arm described by its axes is its own model, because it is drawn at home."""
    if convention_of(chain).is_drawn_at_home:
        return Model(chain, chain, {}, 1.0)
    lettering: dict[tuple[TextRun, ...], tuple[TextRun, ...]] = {}
    length, longer = _model_lengths(chain, lettering)
    joints = []
    for joint, q, offset in zip(chain.joints, chain.q, chain.offsets, strict=True):
        entry = q + _model_offset(q, offset, joint.kind == "R", lettering)
        joint_entries = {"theta": entry, "d": length(joint.d)} if joint.kind == "R" else {"d": entry}
        joints.append(replace(joint, **joint_entries, a=length(joint.a)))
    u, v, w = map(length, chain.point.offset)
    point = Point(chain.point.frame, (u, v, w))
    model_chain = Chain("model", tuple(joints), chain.task, chain.base, point, convention=chain.convention)
    return Model(
        chain, model_chain, {runs(model): runs(arm_letters) for model, arm_letters in lettering.items()}, longer
    )


def _model_lengths(
    chain: Chain, letters: dict[tuple[TextRun, ...], tuple[TextRun, ...]]
) -> tuple[Callable[[sp.Expr], sp.Expr], float]:
    """Return a function from the arm's lengths to the model's, and the arm's size relative to the model.

    The arm's lengths are unchanged if its base position has numbers, because both must stay in proportion. They are
    also unchanged if there are more lengths than steps, or if the arm's labels are wider than the model's.
    """
    unchanged = (lambda value: value), 1.0
    values = [value for joint in chain.joints for value in (joint.a, joint.d)] + list(chain.point.offset)
    sizes = sorted({abs(value) for value in values if value.is_number and value != 0}, reverse=True)
    if not sizes or any(value.is_number and value != 0 for value in chain.base.position):
        return unchanged
    steps: dict[sp.Expr, sp.Rational] = {}
    step = len(_STEPS)
    for size in sizes:
        step = min(step, max(1, round(len(_STEPS) * float(size / sizes[0]))))
        if step < 1:
            return unchanged
        steps[size] = sp.Rational(_STEPS[step - 1], 100)
        step -= 1
    names = {magnitude(model): magnitude(size) for size, model in steps.items()}
    if any(extent(arm_letters)[0] > extent(model)[0] for model, arm_letters in names.items()):
        return unchanged
    letters.update(names)

    def length(value: sp.Expr) -> sp.Expr:
        if not value.is_number or value == 0:
            return value
        return steps[abs(value)] * (1 if value > 0 else -1)

    return length, float(sizes[0]) * 100 / _STEPS[-1]


def _model_offset(
    q: sp.Symbol, offset: sp.Expr, turns: bool, letters: dict[tuple[TextRun, ...], tuple[TextRun, ...]]
) -> sp.Expr:
    """Return the model's offset of a joint, and store the lettering; unchanged if symbolic or if its label is wider."""
    model_offset = _TURN if turns else _SLIDE
    if offset == 0 or not offset.is_number:
        return offset
    model, arm_letters = with_offset(q, model_offset, turns), with_offset(q, offset, turns)
    if extent(arm_letters)[0] > extent(model)[0]:
        return offset
    letters[model] = arm_letters
    return model_offset
