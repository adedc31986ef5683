"""Find the best place for one label among the lines and other labels of a drawing.

Lines are represented by points. Each possible place of the label has a cost, and the cheapest place is chosen.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import pairwise

import numpy as np

from qdot.exercises.figure.lettering import LETTERING_HEIGHT, Lettering, measure_width
from qdot.exercises.figure.shapes import Box, Circle, Polyline, Shape, Vector2D, list_outlines

PLACE_ANGLES = tuple(sorted(range(-160, 181, 20), key=abs))
EXTRA_DISTANCES = (0.0, 6.0, 14.0, 26.0, 42.0, 60.0, 80.0)
"""The possible places of a label: angles from its preferred direction (degrees), and extra distances (pixels)."""
OVERLAP_COST, OUTSIDE_COST = 400_00, 400_00
"""Cost of each overlapped label, and cost of a place outside the figure.

Costs are integers, in hundredths: an extra distance of one pixel costs 1.2, or 120 hundredths.
"""
LEADER_COST, AMBIGUOUS_COST, CROSSED_COST = 14_00, 70_00, 120_00
"""Cost of a leader, and two additional costs.

`AMBIGUOUS_COST` is added if the leader is needed because another object of the same kind is nearer. `CROSSED_COST` is
added if the leader crosses a label or another leader, or if the label covers another leader.
"""
INK_COST, COSTLY_POINT_COUNT, FURTHER_POINT_COST = 14_00, 10, 1_00
"""Costs of the points of lines that a label covers.

Each point costs `FURTHER_POINT_COST`; each of the first `COSTLY_POINT_COUNT` points also costs `INK_COST`.
"""
MIN_DISTANCE_MARGIN = 2.0
"""A label should be nearer to the object that it names than to other objects of the same kind, by this many pixels."""
EDGE_MARGIN = 4.0
"""Width of the free margin at the edge of the figure, in pixels."""
CROSSING_FRACTIONS = (0.1, 0.3, 0.5, 0.7, 0.9)
"""Fractions of a leader's length at which a test checks whether the leader crosses another label."""
HALF_WIDTH = {"link": 6.0, "rod": 4.0, "plate": 1.0}
"""Half the width in pixels of lines of these styles."""
THIN_HALF_WIDTH, CIRCLE_MARGIN = 2.0, 1.5
"""Half the width of lines of other styles, margin included, and the margin around a circle, in pixels."""

_CosSin = tuple[float, float]
"""Cosine and sine of an angle."""
_PlaceEntry = tuple[int, int, int, float, _CosSin]
"""A place: its base cost (hundredths), number, anchor's index, extra distance, and angle from the anchor's
direction."""

LEADER_DISTANCE = 15.0
"""A label gets a leader line if it is farther away than this, in pixels."""


@dataclass(frozen=True)
class LabelRequest:
    """A label that has to be placed about `gap` pixels from one of its anchors.

    An anchor is a point with a preferred direction from the point to the label (y down). `kind` is the kind of object
    that the label names. `further_points` are other points of the same object; no label of another object of the same
    kind should be near these points. Labels of a lower `rank` are placed earlier.
    """

    lettering: Lettering
    anchors: tuple[tuple[Vector2D, Vector2D], ...]
    style: str = "text"
    gap: float = 5.0
    rank: int = 0
    kind: str = "length"
    further_points: tuple[Vector2D, ...] = ()

    @property
    def named_points(self) -> tuple[Vector2D, ...]:
        """The points of the anchors; the label is placed near one of them."""
        return tuple(dict.fromkeys(point for point, _ in self.anchors))


def make_anchors(point: Vector2D, *directions: Vector2D) -> tuple[tuple[Vector2D, Vector2D], ...]:
    """Return anchors at one point with several preferred directions."""
    return tuple((point, direction) for direction in directions)


class InkPoints:
    """Points on the lines of shapes, each with half the width of its line."""

    def __init__(self, shapes: Iterable[Shape]) -> None:
        x, y, half_width = sample_points(shapes).T
        self._left, self._right = x - half_width, x + half_width
        self._top, self._bottom = y - half_width, y + half_width

    def count_covered(self, box: Box) -> int:
        """Return the number of points that a box covers."""
        left, top, right, bottom = box
        is_covered = (self._left < right) & (self._right > left) & (self._top < bottom) & (self._bottom > top)
        return int(np.count_nonzero(is_covered))


