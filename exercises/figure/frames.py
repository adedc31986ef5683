"""Draw the frames of an arm: axes, origins, the world frame with the base's position in it, and the point P."""

import math
from itertools import combinations, compress, product

import numpy as np
import sympy as sp

from qdot.exercises.figure.arm_parts import Scene, draw_arc, draw_dimension, has_no_links, list_anchors_beside
from qdot.exercises.figure.lettering import (
    Lettering,
    write_length,
    write_sign_and_size,
    write_upright,
    write_with_index,
)
from qdot.exercises.figure.places import LabelRequest, make_anchors
from qdot.exercises.figure.shapes import Circle, Polyline, Shape, Vector2D
from qdot.exercises.figure.view import Drawing, View, draw_arrow

AXIS_LENGTH = {True: 52.0, False: 54.0}
"""Length of a frame's axis in a flat drawing and in space, in pixels."""
BODY_AXIS_LENGTH = 44.0
"""Length in pixels of the axes of the body frame; shorter than those of the space frame, which may coincide with
them."""
LONG_AXIS_LENGTH = 96.0
"""Length of an axis of an arm without links, in pixels."""
AXIS_NAMES = "xyz"
MIN_ORIGIN_DISTANCE, MIN_AXIS_DISTANCE, MAX_CROWDING_COST = 34.0, 12.0, 120.0
"""Minimum distances in pixels between two origins, and between an origin and an axis of the world; maximum cost.

The cost is highest for a distance of zero, and falls linearly to 0 at the minimum distance.
"""


def draw_axes(scene: Scene) -> Drawing:
    """Return the axes of frames 0 ... n. Axes that coincide are drawn once, with all their names.

    If the convention has no frames on the links, only the joint axes are drawn.
    """
    convention, view, is_flat = scene.convention, scene.view, scene.is_flat
    if not convention.frame_numbers:
        return _draw_joint_axes(scene)
    length = LONG_AXIS_LENGTH if has_no_links(scene.skeleton) else AXIS_LENGTH[is_flat]
    axes_by_position: dict[tuple[int, ...], tuple[tuple[np.ndarray, np.ndarray, str], Lettering]] = {}
    for (i, frame), (k, name) in product(enumerate(scene.frames), enumerate(AXIS_NAMES)):
        axis, origin = frame[:3, k], frame[:3, 3]
        # in space, the only y axis that is drawn is that of a base frame that is the world frame
        is_shown = view.lies_flat(axis) if is_flat else name != "y" or (i == 0 and convention.base.is_world)
        if not is_shown or (i in scene.frames_without_x and (name == "x" or (name == "y" and scene.is_sparse))):
            continue
        # axes coincide if they differ by less than about two pixels in origin and 0.1 in direction
        key = tuple(map(round, (*(origin * view.scale / 2).tolist(), *(axis * 10).tolist())))
        axis_to_draw, names = axes_by_position.get(key, ((origin, axis, name), ()))
        comma = write_upright(", ") if names else ()
        axes_by_position[key] = axis_to_draw, (*names, *comma, *write_with_index(name, str(i)))
    axes = axes_by_position.values()
    return sum((_draw_axis(view, *axis_to_draw, names, length) for axis_to_draw, names in axes), Drawing())


def _draw_joint_axes(scene: Scene) -> Drawing:
    """Return the direction of every joint at its glyph: an arrow, or only its name if it is seen end-on.

    The name has a prime if the arm is not at home.
    """
    view, drawing = scene.view, Drawing()
    prime = () if scene.is_home else write_upright("′")
    for i, joint in enumerate(scene.chain.joints, 1):
        name = (*write_with_index("ω" if joint.is_revolute else "v", str(i)), *prime)
        axis, position = scene.find_axis(i), scene.glyph_positions[i - 1]
        if not view.is_end_on(axis):
            drawing += _draw_axis(view, position, axis, "z", name, AXIS_LENGTH[scene.is_flat])
            continue
        anchors = make_anchors(view.to_pixels(position), (0.7, -0.7), (-0.7, -0.7), (0.7, 0.7), (-0.7, 0.7))
        drawing += Drawing((), (LabelRequest(name, anchors, "z", gap=13.0, rank=2, kind="axis"),))
    return drawing


def _draw_axis(
    view: View, origin: np.ndarray, axis: np.ndarray, name: str, lettering: Lettering, length: float
) -> Drawing:
    """Return an axis as an arrow of `length` pixels with a label; `name` selects the style of the axis."""
    end = origin + axis * length / view.scale
    tip_points = view.to_pixel_path([origin + fraction * (end - origin) for fraction in (0.85, 0.7, 0.55)])
    anchors = make_anchors(view.to_pixels(end), view.to_drawn_direction(axis))
    request = LabelRequest(lettering, anchors, name, gap=3.0, rank=2, kind="axis", further_points=tip_points)
    return Drawing(draw_arrow(view, origin, end, f"axis-{name}"), (request,))


