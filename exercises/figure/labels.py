"""Where labels go: each at the best place near its anchor that covers neither lines nor other labels.

A label should be nearer to what it names than to anything else of that kind; one that is not, or that stands far off,
gets a thin line that leads to it.
"""

import math
from dataclasses import dataclass, replace
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


def place(requests: list[Request], shapes: list[Shape], width: float, height: float, rounds: int = 1) -> Placement:
    """Place the labels greedily, those of lowest rank first, among shapes in a box of width x height pixels.

    In each further round every label takes the place that is best when all others stay where they are.
    """
    ink = _samples(shapes)
    reaches = [np.array((*request.spots, *request.reach)) for request in requests]
    kinds = [[k for k, other in enumerate(requests) if other.kind == request.kind] for request in requests]
    boxes: dict[int, Box] = {}
    costs: dict[int, float] = {}
    leaders: dict[int, Polyline] = {}
    order = sorted(range(len(requests)), key=lambda k: requests[k].rank)
    for i in order * rounds:
        rivals = np.concatenate([np.empty((0, 2)), *(reaches[k] for k in kinds[i] if k != i)])
        taken = np.array([box for k, box in boxes.items() if k != i]).reshape(-1, 4)
        lines = np.concatenate([ink, *(_samples([line]) for k, line in leaders.items() if k != i)])
        leads = np.array([line.points for k, line in leaders.items() if k != i]).reshape(-1, 2, 2)
        boxes[i], costs[i] = _best(requests[i], _Around(lines, taken, rivals, leads, (width, height)))
        leaders.pop(i, None)
        if _needs_leader(boxes[i], requests[i], rivals):
            leaders[i] = _leader(boxes[i], _nearest(boxes[i], requests[i].spots))
    texts = tuple(_text(requests[i], boxes[i]) for i in order)
    return Placement(texts, tuple(leaders.values()), sum(costs.values()))


def _text(request: Request, box: Box) -> Text:
    middle, base = (box[0] + box[2]) / 2, (box[1] + box[3]) / 2 + 0.27 * FONT
    return Text(middle, base, runs(request.pieces), request.style, box, _nearest(box, request.spots))


def _needs_leader(box: Box, request: Request, rivals: np.ndarray) -> bool:
    own, other = (_gaps(np.array([box]), p).min(initial=np.inf) for p in (np.array(request.spots), rivals))
    return bool(own > min(request.far, other))


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


@dataclass(frozen=True)
class _Around:
    """What a label has around it: points on lines (k x 3), labels' boxes (k x 4), other things of its kind (k x 2).

    `leads` are the leaders of other labels (k x 2 x 2).
    """

    ink: np.ndarray
    taken: np.ndarray
    rivals: np.ndarray
    leads: np.ndarray
    size: Pair


def _best(request: Request, around: _Around) -> tuple[Box, float]:
    """Return the cheapest box and its cost: candidates by what they cost by themselves, until no other can be cheaper.

    Costs are rounded, and a tie goes to the first candidate, on every machine.
    """
    boxes, costs = _candidates(request)
    left, top, right, bottom = boxes.T
    low, high = boxes[:, :2].min(axis=0), boxes[:, 2:].max(axis=0)
    ink, taken = around.ink, around.taken
    ink = ink[((ink[:, :2] + ink[:, 2:] > low) & (ink[:, :2] - ink[:, 2:] < high)).all(axis=1)]
    taken = taken[(taken[:, :2] - 2 <= high).all(axis=1) & (taken[:, 2:] + 2 >= low).all(axis=1)]
    for box in taken:
        over = (left < box[2] + 2) & (right > box[0] - 2) & (top < box[3] + 1) & (bottom > box[1] - 1)
        costs = costs + BOX_COST * over
    outside = (left < 4) | (top < 4) | (right > around.size[0] - 4) | (bottom > around.size[1] - 4)
    costs = np.round(costs + OUTSIDE_COST * outside + CROSSED_COST * _cover(boxes, around.leads), 2)
    rivals, spots = around.rivals, np.array(request.spots)
    rivals = rivals[((rivals > low - request.far) & (rivals < high + request.far)).all(axis=1)]
    order = np.argsort(costs, kind="stable")
    best, least = int(order[0]), np.inf
    for start in range(0, len(order), BATCH):
        some = order[start : start + BATCH]
        if costs[some[0]] > least:
            break
        led = _leader_cost(boxes[some], spots, rivals, replace(around, taken=taken), request.far)
        totals = np.round(costs[some] + _ink_cost(boxes[some], ink) + led, 2)
        found = int(some[totals == totals.min()].min())
        if (float(totals.min()), found) < (least, best):
            best, least = found, float(totals.min())
    x0, y0, x1, y1 = boxes[best].tolist()
    return (x0, y0, x1, y1), least


def _leader_cost(boxes: np.ndarray, spots: np.ndarray, rivals: np.ndarray, around: _Around, far: float) -> np.ndarray:
    """Return what it costs boxes (k x 4) to need a leader (k) to the nearest of some points (m x 2)."""
    gaps = _gaps(boxes, spots)
    own = gaps.min(axis=1)
    confused = own > _gaps(boxes, rivals).min(axis=1, initial=np.inf) - CLEARLY
    led = confused | (own > far)
    if not led.any():
        return np.zeros(len(boxes))
    ends = spots[gaps.argmin(axis=1)]
    crossed = _crossed(boxes, ends, around.taken) | _tangled(boxes, ends, around.leads)
    return np.asarray(led * (LEADER_COST + CONFUSED_COST * confused + CROSSED_COST * crossed))


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


def _ink_cost(boxes: np.ndarray, ink: np.ndarray) -> np.ndarray:
    """Return what it costs boxes (k x 4) to cover lines (k)."""
    low, high = boxes[:, :2].min(axis=0), boxes[:, 2:].max(axis=0)
    near = ((ink[:, :2] + ink[:, 2:] > low) & (ink[:, :2] - ink[:, 2:] < high)).all(axis=1)
    x, y, r = ink[near].T
    left, top, right, bottom = (boxes[:, k, None] for k in range(4))
    hits = ((x > left - r) & (x < right + r) & (y > top - r) & (y < bottom + r)).sum(axis=1)
    return np.asarray(14.0 * np.minimum(hits, 10) + 1.0 * hits)


def _samples(shapes: list[Shape]) -> np.ndarray:
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
