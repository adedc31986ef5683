"""Draw an arm small and without labels: a thumbnail, and panels with singular configurations and a regular one.

Singular configurations are drawn to scale, because they depend on the lengths. Symbolic lengths get default values. A
dashed double arrow at P marks a lost direction, in which P can't move. If the direction points at the reader, the arrow
becomes a ring.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from string import ascii_lowercase

import numpy as np
import sympy as sp

from qdot.exercises.arm.chain import ANGLE_PREFIXES, Base, Chain
from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.figure.arm_parts import draw_links_and_joints, fit_drawing, make_scene
from qdot.exercises.figure.lettering import format_decimal
from qdot.exercises.figure.plane import is_drawn_flat, list_numeric_lengths, make_numbers_exact, scale_prismatic_entries
from qdot.exercises.figure.pose import (
    choose_symbol_values,
    compute_skeleton,
    find_best_poses,
    make_drawable_chain,
    score_poses,
)
from qdot.exercises.figure.shapes import Circle, Figure, Glyph, Polyline, Shape, make_cross
from qdot.exercises.figure.view import Drawing, View, draw_arrow, draw_line_with_arrowhead
from qdot.exercises.formula.printers.unicode import print_unicode
from qdot.exercises.singularities.classification import sample_condition
from qdot.exercises.singularities.normalized_arm import normalize_arm, normalize_conditions
from qdot.exercises.singularities.singular_set import Component, find_singular_set
from qdot.exercises.singularities.singularity_kinds import RANK_TOLERANCE
from qdot.exercises.writing.languages import ENGLISH, Catalogue, load_catalogue
from qdot.exercises.writing.latex import lay_out

PANEL_SIZE, THUMBNAIL_SIZE = (280, 196), (320, 240)
"""Width and height of a panel and of a thumbnail in pixels; both are shown at 60 % of this size."""
Vector = tuple[float, ...]
"""A vector as a value that can be a key of a cache."""
Size = tuple[int, int]
"""Width and height in pixels."""
MARGIN = (12.0, 12.0)
"""Margins on the left and right, and above and below, in pixels."""
ARROW_HALF_LENGTH, RING_RADIUS = 44.0, 14.0
"""Half the length of an arrow, and the radius of a ring, in pixels."""
SHORT_SHARE = 0.3
"""If the visible share of an arrow is smaller than this, the arrow becomes a ring.