def draw_body_frame(scene: Scene) -> Drawing:
    """Return the axes of the body frame {b} at P, for an arm that is described by its axes and drawn at home.

    At home, {b} is parallel to the space frame {s}. In another configuration, or if P is not on the last link, {b} is
    not drawn. If P is at the world's origin, the axes of {s} have the names of {b}'s axes, too.
    """
    if not has_body_frame(scene) or _is_point_at_world_origin(scene):
        return Drawing()
    drawing = Drawing()
    for k in scene.shown_world_axes:
        letters = write_with_index(AXIS_NAMES[k], "b")
        drawing += _draw_axis(scene.view, scene.skeleton.path[-1], np.eye(3)[k], "w", letters, BODY_AXIS_LENGTH)
    return drawing


def has_body_frame(scene: Scene) -> bool:
    """Return whether the body frame is drawn or named: at home, if P is on the last link."""
    return scene.convention.is_drawn_at_home and scene.is_home and scene.chain.point.frame == scene.chain.n


def _is_point_at_world_origin(scene: Scene) -> bool:
    """Return whether P is drawn at the world's origin."""
    return float(np.linalg.norm(scene.skeleton.path[-1])) * scene.view.scale < 1.0


def draw_origins(scene: Scene) -> Drawing:
    """Return the names of the origins O_0 ... O_n and of P; coincident points share a label."""
    view, point = scene.view, scene.skeleton.path[-1]
    body_name = write_upright(", {b}") if has_body_frame(scene) else ()
    named_points = [(point, (*write_with_index("P"), *body_name))]
    named_points += [(scene.frames[i, :3, 3], write_with_index("O", str(i))) for i in scene.convention.frame_numbers]
    labelled_points: list[tuple[np.ndarray, Lettering]] = []
    for position, lettering in named_points:
        for k, (earlier_position, earlier_lettering) in enumerate(labelled_points):
            if np.linalg.norm(position - earlier_position) * view.scale < 1.0:
                labelled_points[k] = (earlier_position, (*earlier_lettering, *write_upright(" = "), *lettering))
                break
        else:
            labelled_points.append((position, lettering))
    requests = []
    for number, (position, lettering) in enumerate(labelled_points):
        anchors = make_anchors(view.to_pixels(position), (0.6, 0.8), (-0.6, 0.8), (0.7, -0.7), (-0.7, -0.7))
        requests.append(LabelRequest(lettering, anchors, gap=11.0, rank=1 if number == 0 else 3, kind="origin"))
    return Drawing((Circle(view.to_pixels(point), 4.6, "point"),), tuple(requests))


def compute_crowding_costs(scene: Scene) -> tuple[float, float]:
    """Return two costs for origins that are drawn too close together; a cost is 0 if none are too close.

    The first cost is for origins of the arm that are close to each other. The second cost is for origins of the arm
    that are close to the world's origin or axes. It is 0 if the base is at the world's origin.
    """
    view = scene.view
    points = [view.to_pixels(origin) for origin in _list_distinct_origins(scene)]
    arm_cost = sum(_compute_closeness_cost(math.dist(p, q), MIN_ORIGIN_DISTANCE) for p, q in combinations(points, 2))
    if not any(scene.convention.base.position):
        return arm_cost, 0.0
    world_origin = view.to_pixels(np.zeros(3))
    distances_to_axes = []
    for axis in scene.shown_world_axes:
        end = view.to_pixels(AXIS_LENGTH[scene.is_flat] / view.scale * np.eye(3)[axis])
        distances_to_axes += [_compute_distance_to_segment(point, world_origin, end) for point in points]
    axis_cost = sum(_compute_closeness_cost(distance, MIN_AXIS_DISTANCE) for distance in distances_to_axes)
    origin_cost = sum(_compute_closeness_cost(math.dist(point, world_origin), MIN_ORIGIN_DISTANCE) for point in points)
    return arm_cost, axis_cost + origin_cost


def _compute_closeness_cost(distance: float, min_distance: float) -> float:
    return MAX_CROWDING_COST * max(0.0, 1.0 - distance / min_distance)


def _compute_distance_to_segment(point: Vector2D, start: Vector2D, end: Vector2D) -> float:
    (x, y), (u, v) = (point[0] - start[0], point[1] - start[1]), (end[0] - start[0], end[1] - start[1])
    fraction = min(max((x * u + y * v) / (u * u + v * v), 0.0), 1.0)
    return math.hypot(x - fraction * u, y - fraction * v)


def _list_distinct_origins(scene: Scene) -> list[np.ndarray]:
    """Return the distinct origins of the arm's frames according to the table, as 3-vectors in m."""
    rows, origins = scene.convention.rows, scene.frames[:, :3, 3]
    is_distinct = [True, *(row.is_prismatic or row.a != 0 or row.d != 0 for row in rows)]
    return list(compress(origins, is_distinct))


