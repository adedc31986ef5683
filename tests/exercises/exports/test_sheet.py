"""What is on a sheet, as data: boxes, room for working, and the pieces of a statement."""

from exercises.exports.boxes import LEAST_SHARE, MOST, PACKED_SHARE, ROW, Box, shrunk, with_share, working


def test_a_box_has_room_for_its_working_and_for_each_of_its_rows() -> None:
    assert Box(40).room > 40 + ROW
    assert Box(40, rows=3).room == Box(40).room + 2 * ROW
    assert Box(50, rows=2, height=9).room == Box(0, rows=2, height=9).room + 50
    assert Box(0, rows=3, units=("m", "m", "m")).room == Box(0).room  # side by side


def test_a_long_solution_has_more_room() -> None:
    assert working("") < working("x" * 1000) < working("x" * 10_000) == MOST


def test_working_shrinks_where_an_exam_takes_many_pages() -> None:
    boxes = [Box(20), Box(30)]
    assert shrunk(boxes, fixed=100, page=500) == 1
    assert shrunk(boxes, fixed=100, page=140) == 0.8
    assert shrunk(boxes, fixed=500, page=100) == LEAST_SHARE
    assert shrunk([], fixed=500, page=100) == 1


def test_a_box_that_is_shrunk_may_be_packed_closer_where_pages_are_filled() -> None:
    assert with_share(Box(20), 1.0) == Box(20, packed=20)
    assert with_share(Box(20), 0.65) == Box(13, packed=round(20 * PACKED_SHARE))