If the last link is shorter than this share of the longest link, an arrow shows the z axis of the last link.
"""
LAST_AXIS_LENGTH = 56.0
"""Length of the arrow for the z axis of a short last link, in pixels."""
CROSS_HALF_SIZE = 6.0
"""Half the size of the cross that marks the point of a submitted answer, in pixels."""
MAX_SINGULAR_DRAWINGS = 8
"""Maximum number of singular configurations that are drawn."""
SAMPLED_CONFIGURATIONS = 24
"""Number of configurations sampled on a condition on several joints. The clearest of them is drawn."""
MAX_CAPTION_LENGTH = 24
"""Maximum number of characters in a caption."""


def draw_thumbnail(chain: Chain) -> Figure:
    """Return the arm in its clearest pose without frames and labels."""
    exact_chain = make_numbers_exact(chain)
    base_at_origin = replace(exact_chain.base, position=Base().position)
    drawn_chain = make_drawable_chain(replace(exact_chain, base=base_at_origin))
    (entries,) = find_best_poses(exact_chain, drawn_chain, 1)
    return _draw_small(drawn_chain, entries, THUMBNAIL_SIZE)


def draw_in_pose(chain: Chain, pose: Mapping[str, float], mark_offset: np.ndarray | None = None) -> Figure:
    """Return a drawing to scale of an arm with numeric lengths in a given configuration.

    `mark_offset` (3, in m) is the vector from P to a point that is marked by a cross.
    """
    scaled_arm = _scale_arm(make_numbers_exact(chain))
    entries = scaled_arm.scale_entries(np.array([pose[q.name] for q in chain.q]) + scaled_arm.offsets)
    mark = None if mark_offset is None else mark_offset / scaled_arm.unit
    return _draw_small(scaled_arm.scaled_chain, entries, PANEL_SIZE, mark=mark)


def _draw_small(
    chain: Chain, entries: np.ndarray, size: Size, directions: Sequence[np.ndarray] = (), mark: np.ndarray | None = None
) -> Figure:
    """Return a small drawing with marks for lost directions (unit vectors).

    The drawing is cached, because many arms have the same proportions. `mark` is the vector from P to another point
    that is marked, if any.
    """
    lost_directions = tuple(tuple(map(float, direction)) for direction in directions)
    mark_vector = None if mark is None else tuple(map(float, mark))
    return _draw_cached(chain, tuple(round(float(entry), 12) for entry in entries), size, lost_directions, mark_vector)


@lru_cache(maxsize=1024)
def _draw_cached(
    chain: Chain, entries: Vector, size: Size, lost_directions: tuple[Vector, ...], mark: Vector | None
) -> Figure:
    """Return a small drawing; arrays are passed as tuples, so that the result can be cached."""
    skeleton = compute_skeleton(chain, np.array(entries))
    shows_last_axis = size == PANEL_SIZE and _is_last_link_too_short(chain)

    def draw(view: View) -> Drawing:
        dot = Circle(view.to_pixels(skeleton.path[-1]), 5.0, "point")
        point, last_origin, z = skeleton.path[-1], skeleton.origins[-1], skeleton.frames[-1, :3, 2]
        arrows = [shape for vector in lost_directions for shape in _draw_lost_direction(view, point, np.array(vector))]
        if shows_last_axis:
            tip = last_origin + LAST_AXIS_LENGTH / view.scale * z
            arrows = [*draw_arrow(view, last_origin, tip, "axis-z"), *arrows]
        cross: tuple[Shape, ...] = ()
        if mark is not None:
            center = view.to_pixels(point + np.array(mark))
            cross = (Circle(center, 1.5 * CROSS_HALF_SIZE, "yours"), *make_cross(center, CROSS_HALF_SIZE, "yours"))
        return Drawing((*draw_links_and_joints(make_scene(chain, skeleton, view)).shapes, *arrows, dot, *cross))

    drawing, _ = fit_drawing(chain, skeleton, draw, (0.9 * size[0], 0.9 * size[1]), size, MARGIN)
    return Figure(*size, drawing.shapes, ())


def _is_last_link_too_short(chain: Chain) -> bool:
    """Return whether the last link is too short to show its z axis, whose direction the previous joint changes."""
    lengths = [max(abs(float(v)) for v in (joint.a, joint.d) if v.is_number) for joint in chain.joints]
    has_wrist_joint = chain.n > 1 and chain.joints[-1].is_revolute and chain.joints[-2].alpha not in (0, sp.pi, -sp.pi)
    return has_wrist_joint and not is_drawn_flat(chain) and lengths[-1] < SHORT_SHARE * max(lengths)


def _draw_lost_direction(view: View, point: np.ndarray, direction: np.ndarray) -> tuple[Shape, ...]:
    """Return a dashed double arrow through P along a unit vector, or a dashed ring."""
    drawn_vector = view.axes[:2] @ direction
    if np.linalg.norm(drawn_vector) < SHORT_SHARE:
        return (Circle(view.to_pixels(point), RING_RADIUS, "lost"),)
    ends = view.to_pixel_path([point + side * ARROW_HALF_LENGTH / view.scale * direction for side in (1.0, -1.0)])
    heads = [draw_line_with_arrowhead((view.to_pixels(point), end), "lost", 10.0)[1] for end in ends]
    return (Polyline(ends, "lost"), *heads)


# --- singular configurations ---


@dataclass(frozen=True)
class _ScaledArm:
    """An arm with numeric lengths (`arm`), and a scaled copy of it without joint offsets (`scaled_chain`).

    `offsets` are the joint offsets, and `values` are the values of the symbolic lengths. `unit` (m) is the longest
    length of `arm`, which becomes 1 in `scaled_chain`.
    """

    arm: Chain
    scaled_chain: Chain
    offsets: np.ndarray
    values: dict[sp.Symbol, sp.Rational]
    unit: float

    def scale_entries(self, table_entries: np.ndarray) -> np.ndarray:
        """Return entries of the table (… x n), scaled like `scaled_chain`."""
        return scale_prismatic_entries(self.arm, table_entries, 1 / self.unit)


@dataclass(frozen=True)
class PanelSet:
    """Drawings with captions; the first drawing shows a regular configuration.

    `legend` explains the marks. `remark` states how many configurations are omitted, if any. `has_lost_direction` says
    whether a direction is marked in which P can't move.
    """

    drawings: tuple[tuple[str, Figure], ...] = ()
    legend: str = ""
    remark: str = ""
    has_lost_direction: bool = False


@lru_cache(maxsize=64)
def draw_singular_panels(chain: Chain, language: str = ENGLISH) -> PanelSet:
    """Return drawings of a regular configuration and of singular configurations on each component.

    The captions number the components of the singular set from 1, with letters if a component has several drawings.
    About MAX_SINGULAR_DRAWINGS singular configurations are drawn at most. Nothing is drawn if the arm has no singular
    configuration for its task, or no regular configuration.
    """
    exact_chain, catalogue = make_numbers_exact(chain), load_catalogue(language)
    components = find_singular_set(chain) or ()
    scaled_arm = _scale_arm(exact_chain)
    drawn_chain = scaled_arm.scaled_chain
    (regular_entries,) = find_best_poses(exact_chain, drawn_chain, 1)
    regular_drawing = _draw_small(drawn_chain, regular_entries, PANEL_SIZE)
    drawings = [(catalogue.pgettext("caption of a drawing", "regular"), regular_drawing)]
    omitted_count = 0
    for number, component in enumerate(components, 1):
        candidates = []
        for caption, entries in _list_configurations(exact_chain, scaled_arm, component, regular_entries, catalogue):
            lost_directions = _find_lost_directions(exact_chain, drawn_chain, entries)
            if lost_directions is not None:
                candidates.append((caption, _draw_small(drawn_chain, entries, PANEL_SIZE, lost_directions)))
        panels = candidates[: max(1, MAX_SINGULAR_DRAWINGS // len(components))]
        letters = ascii_lowercase if len(panels) > 1 else ("",)
        drawings += [(f"{number}{letters[k]}. {caption}", figure) for k, (caption, figure) in enumerate(panels)]
        omitted_count += len(candidates) - len(panels)
    if len(drawings) == 1:
        return PanelSet()
    remark = catalogue.gettext("Singular configurations that are not drawn: %(count)s.", count=omitted_count)
    styles = {shape.style for _, figure in drawings for shape in figure.shapes if not isinstance(shape, Glyph)}
    legend = _make_legend(exact_chain, styles, catalogue)
    return PanelSet(tuple(drawings), legend, remark if omitted_count else "", "lost" in styles)


def _make_legend(chain: Chain, styles: set[str], catalogue: Catalogue) -> str:
    """Return a sentence that explains the marks in drawings with these styles; empty if there are no marks."""
    meanings = (
        ("lost", catalogue.gettext("dashed: P cannot move that way")),
        ("axis-z", catalogue.gettext("blue: %(axis)s", axis=_format_expression(sp.Symbol(f"z{chain.n}"), chain))),
    )
    sentence = "; ".join(meaning for style, meaning in meanings if style in styles)
    return f"{sentence[0].upper()}{sentence[1:]}." if sentence else ""


def _scale_arm(chain: Chain) -> _ScaledArm:
    """Return an arm with default values for its symbolic lengths, together with its scaled copy for drawing."""
    default_values = choose_symbol_values(chain, max(list_numeric_lengths(chain), default=0.5))
    values = {symbol: sp.Rational(round(float(value) * 100), 100) for symbol, value in default_values.items()}
    arm_at_origin = replace(chain, base=replace(chain.base, position=Base().position))
    arm = arm_at_origin.map_entries(lambda _, entry: entry.xreplace(values))
    lengths = [value for joint in arm.joints for value in (joint.a, joint.d) if value.is_number]
    unit = max((abs(value) for value in (*lengths, *arm.point.offset)), default=sp.S.Zero) or sp.S.One
    variables = {q.name: q for q in arm.q}

    def scale_entry(name: str, entry: sp.Expr) -> sp.Expr:
        return variables.get(name) or (entry if name.startswith(ANGLE_PREFIXES) else entry / unit)

    scaled_chain = replace(arm, name="drawn", title="", axis_points=()).map_entries(scale_entry)
    return _ScaledArm(arm, scaled_chain, np.array([float(value) for value in arm.offsets]), values, float(unit))


def _list_configurations(
    chain: Chain, scaled_arm: _ScaledArm, component: Component, regular_entries: np.ndarray, catalogue: Catalogue
) -> list[tuple[str, np.ndarray]]:
    """Return captions and table entries (n) of the real configurations on a component of the singular set.

    Joints that the component leaves free have the entries of a regular configuration.
    """
    if component.solutions is None:
        entries = _find_best_configuration(chain, scaled_arm, component)
        equations = [f"{_format_expression(condition, chain)} = 0" for condition in component.conditions]
        conjunction = catalogue.pgettext("between two conditions", "and")
        return [] if entries is None else [(_fit_caption(f" {conjunction} ".join(equations), catalogue), entries)]
    configurations = []
    for values in component.list_value_combinations():
        numbers = [complex(value.xreplace(scaled_arm.values)) for _, value in values]
        if any(abs(number.imag) > 1e-9 for number in numbers):
            continue
        entries, equations = regular_entries.copy(), []
        for (q, value), number in zip(values, numbers, strict=True):
            i = chain.q.index(q)
            is_prismatic = chain.joints[i].is_prismatic
            entries[i] = (number.real + scaled_arm.offsets[i]) / (scaled_arm.unit if is_prismatic else 1.0)
            value_text = _format_joint_value(value, is_prismatic, chain)
            equations.append(f"{_format_expression(q, chain)} = {value_text}")
        configurations.append((_fit_caption(", ".join(equations), catalogue), entries))
    return configurations


def _find_best_configuration(chain: Chain, scaled_arm: _ScaledArm, component: Component) -> np.ndarray | None:
    """Return the table entries (n) of the clearest configuration on a component; None if no configuration is real."""
    conditions = tuple(condition.xreplace(scaled_arm.values) for condition in component.conditions)
    (condition,) = normalize_conditions(scaled_arm.arm, replace(component, conditions=conditions))
    arm = normalize_arm(scaled_arm.arm)
    samples = sample_condition(arm, condition, "figure", arm_count=1, samples_per_arm=SAMPLED_CONFIGURATIONS)
    if not samples:
        return None
    entries = scaled_arm.scale_entries(np.array([sample.q for sample in samples]))
    is_revolute = [joint.is_revolute for joint in chain.joints]
    entries = np.where(is_revolute, np.arctan2(np.sin(entries), np.cos(entries)), entries)
    return np.asarray(entries[int(np.argmax(np.round(score_poses(chain, scaled_arm.scaled_chain, entries), 3)))])


def _format_expression(expression: sp.Expr, chain: Chain) -> str:
    """Return an expression as one line of Unicode text."""
    return print_unicode(lay_out(expression, chain))


def _format_joint_value(value: sp.Expr, is_length: bool, chain: Chain) -> str:
    """Return the text of an angle in degrees or a length in metres; symbolic constants are unchanged.

    Multiples of a degree are exact, other angles have two decimals.
    """
    constant, symbolic_part = value.as_independent(sp.Symbol, as_Add=True)
    number = f"{format_decimal(constant)} m" if is_length else _format_angle(constant)
    if symbolic_part == 0:
        return number.replace("-", "−")
    sign = "" if constant == 0 else f" − {number[1:]}" if number.startswith("-") else f" + {number}"
    return f"{_format_expression(symbolic_part, chain)}{sign}"


def _format_angle(value: sp.Expr) -> str:
    degrees = value * 180 / sp.pi
    return f"{format_decimal(degrees)}°" if degrees.is_Rational else f"{float(degrees):.2f}°"


def _fit_caption(caption: str, catalogue: Catalogue) -> str:
    """Return the caption or, if it is too long to fit below its drawing, a reference to the numbered condition."""
    if len(caption) <= MAX_CAPTION_LENGTH:
        return catalogue.localize_number(caption)
    return catalogue.gettext("see the condition above")


def _find_lost_directions(chain: Chain, drawn_chain: Chain, entries: np.ndarray) -> tuple[np.ndarray, ...] | None:
    """Return unit vectors of lost linear directions, along which P can't move; None if no rank is lost."""
    jacobian = NumericChain(drawn_chain, {}).compute_jacobian(entries)[chain.task_rows]
    u, sigma, _ = np.linalg.svd(jacobian)
    rank = int(np.sum(sigma > RANK_TOLERANCE * max(float(sigma[0]), 1e-12)))
    if rank == min(jacobian.shape):
        return None
    if jacobian.shape[0] > jacobian.shape[1]:
        return ()
    directions = []
    for lost_direction in _compute_canonical_basis(u[:, rank:]):
        vector = np.zeros(6)
        vector[chain.task_rows] = lost_direction
        if np.linalg.norm(vector[3:]) < 1e-6:
            directions.append(vector[:3])
    return tuple(directions)


