"""Draw the parts of an arm: links, joints, ground, joint angles and lengths of prismatic joints.

Joint i rotates about z_{i-1} or slides along it. Its glyph is drawn on that axis, apart from the other glyphs.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from qdot.exercises.arm.chain import PRISMATIC, Chain
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.arm.conventions.base import Convention
from qdot.exercises.figure.lettering import Lettering, joint_lettering, length_lettering
from qdot.exercises.figure.places import LabelRequest
from qdot.exercises.figure.plane import choose_view, is_drawn_flat
from qdot.exercises.figure.pose import Skeleton, compute_table_entries
from qdot.exercises.figure.shapes import Circle, Glyph, Polyline, Shape, Vector2D, list_outlines, make_cross
from qdot.exercises.figure.view import (
    Drawing,
    View,
    draw_cylinder,
    draw_line_with_arrowhead,
    draw_sleeve,
    perpendicular_vectors,
    unit_vector_at,
)

JOINT_RADIUS, JOINT_HALF_LENGTH, SLEEVE_HALF_LENGTH = 9.0, 11.0, 19.0
"""Radius of a revolute joint, half its length in space, and half the length of a prismatic joint, in pixels."""
GLYPH_DISTANCE, GLYPH_DISTANCE_WITHOUT_LINKS = 27.0, 82.0
"""Minimum distance of two glyphs, and their distance in an arm without links, in pixels."""
WRIST_JOINTS = 3
"""Number of joints of a wrist: the axes of this many frames can be distinguished at one point."""
ARC_RADIUS = {True: 31.0, False: 34.0}
"""Radius in pixels of the arc of a joint angle, in a flat drawing (True) and in space."""


@dataclass(frozen=True)
class Scene:
    """An arm, its skeleton in the pose to draw, the view, and the positions of the joints' glyphs (n x 3).

    `frames` are the link frames by the arm's convention (n+1 x 4 x 4). `frames_without_x` lists those drawn without
    their x axis, because too many axes start at one point. If `is_sparse`, the drawing has only the arm, its
    origins, its z axes, and its first and last frame. A planar arm is drawn flat. At home, all joint variables are 0.
    """

    chain: Chain
    bones: Skeleton
    view: View
    glyph_positions: tuple[np.ndarray, ...]
    frames_without_x: frozenset[int]
    is_planar: bool
    frames: np.ndarray
    is_sparse: bool = False
    is_home: bool = False

    @property
    def convention(self) -> Convention:
        """The convention that describes the arm."""
        return convention_of(self.chain)

    @property
    def shown_world_axes(self) -> list[int]:
        """The numbers of the world's axes that can be drawn: in a flat drawing, only the two in its plane."""
        return [k for k in range(3) if not self.is_planar or self.view.lies_flat(np.eye(3)[k])]

    def axis(self, i: int) -> np.ndarray:
        """Return z_{i-1}, the axis of joint i."""
        return np.asarray(self.bones.frames[i - 1, :3, 2])

    def is_glyph_beside_link(self, i: int) -> bool:
        """Return whether the glyph of joint i is on the joint's axis but neither on the link nor at the origin."""
        start, glyph_position = self.bones.origins[i - 1], self.glyph_positions[i - 1]
        distance_along_axis, link = float((glyph_position - start) @ self.axis(i)), self.bones.corners[i - 1] - start
        share = distance_along_axis / float(link @ self.axis(i)) if _is_movable(self.bones, i - 1) else np.inf
        return abs(distance_along_axis) > 1e-9 and not 0.0 <= share <= 1.0


def make_scene(chain: Chain, bones: Skeleton, view: View, is_sparse: bool = False) -> Scene:
    """Return the scene with a position for each glyph at which it does not cover another one."""
    positions: dict[int, np.ndarray] = {}
    for i in sorted(range(chain.n), key=lambda i: _is_movable(bones, i) and i > 0):
        positions[i] = _find_free_position(bones, view, i, list(positions.values()))
    glyph_positions = tuple(positions[i] for i in range(chain.n))
    is_flat, frames = is_drawn_flat(chain), convention_frames(chain, bones)
    has_small_wrist = convention_of(chain).is_proximal and chain.n <= WRIST_JOINTS  # if so, all x axes are drawn
    frames_without_x = frozenset[int]() if is_flat or has_small_wrist else _crowded_frames(frames[:, :3, 3])
    if is_sparse:
        frames_without_x = frozenset(range(1, chain.n))
    home = compute_table_entries(chain, {q.name: 0.0 for q in chain.q})
    is_home = bool(np.allclose(bones.entries, home, atol=1e-9))
    return Scene(chain, bones, view, glyph_positions, frames_without_x, is_flat, frames, is_sparse, is_home)


