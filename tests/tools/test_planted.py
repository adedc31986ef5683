"""`make planted`: marks tell which test comes to a place, mistakes go where they were drawn, the list still fits."""

from pathlib import Path

import pytest

from tests.support import ROOT
from tests.tools.places import HEAD, marked
from tests.tools.planted import Mistake, Recorded, mistakes

MODULE = '''"""A module."""

from __future__ import annotations


def sign(x: int) -> int:
    if x > 0:
        return 1
    elif x < 0:
        return -1
    return 0
'''


@pytest.mark.parametrize("line", [7, 8, 9, 10, 11])
def test_a_mark_tells_that_a_line_is_reached_and_changes_nothing_else(line: int) -> None:
    text = marked(MODULE, {5: line})
    space: dict[str, object] = {"__name__": "marked"}
    exec(text.replace(HEAD.rstrip(), "seen = []\n_qdot_mark = seen.append"), space)
    assert [space["sign"](x) for x in (3, -3, 0)] == [1, -1, 0]  # type: ignore[operator]
    reached = {7: 3, 8: 1, 9: 3, 10: 1, 11: 1}  # a line of an `elif` is marked before its `if`
    assert space["seen"] == [5] * reached[line]
    assert text.index("__future__") < text.index("_qdot_mark")


def test_a_mistake_is_put_at_the_place_nearest_to_where_it_was_drawn() -> None:
    mistake = Mistake(0, "a.py", 4, "x = 1", "x = 2", "number")
    assert mistake.planted("x = 1\n\n\nx = 1\n") == "x = 1\n\n\nx = 2\n"
    with pytest.raises(ValueError, match="no longer holds"):
        mistake.planted("y = 1\n")


def test_most_of_the_mistakes_that_are_kept_can_be_planted_today() -> None:
    """If too many lines were rewritten, write others into planted.json."""
    kept = mistakes()
    assert [one.number for one in kept] == list(range(120))
    able = [one for one in kept if (ROOT / one.path).exists() and one.old in (ROOT / one.path).read_text("utf-8")]
    for one in able:
        text = (ROOT / one.path).read_text(encoding="utf-8")
        assert one.planted(text) != text
        if not one.in_site:
            compile(one.planted(text), one.path, "exec")
    assert len(able) >= 110
    assert len({Path(one.path).parent for one in able}) >= 15


def test_tests_are_chosen_by_name_then_by_time_and_then_by_file(tmp_path: Path) -> None:
    lines = ["3\ttests/a/test_b.py::slow@group", "3\ttests/a/test_b.py::quick", "3\ttests/a/test_exact.py::one"]
    lines += ["took\ttests/a/test_b.py::slow@group\t9", "took\ttests/a/test_b.py::quick\t1"]
    lines += ["took\ttests/a/test_b.py::other\t0.1", "took\ttests/a/test_exact.py::one\t5", "3\tnobody.py::unknown"]
    (tmp_path / "marks").write_text("\n".join(lines))
    recorded = Recorded.of(tmp_path / "marks")
    chosen = recorded.chosen(Mistake(3, "exercises/formula/exact.py", 1, "", "", ""))
    assert [test.split("/")[-1] for test in chosen] == [
        "test_exact.py::one", "test_b.py::quick", "test_b.py::slow", "test_b.py::other",
    ]  # fmt: skip
    left = recorded.only({"tests/a/test_b.py::slow"}).chosen(Mistake(3, "exercises/formula/exact.py", 1, "", "", ""))
    assert left == ["tests/a/test_b.py::slow"]
