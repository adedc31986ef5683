"""Project points from the world frame (m) to pixels, and draw cylinders, sleeves and arrows in this projection."""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from qdot.exercises.arm.vectors import find_perpendicular_vectors
from qdot.exercises.figure.places import LabelRequest
from qdot.exercises.figure.shapes import Polyline, Shape, Vector2D

ARROWHEAD_LENGTH = 8.0
"""Length of an arrowhead in pixels."""


@dataclass(frozen=True)
class Drawing:
    """Some shapes, from back to front, and the labels to place on them."""

    shapes: tuple[Shape, ...] = ()
    labels: tuple[LabelRequest, ...] = ()

    def __add__(self, drawing_in_front: "Drawing") -> "Drawing":
        return Drawing(self.shapes + drawing_in_front.shapes, self.labels + drawing_in_front.labels)


@dataclass(frozen=True)
class View:
    """A parallel projection from the world frame to pixels.

    `axes` are the directions right, up and towards the reader (rows). `scale` is in pixels per metre. `shift` has the
    pixel coordinates of the world's origin.
    """

    axes: np.ndarray
    scale: float
    shift: Vector2D = (0.0, 0.0)

    @cached_property
    def _rows(self) -> list[list[float]]:
        return self.axes.tolist()

    def _project(self, vector: np.ndarray) -> Vector2D:
        """Return the components of a vector (3) to the right and up."""
        (rx, ry, rz), (ux, uy, uz), _ = self._rows  # plain numbers: NumPy is slow for three numbers
        x, y, z = vector.tolist()
        return rx * x + ry * y + rz * z, ux * x + uy * y + uz * z

    def to_pixels(self, point: np.ndarray) -> Vector2D:
        """Return the pixel coordinates of a point (a 3-vector in m)."""
        right, up = self._project(point)
        return self.scale * right + self.shift[0], -self.scale * up + self.shift[1]

    def to_pixel_path(self, points: Iterable[np.ndarray]) -> tuple[Vector2D, ...]:
        """Return the pixel coordinates of points."""
        return tuple(self.to_pixels(point) for point in points)

    def to_drawn_direction(self, vector: np.ndarray) -> Vector2D:
        """Return the unit direction in which a vector (3) is drawn (y down), or upwards if it points at the reader."""
        right, up = self._project(vector)
        size = math.hypot(right, up)
        return (right / size, -up / size) if size > 1e-6 else (0.0, -1.0)

    def measure_toward_reader(self, vector: np.ndarray) -> float:
        """Return the component of a vector (3) towards the reader."""
        (dx, dy, dz), (x, y, z) = self._rows[2], vector.tolist()
        return float(dx * x + dy * y + dz * z)

    def lies_flat(self, vector: np.ndarray) -> bool:
        """Return whether a unit vector (3) lies almost in the plane of the drawing."""
        return abs(self.measure_toward_reader(vector)) < 0.2

    def is_end_on(self, vector: np.ndarray) -> bool:
        """Return whether a unit vector (3) points at the reader or away from the reader."""
        return abs(self.measure_toward_reader(vector)) > 0.999


def find_convex_hull(points: list[Vector2D]) -> tuple[Vector2D, ...]:
    """Return the convex hull of points in the plane."""
    sorted_points = sorted({(round(x, 6), round(y, 6)) for x, y in points})

    def compute_half_hull(points_in_order: list[Vector2D]) -> list[Vector2D]:
        hull_points: list[Vector2D] = []
        for p in points_in_order:
            while len(hull_points) > 1 and _compute_cross_product(hull_points[-2], hull_points[-1], p) <= 1e-9:
                hull_points.pop()
            hull_points.append(p)
        return hull_points[:-1]

    return tuple(compute_half_hull(sorted_points) + compute_half_hull(sorted_points[::-1]))


