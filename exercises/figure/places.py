"""The places that one label may take, and which of them is best among all others' labels and leaders."""

import math
from collections.abc import Sequence
from functools import lru_cache

from qdot.exercises.figure.ink import Ink, Line
from qdot.exercises.figure.shapes import Box, Pair, TextRun, extent

ROUND = tuple(sorted(range(-160, 181, 20), key=abs))
FURTHER = (0.0, 6.0, 14.0, 26.0, 42.0, 60.0, 80.0)
"""Where a label may stand: turned away from the wished direction (degrees), and further from the anchor (pixels)."""
BOX_COST, OUTSIDE_COST = 400_00, 400_00
LEADER_COST, CONFUSED_COST, CROSSED_COST = 14_00, 70_00, 120_00
INK_COST, INKED, MORE_INK_COST = 14_00, 10, 1_00
"""In hundredths: for each label that is overlapped, for a place outside of the figure; what a leader costs, and one
that is needed because something else of the kind is nearer, and one that crosses another label or its leader, as a
label does that lies on a leader; for each of the first points of lines that are covered, and more for each of all."""
CLEARLY = 2.0
"""By so many pixels its own thing should be nearer to a label than others of the kind."""
EDGE = 4.0
"""Pixels that are kept free at the edge of the figure."""
WAY = (0.1, 0.3, 0.5, 0.7, 0.9)


_Turn = tuple[float, float]
"""Cosine and sine."""
_Listed = tuple[int, int, int, float, _Turn]
"""A place: what it costs by itself (hundredths), its number, which anchor it is at, how far from it, where around."""


@lru_cache(maxsize=64)
def _order(anchors: int) -> tuple[_Listed, ...]:
    """Return the places around so many anchors, the cheapest first."""
    listed: list[_Listed] = []
    for anchor in range(anchors):
        for further in FURTHER:
            for turn in map(math.radians, ROUND):
                cost = round(100 * (1.2 * further + 9.0 * abs(turn) + 1.5 * anchor))
                listed.append((cost, len(listed), anchor, further, (math.cos(turn), math.sin(turn))))
    return tuple(sorted(listed))


class _Place:
    """A place for a label, and what is known of it whatever other labels do: found out when it is asked for.

    `own` is what it costs by itself, `inked` with the lines that it covers, `least` as far as is known.
    """

    __slots__ = ("box", "end", "hits", "inked", "leader", "least", "own")

    def __init__(self, box: Box, own: int) -> None:
        self.box, self.own, self.least = box, own, own
        self.hits = self.leader = -1
        self.inked, self.end = own, (0.0, 0.0)


