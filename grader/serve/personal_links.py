"""Write the table of personal links for a mail merge. Links in an earlier table that still work stay in it."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

from django.db import transaction

from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.files import write_atomically
from qdot.exercises.common.input_file import BYTE_ORDER_MARK, format_csv, read_table
from qdot.grader.serve.models import Person, make_link_token
from qdot.grader.serve.settings import find_options
from qdot.grader.serve.sign_in import compute_digest

COLUMNS = ("student", "name", "email", "link")
PATH = "/in/"
"""The path of a personal link, between the address of the service and the token."""


class WrittenLinks(NamedTuple):
    """How many links the table has, who has a new one, whose old link stopped working, and whose link is unknown."""

    total: int
    new: list[Person]
    replaced: list[Person]
    unknown: list[Person]


def make_link(person: Person) -> str:
    """Give a person a new personal link, and return its token; the old link stops working and signs the person out."""
    token = make_link_token()
    person.link_digest = compute_digest(token)
    person.session_version += 1
    person.save(update_fields=["link_digest", "session_version"])
    return token


def write_links(
    path: Path, people: Sequence[Person], needs_new: Callable[[Person, bool], bool], url: str = ""
) -> WrittenLinks:
    """Write the table: a link that the table has and that still works stays; people without any get a new link.

    `needs_new(person, is_known)` says who else gets a new link; `is_known` is whether the table has the person's link.
    All links begin with `url`; by default, with the address in the earlier table, or else with the service's address.
    Links are stored only if the table could be written. Raises QdotError.
    """
    old_links = [link.rpartition(PATH) for link in _read_links(path)] if path.exists() else []
    tokens = {compute_digest(token): token for _, _, token in old_links}
    if tokens and not Person.objects.filter(link_digest__in=list(tokens)).exists():
        raise QdotError(f"none of the links in {path} belongs to this class; choose another file with --out")
    service_url = url or next((old_url for old_url, _, _ in old_links if old_url), find_options().url)
    rows, written = list[tuple[str, ...]](), WrittenLinks(0, [], [], [])
    with transaction.atomic():
        for person in people:
            token = tokens.get(person.link_digest or "")
            if person.link_digest is None or needs_new(person, token is not None):
                (written.new if person.link_digest is None else written.replaced).append(person)
                token = make_link(person)
            if token is None:
                written.unknown.append(person)
            else:
                rows.append((person.student_id, person.name, person.email, f"{service_url}{PATH}{token}"))
        if written.unknown and not rows:
            advice = "find the earlier table, or make new links with --renew; the old ones then stop working"
            raise QdotError(f"{path} doesn't exist, and qdot can't write links again: {advice}")
        write_atomically(path, BYTE_ORDER_MARK + format_csv([COLUMNS, *rows]), 0o600)
    return written._replace(total=len(rows))


def _read_links(path: Path) -> list[str]:
    """Return the links in a table that was written before. Raises QdotError if it is another table."""
    rows = read_table(path, COLUMNS[0], ",".join(COLUMNS))
    if rows and COLUMNS[-1] not in rows[0][1]:
        raise QdotError(f"{path} exists, and isn't a table of links; choose another file with --out")
    return [row.get(COLUMNS[-1], "") for _, row in rows]