def sample_points(shapes: Iterable[Shape]) -> np.ndarray:
    """Return points on the shapes' lines, about 4 pixels apart, as rows x, y, half width (k x 3)."""
    circles: list[tuple[float, float, float]] = []
    segments: list[tuple[float, ...]] = []
    for outline in list_outlines(shapes):
        if isinstance(outline, Circle):
            circles.append((*outline.center, outline.radius + CIRCLE_MARGIN))
        else:
            half_width = HALF_WIDTH.get(outline.style, THIN_HALF_WIDTH)
            points = (*outline.points, outline.points[0]) if outline.is_closed else outline.points
            segments += [(*start, *end, half_width) for start, end in pairwise(points)]
    circle_points = np.array(circles, dtype=float).reshape(-1, 3)
    return np.concatenate([circle_points, _sample_segments(np.array(segments).reshape(-1, 5))])


def _sample_segments(segments: np.ndarray) -> np.ndarray:
    """Return points on straight segments, ends included, as rows x, y, half width.

    A segment is given by its two ends and half its width: x, y, x, y, half width (k x 5).
    """
    start, direction, half_width = segments[:, :2], segments[:, 2:4] - segments[:, :2], segments[:, 4:]
    counts = np.maximum(1, np.ceil(np.hypot(*direction.T) / 4 - 1e-6)).astype(int)
    segment_index = np.repeat(np.arange(len(segments)), counts + 1)
    step = np.arange(len(segment_index)) - np.repeat(np.cumsum(counts + 1) - counts - 1, counts + 1)
    fraction = (step / counts[segment_index])[:, None]
    return np.hstack([start[segment_index] + direction[segment_index] * fraction, half_width[segment_index]])


class LeaderLine(InkPoints):
    """The straight leader line of a label, as an obstacle for other labels."""

    def __init__(self, shape: Polyline) -> None:
        super().__init__((shape,))
        self.shape = shape
        self.start, self.end = (x0, y0), (x1, y1) = shape.points
        self._points = [(x0 + k / 16 * (x1 - x0), y0 + k / 16 * (y1 - y0)) for k in range(17)]
        r = THIN_HALF_WIDTH
        self._bounds = min(x0, x1) - r, min(y0, y1) - r, max(x0, x1) + r, max(y0, y1) + r

    def is_near(self, box: Box) -> bool:
        """Return whether the line may pass through a box."""
        left, top, right, bottom = self._bounds
        return box[2] > left and box[0] < right and box[3] > top and box[1] < bottom

    def is_covered_by(self, box: Box) -> bool:
        """Return whether a box covers points of the line."""
        left, top, right, bottom = box
        return any(left - 1 < x < right + 1 and top - 1 < y < bottom + 1 for x, y in self._points)

    def crosses(self, start: Vector2D, end: Vector2D) -> bool:
        """Return whether the line crosses the line between two points."""
        has_ends_on_both_sides = _lie_on_both_sides(start, end, self.start, self.end)
        return has_ends_on_both_sides and _lie_on_both_sides(self.start, self.end, start, end)


def _lie_on_both_sides(start: Vector2D, end: Vector2D, point: Vector2D, other_point: Vector2D) -> bool:
    """Return whether two points clearly lie on different sides of the line through `start` and `end`."""
    side, other_side = _compute_side(start, end, point), _compute_side(start, end, other_point)
    return (side < 0 < other_side) or (other_side < 0 < side)


def _compute_side(start: Vector2D, end: Vector2D, point: Vector2D) -> int:
    """Return a number whose sign says on which side of a line a point lies; rounded to be equal on every machine."""
    (x0, y0), (x1, y1), (x, y) = start, end, point
    return round(((x1 - x0) * (y - y0) - (y1 - y0) * (x - x0)) * 1000)


@lru_cache(maxsize=64)
def _list_places(anchor_count: int) -> tuple[_PlaceEntry, ...]:
    """Return the places around the given number of anchors, the cheapest first."""
    entries: list[_PlaceEntry] = []
    for anchor in range(anchor_count):
        for extra_distance in EXTRA_DISTANCES:
            for angle in map(math.radians, PLACE_ANGLES):
                cost = round(100 * (1.2 * extra_distance + 9.0 * abs(angle) + 1.5 * anchor))
                entries.append((cost, len(entries), anchor, extra_distance, (math.cos(angle), math.sin(angle))))
    return tuple(sorted(entries))


class _Place:
    """A place for a label, with costs that don't depend on other labels, computed on demand.

    `base_cost` is the cost of the place itself. `cost_with_lines` includes the covered lines. `lower_bound` is the
    lowest total cost that is still possible. `covered_count` is the number of covered points of lines. `covered_count`
    and `leader_cost` are -1 until they are computed.
    """

    __slots__ = ("base_cost", "box", "cost_with_lines", "covered_count", "leader_cost", "leader_end", "lower_bound")

    def __init__(self, box: Box, base_cost: int) -> None:
        self.box, self.base_cost, self.lower_bound = box, base_cost, base_cost
        self.covered_count = self.leader_cost = -1
        self.cost_with_lines, self.leader_end = base_cost, (0.0, 0.0)


