"""Draw the parts of an arm: links, joints, ground, joint angles and lengths of prismatic joints.

Joint i rotates about z_{i-1} or moves along z_{i-1}. The glyph of a joint is its symbol, a cylinder or a sleeve. Each
glyph lies on the joint's axis, at a distance from the other glyphs.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from qdot.exercises.arm.chain import PRISMATIC, Chain
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.arm.conventions.base import Convention
from qdot.exercises.arm.vectors import find_perpendicular_vectors
from qdot.exercises.figure.lettering import Lettering, write_joint_variable, write_length
from qdot.exercises.figure.places import LabelRequest
from qdot.exercises.figure.plane import choose_view, is_drawn_flat
from qdot.exercises.figure.pose import Skeleton, compute_table_entries
from qdot.exercises.figure.shapes import Circle, Glyph, Polyline, Shape, Vector2D, list_outlines, make_cross
from qdot.exercises.figure.view import (
    Drawing,
    View,
    compute_unit_vector,
    draw_cylinder,
    draw_line_with_arrowhead,
    draw_sleeve,
)

JOINT_RADIUS, JOINT_HALF_LENGTH, SLEEVE_HALF_LENGTH = 9.0, 11.0, 19.0
"""In pixels: the radius of a revolute joint, half its length in space, and half the length of a prismatic joint."""
GLYPH_DISTANCE, GLYPH_DISTANCE_WITHOUT_LINKS = 27.0, 82.0
"""Minimum distance between two glyphs, and distance between two glyphs of an arm without links, in pixels."""
WRIST_JOINTS = 3
"""Number of joints of a wrist. If no more than this many frames share an origin, their axes can be distinguished."""
SLEEVE_HALF_WIDTH = {True: 9.0, False: 8.0}
"""Half the width of a prismatic joint in pixels, in a flat drawing (True) and in space."""
PEDESTAL_HEIGHT, PEDESTAL_HALF_WIDTH, PLATE_HALF_SIZE = 24.0, 13.0, 28.0
"""Sizes in pixels of the two kinds of ground: a pedestal below an axis seen end-on, and a plate in space."""
ARC_RADIUS = {True: 31.0, False: 34.0}
"""Radius in pixels of the arc of a joint angle, in a flat drawing (True) and in space."""


@dataclass(frozen=True)
class Scene:
    """An arm, its skeleton in the drawn pose, the view, and the positions of the joints' glyphs (n x 3).

    `frames` are the link frames by the arm's convention (n+1 x 4 x 4). `frames_without_x` lists the frames that are
    drawn without x axis, because too many axes start at one point. `is_flat` says whether the arm is drawn flat. If
    `is_sparse`, the drawing has only the arm, its origins, its z axes, and its first and last frame. If `is_home`, all
    joint variables are zero.
    """

    chain: Chain
    skeleton: Skeleton
    view: View
    glyph_positions: tuple[np.ndarray, ...]
    frames_without_x: frozenset[int]
    is_flat: bool
    frames: np.ndarray
    is_sparse: bool = False
    is_home: bool = False

    @property
    def convention(self) -> Convention:
        """The convention that describes the arm."""
        return convention_of(self.chain)

    @property
    def shown_world_axes(self) -> list[int]:
        """The indices (0 for x) of the world's axes that can be drawn: in a flat drawing, only the two in its plane."""
        return [k for k in range(3) if not self.is_flat or self.view.lies_flat(np.eye(3)[k])]

    def find_axis(self, i: int) -> np.ndarray:
        """Return z_{i-1}, the axis of joint i."""
        return np.asarray(self.skeleton.frames[i - 1, :3, 2])

    def is_glyph_beside_link(self, i: int) -> bool:
        """Return whether the glyph of joint i is neither on the link along the joint's axis nor at the origin."""
        start, axis = self.skeleton.origins[i - 1], self.find_axis(i)
        distance_along_axis = float((self.glyph_positions[i - 1] - start) @ axis)
        link = self.skeleton.corners[i - 1] - start
        fraction = distance_along_axis / float(link @ axis) if _has_link_along_axis(self.skeleton, i - 1) else np.inf
        return abs(distance_along_axis) > 1e-9 and not 0.0 <= fraction <= 1.0


