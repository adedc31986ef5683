"""Where labels go: each at the best place near its anchor that covers neither lines nor other labels."""

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from exercises.figure.shapes import FONT, Circle, Glyph, Pair, Piece, Shape, Text, extent, runs

HALF_WIDTH = {"link": 6.0, "rod": 4.0, "plate": 1.0}
ROUND = np.radians(sorted(range(-160, 181, 20), key=abs))
FURTHER = np.array([0.0, 6.0, 14.0, 26.0, 42.0])[:, None]
"""Where a label may stand: turned away from the wished direction (rad), and further from the anchor (pixels)."""
BOX_COST, OUTSIDE_COST = 400.0, 400.0
BATCH = 48
"""Candidates that are compared with the lines at once."""


@dataclass(frozen=True)
class Request:
    """A label that wants to stand `gap` pixels from one of its anchors, each with a wished direction (y down)."""

    pieces: tuple[Piece, ...]
    anchors: tuple[tuple[Pair, Pair], ...]
    style: str = "text"
    gap: float = 5.0
    rank: int = 0


@dataclass(frozen=True)
class Placement:
    """The labels and what their places cost: 0 is perfect, more than BOX_COST means that two overlap."""

    texts: tuple[Text, ...]
    cost: float


def place(requests: list[Request], shapes: list[Shape], width: float, height: float) -> Placement:
    """Place the labels greedily, those of lowest rank first, among shapes in a box of width x height pixels."""
    ink = _samples(shapes)
    boxes: list[tuple[float, float, float, float]] = []
    texts, total = [], 0.0
    for request in sorted(requests, key=lambda r: r.rank):
        box, cost = _best(request, ink, boxes, (width, height))
        boxes.append(box)
        total += cost
        middle, base = (box[0] + box[2]) / 2, (box[1] + box[3]) / 2 + 0.27 * FONT
        texts.append(Text(middle, base, runs(request.pieces), request.style, box))
    return Placement(tuple(texts), total)


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


def _best(
    request: Request, ink: np.ndarray, taken: list[tuple[float, float, float, float]], size: Pair
) -> tuple[tuple[float, float, float, float], float]:
    """Return the cheapest box and its cost: candidates by what they cost by themselves, until no other can be cheaper.

    Costs are rounded, and a tie goes to the first candidate, on every machine.
    """
    boxes, costs = _candidates(request)
    left, top, right, bottom = boxes.T
    low, high = boxes[:, :2].min(axis=0), boxes[:, 2:].max(axis=0)
    ink = ink[((ink[:, :2] + ink[:, 2:] > low) & (ink[:, :2] - ink[:, 2:] < high)).all(axis=1)]
    for box in taken:
        if box[0] - 2 > high[0] or box[2] + 2 < low[0] or box[1] - 2 > high[1] or box[3] + 2 < low[1]:
            continue
        over = (left < box[2] + 2) & (right > box[0] - 2) & (top < box[3] + 1) & (bottom > box[1] - 1)
        costs = costs + BOX_COST * over
    outside = (left < 4) | (top < 4) | (right > size[0] - 4) | (bottom > size[1] - 4)
    costs = np.round(costs + OUTSIDE_COST * outside, 2)
    order = np.argsort(costs, kind="stable")
    best, least = int(order[0]), np.inf
    for start in range(0, len(order), BATCH):
        some = order[start : start + BATCH]
        if costs[some[0]] > least:
            break
        totals = np.round(costs[some] + _ink_cost(boxes[some], ink), 2)
        found = int(some[totals == totals.min()].min())
        if (float(totals.min()), found) < (least, best):
            best, least = found, float(totals.min())
    x0, y0, x1, y1 = boxes[best].tolist()
    return (x0, y0, x1, y1), least


def _ink_cost(boxes: np.ndarray, ink: np.ndarray) -> np.ndarray:
    """Return what it costs boxes (k x 4) to cover lines (k)."""
    low, high = boxes[:, :2].min(axis=0), boxes[:, 2:].max(axis=0)
    near = ((ink[:, :2] + ink[:, 2:] > low) & (ink[:, :2] - ink[:, 2:] < high)).all(axis=1)
    x, y, r = ink[near].T
    left, top, right, bottom = (boxes[:, k, None] for k in range(4))
    hits = ((x > left - r) & (x < right + r) & (y > top - r) & (y < bottom + r)).sum(axis=1)
    return np.asarray(14.0 * np.minimum(hits, 6) + 1.0 * hits)


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
