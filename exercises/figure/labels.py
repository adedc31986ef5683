"""Where labels go: each at the best place near its anchor that covers neither lines nor other labels.

A label should be nearer to what it names than to anything else of that kind; one that is not, or that stands far off,
gets a thin line that leads to it.
"""

import math
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from exercises.figure.shapes import FONT, Circle, Glyph, Pair, Piece, Polyline, Shape, Text, extent, runs

HALF_WIDTH = {"link": 6.0, "rod": 4.0, "plate": 1.0}
ROUND = np.radians(sorted(range(-160, 181, 20), key=abs))
FURTHER = np.array([0.0, 6.0, 14.0, 26.0, 42.0, 60.0, 80.0])[:, None]
"""Where a label may stand: turned away from the wished direction (rad), and further from the anchor (pixels)."""
BOX_COST, OUTSIDE_COST = 400.0, 400.0
FAR, LEADER_COST, CONFUSED_COST, CROSSED_COST = 15.0, 14.0, 70.0, 120.0
CLEARLY = 2.0
"""Pixels from which on a label gets a leader; what a leader costs, and one that is needed because something else of the
kind is nearer, and one that crosses another label or its leader, as a label does that lies on a leader; by so many
pixels its own thing should be nearer."""
BATCH = 64
"""Candidates that are compared with the lines at once."""


Box = tuple[float, float, float, float]


@dataclass(frozen=True)
class Request:
    """A label that wants to stand `gap` pixels from one of its anchors, each with a wished direction (y down).

    `kind` says what it names; near `reach`, further points of that thing, no other label of the kind should be.
    """

    pieces: tuple[Piece, ...]
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

    @property
    def far(self) -> float:
        """The distance, in pixels, from which on the label needs a leader."""
        return max(FAR, self.gap + FAR - 3.0)


@dataclass(frozen=True)
class Placement:
    """The labels and what their places cost: 0 is perfect, more than BOX_COST means that two overlap."""

    texts: tuple[Text, ...]
    leaders: tuple[Polyline, ...]
    cost: float


class Layout:
    """Labels among shapes in a box of width x height pixels; what does not depend on other labels is worked out once.

    They are placed greedily, those of lowest rank first. In each further round every label takes the place that is best
    when all others stay where they are.
    """

    def __init__(self, requests: Sequence[Request], shapes: Sequence[Shape], size: Pair) -> None:
        ink = _samples(shapes)
        reaches = [np.array((*request.spots, *request.reach)) for request in requests]
        kinds = [[k for k, other in enumerate(requests) if other.kind == request.kind] for request in requests]
        self._labels: list[_Label] = []
        for i, request in enumerate(requests):
            rivals = np.concatenate([np.empty((0, 2)), *(reaches[k] for k in kinds[i] if k != i)])
            self._labels.append(_Label(request, ink, rivals, size))
        self._order = sorted(range(len(requests)), key=lambda k: requests[k].rank)
        self._boxes: dict[int, Box] = {}
        self._costs: dict[int, float] = {}
        self._leaders: dict[int, Polyline] = {}
        self._seen: dict[int, tuple[dict[int, Box], dict[int, Polyline]]] = {}

    def place_all(self) -> None:
        """Put each label where it is best among the others as they are now: the first time among those before it."""
        for i in self._order:
            boxes = {k: box for k, box in self._boxes.items() if k != i}
            leaders = {k: line for k, line in self._leaders.items() if k != i}
            led = self._leaders.pop(i, None)
            if self._seen.get(i) != (boxes, leaders):
                self._boxes[i], self._costs[i] = self._labels[i].best(boxes.values(), leaders.values())
                led = self._labels[i].leader(self._boxes[i])
                self._seen[i] = boxes, leaders
            if led is not None:
                self._leaders[i] = led

    @property
    def placement(self) -> Placement:
        """The labels where they are now."""
        texts = tuple(_text(self._labels[i].request, self._boxes[i]) for i in self._order)
        return Placement(texts, tuple(self._leaders.values()), self.cost)

    @property
    def cost(self) -> float:
        """What the labels' places cost together."""
        return sum(self._costs.values())