def make_scene(chain: Chain, skeleton: Skeleton, view: View, is_sparse: bool = False) -> Scene:
    """Return the scene, with the glyphs at positions where none covers another."""
    positions: dict[int, np.ndarray] = {}
    for i in sorted(range(chain.n), key=lambda i: _has_link_along_axis(skeleton, i) and i > 0):
        positions[i] = _find_free_position(skeleton, view, i, list(positions.values()))
    glyph_positions = tuple(positions[i] for i in range(chain.n))
    is_flat, frames = is_drawn_flat(chain), compute_convention_frames(chain, skeleton)
    has_small_wrist = convention_of(chain).is_proximal and chain.n <= WRIST_JOINTS  # all its x axes are drawn
    frames_without_x = frozenset[int]() if is_flat or has_small_wrist else _list_crowded_frames(frames[:, :3, 3])
    if is_sparse:
        frames_without_x = frozenset(range(1, chain.n))
    home = compute_table_entries(chain, {q.name: 0.0 for q in chain.q})
    is_home = bool(np.allclose(skeleton.entries, home, atol=1e-9))
    return Scene(chain, skeleton, view, glyph_positions, frames_without_x, is_flat, frames, is_sparse, is_home)


def compute_convention_frames(chain: Chain, skeleton: Skeleton) -> np.ndarray:
    """Return the link frames of an arm by its convention (n+1 x 4 x 4)."""
    convention = convention_of(chain)
    base_origin = np.zeros(3) if convention.base.is_world else skeleton.origins[0]  # drawn base
    return convention.convert_standard_frames(skeleton.frames, skeleton.corners, base_origin)


def _has_link_along_axis(skeleton: Skeleton, i: int) -> bool:
    """Return whether a link runs along the axis of joint i + 1, so that its glyph can be moved along the link."""
    return bool(np.linalg.norm(skeleton.corners[i] - skeleton.origins[i]) > 1e-6)


def _list_crowded_frames(origins: np.ndarray) -> frozenset[int]:
    """Return the frames that share their origin with two or more frames, except the arm's first and last frame."""
    distances = np.linalg.norm(origins[:, None] - origins[None], axis=2)
    is_crowded = np.sum(distances < 1e-6, axis=1) > 2
    return frozenset(i for i in range(1, len(origins) - 1) if is_crowded[i])


def _find_free_position(skeleton: Skeleton, view: View, i: int, taken_positions: list[np.ndarray]) -> np.ndarray:
    """Return a position (3) on the axis of joint i + 1 where the joint's glyph covers no other glyph.

    If there is no such position, return the first candidate.
    """
    origin, z = skeleton.origins[i], skeleton.frames[i, :3, 2]
    link = skeleton.corners[i] - origin
    candidates = [origin + fraction * link for fraction in (0.0, 0.45, 0.6, 0.3)]
    if not view.is_end_on(z):
        if i == 0 and _have_same_origin(skeleton):
            candidates = []  # the shared origin is left to joint 2
        distance, steps = GLYPH_DISTANCE, ([-1.0, 1.0, -2.0, 2.0] if i == 0 else [1.0, -1.0, 2.0, -2.0])
        if has_no_links(skeleton) and not _has_link_along_axis(skeleton, i):
            distance, steps = GLYPH_DISTANCE_WITHOUT_LINKS, (steps if i == 0 else [1.0, 0.5, -1.0, -0.5, 2.0])
        candidates += [origin + step * distance / view.scale * z for step in steps]
    for candidate in candidates:
        pixel = view.to_pixels(candidate)
        # three pixels less, because an axis may be drawn a little shortened
        if all(math.dist(pixel, view.to_pixels(position)) >= GLYPH_DISTANCE - 3 for position in taken_positions):
            return np.asarray(candidate)
    return np.asarray(candidates[0])


