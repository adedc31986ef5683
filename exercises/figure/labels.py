"""Where labels go: each at the best place near its anchor that covers neither lines nor other labels."""

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from exercises.figure.shapes import FONT, Circle, Glyph, Pair, Piece, Polyline, Shape, Text, extent, runs

HALF_WIDTH = {"link": 6.0, "rod": 4.0, "plate": 1.0}
ROUND = np.radians(sorted(range(-160, 181, 20), key=abs))
FURTHER = np.array([0.0, 6.0, 14.0, 26.0, 42.0])[:, None]
"""Where a label may stand: turned away from the wished direction (rad), and further from the anchor (pixels)."""
BOX_COST, OUTSIDE_COST = 400.0, 400.0


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
    boxes, costs = _candidates(request)
    left, top, right, bottom = (boxes[:, k, None] for k in range(4))
    low, high = boxes[:, :2].min(axis=0) - 6, boxes[:, 2:].max(axis=0) + 6
    x, y, r = ink[((ink[:, :2] + ink[:, 2:] > low) & (ink[:, :2] - ink[:, 2:] < high)).all(axis=1)].T
    hit = (x > left - r) & (x < right + r) & (y > top - r) & (y < bottom + r)
    costs = costs + 14.0 * np.minimum(hit.sum(axis=1), 6) + 1.0 * hit.sum(axis=1)
    for box in taken:
        over = (left < box[2] + 2) & (right > box[0] - 2) & (top < box[3] + 1) & (bottom > box[1] - 1)
        costs = costs + BOX_COST * over[:, 0]
    outside = (left < 4) | (top < 4) | (right > size[0] - 4) | (bottom > size[1] - 4)
    costs = np.round(costs + OUTSIDE_COST * outside[:, 0], 2)  # rounded: a tie goes to the first on every machine
    best = int(np.argmin(costs))
    found = boxes[best].tolist()
    return (found[0], found[1], found[2], found[3]), float(costs[best])


def _samples(shapes: list[Shape]) -> np.ndarray:
    """Return points on the shapes' lines, about 4 pixels apart, as rows x, y, half width (k x 3)."""
    rows: list[tuple[float, float, float]] = []
    for shape in shapes:
        if isinstance(shape, Glyph):
            rows += [tuple(row) for row in _samples(list(shape.shapes))]
        elif isinstance(shape, Circle):
            rows.append((*shape.center, shape.radius + 1.5))
        else:
            rows += _along(shape)
    return np.array(rows, dtype=float).reshape(-1, 3)


def _along(line: Polyline) -> list[tuple[float, float, float]]:
    half = HALF_WIDTH.get(line.style, 2.0)
    points = [*line.points, line.points[0]] if line.closed else list(line.points)
    rows = []
    for (x0, y0), (x1, y1) in pairwise(points):
        count = max(1, math.ceil(math.hypot(x1 - x0, y1 - y0) / 4 - 1e-6))
        rows += [(x0 + (x1 - x0) * k / count, y0 + (y1 - y0) * k / count, half) for k in range(count + 1)]
    return rows
