"""Draw an arm small and without lettering: a thumbnail, and singular configurations beside a regular one.

Singular configurations are drawn to scale, because they depend on the lengths; symbolic lengths get default values.
A dashed double arrow at P marks a direction in which P can't move. If it points at the reader, it becomes a ring.
"""

import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from string import ascii_lowercase

import numpy as np
import sympy as sp

from qdot.exercises.arm.chain import TASK_ROWS, Base, Chain, Joint
from qdot.exercises.arm.classification import samples_on
from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.arm.normalized_arm import normalize_arm, normalized_pieces
from qdot.exercises.arm.singularity import Component, singular_set
from qdot.exercises.arm.singularity_kinds import REGULAR
from qdot.exercises.figure.arm import draw_body, fit_drawing, make_scene
from qdot.exercises.figure.plane import exact, is_flat
from qdot.exercises.figure.pose import best_poses, drawn_chain, score_poses, skeleton, symbol_values
from qdot.exercises.figure.shapes import Circle, Figure, Glyph, Pair, Polyline, Shape, decimal
from qdot.exercises.figure.view import Drawing, View, arrow, tip
from qdot.exercises.formula.printers.unicode import unicode_math
from qdot.exercises.writing.languages import ENGLISH, Catalogue, catalogue
from qdot.exercises.writing.latex import lay_out

PANEL, THUMBNAIL = (280, 196), (320, 240)
"""Width and height of these drawings in pixels; both are shown at 60 % of this size."""
MARGIN = (12.0, 12.0)
ARROW, RING, SHORT = 44.0, 14.0, 0.3
"""Half the length of an arrow, the radius of a ring, and the visible share of an arrow below which it becomes a ring.

A last link shorter than this share of the longest link gets an arrow along its z axis, HAND pixels long.
"""
HAND = 56.0
CROSS = 6.0
"""Half the size of the cross that marks the point of a submitted answer, in pixels."""
MOST = 8
"""Maximum number of singular configurations that are drawn."""
TRIED = 24
"""Number of configurations sampled on a condition in several joints; the one easiest to read is drawn."""
CAPTION = 24
"""Maximum number of characters in a caption."""


def draw_thumbnail(chain: Chain) -> Figure:
    """Return the arm in its clearest pose without frames and lettering."""
    chain = exact(chain)
    drawn = drawn_chain(replace(chain, base=replace(chain.base, position=Base().position)))
    return _figure(drawn, best_poses(chain, drawn, 1)[0], THUMBNAIL)


def figure_in_pose(chain: Chain, pose: Mapping[str, float], beside: np.ndarray | None = None) -> Figure:
    """Return a drawing to scale of an arm with numeric lengths in a given configuration.

    `beside` (3, in m) is the vector from P to a point that is marked by a cross.
    """
    scaled_arm = _scale_arm(exact(chain))
    entries = scaled_arm.entries(np.array([pose[q.name] for q in chain.q]) + scaled_arm.offsets)
    return _figure(scaled_arm.drawn, entries, PANEL, beside=None if beside is None else beside / scaled_arm.unit)


def _figure(
    drawn: Chain,
    entries: np.ndarray,
    size: tuple[int, int],
    lost: tuple[np.ndarray, ...] = (),
    beside: np.ndarray | None = None,
) -> Figure:
    """Return a small drawing; cached, because many arms of a class have the same proportions."""
    vectors = (*lost, *(() if beside is None else (beside,)))
    key = tuple(round(float(entry), 12) for entry in entries), tuple(tuple(map(float, vector)) for vector in vectors)
    return _draw_cached(drawn, *key, size, beside is not None)


@lru_cache(maxsize=1024)
def _draw_cached(
    drawn: Chain,
    pose: tuple[float, ...],
    places: tuple[tuple[float, ...], ...],
    size: tuple[int, int],
    with_cross: bool,
) -> Figure:
    entries, vectors = np.array(pose), [np.array(vector) for vector in places]
    cross_vector = vectors.pop() if with_cross else None
    lost_directions = tuple(vectors)
    bones, shows_hand_axis = skeleton(drawn, entries), size == PANEL and _hides_hand(drawn)

    def draw(view: View) -> Drawing:
        dot = Circle(view.px(bones.path[-1]), 5.0, "point")
        marks = itertools.chain(
            *(_blocked_direction_mark(view, bones.path[-1], direction) for direction in lost_directions)
        )
        last_origin, z = bones.origins[-1], bones.frames[-1, :3, 2]
        hand_axis = arrow(view, last_origin, last_origin + HAND / view.scale * z, "axis-z") if shows_hand_axis else ()
        cross = () if cross_vector is None else _cross(view.px(bones.path[-1] + cross_vector))
        return Drawing((*draw_body(make_scene(drawn, bones, view)).shapes, *hand_axis, *marks, dot, *cross))

    drawing, _ = fit_drawing(drawn, bones, draw, (0.9 * size[0], 0.9 * size[1]), size, MARGIN)
    return Figure(*size, drawing.shapes, ())