def _compute_cross_product(a: Vector2D, b: Vector2D, c: Vector2D) -> float:
    """Return the cross product of b - a and c - a."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def draw_cylinder(
    view: View, center: np.ndarray, axis: np.ndarray, radius: float, half_length: float
) -> tuple[Polyline, ...]:
    """Return the outline of a cylinder about an axis (sizes in pixels), and its end that faces the reader."""
    x, y = view.to_pixels(center)
    rings = _compute_cylinder_rings(tuple(view.axes.ravel().tolist()), tuple(axis.tolist()), radius, half_length)
    outline, front = (tuple((x + dx, y + dy) for dx, dy in ring) for ring in rings)
    return (Polyline(outline, "joint-side", is_closed=True), Polyline(front, "joint-face", is_closed=True))


@lru_cache(maxsize=1024)
def _compute_cylinder_rings(
    view_axes: tuple[float, ...], axis_components: tuple[float, ...], radius: float, half_length: float
) -> tuple[tuple[Vector2D, ...], tuple[Vector2D, ...]]:
    """Return the outline and the near end of a cylinder, in pixels relative to its centre.

    Arrays are tuples, so that the result can be cached; `view_axes` has the rows of `View.axes` one after another.
    """
    axes, axis = np.array(view_axes).reshape(3, 3), np.array(axis_components)
    u, v = find_perpendicular_vectors(axis)
    angles = np.linspace(0.0, 2 * np.pi, 41)[:-1, None]
    ring = (u * np.cos(angles) + v * np.sin(angles)) * radius
    near_end = axis * (1.0 if axes[2] @ axis >= 0 else -1.0) * half_length
    right_down = axes[:2].T * (1.0, -1.0)
    front, back = ([(float(x), float(y)) for x, y in (ring + end) @ right_down] for end in (near_end, -near_end))
    return find_convex_hull([*front, *back]), tuple(front)


def draw_sleeve(
    view: View, center: np.ndarray, axis: np.ndarray, half_length: float, half_width: float
) -> tuple[Polyline, ...]:
    """Return the faces that the reader sees of a square sleeve along an axis (sizes in pixels)."""
    u, v = find_perpendicular_vectors(axis)
    sizes = np.array([half_length, half_width, half_width]) / view.scale
    edges = [e * s for e, s in zip((axis, u, v), sizes, strict=True)]
    faces = []
    for k in range(3):
        normal, a, b = edges[k], edges[(k + 1) % 3], edges[(k + 2) % 3]
        toward_reader = float(view.axes[2] @ normal)
        if abs(toward_reader) * view.scale < 1e-6:
            continue
        middle = center + normal * (1.0 if toward_reader > 0 else -1.0)
        corners = [middle + a + b, middle - a + b, middle - a - b, middle + a - b]
        faces.append(Polyline(view.to_pixel_path(corners), "joint-face" if k == 0 else "joint-side", is_closed=True))
    return tuple(faces)


def draw_arrow(view: View, start: np.ndarray, end: np.ndarray, style: str) -> tuple[Polyline, ...]:
    """Return a straight arrow between two points (3-vectors in m)."""
    return draw_line_with_arrowhead((view.to_pixels(start), view.to_pixels(end)), style)


def draw_line_with_arrowhead(
    points: tuple[Vector2D, ...], style: str, size: float = ARROWHEAD_LENGTH
) -> tuple[Polyline, ...]:
    """Return a line that ends in an arrowhead of this size (pixels); nothing if its last segment has no length."""
    (x0, y0), (x1, y1) = points[-2], points[-1]
    length = math.hypot(x1 - x0, y1 - y0)
    if length < 1e-6:
        return ()
    head_length = min(size, 0.6 * length) if len(points) == 2 else size
    ux, uy = (x1 - x0) / length, (y1 - y0) / length
    wing = 0.36 * head_length
    bx, by = x1 - ux * head_length, y1 - uy * head_length
    head = ((x1, y1), (bx - uy * wing, by + ux * wing), (bx + uy * wing, by - ux * wing))
    # the line ends inside the head, so that its blunt end does not show at the tip
    line_end = (x1 - ux * min(head_length, length) * 0.7, y1 - uy * min(head_length, length) * 0.7)
    return (Polyline((*points[:-1], line_end), style), Polyline(head, f"{style}-head", is_closed=True))


def compute_unit_vector(x: np.ndarray, y: np.ndarray, angle: float | np.ndarray) -> np.ndarray:
    """Return the unit vector at an angle (rad) from x towards y; for angles (k x 1), the vectors (k x 3)."""
    return np.asarray(x * np.cos(angle) + y * np.sin(angle))