def convention_frames(chain: Chain, bones: Skeleton) -> np.ndarray:
    """Return the link frames of an arm by its convention (n+1 x 4 x 4)."""
    convention = convention_of(chain)
    base_origin = np.zeros(3) if convention.base.is_world else bones.origins[0]  # the base as drawn
    return convention.convert_standard_frames(bones.frames, bones.corners, base_origin)


def _is_movable(bones: Skeleton, i: int) -> bool:
    """Return whether a link runs along the axis of joint i, so that its glyph can be moved along the link."""
    return bool(np.linalg.norm(bones.corners[i] - bones.origins[i]) > 1e-6)


def _crowded_frames(origins: np.ndarray) -> frozenset[int]:
    """Return the frames that share their origin with at least two others, except the arm's first and last frame."""
    distances = np.linalg.norm(origins[:, None] - origins[None], axis=2)
    crowded = np.sum(distances < 1e-6, axis=1) > 2
    return frozenset(i for i in range(1, len(crowded) - 1) if crowded[i])


def _find_free_position(bones: Skeleton, view: View, i: int, taken_positions: list[np.ndarray]) -> np.ndarray:
    """Return a position on the axis of joint i + 1 where its glyph covers no other one, if there is such a position."""
    origin, link = bones.origins[i], bones.corners[i] - bones.origins[i]
    z = bones.frames[i, :3, 2]
    candidates = [origin + share * link for share in (0.0, 0.45, 0.6, 0.3)]
    if not view.is_end_on(z):
        distance, steps = GLYPH_DISTANCE, [-1.0, 1.0, -2.0, 2.0] if i == 0 else [1.0, -1.0, 2.0, -2.0]
        if has_no_links(bones) and not _is_movable(bones, i):
            distance, steps = GLYPH_DISTANCE_WITHOUT_LINKS, steps if i == 0 else [1.0, 0.5, -1.0, -0.5, 2.0]
        candidates += [origin + step * distance / view.scale * z for step in steps]
        if i == 0 and _shares_origin(bones):
            candidates = candidates[4:]
    for candidate in candidates:
        pixel = view.to_pixels(candidate)
        if all(math.dist(pixel, view.to_pixels(taken_place)) >= GLYPH_DISTANCE - 3 for taken_place in taken_positions):
            return np.asarray(candidate)
    return np.asarray(candidates[0])


def has_no_links(bones: Skeleton) -> bool:
    """Return whether the arm has no links, like a wrist."""
    return bool(np.ptp(np.vstack([bones.origins, bones.corners, bones.path]), axis=0).max() < 1e-6)


def _shares_origin(bones: Skeleton) -> bool:
    """Return whether joints 1 and 2 have the same origin and neither can be moved along a link."""
    distance = np.linalg.norm(bones.origins[1] - bones.origins[0])
    return len(bones.corners) > 1 and bool(distance < 1e-6) and not (_is_movable(bones, 0) or _is_movable(bones, 1))


def draw_link(scene: Scene, i: int) -> Drawing:
    """Return link i as bars, labelled with its lengths."""
    bones, view, joint, glyph = scene.bones, scene.view, scene.chain.joints[i - 1], scene.glyph_positions[i - 1]
    start, corner, end = bones.origins[i - 1], bones.corners[i - 1], bones.origins[i]
    bars = [([glyph, start], "link")] if scene.is_glyph_beside_link(i) else []
    labels = _label_length(view, corner, end, length_lettering(joint.a))
    if joint.is_prismatic:
        bars += [([glyph, corner], "rod"), ([start, glyph], "link"), ([corner, end], "link")]
    else:
        bars.append(([start, corner, end], "link"))
        labels = _label_length(view, start, corner, length_lettering(joint.d)) + labels
    return Drawing(tuple(shape for points, style in bars for shape in _draw_bar(view, points, style)), tuple(labels))


def draw_path_to_point(scene: Scene) -> Drawing:
    """Return the bar from O_k to the point P, labelled with its lengths."""
    path = scene.bones.path
    labels: list[LabelRequest] = []
    for k, value in enumerate(scene.chain.point.offset):
        labels += _label_length(scene.view, path[k], path[k + 1], length_lettering(value))
    return Drawing(_draw_bar(scene.view, list(path), "link"), tuple(labels))


