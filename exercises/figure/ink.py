"""The lines of a drawing as points, sorted so that the points in a box can be counted fast."""

from bisect import bisect_left, bisect_right
from collections.abc import Iterable
from functools import lru_cache
from itertools import accumulate, pairwise
from operator import or_

import numpy as np

from qdot.exercises.figure.shapes import Box, Circle, Glyph, Pair, Polyline, Shape

HALF_WIDTH = {"link": 6.0, "rod": 4.0, "plate": 1.0}
THIN, EDGE = 2.0, 1.5
"""Half the width of other lines, with some air, and the air around a circle."""


@lru_cache(maxsize=8)
def _bits(count: int) -> tuple[int, ...]:
    return tuple(1 << k for k in range(count))


def _sort_with_sets(values: np.ndarray) -> tuple[list[float], list[int]]:
    """Return sorted numbers, and for each k the set of the indices of the k smallest, as the bits of an integer."""
    order = np.argsort(values)
    bits = _bits(1 << len(values).bit_length())
    return values[order].tolist(), [0, *accumulate(map(bits.__getitem__, order.tolist()), or_)]


class Ink:
    """Points on the lines of shapes, each with half the width of its line."""

    def __init__(self, shapes: Iterable[Shape]) -> None:
        x, y, half = samples(shapes).T
        self._edges = (
            *_sort_with_sets(x - half),
            *_sort_with_sets(x + half),
            *_sort_with_sets(y - half),
            *_sort_with_sets(y + half),
        )

    def hits(self, box: Box) -> int:
        """Return how many points a box covers."""
        left, top, right, bottom = box
        lefts, from_left, rights, from_right, tops, from_top, bottoms, from_bottom = self._edges
        begun = from_left[bisect_left(lefts, right)] & from_top[bisect_left(tops, bottom)]
        ended = from_right[bisect_right(rights, left)] | from_bottom[bisect_right(bottoms, top)]
        return (begun & ~ended).bit_count()


def samples(shapes: Iterable[Shape]) -> np.ndarray:
    """Return points on the shapes' lines, about 4 pixels apart, as rows x, y, half width (k x 3)."""
    circles: list[tuple[float, float, float]] = []
    pieces: list[tuple[float, ...]] = []
    for shape in shapes:
        for inner in shape.shapes if isinstance(shape, Glyph) else (shape,):
            if isinstance(inner, Circle):
                circles.append((*inner.center, inner.radius + EDGE))
            else:
                half = HALF_WIDTH.get(inner.style, THIN)
                points = (*inner.points, inner.points[0]) if inner.closed else inner.points
                pieces += [(*start, *end, half) for start, end in pairwise(points)]
    return np.concatenate(
        [np.array(circles, dtype=float).reshape(-1, 3), _points_along(np.array(pieces).reshape(-1, 5))]
    )


def _points_along(pieces: np.ndarray) -> np.ndarray:
    """Return points on straight pieces given as x, y, x, y, half width (k x 5), ends included."""
    start, way, half = pieces[:, :2], pieces[:, 2:4] - pieces[:, :2], pieces[:, 4:]
    counts = np.maximum(1, np.ceil(np.hypot(*way.T) / 4 - 1e-6)).astype(int)
    which = np.repeat(np.arange(len(pieces)), counts + 1)
    step = np.arange(len(which)) - np.repeat(np.cumsum(counts + 1) - counts - 1, counts + 1)
    share = (step / counts[which])[:, None]
    return np.hstack([start[which] + way[which] * share, half[which]])


class Line:
    """A label's leader among other labels: a straight line with points on it."""

    def __init__(self, shape: Polyline) -> None:
        self.shape = shape
        self.start, self.end = shape.points
        (x0, y0), (x1, y1) = shape.points
        self._ink: list[Pair] = samples((shape,))[:, :2].tolist()
        self._points = [(x0 + k / 16 * (x1 - x0), y0 + k / 16 * (y1 - y0)) for k in range(17)]
        self._low, self._high = (min(x0, x1) - THIN, min(y0, y1) - THIN), (max(x0, x1) + THIN, max(y0, y1) + THIN)

    def is_near(self, box: Box) -> bool:
        """Whether the line may pass through a box."""
        left, top, right, bottom = box
        return right > self._low[0] and left < self._high[0] and bottom > self._low[1] and top < self._high[1]

    def hits(self, box: Box) -> int:
        """Return how many points of the line a box covers."""
        left, top, right, bottom = box[0] - THIN, box[1] - THIN, box[2] + THIN, box[3] + THIN
        return sum(left < x < right and top < y < bottom for x, y in self._ink)

    def is_under(self, box: Box) -> bool:
        """Whether a box covers points of the line."""
        left, top, right, bottom = box
        return any(left - 1 < x < right + 1 and top - 1 < y < bottom + 1 for x, y in self._points)

    def crosses(self, start: Pair, end: Pair) -> bool:
        """Whether the line crosses another one."""
        return _lie_on_both_sides(start, end, self.start, self.end) and _lie_on_both_sides(
            self.start, self.end, start, end
        )


def _lie_on_both_sides(start: Pair, end: Pair, first: Pair, second: Pair) -> bool:
    """Whether two points lie clearly on different sides of a line."""
    first_side, second_side = _side(start, end, first), _side(start, end, second)
    return (first_side < 0 < second_side) or (second_side < 0 < first_side)


def _side(start: Pair, end: Pair, point: Pair) -> int:
    """Return the side of a line on which a point lies, as a sign. Rounded, so that it is the same on every machine."""
    (x0, y0), (x1, y1), (x, y) = start, end, point
    return round(((x1 - x0) * (y - y0) - (y1 - y0) * (x - x0)) * 1000)