def _compute_canonical_basis(basis: np.ndarray) -> list[np.ndarray]:
    """Return an orthonormal basis of the space that the columns of `basis` span; it depends only on the space.

    The basis from the singular value decomposition depends on the processor. Therefore the coordinate axes are
    projected onto the space, one after another, and their new components form the basis.
    """
    projector, vectors = basis @ basis.T, list[np.ndarray]()
    for threshold in (0.3, 1e-3):  # axes that add a clearly new direction come first
        for axis in projector:
            component = axis - sum((axis @ vector) * vector for vector in vectors)
            if len(vectors) < basis.shape[1] and np.linalg.norm(component) > threshold:
                vectors.append(component / np.linalg.norm(component))
    return vectors


def choose_grid(count: int, caption_width: float, width: float) -> tuple[int, int]:
    """Return the numbers of columns and rows for `count` drawings in a total width (pixels).

    The widest caption, with `caption_width` pixels, fits into a column.

    >>> choose_grid(9, 170.0, 520.0), choose_grid(9, 198.0, 520.0), choose_grid(4, 60.0, 520.0)
    ((3, 3), (2, 5), (2, 2))
    """
    columns = count if count <= 3 else 2 if count == 4 else 3
    columns = max(1, min(columns, int(width / caption_width)))
    return columns, math.ceil(count / columns)