def _hides_hand(drawn: Chain) -> bool:
    """Return whether the last link is too short to show its z axis, whose direction the previous joint changes."""
    sizes = [max(abs(float(v)) for v in (joint.a, joint.d) if v.is_number) for joint in drawn.joints]
    has_wrist_joint = drawn.n > 1 and drawn.joints[-1].kind == "R" and drawn.joints[-2].alpha not in (0, sp.pi, -sp.pi)
    return has_wrist_joint and not is_flat(drawn) and sizes[-1] < SHORT * max(sizes)


def _cross(at: Pair) -> tuple[Shape, ...]:
    """Return a cross in a circle, which marks the point of a submitted answer."""
    (x, y), d = at, CROSS
    return (
        Circle(at, 1.5 * CROSS, "yours"),
        Polyline(((x - d, y - d), (x + d, y + d)), "yours"),
        Polyline(((x - d, y + d), (x + d, y - d)), "yours"),
    )


def _blocked_direction_mark(view: View, point: np.ndarray, direction: np.ndarray) -> tuple[Shape, ...]:
    """Return a dashed double arrow through P along a unit vector, or a dashed ring."""
    drawn_direction = view.axes[:2] @ direction
    if np.linalg.norm(drawn_direction) < SHORT:
        return (Circle(view.px(point), RING, "lost"),)
    ends: list[Pair] = [view.px(point + side * ARROW / view.scale * direction) for side in (1.0, -1.0)]
    heads: list[Polyline] = [tip((view.px(point), end), "lost", 10.0)[1] for end in ends]
    return (Polyline(tuple(ends), "lost"), *heads)


# --- singular configurations ---


@dataclass(frozen=True)
class _ScaledArm:
    """An arm with numeric lengths, with joint offsets (`chain`) and without (`drawn`).

    `offsets` are the joint offsets, `values` are the values of the symbolic lengths. `drawn` is scaled so that its
    longest length is 1 instead of `unit` (m).
    """

    chain: Chain
    drawn: Chain
    offsets: np.ndarray
    values: dict[sp.Symbol, sp.Rational]
    unit: float

    def entries(self, table_entries: np.ndarray) -> np.ndarray:
        """Return entries of the table (… x n), scaled like `drawn`."""
        is_prismatic = np.array([joint.kind == "P" for joint in self.chain.joints])
        return np.where(is_prismatic, table_entries / self.unit, table_entries)


@dataclass(frozen=True)
class Panel:
    """Drawings with captions, a regular configuration first.

    `key` explains the marks. `remark` says how many configurations are omitted, if any. `has_lost` says whether a
    direction in which P can't move is marked.
    """

    drawings: tuple[tuple[str, Figure], ...] = ()
    key: str = ""
    remark: str = ""
    has_lost: bool = False