def has_no_links(skeleton: Skeleton) -> bool:
    """Return whether the arm has no links, like a wrist."""
    return bool(np.ptp(np.vstack([skeleton.origins, skeleton.corners, skeleton.path]), axis=0).max() < 1e-6)


def _have_same_origin(skeleton: Skeleton) -> bool:
    """Return whether the axes of joints 1 and 2 start at the same origin, and no link runs along them."""
    if len(skeleton.corners) < 2 or _has_link_along_axis(skeleton, 0) or _has_link_along_axis(skeleton, 1):
        return False
    return bool(np.linalg.norm(skeleton.origins[1] - skeleton.origins[0]) < 1e-6)


def draw_link(scene: Scene, i: int) -> Drawing:
    """Return the drawing of link i: bars, labelled with the link's lengths."""
    skeleton, view, joint, glyph = scene.skeleton, scene.view, scene.chain.joints[i - 1], scene.glyph_positions[i - 1]
    start, corner, end = skeleton.origins[i - 1], skeleton.corners[i - 1], skeleton.origins[i]
    bars = [([glyph, start], "link")] if scene.is_glyph_beside_link(i) else []
    labels = _label_length(view, corner, end, write_length(joint.a))
    if joint.is_prismatic:
        bars += [([glyph, corner], "rod"), ([start, glyph], "link"), ([corner, end], "link")]
    else:
        bars.append(([start, corner, end], "link"))
        labels = _label_length(view, start, corner, write_length(joint.d)) + labels
    return Drawing(tuple(shape for points, style in bars for shape in _draw_bar(view, points, style)), tuple(labels))


def draw_path_to_point(scene: Scene) -> Drawing:
    """Return the bar from the origin of P's frame to P, labelled with its lengths."""
    path = scene.skeleton.path
    labels: list[LabelRequest] = []
    for (start, end), value in zip(pairwise(path), scene.chain.point.offset, strict=True):
        labels += _label_length(scene.view, start, end, write_length(value))
    return Drawing(_draw_bar(scene.view, list(path), "link"), tuple(labels))


def _draw_bar(view: View, points: list[np.ndarray], style: str) -> tuple[Shape, ...]:
    """Return a bar along points (3-vectors in m), drawn as an outline and a filling; nothing if all points coincide."""
    later_points = (end for start, end in pairwise(points) if np.linalg.norm(end - start) > 1e-9)
    distinct_points = [points[0], *later_points]
    if len(distinct_points) < 2:
        return ()
    line = view.to_pixel_path(distinct_points)
    return (Polyline(line, style), Polyline(line, f"{style}-inside"))


def _label_length(view: View, start: np.ndarray, end: np.ndarray, lettering: Lettering) -> list[LabelRequest]:
    """Return the label of a straight segment, which can be placed on either side; no label for a zero length."""
    if np.linalg.norm(end - start) < 1e-9:
        return []
    return [LabelRequest(lettering, list_anchors_beside(*view.to_pixel_path([start, end])), gap=8.0, rank=1)]


def list_anchors_beside(start: Vector2D, end: Vector2D) -> tuple[tuple[Vector2D, Vector2D], ...]:
    """Return anchors (see `LabelRequest`) along a drawn line: points with a direction to each side of the line."""
    dx, dy = end[0] - start[0], end[1] - start[1]
    size = max(math.hypot(dx, dy), 1e-9)
    first_side = (dy / size, -dx / size)
    second_side = (-first_side[0], -first_side[1])
    if (round(first_side[1], 3), round(first_side[0], 3)) > (0.0, 0.0):
        first_side, second_side = second_side, first_side
    points = [(start[0] + fraction * dx, start[1] + fraction * dy) for fraction in (0.5, 0.65, 0.35, 0.8, 0.2)]
    return tuple((point, side) for point in points for side in (first_side, second_side))


