"""The arm that is drawn in the place of another: many arms of a class look alike, but for what their labels say.

A figure is not to scale, so that lengths in numbers are drawn in a few steps, equal ones equal and longer ones longer.
Offsets of joints are told by labels alone. A figure is worked out once for all arms with the same model, with room for
the widest of their labels; then each arm's own labels are put in.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import sympy as sp

from qdot.exercises.arm.chain import Chain, Point
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.figure.pose import told_pose
from qdot.exercises.figure.shapes import Figure, Run, TextRun, extent, magnitude, runs, with_offset

_STEPS = (9, 24, 36, 48, 59, 72, 84, 96)
"""Lengths of models in centimetres: two digits each, of full width; the longest one of an arm has the last."""
_TURN, _SLIDE = sp.pi / 6, sp.Rational(35, 100)
"""Offsets of models: labelled as wide as most are."""


@dataclass(frozen=True)
class Model:
    """What is drawn in the place of an arm, the arm's own letters for those of it, and how much longer the arm is."""

    arm: Chain
    chain: Chain
    letters: Mapping[tuple[Run, ...], tuple[Run, ...]]
    longer: float

    def pose(self, told: Mapping[str, float]) -> tuple[tuple[str, float], ...]:
        """Return the joint values of the model (rad, m) for those of the arm. Raises QdotError where one is missing."""
        entries = self._scaled(told_pose(self.arm, told), 1 / self.longer)
        zeros = told_pose(self.chain, {q.name: 0.0 for q in self.chain.q})
        return tuple(
            (q.name, round(float(entry - zero), 9)) for q, entry, zero in zip(self.arm.q, entries, zeros, strict=True)
        )

    def entries(self, drawn: Sequence[float] | np.ndarray) -> tuple[float, ...]:
        """Return the entries of the arm's table in a pose of the model."""
        return tuple(map(float, self._scaled(np.array(drawn), self.longer)))

    def _scaled(self, entries: np.ndarray, by: float) -> np.ndarray:
        slides = np.array([joint.kind == "P" for joint in self.arm.joints])
        return np.where(slides, entries * by, entries)

    def lettered(self, figure: Figure) -> Figure:
        """Return the model's figure with the arm's own letters."""
        if not self.letters:
            return figure
        texts = (replace(text, runs=self.letters.get(text.runs, text.runs)) for text in figure.texts)
        return replace(figure, texts=tuple(texts))


def model_of(chain: Chain) -> Model:
    """Return the model of an arm; the arm itself where it is told by its axes, whose home its zeros are."""
    if not convention_of(chain).has_frames:
        return Model(chain, chain, {}, 1.0)
    letters: dict[tuple[TextRun, ...], tuple[TextRun, ...]] = {}
    length, longer = _lengths(chain, letters)
    joints = []
    for joint, q, offset in zip(chain.joints, chain.q, chain.offsets, strict=True):
        own = q + _offset(q, offset, joint.kind == "R", letters)
        turns = {"theta": own, "d": length(joint.d)} if joint.kind == "R" else {"d": own}
        joints.append(replace(joint, **turns, a=length(joint.a)))
    u, v, w = map(length, chain.point.offset)
    point = Point(chain.point.frame, (u, v, w))
    plain = Chain("model", tuple(joints), chain.task, chain.base, point, convention=chain.convention)
    return Model(chain, plain, {runs(model): runs(own) for model, own in letters.items()}, longer)


def _lengths(
    chain: Chain, letters: dict[tuple[TextRun, ...], tuple[TextRun, ...]]
) -> tuple[Callable[[sp.Expr], sp.Expr], float]:
    """Return what gives the model's length for one of the arm's, and how much longer the arm is than the model.

    An arm is not changed whose base stands at numbers, which its lengths are drawn in proportion to, and one with more
    lengths than there are steps, or with longer labels.
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
    if any(extent(own)[0] > extent(model)[0] for model, own in names.items()):
        return unchanged
    letters.update(names)

    def length(value: sp.Expr) -> sp.Expr:
        if not value.is_number or value == 0:
            return value
        return steps[abs(value)] * (1 if value > 0 else -1)

    return length, float(sizes[0]) * 100 / _STEPS[-1]


def _offset(
    q: sp.Symbol, offset: sp.Expr, turns: bool, letters: dict[tuple[TextRun, ...], tuple[TextRun, ...]]
) -> sp.Expr:
    """Return the model's offset of a joint."""
    usual = _TURN if turns else _SLIDE
    if offset == 0 or not offset.is_number:
        return offset
    model, own = with_offset(q, usual, turns), with_offset(q, offset, turns)
    if extent(own)[0] > extent(model)[0]:
        return offset
    letters[model] = own
    return usual