@lru_cache(maxsize=64)
def singular_panel(chain: Chain, language: str = ENGLISH) -> Panel:
    """Return drawings of a regular configuration and of singular ones for each component, up to a maximum number.

    The captions number the components of the singular set from 1, with letters if a component has several drawings.
    Nothing is drawn if the arm has no singular configuration for its task, or no regular one.
    """
    chain, words, components = exact(chain), catalogue(language), singular_set(chain) or ()
    scaled_arm = _scale_arm(chain)
    regular = best_poses(chain, scaled_arm.drawn, 1)[0]
    drawings = [(words.pgettext("caption of a drawing", "regular"), _figure(scaled_arm.drawn, regular, PANEL))]
    omitted_count = 0
    for number, component in enumerate(components, 1):
        configurations = [
            (caption, _figure(scaled_arm.drawn, entries, PANEL, lost))
            for caption, entries in _configurations(chain, scaled_arm, component, regular, words)
            if (lost := _lost_directions(chain, scaled_arm, entries)) is not None
        ]
        shown_configurations = configurations[: max(1, MOST // len(components))]
        letters = ascii_lowercase if len(shown_configurations) > 1 else ("",)
        drawings += [
            (f"{number}{letters[k]}. {caption}", figure) for k, (caption, figure) in enumerate(shown_configurations)
        ]
        omitted_count += len(configurations) - len(shown_configurations)
    if len(drawings) == 1:
        return Panel()
    remark = (
        words.gettext("%(count)s more singular configurations are not drawn.", count=omitted_count)
        if omitted_count
        else ""
    )
    styles = {shape.style for _, figure in drawings for shape in figure.shapes if not isinstance(shape, Glyph)}
    return Panel(tuple(drawings), _key(chain, styles, words), remark, "lost" in styles)


def _key(chain: Chain, styles: set[str], words: Catalogue) -> str:
    """Return a sentence that explains the marks in drawings with these styles; empty if there are no marks."""
    meanings = (
        ("lost", words.gettext("dashed: P cannot move that way")),
        ("axis-z", words.gettext("blue: %(axis)s", axis=_text(sp.Symbol(f"z{chain.n}"), chain))),
    )
    sentence = "; ".join(meaning for style, meaning in meanings if style in styles)
    return f"{sentence[0].upper()}{sentence[1:]}." if sentence else ""


def _scale_arm(chain: Chain) -> _ScaledArm:
    """Return an arm with default values for its symbolic lengths, and scaled for drawing."""
    sizes = [abs(float(v)) for joint in chain.joints for v in (joint.a, joint.d) if v.is_number and v != 0]
    default_values = symbol_values(chain, max(sizes, default=0.5))
    values = {symbol: sp.Rational(round(float(value) * 100), 100) for symbol, value in default_values.items()}

    def numbers(joint: Joint) -> Joint:
        return Joint(joint.kind, *(value.xreplace(values) for value in (joint.theta, joint.d, joint.a, joint.alpha)))

    u, v, w = (value.xreplace(values) for value in chain.point.offset)
    base = Base(Base().position, chain.base.yaw.xreplace(values), chain.base.tilt.xreplace(values))
    tool = replace(chain.point, offset=(u, v, w))
    joints = tuple(map(numbers, chain.joints))
    joints_without_offsets = tuple(
        replace(joint, theta=q) if joint.kind == "R" else replace(joint, d=q)
        for joint, q in zip(joints, chain.q, strict=True)
    )
    numeric_arm = replace(chain, joints=joints, base=base, tool=tool)
    offsets = np.array([float(value) for value in numeric_arm.offsets])
    drawn, unit = _normalize_size(
        replace(numeric_arm, name="drawn", title="", joints=joints_without_offsets, axis_points=())
    )
    return _ScaledArm(numeric_arm, drawn, offsets, values, unit)


def _normalize_size(chain: Chain) -> tuple[Chain, float]:
    """Return an arm with numeric lengths scaled so that its longest length is 1, and that length (m)."""
    lengths = [value for joint in chain.joints for value in (joint.a, joint.d) if value.is_number]
    unit = max((abs(value) for value in (*lengths, *chain.point.offset)), default=sp.S.Zero) or sp.S.One

    def shrink(value: sp.Expr) -> sp.Expr:
        return value / unit if value.is_number else value

    joints = tuple(replace(joint, a=shrink(joint.a), d=shrink(joint.d)) for joint in chain.joints)
    u, v, w = map(shrink, chain.point.offset)
    return replace(chain, joints=joints, tool=replace(chain.point, offset=(u, v, w))), float(unit)


def _configurations(
    chain: Chain, scaled: _ScaledArm, component: Component, regular: np.ndarray, words: Catalogue
) -> list[tuple[str, np.ndarray]]:
    """Return captions and table entries (n) of configurations on a component; empty if none is real."""
    if component.solutions is None:
        entries = _best_on_condition(chain, scaled, component)
        conjunction = words.pgettext("between two conditions", "and")
        condition_text = f" {conjunction} ".join(f"{_text(condition, chain)} = 0" for condition in component.conditions)
        return [] if entries is None else [(_fit_caption(condition_text, words), entries)]
    configurations = []
    joints = [joint for joint, _ in component.solutions]
    for values in itertools.product(*(values for _, values in component.solutions)):
        numbers = [complex(value.xreplace(scaled.values)) for value in values]
        if any(abs(number.imag) > 1e-9 for number in numbers):
            continue
        entries = regular.copy()
        for joint, number in zip(joints, numbers, strict=True):
            i = chain.q.index(joint)
            entries[i] = number.real + scaled.offsets[i]
            entries[i] /= scaled.unit if chain.joints[i].kind == "P" else 1.0
        kinds = [chain.joints[chain.q.index(joint)].kind for joint in joints]
        joint_values = zip(joints, values, kinds, strict=True)
        caption = ", ".join(f"{_text(q, chain)} = {_value(value, kind, chain)}" for q, value, kind in joint_values)
        configurations.append((_fit_caption(caption, words), entries))
    return configurations


def _best_on_condition(chain: Chain, scaled: _ScaledArm, component: Component) -> np.ndarray | None:
    """Return the table entries (n) of the clearest configuration on a component; None if none is real."""
    numeric_component = replace(
        component, conditions=tuple(condition.xreplace(scaled.values) for condition in component.conditions)
    )
    (text,) = normalized_pieces(scaled.chain, numeric_component)
    samples = samples_on(normalize_arm(scaled.chain), text, "figure", arms=1, each=TRIED)
    if not samples:
        return None
    entries = scaled.entries(np.array([sample.q for sample in samples]))
    is_revolute = np.array([joint.kind == "R" for joint in chain.joints])
    entries = np.where(is_revolute, np.arctan2(np.sin(entries), np.cos(entries)), entries)
    return np.asarray(entries[int(np.argmax(np.round(score_poses(chain, scaled.drawn, entries), 3)))])


def _text(expression: sp.Expr, chain: Chain) -> str:
    """Return an expression as one line of Unicode text."""
    return unicode_math(lay_out(expression, chain))


def _value(value: sp.Expr, kind: str, chain: Chain) -> str:
    """Return the text of an angle in degrees or a length in metres; symbolic constants are unchanged.

    Multiples of a degree are exact, other angles have two decimals.
    """
    constant, rest = (
        value.as_independent(*value.free_symbols, as_Add=True) if value.free_symbols else (value, sp.S.Zero)
    )
    number = _angle(constant) if kind == "R" else f"{decimal(constant)} m"
    if rest == 0:
        return number.replace("-", "−")
    sign = "" if constant == 0 else f" − {number[1:]}" if number.startswith("-") else f" + {number}"
    return f"{_text(rest, chain)}{sign}"


def _angle(value: sp.Expr) -> str:
    degrees = value * 180 / sp.pi
    return f"{decimal(degrees)}°" if degrees.is_Rational else f"{float(degrees):.2f}°"


def _fit_caption(caption: str, words: Catalogue) -> str:
    """Return the caption, or a reference to the numbered condition if it is too long to fit below its drawing."""
    return words.with_decimal(caption) if len(caption) <= CAPTION else words.gettext("see the condition above")


def _lost_directions(chain: Chain, scaled: _ScaledArm, entries: np.ndarray) -> tuple[np.ndarray, ...] | None:
    """Return unit vectors of lost linear directions, along which P can't move; None if no rank is lost."""
    task = [TASK_ROWS.index(row) for row in chain.task]
    jacobian = NumericChain(scaled.drawn, {}).jacobian(entries)[task]
    u, sigma, _ = np.linalg.svd(jacobian)
    rank = int(np.sum(sigma > REGULAR * max(float(sigma[0]), 1e-12)))
    if rank == min(jacobian.shape):
        return None
    if jacobian.shape[0] > jacobian.shape[1]:
        return ()
    directions = []
    for lost_direction in _canonical_basis(u[:, rank:]):
        vector = np.zeros(6)
        vector[task] = lost_direction
        if np.linalg.norm(vector[3:]) < 1e-6:
            directions.append(vector[:3])
    return tuple(directions)


def _canonical_basis(basis: np.ndarray) -> list[np.ndarray]:
    """Return a canonical basis (rows) of the space that the columns span, independent of the given basis and signs.

    The basis from the singular value decomposition depends on the processor. So the coordinate axes are projected to
    the space, one after another, and their new components form the basis.
    """
    projector, vectors = basis @ basis.T, list[np.ndarray]()
    for threshold in (0.3, 1e-3):
        for axis in projector:
            new = axis - sum((axis @ vector) * vector for vector in vectors)
            if len(vectors) < basis.shape[1] and np.linalg.norm(new) > threshold:
                vectors.append(new / np.linalg.norm(new))
    return vectors


def cells(count: int, caption: float, width: float) -> tuple[int, int]:
    """Return the numbers of columns and rows for `count` drawings; the widest caption (pixels) fits into a column.

    >>> cells(9, 170.0, 520.0), cells(9, 198.0, 520.0), cells(4, 60.0, 520.0)
    ((3, 3), (2, 5), (2, 2))
    """
    columns = count if count <= 3 else 2 if count == 4 else 3
    columns = max(1, min(columns, int(width / caption)))
    return columns, math.ceil(count / columns)
