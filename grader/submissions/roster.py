"""Find the student who made a submission, by looking up a platform's identifiers and names in the roster.

The owner is never guessed: if several students fit, all of them are returned.
"""

import re
import unicodedata
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from qdot.grader.submissions.layouts import SubmittedPath, check_safely

if TYPE_CHECKING:
    from qdot.exercises.assignment.assignment import Student

_ID_COLUMN = re.compile(r"id\b|identif|login|user|mail|sis\b|matri|participant|(student|candidate).?(no|nr|number)")
"""Matches the names of the roster columns that may contain a platform's identifiers; a seat number is not one."""


SAME_NAME = "several students have this name"
"""The reason if students have the same name, so that only the metadata of their notebooks can tell them apart."""


@dataclass(frozen=True)
class PossibleOwners:
    """The students who may have made a submission: only the owner if certain, otherwise all who fit, and the reason."""

    students: tuple[str, ...]
    reason: str = ""

    @property
    def is_certain(self) -> bool:
        """Whether exactly one student can have made the submission."""
        return len(self.students) == 1 and not self.reason


class Roster:
    """Looks up the owner of a submission in a class.

    `moodle_numbers` maps the Moodle numbers under which `qdot release` packed notebooks to the students.
    """

    def __init__(self, students: "Sequence[Student]", moodle_numbers: Mapping[str, str] | None = None) -> None:
        from qdot.exercises.assignment.handout import make_file_name  # a student's `qdot check` needs no assignment

        names = {_fold_case(make_file_name(student)): student.id for student in students}
        self._student_ids: dict[str, str] = names | {_fold_case(student.id): student.id for student in students}
        self._other_ids: dict[str, set[str]] = {}
        self._names: dict[str, set[str]] = {}
        ids = self._student_ids.values()
        self._moodle_numbers = {number: owner for number, owner in (moodle_numbers or {}).items() if owner in ids}
        for student in students:
            identifiers = [value for column, value in student.other_cells if _ID_COLUMN.search(column)]
            for text in (student.email, student.email.partition("@")[0], *identifiers):
                if text.strip():
                    self._other_ids.setdefault(_fold_case(text), set()).add(student.id)
            for name in set(_list_spellings(student.name)):
                self._names.setdefault(name, set()).add(student.id)

    def find_owner(self, submitted_path: SubmittedPath) -> PossibleOwners:
        """Return the student after whom a submitted path is named, or all students who fit the identifiers and name."""
        path = submitted_path.path
        path_name = _fold_case(path.name if check_safely(path.is_dir) else path.stem)
        if path_name in self._student_ids:
            return PossibleOwners((self._student_ids[path_name],))
        texts = [*map(_fold_case, submitted_path.ids), path_name]
        student_id_owners = {self._student_ids[text] for text in texts if text in self._student_ids}
        id_owners = student_id_owners or {owner for text in texts for owner in self._other_ids.get(text, ())}
        if submitted_path.platform == "Moodle":
            id_owners |= {self._moodle_numbers[text] for text in submitted_path.ids if text in self._moodle_numbers}
        name_owners = self._find_by_name(submitted_path.name)
        # An identifier decides unless the name contradicts it; a student's own id always decides.
        if len(id_owners) == 1 and (student_id_owners or not name_owners or id_owners <= name_owners):
            return PossibleOwners(tuple(id_owners))
        if len(id_owners) > 1 and len(id_owners & name_owners) == 1:
            return PossibleOwners(tuple(id_owners & name_owners))
        if id_owners and name_owners and not id_owners & name_owners:
            students = tuple(sorted(id_owners | name_owners))
            return PossibleOwners(students, "its name and its number belong to different students")
        if id_owners:
            return PossibleOwners(tuple(sorted(id_owners)), "its identifier fits several students")
        reason = SAME_NAME if len(name_owners) > 1 else ""
        return PossibleOwners(tuple(sorted(name_owners)), reason)

    def _find_by_name(self, name: str) -> set[str]:
        """Return the students with this name; an empty set if there are none.

        The name is tried unchanged, then without accents, then without a group's name before the student's name.
        """
        spellings = [name, _strip_accents(name), *(name.split("-", n)[-1] for n in range(1, name.count("-") + 1))]
        return next(filter(None, (self._names.get("".join(_split_words(spelling))) for spelling in spellings)), set())


def _fold_case(text: str) -> str:
    """Return a text in which case and the encoding of letters no longer matter."""
    return unicodedata.normalize("NFC", text.strip()).casefold()


def _strip_accents(name: str) -> str:
    return "".join(char for char in unicodedata.normalize("NFKD", name) if not unicodedata.combining(char))


def _split_words(name: str) -> list[str]:
    """Return the words of a name in lower case, without punctuation."""
    return re.findall(r"[^\W_]+", unicodedata.normalize("NFC", name).casefold())


def _list_spellings(name: str) -> Iterator[str]:
    """Yield the spellings of a name that platforms use, without spaces: "Ada King Lovelace" may be kinglovelaceada."""
    for spelling in (name, _strip_accents(name)):
        words = _split_words(spelling)
        for first_index in range(len(words)):
            yield "".join(words[first_index:] + words[:first_index])