def _draw_bar(view: View, points: list[np.ndarray], style: str) -> tuple[Shape, ...]:
    """Return a bar along points (3, m), drawn as an outline and a filling; nothing if all points coincide."""
    distinct_points = [points[0]]
    distinct_points += [point for previous, point in pairwise(points) if np.linalg.norm(point - previous) > 1e-9]
    if len(distinct_points) < 2:
        return ()
    line = view.path_in_pixels(distinct_points)
    return (Polyline(line, style), Polyline(line, f"{style}-inside"))


def _label_length(view: View, start: np.ndarray, end: np.ndarray, pieces: Lettering) -> list[LabelRequest]:
    """Return the label of a straight piece, which can be placed on either side; none for a zero length."""
    if np.linalg.norm(end - start) < 1e-9:
        return []
    return [LabelRequest(pieces, anchors_beside(*view.path_in_pixels([start, end])), gap=8.0, rank=1)]


def anchors_beside(first: Vector2D, second: Vector2D) -> tuple[tuple[Vector2D, Vector2D], ...]:
    """Return anchors along a drawn line, with directions to both of its sides."""
    dx, dy = second[0] - first[0], second[1] - first[1]
    size = max(math.hypot(dx, dy), 1e-9)
    first_side = (dy / size, -dx / size)
    if (round(first_side[1], 3), round(first_side[0], 3)) > (0.0, 0.0):
        first_side = (-first_side[0], -first_side[1])
    second_side = (-first_side[0], -first_side[1])
    points = [(first[0] + share * dx, first[1] + share * dy) for share in (0.5, 0.65, 0.35, 0.8, 0.2)]
    return tuple((point, side) for point in points for side in (first_side, second_side))


def draw_joint(scene: Scene, i: int) -> Drawing:
    """Return the glyph of joint i."""
    kind, position, z, view = scene.chain.joints[i - 1].kind, scene.glyph_positions[i - 1], scene.axis(i), scene.view
    shapes: tuple[Polyline | Circle, ...]
    if kind == PRISMATIC:
        length_to_corner = view.scale * float(np.linalg.norm(scene.bones.corners[i - 1] - position))
        half_length = max(min(SLEEVE_HALF_LENGTH, 0.4 * length_to_corner), 8.0)
        shapes = draw_sleeve(view, position, z, half_length, 9.0 if scene.is_planar else 8.0)
    elif not view.is_end_on(z):
        shapes = draw_cylinder(view, position, z, JOINT_RADIUS, JOINT_HALF_LENGTH)
    else:  # a dot if the axis comes out of the page, a cross if it goes into it
        center = view.to_pixels(position)
        comes_out = view.component_toward_reader(z) > 0
        mark = (Circle(center, 2.4, "dot"),) if comes_out else make_cross(center, 0.7071 * JOINT_RADIUS, "mark")
        shapes = (Circle(center, JOINT_RADIUS, "joint-face"), *mark)
    return Drawing((Glyph(i, kind, shapes),))


def draw_ground(scene: Scene) -> Drawing:
    """Return the hatched ground that carries the base: a line in a flat drawing, a plate in space."""
    view, frame = scene.view, scene.bones.frames[0]
    x, y, z, origin = frame[:3].T
    if view.is_end_on(z):  # a pedestal
        middle = origin - 24 / view.scale * y
        foot = [origin, middle - 13 / view.scale * x, middle + 13 / view.scale * x]
        pedestal = Polyline(view.path_in_pixels(foot), "pedestal", True)
        return Drawing((pedestal, *_draw_hatched_line(view, middle, x, -y)))
    half_height = JOINT_HALF_LENGTH if scene.chain.joints[0].is_revolute else SLEEVE_HALF_LENGTH
    ground_level = min(float((scene.glyph_positions[0] - origin) @ z) * view.scale, 0.0) - half_height
    middle, size = origin + ground_level / view.scale * z, 28.0 / view.scale
    if scene.is_planar:
        return Drawing(_draw_hatched_line(view, middle, x if view.lies_flat(x) else y, -z))
    corners = [middle + size * (a * x + b * y) for a, b in ((1, 1), (-1, 1), (-1, -1), (1, -1))]
    shapes: list[Shape] = [Polyline(view.path_in_pixels(corners), "plate", True)]
    for k in np.linspace(-1.5, 1.5, 9):  # the lines a + b = k of the square
        ends = [(min(1.0, k + 1), max(-1.0, k - 1)), (max(-1.0, k - 1), min(1.0, k + 1))]
        shapes.append(Polyline(view.path_in_pixels([middle + size * (a * x + b * y) for a, b in ends]), "hatch"))
    return Drawing(tuple(shapes))


