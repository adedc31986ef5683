"""Lay out all labels of a drawing, so that they cover neither lines nor other labels.

A label should be nearer to the object that it names than to other objects of the same kind. If a label is not nearer,
or if it is far away, a thin leader line connects the label to its object.
"""

import math
from collections.abc import Sequence

from qdot.exercises.figure.lettering import FONT_SIZE, make_font_runs
from qdot.exercises.figure.places import InkPoints, LabelPlaces, LabelRequest, LeaderLine
from qdot.exercises.figure.shapes import Box, Polyline, Shape, Text, Vector2D


class Layout:
    """The places of labels among shapes in a box of width x height pixels.

    Labels are placed greedily, those of the lowest rank first. In each further round, every label moves to its best
    place while all other labels stay. Costs that don't depend on other labels are cached.
    """

    def __init__(self, requests: Sequence[LabelRequest], shapes: Sequence[Shape], size: Vector2D) -> None:
        ink = InkPoints(shapes)
        points_by_request = [(*request.named_points, *request.further_points) for request in requests]
        self._requests = requests
        self._places: list[LabelPlaces] = []
        for i, request in enumerate(requests):
            rival_indices = (k for k, rival in enumerate(requests) if rival.kind == request.kind and k != i)
            rivals = [point for k in rival_indices for point in points_by_request[k]]
            self._places.append(LabelPlaces(request, rivals, ink, size))
        self._order = sorted(range(len(requests)), key=lambda k: requests[k].rank)
        self._boxes: dict[int, Box] = {}
        self._costs: dict[int, float] = {}
        self._leaders: dict[int, LeaderLine] = {}
        self._last_surroundings: dict[int, tuple[dict[int, Box], dict[int, Polyline]]] = {}

    def place_all(self, max_cost: float = math.inf) -> bool:
        """Move each label to its best place among the labels that were placed before.

        Return whether the total cost in the first round is at most `max_cost`; a layout that costs more is abandoned.
        """
        for i in self._order:
            boxes = {k: box for k, box in self._boxes.items() if k != i}
            leader = self._leaders.pop(i, None)
            leaders = {k: line.shape for k, line in self._leaders.items()}
            if self._last_surroundings.get(i) != (boxes, leaders):
                obstacles = list(boxes.values()), list(self._leaders.values())
                best_place = self._places[i].find_best_place(*obstacles, max_cost - self.cost)
                if best_place is None:
                    return False
                self._boxes[i], self._costs[i] = best_place
                leader = self._make_leader(i)
                self._last_surroundings[i] = boxes, leaders
            if leader is not None:
                self._leaders[i] = leader
        return True

    def _make_leader(self, i: int) -> LeaderLine | None:
        """Return the leader from a label to the object that the label names, or None if no leader is needed.

        The leader goes from the edge of the label's box to just before the nearest point of the object.
        """
        box = left, top, right, bottom = self._boxes[i]
        if not self._places[i].needs_leader(box):
            return None
        _, (x, y) = self._places[i].find_nearest_point(box)
        u, v = min(max(x, left), right), min(max(y, top + 2), bottom - 2)
        fraction = max(0.0, 1.0 - 2.5 / max(math.hypot(x - u, y - v), 1e-9))
        return LeaderLine(Polyline(((u, v), (u + (x - u) * fraction, v + (y - v) * fraction)), "leader"))

    @property
    def leaders(self) -> tuple[Polyline, ...]:
        """The leaders of the labels at their current places."""
        return tuple(line.shape for line in self._leaders.values())

    @property
    def texts(self) -> tuple[Text, ...]:
        """The labels at their current places, those of the lowest rank first."""
        texts = []
        for i in self._order:
            box, request = self._boxes[i], self._requests[i]
            # the baseline lies below the middle of the letters
            middle, baseline = (box[0] + box[2]) / 2, (box[1] + box[3]) / 2 + 0.27 * FONT_SIZE
            _, named_point = self._places[i].find_nearest_point(box)
            texts.append(Text(middle, baseline, make_font_runs(request.lettering), request.style, box, named_point))
        return tuple(texts)

    @property
    def cost(self) -> float:
        """The total cost of the labels' places: 0 is perfect, 400 or more means that two overlap."""
        return sum(self._costs.values())