def draw_end_on_z_names(scene: Scene) -> Drawing:
    """Return the names of the z axes that are seen end-on in a flat drawing, unless all z axes face the reader."""
    view, n = scene.view, scene.chain.n
    signs = [view.measure_toward_reader(frame[:3, 2]) for frame in scene.frames]
    if not scene.is_flat or min(signs) > 0.9 or not scene.convention.frame_numbers:
        return Drawing()
    labels, first_frame = [], scene.convention.find_frame_on_axis(1)
    are_all_end_on = min(map(abs, signs)) > 0.9
    last_frame = first_frame + n - 1 if are_all_end_on else n  # if all are end-on, only the joint axes are named
    for i in range(first_frame, last_frame + 1):
        if abs(signs[i]) > 0.9:
            pixel = view.to_pixels(scene.frames[i, :3, 3])
            anchors = make_anchors(pixel, (-0.7, -0.7), (0.7, 0.7), (-0.7, 0.7), (0.7, -0.7))
            labels.append(LabelRequest(write_with_index("z", str(i)), anchors, "z", gap=11.0, rank=2, kind="axis"))
    return Drawing((), tuple(labels))


def draw_world(scene: Scene) -> Drawing:
    """Return the world frame, the base's position as dashed lines, and the base's yaw.

    If the base is the world frame, draw only the length a_0, which only a modified table can have.
    """
    view, convention = scene.view, scene.convention
    base, name = convention.base, convention.fixed_frame
    if base.is_world and convention.frame_numbers:
        _, length = convention.find_step_to_standard_frame(0)
        ends = scene.frames[0, :3, 3], scene.skeleton.origins[0]
        return Drawing() if length == 0 else _draw_position_line(scene, *ends, length)
    origin, corner, base_origin = np.zeros(3), np.zeros(3), scene.frames[0, :3, 3]
    is_apart = float(np.linalg.norm(base_origin)) * view.scale > 1.0
    # at the same origin, the world's axes are longer than those of frame 0, so that they can be distinguished
    axis_length = AXIS_LENGTH[scene.is_flat] + (0.0 if is_apart else 18.0)
    carries_body_names = has_body_frame(scene) and _is_point_at_world_origin(scene)
    drawing = Drawing()
    for k in scene.shown_world_axes:
        axis, length, letters = np.eye(3)[k], base.position[k], write_with_index(AXIS_NAMES[k], name)
        if carries_body_names:
            letters = (*letters, *write_upright(", "), *write_with_index(AXIS_NAMES[k], "b"))
        drawing += _draw_axis(view, origin, axis, "w", letters, axis_length)
        end = corner + axis * base_origin[k]
        if length != 0 and not scene.is_sparse and _is_along_first_link(scene, k):
            drawing += draw_dimension(scene, corner, end, write_length(length), 46.0)
        elif length != 0:
            drawing += _draw_position_line(scene, corner, end, length)
        corner = end
    if is_apart:
        anchors = make_anchors(view.to_pixels(origin), (-0.7, 0.7), (0.7, 0.7))
        drawing += Drawing((), (LabelRequest(write_with_index("O", name), anchors, gap=6.0, rank=3, kind="origin"),))
    return drawing + _draw_base_yaw(scene, is_apart) if convention.frame_numbers else drawing


def _draw_position_line(scene: Scene, start: np.ndarray, end: np.ndarray, length: sp.Expr) -> Drawing:
    """Return a dashed line between two points (3-vectors in m).

    The line is labelled with its length unless the drawing is sparse.
    """
    ends = scene.view.to_pixel_path([start, end])
    label = LabelRequest(write_length(length), list_anchors_beside(*ends), "text", gap=4.0, rank=1)
    return Drawing((Polyline(ends, "leg"),), () if scene.is_sparse else (label,))


def _is_along_first_link(scene: Scene, k: int) -> bool:
    """Return whether the dashed line along axis k of the world frame ends at O_0 and the first link continues it."""
    link = scene.skeleton.corners[0] - scene.skeleton.origins[0]
    ends_at_base = not any(scene.convention.base.position[k + 1 :])
    return ends_at_base and abs(float(link[k])) > 0.99 * float(np.linalg.norm(link)) > 0


def _draw_base_yaw(scene: Scene, shows_x_direction: bool) -> Drawing:
    """Return the arc of the base's yaw, from the direction of the world's x axis to the x axis of frame 0.

    If `shows_x_direction`, a dashed line shows the direction at which the arc starts.
    """
    base, view, frame = scene.convention.base, scene.view, scene.frames[0]
    if base.yaw == 0 or scene.is_sparse:
        return Drawing()
    x, origin = frame[:3, 0], frame[:3, 3]
    angle = float(np.arctan2(x[1], x[0]))
    radius = AXIS_LENGTH[scene.is_flat] - 7.0
    end = origin + np.eye(3)[0] * (radius + 16) / view.scale
    line: tuple[Shape, ...] = (Polyline(view.to_pixel_path([origin, end]), "dashed"),) if shows_x_direction else ()
    sign, letters = write_sign_and_size(base.yaw, is_angle=True)
    lettering = (*(write_upright("−") if sign == "−" else ()), *letters)
    return Drawing(line) + draw_arc(view, origin, (np.eye(3)[0], np.eye(3)[1]), angle, radius, lettering)
