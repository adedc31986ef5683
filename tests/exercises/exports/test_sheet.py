"""What is on a sheet, as data."""

from exercises.exports.sheet import ROW, Box


def test_a_box_has_room_for_its_working_and_for_each_of_its_rows() -> None:
    assert Box(40).room > 40 + ROW
    assert Box(40, rows=3).room == Box(40).room + 2 * ROW
    assert Box(50, rows=2, height=9).room == Box(0, rows=2, height=9).room + 50
