"""Place each label at the best position near its anchor that covers neither lines nor other labels.

A label should be nearer to the thing that it names than to others of that kind. If it is not, or if it is far away, a
thin leader line connects the label to the thing.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from qdot.exercises.figure.places import InkPoints, LabelPlaces, LeaderLine
from qdot.exercises.figure.shapes import (
    FONT_SIZE,
    Box,
    Polyline,
    Shape,
    Text,
    TextRun,
    Vector2D,
    make_font_runs,
    shift_points,
)

LEADER_DISTANCE = 15.0
"""Distance in pixels from which a label gets a leader line."""


@dataclass(frozen=True)
class LabelRequest:
    """A label to place `gap` pixels from one of its anchors, each with a preferred direction (y down).

    `kind` is the kind of thing that the label names. `further_points` has more points of that thing; no other label of
    the kind should be near them. Labels of a lower `rank` are placed earlier.
    """

    pieces: tuple[TextRun, ...]
    anchors: tuple[tuple[Vector2D, Vector2D], ...]
    style: str = "text"
    gap: float = 5.0
    rank: int = 0
    kind: str = "length"
    further_points: tuple[Vector2D, ...] = ()

    @property
    def named_points(self) -> tuple[Vector2D, ...]:
        """The points that the label may name; the label is placed near one of them."""
        return tuple(dict.fromkeys(spot for spot, _ in self.anchors))

    def shift(self, vector: Vector2D) -> "LabelRequest":
        """Return the label shifted by a vector."""
        spots = shift_points(tuple([spot for spot, _ in self.anchors]), vector)
        anchors = tuple([(spot, direction) for spot, (_, direction) in zip(spots, self.anchors, strict=True)])
        return replace(self, anchors=anchors, further_points=shift_points(self.further_points, vector))

    @property
    def leader_distance(self) -> float:
        """The distance in pixels from which the label needs a leader."""
        return max(LEADER_DISTANCE, self.gap + LEADER_DISTANCE - 3.0)


@dataclass(frozen=True)
class Placement:
    """The labels and the cost of their places: 0 is perfect, 400 or more means that two overlap."""

    texts: tuple[Text, ...]
    leaders: tuple[Polyline, ...]
    cost: float


class Layout:
    """Labels among shapes in a box of width x height pixels; costs that don't depend on other labels are cached.

    Labels are placed greedily, lowest rank first. In each further round every label moves to its best place while all
    others stay.
    """

    def __init__(self, requests: Sequence[LabelRequest], shapes: Sequence[Shape], size: Vector2D) -> None:
        ink = InkPoints(shapes)
        points_by_request = [(*request.named_points, *request.further_points) for request in requests]
        self._requests = requests
        self._places: list[LabelPlaces] = []
        for i, request in enumerate(requests):
            same_kind = (k for k, another in enumerate(requests) if another.kind == request.kind and k != i)
            rivals = [point for k in same_kind for point in points_by_request[k]]
            self._places.append(
                LabelPlaces(request.pieces, request.anchors, request.gap, request.leader_distance, rivals, ink, size)
            )
        self._order = sorted(range(len(requests)), key=lambda k: requests[k].rank)
        self._boxes: dict[int, Box] = {}
        self._costs: dict[int, float] = {}
        self._leaders: dict[int, LeaderLine] = {}
        self._last_surroundings: dict[int, tuple[dict[int, Box], dict[int, Polyline]]] = {}

    def place_all(self, max_cost: float = math.inf) -> bool:
        """Move each label to its best place among the others (in the first round, among those placed before it).

        Return whether the total cost in the first round is at most `max_cost`; a layout that costs more is abandoned.
        """
        for i in self._order:
            boxes = {k: box for k, box in self._boxes.items() if k != i}
            leader = self._leaders.pop(i, None)
            leaders = {k: line.shape for k, line in self._leaders.items()}
            if self._last_surroundings.get(i) != (boxes, leaders):
                obstacles = list(boxes.values()), list(self._leaders.values())
                best_place = self._places[i].find_best(*obstacles, max_cost - self.cost)
                if best_place is None:
                    return False
                self._boxes[i], self._costs[i] = best_place
                leader = self._make_leader(i)
                self._last_surroundings[i] = boxes, leaders
            if leader is not None:
                self._leaders[i] = leader
        return True

    def _make_leader(self, i: int) -> LeaderLine | None:
        """Return the leader from a label to the thing that it names, None if it needs none."""
        box, label_places = self._boxes[i], self._places[i]
        if label_places.needs_leader(box):
            return LeaderLine(_leader_line(box, label_places.find_nearest_point(box)[1]))
        return None

    @property
    def placement(self) -> Placement:
        """The labels at their current places."""
        texts = tuple(self._make_text(i) for i in self._order)
        return Placement(texts, tuple(line.shape for line in self._leaders.values()), self.cost)

    def _make_text(self, i: int) -> Text:
        box, request = self._boxes[i], self._requests[i]
        middle, base = (box[0] + box[2]) / 2, (box[1] + box[3]) / 2 + 0.27 * FONT_SIZE
        return Text(
            middle, base, make_font_runs(request.pieces), request.style, box, self._places[i].find_nearest_point(box)[1]
        )

    @property
    def cost(self) -> float:
        """The total cost of the labels' places."""
        return sum(self._costs.values())


def _leader_line(box: Box, point: Vector2D) -> Polyline:
    """Return a line from the edge of a box to just before a point."""
    (x, y), (left, top, right, bottom) = point, box
    u, v = min(max(x, left), right), min(max(y, top + 2), bottom - 2)
    share = max(0.0, 1.0 - 2.5 / max(math.hypot(x - u, y - v), 1e-9))
    return Polyline(((u, v), (u + (x - u) * share, v + (y - v) * share)), "leader")
