"""Where labels go: each at the best place near its anchor that covers neither lines nor other labels.

A label should be nearer to what it names than to anything else of that kind; one that is not, or that stands far off,
gets a thin line that leads to it.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from qdot.exercises.figure.ink import Ink, Line
from qdot.exercises.figure.places import Places
from qdot.exercises.figure.shapes import FONT, Box, Pair, Polyline, Shape, Text, TextRun, runs, shifted

FAR = 15.0
"""Pixels from which on a label gets a leader."""


@dataclass(frozen=True)
class Request:
    """A label that wants to stand `gap` pixels from one of its anchors, each with a wished direction (y down).

    `kind` says what it names; near `reach`, further points of that thing, no other label of the kind should be.
    """

    pieces: tuple[TextRun, ...]
    anchors: tuple[tuple[Pair, Pair], ...]
    style: str = "text"
    gap: float = 5.0
    rank: int = 0
    kind: str = "length"
    reach: tuple[Pair, ...] = ()

    @property
    def spots(self) -> tuple[Pair, ...]:
        """The points that are named."""
        return tuple(dict.fromkeys(spot for spot, _ in self.anchors))

    def moved(self, by: Pair) -> "Request":
        """Return the same label at another place."""
        spots = shifted(tuple([spot for spot, _ in self.anchors]), by)
        anchors = tuple([(spot, wish) for spot, (_, wish) in zip(spots, self.anchors, strict=True)])
        return replace(self, anchors=anchors, reach=shifted(self.reach, by))

    @property
    def far(self) -> float:
        """The distance, in pixels, from which on the label needs a leader."""
        return max(FAR, self.gap + FAR - 3.0)


@dataclass(frozen=True)
class Placement:
    """The labels and what their places cost: 0 is perfect, 400 or more means that two overlap."""

    texts: tuple[Text, ...]
    leaders: tuple[Polyline, ...]
    cost: float


class Layout:
    """Labels among shapes in a box of width x height pixels; what does not depend on other labels is worked out once.

    They are placed greedily, those of lowest rank first. In each further round every label takes the place that is best
    when all others stay where they are.
    """

    def __init__(self, requests: Sequence[Request], shapes: Sequence[Shape], size: Pair) -> None:
        ink = Ink(shapes)
        reaches = [(*request.spots, *request.reach) for request in requests]
        self._requests = requests
        self._places: list[Places] = []
        for i, one in enumerate(requests):
            alike = (k for k, other in enumerate(requests) if other.kind == one.kind and k != i)
            rivals = [point for k in alike for point in reaches[k]]
            self._places.append(Places(one.pieces, one.anchors, one.gap, one.far, rivals, ink, size))
        self._order = sorted(range(len(requests)), key=lambda k: requests[k].rank)
        self._boxes: dict[int, Box] = {}
        self._costs: dict[int, float] = {}
        self._leaders: dict[int, Line] = {}
        self._seen: dict[int, tuple[dict[int, Box], dict[int, Polyline]]] = {}

    def place_all(self, most: float = math.inf) -> bool:
        """Put each label where it is best among the others as they are now: the first time among those before it.

        Whether they cost `most` together at most, when placed the first time; what costs more is not placed to the end.
        """
        for i in self._order:
            boxes = {k: box for k, box in self._boxes.items() if k != i}
            led = self._leaders.pop(i, None)
            leaders = {k: line.shape for k, line in self._leaders.items()}
            if self._seen.get(i) != (boxes, leaders):
                others = list(boxes.values()), list(self._leaders.values())
                place = self._places[i].best(*others, most - self.cost)
                if place is None:
                    return False
                self._boxes[i], self._costs[i] = place
                led = self._led(i)
                self._seen[i] = boxes, leaders
            if led is not None:
                self._leaders[i] = led
        return True

    def _led(self, i: int) -> Line | None:
        """Return the line that leads from a label to what it names, None where it needs none."""
        box, places = self._boxes[i], self._places[i]
        return Line(_leader(box, places.nearest(box)[1])) if places.needs_leader(box) else None

    @property
    def placement(self) -> Placement:
        """The labels where they are now."""
        texts = tuple(self._text(i) for i in self._order)
        return Placement(texts, tuple(line.shape for line in self._leaders.values()), self.cost)

    def _text(self, i: int) -> Text:
        box, request = self._boxes[i], self._requests[i]
        middle, base = (box[0] + box[2]) / 2, (box[1] + box[3]) / 2 + 0.27 * FONT
        return Text(middle, base, runs(request.pieces), request.style, box, self._places[i].nearest(box)[1])

    @property
    def cost(self) -> float:
        """What the labels' places cost together."""
        return sum(self._costs.values())


def _leader(box: Box, spot: Pair) -> Polyline:
    """Return a line from the edge of a box to a little before a point."""
    (x, y), (left, top, right, bottom) = spot, box
    u, v = min(max(x, left), right), min(max(y, top + 2), bottom - 2)
    share = max(0.0, 1.0 - 2.5 / max(math.hypot(x - u, y - v), 1e-9))
    return Polyline(((u, v), (u + (x - u) * share, v + (y - v) * share)), "leader")