class Places:
    """The places of one label that stands `gap` pixels from one of its anchors, each with a wished direction.

    `far` is the distance from which on it needs a leader; `rivals` are points of other things of the kind.
    """

    def __init__(
        self,
        pieces: tuple[TextRun, ...],
        anchors: Sequence[tuple[Pair, Pair]],
        gap: float,
        far: float,
        rivals: Sequence[Pair],
        ink: Ink,
        size: Pair,
    ) -> None:
        self._gap, self._far, self._rivals, self._ink = gap, far, rivals, ink
        w, h = extent(pieces)
        self._half = (w / 2, h / 2)
        self._right, self._bottom = size[0] - EDGE, size[1] - EDGE
        self._anchors = [(*spot, *_unit(wish)) for spot, wish in anchors]
        self._spots = tuple(dict.fromkeys(spot for spot, _ in anchors))
        self._known: dict[int, _Place] = {}
        x, y = zip(*self._spots, strict=True)
        far = gap + FURTHER[-1] + 2 * w
        self._reach: Box = (min(x) - far, min(y) - far, max(x) + far, max(y) + far)
        self._all: Box | None = None

    def best(self, taken: Sequence[Box], lines: Sequence[Line], most: float) -> tuple[Box, float] | None:
        """Return the cheapest box and its cost: places by what they cost by themselves, until none can be cheaper.

        Around it are other labels' boxes and leaders. Costs are whole hundredths, and a tie goes to the place with the
        least number, on every machine. Nothing is returned where all cost more than `most`.
        """
        x0, y0, x1, y1 = self._reach
        taken = [box for box in taken if box[0] < x1 and box[2] > x0 and box[1] < y1 and box[3] > y0]
        room = [(left - 2, top - 1, right + 2, bottom + 1) for left, top, right, bottom in taken]
        known = self._known
        best, least = -1, math.ceil(100 * min(most, 1e9)) + 1
        for own, number, anchor, further, turn in _order(len(self._anchors)):
            if own > least or (own == least and number > best):
                break
            place = known.get(number)
            if place is None:
                place = known[number] = self._place(own, anchor, further, turn)
            if place.least > least:
                continue
            left, top, right, bottom = place.box
            over = 0
            for x0, y0, x1, y1 in room:
                if left < x1 and right > x0 and top < y1 and bottom > y0:
                    over += BOX_COST
            if over + place.least > least:
                continue
            cost = over + self._inked(place, lines)
            if cost <= least:
                if place.leader < 0:
                    self._find_out(place)
                cost += place.leader
                if place.leader and cost <= least and _is_crossed(place.box, place.end, taken, lines):
                    cost += CROSSED_COST
                if cost < least or (cost == least and number < best):
                    best, least = number, cost
        return (known[best].box, least / 100) if best >= 0 else None

    def _place(self, own: int, anchor: int, further: float, turn: _Turn) -> _Place:
        """Return the place whose box touches a circle of radius gap + further around the anchor from outside."""
        (w, h), (x, y, u, v), (cos, sin) = self._half, self._anchors[anchor], turn
        c, s = u * cos - v * sin, v * cos + u * sin
        aside, above = abs(c), abs(s)
        reach = self._gap + further + (w / aside if w * above < h * aside else h / above)
        x, y = x + c * reach, y + s * reach
        box = left, top, right, bottom = x - w, y - h, x + w, y + h
        inside = left >= EDGE and top >= EDGE and right <= self._right and bottom <= self._bottom
        return _Place(box, own if inside else own + OUTSIDE_COST)

    def _inked(self, place: _Place, lines: Sequence[Line]) -> int:
        """Return what a place costs by itself and with the lines that it covers, other labels' leaders among them."""
        if place.hits < 0:
            place.hits = self._ink.hits(place.box)
            place.least = place.inked = place.own + _ink_cost(place.hits)
        near = [line for line in lines if line.is_near(place.box)] if lines else lines
        if not near:
            return place.inked
        cost = place.own + _ink_cost(place.hits + sum(line.hits(place.box) for line in near))
        return cost + CROSSED_COST * any(line.is_under(place.box) for line in near)

    def _find_out(self, place: _Place) -> None:
        """Find out whether a place needs a leader, to where, and what that costs wherever others are."""
        own, place.end = self.nearest(place.box)
        if self._is_confused(place.box, own):
            place.leader = LEADER_COST + CONFUSED_COST
        else:
            place.leader = LEADER_COST if own > self._far else 0
        place.least += place.leader

    def nearest(self, box: Box) -> tuple[float, Pair]:
        """Return the distance of a box from what the label names, and the point of it that is nearest."""
        gaps = [_gap(box, spot) for spot in self._spots]
        own = min(gaps)
        return own, self._spots[gaps.index(own)]

    def _is_confused(self, box: Box, own: float) -> bool:
        """Whether something else of the kind is not clearly further away than its own thing is."""
        for rival in _near(box, self._rivals, own + CLEARLY):
            gap = _gap(box, rival)
            if own > gap - CLEARLY and (gap < self._far or self._is_around(rival)):
                return True
        return False

    def _is_around(self, rival: Pair) -> bool:
        """Whether a point is within reach of any place: what is far from all of them confuses nobody."""
        (x, y), far = rival, self._far
        left, top, right, bottom = self._around()
        return left - far < x < right + far and top - far < y < bottom + far

    def _around(self) -> Box:
        """Return the box of all places."""
        if self._all is None:
            last = [
                self._place(0, anchor, further, turn).box
                for _, _, anchor, further, turn in _order(len(self._anchors))
                if further == FURTHER[-1]
            ]
            left, top, right, bottom = zip(*last, strict=True)
            self._all = min(left), min(top), max(right), max(bottom)
        return self._all

    def needs_leader(self, box: Box) -> bool:
        """Whether a label in a box stands far off, or nearer to something else of the kind."""
        own, _ = self.nearest(box)
        return own > self._far or any(_gap(box, rival) < own for rival in _near(box, self._rivals, own))


def _unit(wish: Pair) -> Pair:
    """Return the unit vector along a direction; some, where a link seen end-on has none."""
    turn = math.atan2(wish[1], wish[0])
    return math.cos(turn), math.sin(turn)


def _ink_cost(hits: int) -> int:
    return INK_COST * (hits if hits < INKED else INKED) + MORE_INK_COST * hits


def _gap(box: Box, point: Pair) -> float:
    """Return the distance of a box from a point; 0 inside. Rounded, so that it is the same on every machine."""
    left, top, right, bottom = box
    x, y = point
    aside = left - x if x < left else x - right if x > right else 0.0
    above = top - y if y < top else y - bottom if y > bottom else 0.0
    return round((math.hypot(aside, above) if aside and above else aside + above) * 1000) / 1000


def _near(box: Box, points: Sequence[Pair], most: float) -> list[Pair]:
    """Return the points that may be less than `most` away from a box."""
    left, top, right, bottom = box[0] - most - 0.01, box[1] - most - 0.01, box[2] + most + 0.01, box[3] + most + 0.01
    return [point for point in points if left < point[0] < right and top < point[1] < bottom]


def leader_start(box: Box, spot: Pair) -> Pair:
    """Return the point of a box that is nearest to a point."""
    return min(max(spot[0], box[0]), box[2]), min(max(spot[1], box[1]), box[3])


def _is_crossed(box: Box, spot: Pair, taken: Sequence[Box], lines: Sequence[Line]) -> bool:
    """Whether the way from a box to a point crosses other boxes or leaders."""
    (x, y), (u, v) = start, _ = leader_start(box, spot), spot
    x0, x1, y0, y1 = min(x, u), max(x, u), min(y, v), max(y, v)
    for left, top, right, bottom in taken:
        if left < x1 and right > x0 and top < y1 and bottom > y0:
            for share in WAY:
                if left < x + share * (u - x) < right and top < y + share * (v - y) < bottom:
                    return True
    return any(line.crosses(start, spot) for line in lines)