class LabelPlaces:
    """The places of one label; `rivals` are points of other objects of the same kind."""

    def __init__(self, request: LabelRequest, rivals: Sequence[Vector2D], ink: InkPoints, size: Vector2D) -> None:
        self._gap, self._rivals, self._ink = request.gap, rivals, ink
        self._leader_distance = max(LEADER_DISTANCE, self._gap + LEADER_DISTANCE - 3.0)
        width = measure_width(request.lettering)
        self._half_size = (width / 2, LETTERING_HEIGHT / 2)
        self._right, self._bottom = size[0] - EDGE_MARGIN, size[1] - EDGE_MARGIN
        self._anchors = [(*point, *_normalize(direction)) for point, direction in request.anchors]
        self._named_points = request.named_points
        self._evaluated_places: dict[int, _Place] = {}
        x, y = zip(*self._named_points, strict=True)
        max_reach = self._gap + EXTRA_DISTANCES[-1] + 2 * width
        self._outer_bounds: Box = (min(x) - max_reach, min(y) - max_reach, max(x) + max_reach, max(y) + max_reach)

    def find_best_place(
        self, label_boxes: Sequence[Box], leaders: Sequence[LeaderLine], max_cost: float
    ) -> tuple[Box, float] | None:
        """Return the box and the cost of the cheapest place, given other labels' boxes (`label_boxes`) and `leaders`.

        Places are tried in the order of their base costs until no further place can be cheaper. Of equally cheap
        places, the place with the smallest number is chosen. Because costs are integers, every machine chooses the same
        place. Returns None if all places cost more than `max_cost`.
        """
        min_x, min_y, max_x, max_y = self._outer_bounds
        near_boxes = [b for b in label_boxes if b[0] < max_x and b[2] > min_x and b[1] < max_y and b[3] > min_y]
        padded_boxes = [(left - 2, top - 1, right + 2, bottom + 1) for left, top, right, bottom in near_boxes]
        evaluated_places = self._evaluated_places
        best_number, least_cost = -1, math.ceil(100 * min(max_cost, 1e9)) + 1
        for base_cost, number, anchor, extra_distance, direction in _list_places(len(self._anchors)):
            if base_cost > least_cost or (base_cost == least_cost and number > best_number):
                break
            place = evaluated_places.get(number)
            if place is None:
                place = evaluated_places[number] = self._make_place(base_cost, anchor, extra_distance, direction)
            if place.lower_bound > least_cost:
                continue
            left, top, right, bottom = place.box
            overlap_cost = 0
            for x0, y0, x1, y1 in padded_boxes:
                if left < x1 and right > x0 and top < y1 and bottom > y0:
                    overlap_cost += OVERLAP_COST
            if overlap_cost + place.lower_bound > least_cost:
                continue
            cost = overlap_cost + self._compute_cost_with_lines(place, leaders)
            if cost <= least_cost:
                if place.leader_cost < 0:
                    self._evaluate_leader(place)
                cost += place.leader_cost
                may_be_best = place.leader_cost and cost <= least_cost
                if may_be_best and _is_crossed(place.box, place.leader_end, near_boxes, leaders):
                    cost += CROSSED_COST
                if cost < least_cost or (cost == least_cost and number < best_number):
                    best_number, least_cost = number, cost
        return (evaluated_places[best_number].box, least_cost / 100) if best_number >= 0 else None

    def _make_place(self, base_cost: int, anchor: int, extra_distance: float, direction: _CosSin) -> _Place:
        """Return the place at which the box touches a circle of radius gap + extra_distance around the anchor."""
        (half_width, half_height), (x, y, u, v), (cos, sin) = self._half_size, self._anchors[anchor], direction
        dx, dy = u * cos - v * sin, v * cos + u * sin
        horizontal, vertical = abs(dx), abs(dy)
        box_reach = (
            half_width / horizontal if half_width * vertical < half_height * horizontal else half_height / vertical
        )
        reach = self._gap + extra_distance + box_reach
        x, y = x + dx * reach, y + dy * reach
        box = left, top, right, bottom = x - half_width, y - half_height, x + half_width, y + half_height
        is_inside = left >= EDGE_MARGIN and top >= EDGE_MARGIN and right <= self._right and bottom <= self._bottom
        return _Place(box, base_cost if is_inside else base_cost + OUTSIDE_COST)

    def _compute_cost_with_lines(self, place: _Place, leaders: Sequence[LeaderLine]) -> int:
        """Return the cost of a place with the lines that it covers, including other labels' leaders."""
        if place.covered_count < 0:
            place.covered_count = self._ink.count_covered(place.box)
            place.lower_bound = place.cost_with_lines = place.base_cost + _compute_ink_cost(place.covered_count)
        near_leaders = [line for line in leaders if line.is_near(place.box)] if leaders else leaders
        if not near_leaders:
            return place.cost_with_lines
        cost = place.base_cost + _compute_ink_cost(
            place.covered_count + sum(line.count_covered(place.box) for line in near_leaders)
        )
        return cost + CROSSED_COST * any(line.is_covered_by(place.box) for line in near_leaders)

    def _evaluate_leader(self, place: _Place) -> None:
        """Find out whether a place needs a leader; store the leader's end and its cost, not counting crossings."""
        distance, place.leader_end = self.find_nearest_point(place.box)
        if self._is_ambiguous(place.box, distance):
            place.leader_cost = LEADER_COST + AMBIGUOUS_COST
        else:
            place.leader_cost = LEADER_COST if distance > self._leader_distance else 0
        place.lower_bound += place.leader_cost

    def find_nearest_point(self, box: Box) -> tuple[float, Vector2D]:
        """Return the distance of a box from the object that the label names, and the nearest point of that object."""
        gaps = [_compute_distance(box, point) for point in self._named_points]
        distance = min(gaps)
        return distance, self._named_points[gaps.index(distance)]

    def _is_ambiguous(self, box: Box, distance: float) -> bool:
        """Return whether another object of the same kind is nearly as close to a box as the label's object."""
        for rival in _select_near_points(box, self._rivals, distance + MIN_DISTANCE_MARGIN):
            gap = _compute_distance(box, rival)
            if distance > gap - MIN_DISTANCE_MARGIN and (gap < self._leader_distance or self._is_near_any_place(rival)):
                return True
        return False

    def _is_near_any_place(self, rival: Vector2D) -> bool:
        """Return whether a point is near any possible place; a point far from all places causes no confusion."""
        (x, y), max_distance = rival, self._leader_distance
        left, top, right, bottom = self._bounding_box
        return left - max_distance < x < right + max_distance and top - max_distance < y < bottom + max_distance

    @cached_property
    def _bounding_box(self) -> Box:
        places = (
            self._make_place(0, anchor, distance, direction)
            for _, _, anchor, distance, direction in _list_places(len(self._anchors))
            if distance == EXTRA_DISTANCES[-1]
        )
        left, top, right, bottom = zip(*(place.box for place in places), strict=True)
        return min(left), min(top), max(right), max(bottom)

    def needs_leader(self, box: Box) -> bool:
        """Return whether a label in a box is far from its object, or nearer to another object of the same kind."""
        distance, _ = self.find_nearest_point(box)
        near_rivals = _select_near_points(box, self._rivals, distance)
        return distance > self._leader_distance or any(
            _compute_distance(box, rival) < distance for rival in near_rivals
        )