def draw_joint(scene: Scene, i: int) -> Drawing:
    """Return the glyph of joint i."""
    kind, view = scene.chain.joints[i - 1].kind, scene.view
    position, z = scene.glyph_positions[i - 1], scene.find_axis(i)
    shapes: tuple[Polyline | Circle, ...]
    if kind == PRISMATIC:
        length_to_corner = view.scale * float(np.linalg.norm(scene.skeleton.corners[i - 1] - position))
        half_length = max(min(SLEEVE_HALF_LENGTH, 0.4 * length_to_corner), 8.0)  # short enough to show the rod
        shapes = draw_sleeve(view, position, z, half_length, SLEEVE_HALF_WIDTH[scene.is_flat])
    elif not view.is_end_on(z):
        shapes = draw_cylinder(view, position, z, JOINT_RADIUS, JOINT_HALF_LENGTH)
    else:  # a dot if the axis comes out of the page, a cross if it goes into it
        center = view.to_pixels(position)
        comes_out = view.measure_toward_reader(z) > 0
        mark = (Circle(center, 2.4, "dot"),) if comes_out else make_cross(center, 0.7071 * JOINT_RADIUS, "mark")
        shapes = (Circle(center, JOINT_RADIUS, "joint-face"), *mark)
    return Drawing((Glyph(i, kind, shapes),))


def draw_ground(scene: Scene) -> Drawing:
    """Return the hatched ground that carries the base: a line in a flat drawing, a plate in space.

    If the axis of joint 1 is seen end-on, the arm stands on a pedestal.
    """
    view, frame = scene.view, scene.skeleton.frames[0]
    x, y, z, origin = frame[:3].T
    if view.is_end_on(z):
        middle, half_width = origin - PEDESTAL_HEIGHT / view.scale * y, PEDESTAL_HALF_WIDTH / view.scale
        foot = [origin, middle - half_width * x, middle + half_width * x]
        pedestal = Polyline(view.to_pixel_path(foot), "pedestal", is_closed=True)
        return Drawing((pedestal, *_draw_hatched_line(view, middle, x, -y)))
    half_height = JOINT_HALF_LENGTH if scene.chain.joints[0].is_revolute else SLEEVE_HALF_LENGTH
    ground_level = min(float((scene.glyph_positions[0] - origin) @ z) * view.scale, 0.0) - half_height
    middle, size = origin + ground_level / view.scale * z, PLATE_HALF_SIZE / view.scale
    if scene.is_flat:
        return Drawing(_draw_hatched_line(view, middle, x if view.lies_flat(x) else y, -z))
    corners = [middle + size * (a * x + b * y) for a, b in ((1, 1), (-1, 1), (-1, -1), (1, -1))]
    shapes: list[Shape] = [Polyline(view.to_pixel_path(corners), "plate", is_closed=True)]
    for k in np.linspace(-1.5, 1.5, 9):  # the lines a + b = k of the square
        ends = [(min(1.0, k + 1), max(-1.0, k - 1)), (max(-1.0, k - 1), min(1.0, k + 1))]
        shapes.append(Polyline(view.to_pixel_path([middle + size * (a * x + b * y) for a, b in ends]), "hatch"))
    return Drawing(tuple(shapes))


def _draw_hatched_line(view: View, middle: np.ndarray, x: np.ndarray, down: np.ndarray) -> tuple[Shape, ...]:
    """Return a line along x, 60 pixels long, with hatching 8 pixels below the line."""
    pixel = 1.0 / view.scale  # in metres
    ticks = [
        Polyline(view.to_pixel_path([middle + pixel * k * x, middle + pixel * (8 * down + (k - 8) * x)]), "hatch")
        for k in range(-24, 31, 9)
    ]
    return (*ticks, Polyline(view.to_pixel_path([middle - pixel * 30 * x, middle + pixel * 30 * x]), "ground"))


def draw_joint_variable(scene: Scene, i: int) -> Drawing:
    """Return the arc of theta_i or the dimension line of d_i; an empty drawing for an arm described by its axes."""
    if scene.convention.is_drawn_at_home:  # without x axes, no angle is shown
        return Drawing()
    return _draw_joint_angle(scene, i) if scene.chain.joints[i - 1].is_revolute else _draw_joint_length(scene, i)


