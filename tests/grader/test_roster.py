"""Whose a submission is: by identifiers, which a name may decide between, and never guessed."""

from pathlib import Path

import pytest

from exercises.assignment import Student
from grader.layouts import Handed
from grader.roster import Roster

ROSTER = Roster(
    [
        Student("ada", "Ada Lovelace", "twins@x.org"),
        Student("bo", "Bo Lovelace", "twins@x.org"),
        Student("cy", "Cy Ada", "cy@x.org"),
    ]
)


@pytest.mark.parametrize(
    ("ids", "name", "students"),
    [
        (("ada",), "", ("ada",)),
        (("ADA ",), "Bo Lovelace", ("ada",)),  # a student's own identifier is sure
        (("cy@x.org",), "", ("cy",)),
        (("cy@x.org",), "Ada Lovelace", ("ada", "cy")),
        (("twins@x.org",), "", ("ada", "bo")),
        (("twins@x.org",), "Bo Lovelace", ("bo",)),
        (("twins@x.org",), "Lovelace, Ada", ("ada",)),
        (("twins@x.org",), "Somebody Else", ("ada", "bo")),
        ((), "Lovelace Bo", ("bo",)),
        ((), "Lovelace", ()),
    ],
)
def test_whose_it_is(ids: tuple[str, ...], name: str, students: tuple[str, ...]) -> None:
    match = ROSTER.owner(Handed(Path("hw.ipynb"), ids, name))
    assert match.students == students
    assert bool(match.why) == (len(students) > 1)