def _draw_hatched_line(view: View, middle: np.ndarray, x: np.ndarray, down: np.ndarray) -> tuple[Shape, ...]:
    """Return a line along x with hatching below it."""
    unit = 1.0 / view.scale
    ticks = [
        Polyline(view.path_in_pixels([middle + unit * k * x, middle + unit * (8 * down + (k - 8) * x)]), "hatch")
        for k in range(-24, 31, 9)
    ]
    return (*ticks, Polyline(view.path_in_pixels([middle - unit * 30 * x, middle + unit * 30 * x]), "ground"))


def draw_joint_variable(scene: Scene, i: int) -> Drawing:
    """Return the arc of theta_i or the dimension line of d_i; nothing for an arm that is described by its axes."""
    if scene.convention.is_drawn_at_home:  # without x axes, no angle is shown
        return Drawing()
    return _draw_joint_angle(scene, i) if scene.chain.joints[i - 1].is_revolute else _draw_joint_length(scene, i)


def _draw_joint_angle(scene: Scene, i: int) -> Drawing:
    """Return the arc of theta_i from x_{i-1} to x_i about z_{i-1}, with dashed lines for axes that are not drawn."""
    row, bones, view = scene.chain.joints[i - 1], scene.bones, scene.view
    angle = float(np.arctan2(np.sin(bones.entries[i - 1]), np.cos(bones.entries[i - 1])))
    x, y, center = bones.frames[i - 1, :3, 0], bones.frames[i - 1, :3, 1], scene.glyph_positions[i - 1]
    directions = []
    is_apart = bool(np.linalg.norm(center - bones.origins[i - 1]) > 1e-9)
    if is_apart or i - 1 in scene.frames_without_x or scene.convention.is_proximal:
        directions.append(x)
    if np.linalg.norm(bones.corners[i - 1] - center) > 1e-9 or row.a == 0:
        directions.append(unit_vector_at(x, y, angle))
    radius = ARC_RADIUS[scene.is_planar] + (5.0 if i == 1 and not scene.is_planar else 0.0)
    ends = [center + direction * (radius + 14) / view.scale for direction in directions]
    dashed = tuple(Polyline(view.path_in_pixels([center, end]), "dashed") for end in ends)
    label = joint_lettering(scene.chain.q[i - 1], scene.chain.offsets[i - 1], is_angle=True)
    return draw_arc(view, center, (x, y), angle, radius, label) + Drawing(dashed)