def _draw_joint_angle(scene: Scene, i: int) -> Drawing:
    """Return the arc of theta_i from x_{i-1} to x_i about z_{i-1}, with dashed lines for axes that are not drawn."""
    row, skeleton, view = scene.chain.joints[i - 1], scene.skeleton, scene.view
    entry = skeleton.entries[i - 1]
    angle = float(np.arctan2(np.sin(entry), np.cos(entry)))
    x, y, center = skeleton.frames[i - 1, :3, 0], skeleton.frames[i - 1, :3, 1], scene.glyph_positions[i - 1]
    directions = []
    is_apart = bool(np.linalg.norm(center - skeleton.origins[i - 1]) > 1e-9)
    if is_apart or i - 1 in scene.frames_without_x or scene.convention.is_proximal:
        directions.append(x)
    if np.linalg.norm(skeleton.corners[i - 1] - center) > 1e-9 or row.a == 0:
        directions.append(compute_unit_vector(x, y, angle))
    radius = ARC_RADIUS[scene.is_flat] + (5.0 if i == 1 and not scene.is_flat else 0.0)
    ends = [center + direction * (radius + 14) / view.scale for direction in directions]
    dashed_lines = tuple(Polyline(view.to_pixel_path([center, end]), "dashed") for end in ends)
    label = write_joint_variable(scene.chain.q[i - 1], scene.chain.offsets[i - 1], is_angle=True)
    return draw_arc(view, center, (x, y), angle, radius, label) + Drawing(dashed_lines)


