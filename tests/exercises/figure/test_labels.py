"""Where labels go: the lines that they cover are counted, and the cheapest place is found, as by looking at all."""

import math
from itertools import product

import pytest

from exercises.figure.ink import Ink, Line, samples
from exercises.figure.labels import Layout, Request
from exercises.figure.places import Places
from exercises.figure.shapes import Box, Circle, Glyph, Polyline, Shape, moved, symbol

SHAPES: tuple[Shape, ...] = (
    Polyline(((40.0, 300.0), (180.0, 140.0), (330.0, 170.0)), "link"),
    Polyline(((20.0, 310.0), (60.0, 310.0), (40.0, 330.0)), "plate", True),
    Glyph(1, "R", (Circle((180.0, 140.0), 9.0, "joint-face"), Circle((180.0, 140.0), 2.4, "dot"))),
)
BOXES = [(x, y, x + 31.0, y + 17.4) for x, y in product(range(10, 340, 15), range(100, 330, 11))]
SIZE = (520.0, 360.0)


def by_hand(box: Box, shapes: tuple[Shape, ...]) -> int:
    left, top, right, bottom = box
    points = samples(shapes).tolist()
    return sum(left - r < x < right + r and top - r < y < bottom + r for x, y, r in points)


def places(*rivals: tuple[float, float]) -> Places:
    anchors = (((180.0, 140.0), (0.6, 0.8)), ((330.0, 170.0), (0.0, -1.0)))
    return Places(symbol("O", "1"), anchors, 11.0, 23.0, rivals, Ink(SHAPES), SIZE)


def test_points_in_a_box_are_counted_as_one_by_one() -> None:
    ink, counts = Ink(SHAPES), [by_hand(box, SHAPES) for box in BOXES]
    assert [ink.hits(box) for box in BOXES] == counts and len(set(counts)) > 5


def test_a_leader_is_a_line_like_others() -> None:
    shape = Polyline(((100.0, 200.0), (140.0, 260.0)), "leader")
    line = Line(shape)
    assert [line.hits(box) for box in BOXES] == [by_hand(box, (shape,)) for box in BOXES]
    assert all(line.is_near(box) for box in BOXES if line.hits(box) or line.is_under(box))
    assert line.crosses((90.0, 240.0), (150.0, 220.0)) and not line.crosses((90.0, 240.0), (90.0, 200.0))


@pytest.mark.parametrize("rivals", [(), ((195.0, 160.0), (330.0, 150.0))])
def test_no_place_is_cheaper_than_the_best(rivals: tuple[tuple[float, float], ...]) -> None:
    taken = [(190.0, 145.0, 230.0, 165.0), (310.0, 130.0, 360.0, 150.0)]
    found = places(*rivals).best(taken, [], math.inf)
    assert found is not None
    box, cost = found
    assert places(*rivals).best(taken, [], cost) == found
    assert places(*rivals).best(taken, [], cost - 0.02) is None
    assert not any(box[0] < b[2] and b[0] < box[2] and box[1] < b[3] and b[1] < box[3] for b in taken)


def test_a_link_seen_end_on_still_has_a_label() -> None:
    nowhere = Places(symbol("a", "1"), [((90.0, 90.0), (0.0, -0.0))], 8.0, 20.0, (), Ink(SHAPES), SIZE)
    assert nowhere.best([], [], math.inf) is not None


def test_labels_that_cost_too_much_are_given_up() -> None:
    requests = [Request(symbol("O", str(k)), (((180.0, 140.0), (0.6, 0.8)),), kind="origin") for k in range(4)]
    whole = Layout(requests, SHAPES, SIZE)
    assert whole.place_all() and whole.cost > 1.0
    assert Layout(requests, SHAPES, SIZE).place_all(whole.cost)
    assert not Layout(requests, SHAPES, SIZE).place_all(whole.cost - 1.0)


def test_what_is_moved_keeps_its_form() -> None:
    there = tuple(moved(shape, (7.0, -5.0)) for shape in SHAPES)
    assert there != SHAPES
    back = samples(there) - (7.0, -5.0, 0.0)
    assert abs(back - samples(SHAPES)).max() < 1e-9