def _normalize(direction: Vector2D) -> Vector2D:
    """Return the unit vector along a direction; (1, 0) for the zero vector of a link that is seen end-on."""
    angle = math.atan2(direction[1], direction[0])
    return math.cos(angle), math.sin(angle)


def _compute_ink_cost(covered_count: int) -> int:
    """Return the cost of covering a number of points of lines."""
    return INK_COST * min(covered_count, COSTLY_POINT_COUNT) + FURTHER_POINT_COST * covered_count


def _compute_distance(box: Box, point: Vector2D) -> float:
    """Return the distance of a box from a point, 0 inside the box; rounded to be equal on every machine."""
    left, top, right, bottom = box
    x, y = point
    horizontal = left - x if x < left else x - right if x > right else 0.0
    vertical = top - y if y < top else y - bottom if y > bottom else 0.0
    return round((math.hypot(horizontal, vertical) if horizontal and vertical else horizontal + vertical) * 1000) / 1000


def _select_near_points(box: Box, points: Sequence[Vector2D], max_distance: float) -> list[Vector2D]:
    """Return the points that may be less than `max_distance` away from a box."""
    reach = max_distance + 0.01
    left, top, right, bottom = box[0] - reach, box[1] - reach, box[2] + reach, box[3] + reach
    return [point for point in points if left < point[0] < right and top < point[1] < bottom]


def _is_crossed(box: Box, point: Vector2D, label_boxes: Sequence[Box], leaders: Sequence[LeaderLine]) -> bool:
    """Return whether the leader from a box to a point crosses the boxes or leaders of other labels."""
    u, v = point
    x, y = min(max(u, box[0]), box[2]), min(max(v, box[1]), box[3])  # the nearest point of the box
    x0, x1, y0, y1 = min(x, u), max(x, u), min(y, v), max(y, v)
    for left, top, right, bottom in label_boxes:
        if left < x1 and right > x0 and top < y1 and bottom > y0:
            for fraction in CROSSING_FRACTIONS:
                if left < x + fraction * (u - x) < right and top < y + fraction * (v - y) < bottom:
                    return True
    return any(line.crosses((x, y), point) for line in leaders)