def _text(request: Request, box: Box) -> Text:
    middle, base = (box[0] + box[2]) / 2, (box[1] + box[3]) / 2 + 0.27 * FONT
    return Text(middle, base, runs(request.pieces), request.style, box, _nearest(box, request.spots))


def _gaps(boxes: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return the distances of boxes (k x 4) from points (m x 2) as k x m; 0 inside."""
    left, top, right, bottom = (boxes[:, k, None] for k in range(4))
    x, y = points.T
    aside, above = np.maximum(left - x, x - right), np.maximum(top - y, y - bottom)
    return np.asarray(np.round(np.hypot(np.maximum(aside, 0), np.maximum(above, 0)), 3))


def _nearest(box: Box, spots: tuple[Pair, ...]) -> Pair:
    return spots[int(np.argmin(_gaps(np.array([box]), np.array(spots))))]


def _leader(box: Box, spot: Pair) -> Polyline:
    """Return a line from the edge of a box to a little before a point."""
    (x, y), (left, top, right, bottom) = spot, box
    u, v = min(max(x, left), right), min(max(y, top + 2), bottom - 2)
    share = max(0.0, 1.0 - 2.5 / max(math.hypot(x - u, y - v), 1e-9))
    return Polyline(((u, v), (u + (x - u) * share, v + (y - v) * share)), "leader")


def _candidates(request: Request) -> tuple[np.ndarray, np.ndarray]:
    """Return the boxes (k x 4) that the label may take and what each costs by itself (k)."""
    w, h = extent(request.pieces)
    points = np.array([point for point, _ in request.anchors])[:, None, None]
    wishes = np.array([math.atan2(y, x) for _, (x, y) in request.anchors])[:, None, None]
    order = np.arange(len(request.anchors))[:, None, None]
    c, s = np.cos(wishes + ROUND), np.sin(wishes + ROUND)
    # the box touches a circle of radius gap + further around the anchor from outside
    touch = np.minimum(w / 2 / np.maximum(np.abs(c), 1e-9), h / 2 / np.maximum(np.abs(s), 1e-9))
    reach = request.gap + FURTHER + touch
    x, y = points[..., 0] + c * reach, points[..., 1] + s * reach
    boxes = np.stack([x - w / 2, y - h / 2, x + w / 2, y + h / 2], axis=-1).reshape(-1, 4)
    costs = 1.2 * FURTHER + 9.0 * np.abs(ROUND) + 1.5 * order
    return boxes, costs.ravel()


class _Label:
    """One label's candidates, and what speaks against each whatever other labels do, found out when it is asked for."""

    def __init__(self, request: Request, ink: np.ndarray, rivals: np.ndarray, size: Pair) -> None:
        self.request, self._rivals, self._spots = request, rivals, np.array(request.spots)
        self._boxes, self._costs = _candidates(request)
        left, top, right, bottom = self._boxes.T
        self._outside = (left < 4) | (top < 4) | (right > size[0] - 4) | (bottom > size[1] - 4)
        self._low, self._high = self._boxes[:, :2].min(axis=0), self._boxes[:, 2:].max(axis=0)
        self._ink = self._near(ink)
        near = (rivals > self._low - request.far) & (rivals < self._high + request.far)
        self._near_rivals = rivals[near.all(axis=1)]
        count = len(self._boxes)
        self._known, self._hits = np.zeros(count, dtype=bool), np.zeros(count, dtype=int)
        self._led, self._confused = np.zeros(count, dtype=bool), np.zeros(count, dtype=bool)
        self._ends = np.zeros((count, 2))

    def _near(self, ink: np.ndarray) -> np.ndarray:
        return ink[((ink[:, :2] + ink[:, 2:] > self._low) & (ink[:, :2] - ink[:, 2:] < self._high)).all(axis=1)]

    def _find_out(self, some: np.ndarray) -> None:
        """Find out how many points of lines candidates cover, and whether they need a leader, and to where."""
        some = some[~self._known[some]]
        if not len(some):
            return
        boxes = self._boxes[some]
        gaps = _gaps(boxes, self._spots)
        own = gaps.min(axis=1)
        self._hits[some] = _hits(boxes, self._ink)
        self._confused[some] = own > _gaps(boxes, self._near_rivals).min(axis=1, initial=np.inf) - CLEARLY
        self._led[some] = self._confused[some] | (own > self.request.far)
        self._ends[some] = self._spots[gaps.argmin(axis=1)]
        self._known[some] = True

    def best(self, others: Iterable[Box], lines: Collection[Polyline]) -> tuple[Box, float]:
        """Return the cheapest box and its cost: candidates by what they cost by themselves, until none can be cheaper.

        Around it are other labels' boxes and leaders. Costs are rounded, and a tie goes to the first candidate, on
        every machine.
        """
        boxes, costs = self._boxes, self._costs
        left, top, right, bottom = boxes.T
        taken = np.array(list(others)).reshape(-1, 4)
        leads = np.array([line.points for line in lines]).reshape(-1, 2, 2)
        ink = self._near(_samples(lines)) if lines else None
        taken = taken[(taken[:, :2] - 2 <= self._high).all(axis=1) & (taken[:, 2:] + 2 >= self._low).all(axis=1)]
        for box in taken:
            over = (left < box[2] + 2) & (right > box[0] - 2) & (top < box[3] + 1) & (bottom > box[1] - 1)
            costs = costs + BOX_COST * over
        costs = costs + OUTSIDE_COST * self._outside
        costs = np.round(costs + CROSSED_COST * _cover(boxes, leads) if lines else costs, 2)
        order = np.argsort(costs, kind="stable")
        best, least = int(order[0]), np.inf
        for start in range(0, len(order), BATCH):
            some = order[start : start + BATCH]
            if costs[some[0]] > least:
                break
            self._find_out(some)
            hits = self._hits[some] if ink is None else self._hits[some] + _hits(boxes[some], ink)
            inked = 14.0 * np.minimum(hits, 10) + 1.0 * hits
            totals = np.round(costs[some] + inked + self._leader_cost(some, taken, leads), 2)
            found = int(some[totals == totals.min()].min())
            if (float(totals.min()), found) < (least, best):
                best, least = found, float(totals.min())
        x0, y0, x1, y1 = boxes[best].tolist()
        return (x0, y0, x1, y1), least

    def _leader_cost(self, some: np.ndarray, taken: np.ndarray, leads: np.ndarray) -> np.ndarray | float:
        """Return what it costs candidates to need a leader (k) among other boxes and leaders."""
        led = self._led[some]
        if not led.any():
            return 0.0
        boxes, ends = self._boxes[some], self._ends[some]
        crossed = _crossed(boxes, ends, taken) | _tangled(boxes, ends, leads)
        return np.asarray(led * (LEADER_COST + CONFUSED_COST * self._confused[some] + CROSSED_COST * crossed))

    def leader(self, box: Box) -> Polyline | None:
        """Return the line that leads from the label in a box to what it names, None where it needs none."""
        own, other = (_gaps(np.array([box]), p).min(initial=np.inf) for p in (self._spots, self._rivals))
        if not own > min(self.request.far, other):
            return None
        return _leader(box, _nearest(box, self.request.spots))


def _crossed(boxes: np.ndarray, spots: np.ndarray, taken: np.ndarray) -> np.ndarray:
    """Tell whether the way from boxes (k x 4) to points (k x 2) crosses other boxes (k)."""
    starts = np.clip(spots, boxes[:, :2], boxes[:, 2:])
    shares = np.array([0.1, 0.3, 0.5, 0.7, 0.9])[:, None, None]
    points = (starts + shares * (spots - starts))[:, :, None]
    return np.asarray(((points > taken[:, :2]) & (points < taken[:, 2:])).all(axis=3).any(axis=(0, 2)))


def _tangled(boxes: np.ndarray, spots: np.ndarray, leads: np.ndarray) -> np.ndarray:
    """Tell whether the way from boxes (k x 4) to points (k x 2) crosses other leaders (m x 2 x 2) (k)."""
    first, second = np.clip(spots, boxes[:, :2], boxes[:, 2:])[:, None], spots[:, None]
    here = _side(first, second, leads[:, 0]) * _side(first, second, leads[:, 1])
    there = _side(leads[:, 0], leads[:, 1], first) * _side(leads[:, 0], leads[:, 1], second)
    return np.asarray(((here < 0) & (there < 0)).any(axis=1))


def _side(start: np.ndarray, end: np.ndarray, point: np.ndarray) -> np.ndarray:
    """Return on which side of lines points lie: the sign says it."""
    way, there = end - start, point - start
    return np.asarray(np.round(way[..., 0] * there[..., 1] - way[..., 1] * there[..., 0], 3))


def _cover(boxes: np.ndarray, leads: np.ndarray) -> np.ndarray:
    """Tell whether boxes (k x 4) lie on leaders (m x 2 x 2) (k)."""
    points = leads[:, None, 0] + np.linspace(0, 1, 17)[:, None] * (leads[:, 1] - leads[:, 0])[:, None]
    points = points.reshape(-1, 2)
    return np.asarray(((points > boxes[:, None, :2] - 1) & (points < boxes[:, None, 2:] + 1)).all(axis=2).any(axis=1))


def _hits(boxes: np.ndarray, ink: np.ndarray) -> np.ndarray:
    """Return how many points of lines (rows x, y, half width) boxes (k x 4) cover (k)."""
    low, high = boxes[:, :2].min(axis=0), boxes[:, 2:].max(axis=0)
    near = ((ink[:, :2] + ink[:, 2:] > low) & (ink[:, :2] - ink[:, 2:] < high)).all(axis=1)
    x, y, r = ink[near].T
    left, top, right, bottom = (boxes[:, k, None] for k in range(4))
    return np.asarray(((x > left - r) & (x < right + r) & (y > top - r) & (y < bottom + r)).sum(axis=1))


def _samples(shapes: Iterable[Shape]) -> np.ndarray:
    """Return points on the shapes' lines, about 4 pixels apart, as rows x, y, half width (k x 3)."""
    circles: list[tuple[float, float, float]] = []
    pieces: list[tuple[float, ...]] = []
    for shape in shapes:
        for inner in shape.shapes if isinstance(shape, Glyph) else (shape,):
            if isinstance(inner, Circle):
                circles.append((*inner.center, inner.radius + 1.5))
            else:
                half = HALF_WIDTH.get(inner.style, 2.0)
                points = (*inner.points, inner.points[0]) if inner.closed else inner.points
                pieces += [(*start, *end, half) for start, end in pairwise(points)]
    return np.concatenate([np.array(circles, dtype=float).reshape(-1, 3), _along(np.array(pieces).reshape(-1, 5))])


def _along(pieces: np.ndarray) -> np.ndarray:
    """Return points on straight pieces given as x, y, x, y, half width (k x 5), ends included."""
    start, way, half = pieces[:, :2], pieces[:, 2:4] - pieces[:, :2], pieces[:, 4:]
    counts = np.maximum(1, np.ceil(np.hypot(*way.T) / 4 - 1e-6)).astype(int)
    which = np.repeat(np.arange(len(pieces)), counts + 1)
    step = np.arange(len(which)) - np.repeat(np.cumsum(counts + 1) - counts - 1, counts + 1)
    share = (step / counts[which])[:, None]
    return np.hstack([start[which] + way[which] * share, half[which]])
