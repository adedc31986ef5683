"""Whose is it: what a platform says of a submission, looked up in the roster, and never guessed."""

import re
import unicodedata
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from qdot.grader.submissions.layouts import Handed

if TYPE_CHECKING:
    from qdot.exercises.assignment.assignment import Student

_IDENTIFIES = re.compile(r"id\b|identif|login|user|mail|sis\b|matri|participant|(student|candidate).?(no|nr|number)")
"""What columns of a roster are called by which a platform may know a student; a seat's number is none."""


@dataclass(frozen=True)
class Match:
    """The students who may have handed something in: one, where it is sure; several where it is not, and why."""

    students: tuple[str, ...]
    why: str = ""


class Roster:
    """A roster, to be asked who a submission is of."""

    def __init__(self, students: "Sequence[Student]") -> None:
        self._own: dict[str, str] = {_folded(student.id): student.id for student in students}
        self._ids: dict[str, set[str]] = {}
        self._names: dict[str, set[str]] = {}
        for student in students:
            others = [value for column, value in student.others if _IDENTIFIES.search(column)]
            for text in (student.email, student.email.partition("@")[0], *others):
                if text.strip():
                    self._ids.setdefault(_folded(text), set()).add(student.id)
            for name in set(_spellings(student.name)):
                self._names.setdefault(name, set()).add(student.id)

    def of_identifier(self, text: str) -> Match | None:
        """Return who has this identifier in the roster, in any case."""
        own = self._own.get(_folded(text))
        return None if own is None else Match((own,))

    def owner(self, handed: Handed) -> Match:
        """Return whose a submission is: by identifiers, which a name may not contradict, else by the name."""
        own = {self._own[text] for text in map(_folded, handed.ids) if text in self._own}
        ids = own or {who for text in handed.ids for who in self._ids.get(_folded(text), ())}
        names = self._named(handed.name)
        if len(ids) == 1 and (own or not names or ids <= names):
            return Match(tuple(ids))
        if len(ids) > 1 and len(ids & names) == 1:
            return Match(tuple(ids & names))
        if ids and names and not ids & names:
            return Match(tuple(sorted(ids | names)), "its name and its number are of different students")
        if ids:
            return Match(tuple(sorted(ids)), "what it is called fits several students")
        return Match(tuple(sorted(names)), "several students have this name" if len(names) > 1 else "")

    def _named(self, name: str) -> set[str]:
        """Return who is called so: as it is written, else without accents, else without a group before the name."""
        for form in (name, _bare(name), *(name.split("-", n)[-1] for n in range(1, name.count("-") + 1))):
            if students := self._names.get(_joined(form)):
                return students
        return set()


def _folded(text: str) -> str:
    return unicodedata.normalize("NFC", text.strip()).casefold()


def _bare(name: str) -> str:
    """Return a name without accents."""
    return "".join(ch for ch in unicodedata.normalize("NFKD", name) if not unicodedata.combining(ch))


def _words(name: str) -> list[str]:
    return re.findall(r"[^\W_]+", unicodedata.normalize("NFC", name).casefold())


def _joined(name: str) -> str:
    return "".join(_words(name))


def _spellings(name: str) -> Iterator[str]:
    """Yield what a platform may make of a name: "Ada King Lovelace" is kinglovelaceada, or has no accents."""
    for form in (name, _bare(name)):
        words = _words(form)
        for first in range(len(words)):
            yield "".join(words[first:] + words[:first])