def draw_arc(
    view: View, center: np.ndarray, xy: tuple[np.ndarray, np.ndarray], angle: float, radius: float, lettering: Lettering
) -> Drawing:
    """Return an arc with an arrowhead about a centre, and its label outside; the radius is in pixels.

    The arc begins at the first unit vector of `xy` and runs towards the second.
    """
    segment_count = max(8, int(abs(angle) * 12 + 1e-6))
    arc_angles = angle * np.arange(segment_count + 1)[:, None] / segment_count
    points = view.to_pixel_path(center + compute_unit_vector(*xy, arc_angles) * radius / view.scale)
    radial_vectors = [compute_unit_vector(*xy, fraction * angle) for fraction in (0.5, 0.35, 0.65, 0.2, 0.8)]
    arc_points = view.to_pixel_path([center + vector * radius / view.scale for vector in radial_vectors])
    anchors = tuple(zip(arc_points, map(view.to_drawn_direction, radial_vectors), strict=True))
    further_points = points[:: max(1, segment_count // 8)]
    request = LabelRequest(lettering, anchors, "angle", gap=4.0, kind="angle", further_points=further_points)
    return Drawing(draw_line_with_arrowhead(points, "arc", 7.0), (request,))


def _draw_joint_length(scene: Scene, i: int) -> Drawing:
    """Return the dimension line of d_i of a prismatic joint, from O_{i-1} along z_{i-1}."""
    start, end = scene.skeleton.origins[i - 1], scene.skeleton.corners[i - 1]
    is_glyph_apart = np.linalg.norm(scene.glyph_positions[i - 1] - start) > 1e-9
    distance = ARC_RADIUS[scene.is_flat] + 9.0 if is_glyph_apart else 23.0  # another joint's arc may be at O_{i-1}
    label = write_joint_variable(scene.chain.q[i - 1], scene.chain.offsets[i - 1], is_angle=False)
    return draw_dimension(scene, start, end, label, distance)


def draw_dimension(scene: Scene, start: np.ndarray, end: np.ndarray, label: Lettering, distance: float) -> Drawing:
    """Return a dimension line for two points (3-vectors in m), `distance` pixels away on the side without the arm."""
    view, side = scene.view, _find_free_side(scene, start, end) / scene.view.scale
    line = view.to_pixel_path([point + side * distance for point in (start, end)])
    (x0, y0), (x1, y1) = line
    middle = ((x0 + x1) / 2, (y0 + y1) / 2)
    ends = [[point + side * 6.0, point + side * (distance + 5.0)] for point in (start, end)]
    lines = tuple(Polyline(view.to_pixel_path(pair), "extension") for pair in ends)
    arrows = [arrow for line_end in line for arrow in draw_line_with_arrowhead((middle, line_end), "dimension", 7.0)]
    points = dict.fromkeys(point for point, _ in list_anchors_beside(*line))
    anchors = tuple((point, view.to_drawn_direction(side)) for point in points)
    return Drawing((*lines, *arrows), (LabelRequest(label, anchors, gap=4.0),))


def _find_free_side(scene: Scene, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Return the unit vector perpendicular to a line, in the plane of the drawing, that points away from the arm."""
    toward_reader = scene.view.axes[2]
    side = np.cross(toward_reader, end - start)
    if np.linalg.norm(side) < 1e-9:
        side, _ = find_perpendicular_vectors(toward_reader)
    side = side / np.linalg.norm(side)
    middle = np.mean(np.vstack([scene.skeleton.origins, scene.skeleton.corners]), axis=0)
    return np.asarray(-side if float(side @ (middle - start)) > 1e-9 else side)


# --- the arm without frames and joint variables ---


def draw_links_and_joints(scene: Scene) -> Drawing:
    """Return the ground, links and joints from back to front, with the links' lengths as labels."""
    chain, skeleton, view = scene.chain, scene.skeleton, scene.view
    is_ground_in_front = not scene.is_flat and view.measure_toward_reader(skeleton.frames[0, :3, 2]) < -1e-9
    drawing = Drawing() if is_ground_in_front else draw_ground(scene)
    for i in range(1, chain.n + 1):
        depth_change = view.measure_toward_reader(skeleton.corners[i - 1] - skeleton.origins[i - 1])
        joint, link = draw_joint(scene, i), draw_link(scene, i)
        drawing += joint + link if depth_change > 1e-9 and chain.joints[i - 1].is_revolute else link + joint
        if i == chain.point.frame:
            drawing += draw_path_to_point(scene)
        if i == 1 and is_ground_in_front:
            drawing += draw_ground(scene)
    return drawing


def fit_drawing(
    chain: Chain,
    skeleton: Skeleton,
    draw: Callable[[View], Drawing],
    max_arm_size: Vector2D,
    size: Vector2D,
    margin: Vector2D,
    axes: np.ndarray | None = None,
) -> tuple[Drawing, View]:
    """Return a drawing that fits into `size` minus `margin` on each side, and its view; sizes are in pixels.

    The skeleton takes at most `max_arm_size`. `axes` are the view's directions right, up and towards the reader (rows).
    Without `axes`, the arm's usual view is used.
    """
    view = _scale_view(chain, skeleton, max_arm_size, choose_view(chain) if axes is None else axes)
    for _ in range(3):  # several times, because joints and arrows do not shrink with the arm
        (left, top), (right, bottom) = find_bounding_box(draw(view).shapes)
        shift = (size[0] / 2 - (left + right) / 2 + view.shift[0], size[1] / 2 - (top + bottom) / 2 + view.shift[1])
        width_factor = (size[0] - 2 * margin[0]) / max(right - left, 1e-9)
        scale_factor = min(width_factor, (size[1] - 2 * margin[1]) / max(bottom - top, 1e-9))
        if scale_factor >= 0.999:
            view = View(view.axes, view.scale, shift)
            break
        view = View(view.axes, view.scale * scale_factor, shift)
    return draw(view), view


def _scale_view(chain: Chain, skeleton: Skeleton, max_arm_size: Vector2D, axes: np.ndarray) -> View:
    """Return the view in which the skeleton, with the world's origin if it is shown, fills `max_arm_size`."""
    points = [*skeleton.origins, *skeleton.corners, *skeleton.path]
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
    x_values, y_values = zip(*points, strict=True)
    return (min(x_values), min(y_values)), (max(x_values), max(y_values))