def draw_arc(
    view: View, center: np.ndarray, xy: tuple[np.ndarray, np.ndarray], angle: float, radius: float, pieces: Lettering
) -> Drawing:
    """Return an arc with an arrowhead from x towards y (sizes in pixels), with its label outside."""
    count = max(8, int(abs(angle) * 12 + 1e-6))
    arc_angles = angle * np.arange(count + 1)[:, None] / count
    points = view.path_in_pixels(center + unit_vector_at(*xy, arc_angles) * radius / view.scale)
    outward = [unit_vector_at(*xy, share * angle) for share in (0.5, 0.35, 0.65, 0.2, 0.8)]
    spots = view.path_in_pixels([center + vector * radius / view.scale for vector in outward])
    anchors = tuple(zip(spots, map(view.drawn_direction, outward), strict=True))
    further_points = points[:: max(1, count // 8)]
    request = LabelRequest(pieces, anchors, "angle", gap=4.0, kind="angle", further_points=further_points)
    return Drawing(draw_line_with_arrowhead(points, "arc", 7.0), (request,))


def _draw_joint_length(scene: Scene, i: int) -> Drawing:
    """Return the dimension line of d_i of a prismatic joint, from O_{i-1} along z_{i-1}."""
    start, end = scene.bones.origins[i - 1], scene.bones.corners[i - 1]
    is_glyph_apart = np.linalg.norm(scene.glyph_positions[i - 1] - start) > 1e-9
    distance = ARC_RADIUS[scene.is_planar] + 9.0 if is_glyph_apart else 23.0  # another joint's arc may be at O_{i-1}
    label = joint_lettering(scene.chain.q[i - 1], scene.chain.offsets[i - 1], is_angle=False)
    return draw_dimension(scene, start, end, label, distance)


def draw_dimension(scene: Scene, start: np.ndarray, end: np.ndarray, label: Lettering, distance: float) -> Drawing:
    """Return a dimension line for two points (3, m), `distance` pixels from them, on the side away from the arm."""
    view, side = scene.view, _find_free_side(scene, start, end) / scene.view.scale
    first, second = view.path_in_pixels([point + side * distance for point in (start, end)])
    middle = ((first[0] + second[0]) / 2, (first[1] + second[1]) / 2)
    ends = [[point + side * 6.0, point + side * (distance + 5.0)] for point in (start, end)]
    lines = tuple(Polyline(view.path_in_pixels(pair), "extension") for pair in ends)
    arrows = [arrow for end in (first, second) for arrow in draw_line_with_arrowhead((middle, end), "dimension", 7.0)]
    anchors = tuple((spot, view.drawn_direction(side)) for spot, _ in anchors_beside(first, second)[::2])
    return Drawing((*lines, *arrows), (LabelRequest(label, anchors, gap=4.0),))


def _find_free_side(scene: Scene, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Return the unit vector perpendicular to a line, in the plane of the drawing, that points away from the arm."""
    toward_reader = scene.view.axes[2]
    side = np.cross(toward_reader, end - start)
    if np.linalg.norm(side) < 1e-9:
        side = perpendicular_vectors(toward_reader)[0]
    side = side / np.linalg.norm(side)
    middle = np.mean(np.vstack([scene.bones.origins, scene.bones.corners]), axis=0)
    return np.asarray(-side if float(side @ (middle - start)) > 1e-9 else side)


# --- the arm without frames and lettering ---


def draw_links_and_joints(scene: Scene) -> Drawing:
    """Return the ground, links and joints from back to front, with the links' lengths as labels."""
    chain, bones, view = scene.chain, scene.bones, scene.view
    is_ground_in_front = not scene.is_planar and view.component_toward_reader(bones.frames[0, :3, 2]) < -1e-9
    drawing = Drawing() if is_ground_in_front else draw_ground(scene)
    for i in range(1, chain.n + 1):
        along = view.component_toward_reader(bones.corners[i - 1] - bones.origins[i - 1])
        joint, link = draw_joint(scene, i), draw_link(scene, i)
        drawing += joint + link if along > 1e-9 and chain.joints[i - 1].is_revolute else link + joint
        if i == chain.point.frame:
            drawing += draw_path_to_point(scene)
        if i == 1 and is_ground_in_front:
            drawing += draw_ground(scene)
    return drawing


def fit_drawing(
    chain: Chain,
    bones: Skeleton,
    draw: Callable[[View], Drawing],
    max_arm_size: Vector2D,
    size: Vector2D,
    margin: Vector2D,
    axes: np.ndarray | None = None,
) -> tuple[Drawing, View]:
    """Return a drawing that fits into `size` less `margin` on each side, and its view.

    The skeleton takes at most `max_arm_size`. `axes` are the view's directions right, up and towards the reader (rows),
    if it is not the usual view.
    """
    view = _initial_view(chain, bones, max_arm_size, choose_view(chain) if axes is None else axes)
    for _ in range(3):
        drawing = draw(view)
        low, high = find_bounding_box(drawing.shapes)
        offset = (size[0] / 2 - (low[0] + high[0]) / 2, size[1] / 2 - (low[1] + high[1]) / 2)
        shift = (offset[0] + view.shift[0], offset[1] + view.shift[1])
        scale_factor = min((size[k] - 2 * margin[k]) / max(high[k] - low[k], 1e-9) for k in range(2))
        if scale_factor >= 0.999:
            return drawing.shift(offset), View(view.axes, view.scale, shift)
        view = View(view.axes, view.scale * scale_factor, shift)
    return draw(view), view


def _initial_view(chain: Chain, bones: Skeleton, max_arm_size: Vector2D, axes: np.ndarray) -> View:
    """Return the view in which the skeleton, with the world's origin if it is shown, fills `max_arm_size`."""
    points = [*bones.origins, *bones.corners, *bones.path]
    if not chain.base.is_world:
        points.append(np.zeros(3))
    spread = np.ptp(np.array(points) @ axes[:2].T, axis=0)
    return View(axes, float(np.min(np.array(max_arm_size) / np.maximum(spread, 1e-3))))


def find_bounding_box(shapes: tuple[Shape, ...]) -> tuple[Vector2D, Vector2D]:
    """Return two corners of the bounding box of shapes: the smallest and the largest coordinates."""
    points: list[Vector2D] = []
    for outline in list_outlines(shapes):
        if isinstance(outline, Circle):
            (x, y), r = outline.center, outline.radius
            points += [(x - r, y - r), (x + r, y + r)]
        else:
            points += outline.points
    x_values, y_values = [x for x, _ in points], [y for _, y in points]
    return (min(x_values), min(y_values)), (max(x_values), max(y_values))
