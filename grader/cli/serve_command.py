"""`qdot serve`: serve an assignment online, and look after the service."""

import os
import re
import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Annotated
from urllib.parse import urlsplit

import typer

from qdot.exercises.assignment.assignment import load_assignment
from qdot.exercises.assignment.certified_problems import FailedSlot, raise_failed_slots
from qdot.exercises.assignment.release import ReleaseResult, release_notebooks
from qdot.exercises.common.console import note, print_result, show_progress
from qdot.exercises.common.errors import QdotError, count_noun, make_name_error, write_first
from qdot.exercises.common.extras import require_extra
from qdot.exercises.common.parallel import CORE_COUNT
from qdot.exercises.site.pages import find_assets
from qdot.grader.cli.options import JobsOption
from qdot.grader.grading.certify import CERTIFIER

if TYPE_CHECKING:
    from qdot.grader.serve.models import Classroom, Person

FoldersArgument = Annotated[list[Path], typer.Argument(metavar="DIR...", help="Folders of assignments.")]
DatabaseOption = Annotated[
    str,
    typer.Option(metavar="ADDRESS", envvar="QDOT_DATABASE", help="As in postgresql://user@host/qdot. Default: SQLite."),
]
UrlOption = Annotated[
    str,
    typer.Option(
        "--url",
        metavar="URL",
        envvar="QDOT_URL",
        help="The address that browsers open. Default: http://127.0.0.1:PORT.",
    ),
]
PortOption = Annotated[int, typer.Option(min=1, max=65535, help="The port on which the service listens.")]
BackupOption = Annotated[Path, typer.Option("--out", metavar="PATH", help="The zip.")]
DEFAULT_PORT = 8000


def _configure(
    folders: list[Path], database: str, url: str = "", jobs: int = CORE_COUNT, port: int = DEFAULT_PORT
) -> None:
    """Connect to the database of the service, and update its tables. Raises QdotError."""
    require_extra("serve", "qdot serve")
    from qdot.grader.serve.settings import ServiceOptions, configure

    for folder in folders:
        load_assignment(folder)  # reports errors before anything is written
    address = url or f"http://127.0.0.1:{port}"
    configure(ServiceOptions(tuple(folder.resolve() for folder in folders), database, address, jobs))
    from django.db import OperationalError

    from qdot.grader.serve.class_list import update_folder_class
    from qdot.grader.serve.server import prepare_database

    try:
        prepare_database()
    except OperationalError as error:
        raise QdotError(f"the database can't be used: {' '.join(str(error).split())}") from None
    update_folder_class()


def _write_command(name: str, folders: list[Path], database: str, url: str, port: int = DEFAULT_PORT) -> str:
    """Return a command of `qdot serve` for the same service, without options that the environment sets."""
    words = ["qdot", "serve", name, *map(str, folders)]
    if database and database != os.environ.get("QDOT_DATABASE"):
        words += ["--database", re.sub(r":[^:@/]+@", ":PASSWORD@", database)]
    if url and url != os.environ.get("QDOT_URL"):
        words += ["--url", url]
    elif not url and port != DEFAULT_PORT:
        words += ["--port", str(port)]
    return shlex.join(words)


def _find_class(course: int) -> "Classroom":
    """Return the class of a course of a platform, or that of the folder's roster. Raises QdotError."""
    from qdot.grader.serve.class_list import find_folder_class
    from qdot.grader.serve.models import Classroom

    if not course:
        return find_folder_class()
    classroom = Classroom.objects.filter(pk=course, lti_context__isnull=False).first()
    if classroom is None:
        raise QdotError(f"there is no course {course}; `qdot serve connect` lists them")
    return classroom


def start(
    folders: FoldersArgument,
    database: DatabaseOption = "",
    url: UrlOption = "",
    host: Annotated[str, typer.Option(help="The network address on which the service listens.")] = "127.0.0.1",
    port: PortOption = DEFAULT_PORT,
    jobs: JobsOption = CORE_COUNT,
) -> None:
    """Serve assignments online, until Ctrl-C.

    Students answer in the browser and see the verdict at once. They sign in with personal links (`qdot serve links`) or
    come from a learning platform (`qdot serve register`). The database is DIR/online/database.sqlite3, unless
    --database names another one. Put a web server with a certificate in front of it (docs/serve.md), and say with --url
    which address browsers open.

    Examples:
      qdot serve homework
          on this machine, at http://127.0.0.1:8000
      qdot serve week1 week2 --url https://qdot.example.edu --database postgresql:///qdot
          two assignments, behind a web server
    """
    find_assets()  # reports missing pages before anything is generated
    _configure(folders, database, url, jobs, port)
    from qdot.grader.serve.server import claim_database, run_service
    from qdot.grader.serve.settings import find_options

    links_command = _write_command("links", folders, database, url, port)
    ready_message = f"qdot is at {find_options().url}; stop it with Ctrl-C. Personal links: {links_command}"
    with claim_database() as keep_claim:
        for folder in folders:
            _release(folder, jobs)
        note("starting the processes that judge answers, which takes some seconds")
        run_service(find_options(), host, port, keep_claim, lambda: print_result(ready_message))


def _release(folder: Path, jobs: int) -> None:
    """Write the problems of the students on the roster, as `qdot generate` does."""
    assignment = load_assignment(folder)
    failed_slots = list[FailedSlot]()
    if not assignment.roster:
        return
    with show_progress("generating", len(assignment.roster)) as counter:

        def report_student(result: ReleaseResult) -> None:
            failed_slots.extend(result.failed_slots)
            counter.step()

        release_notebooks(assignment, CERTIFIER, min(jobs, len(assignment.roster)), report_student)
    raise_failed_slots(assignment, failed_slots)


def links(
    folders: FoldersArgument,
    database: DatabaseOption = "",
    url: UrlOption = "",
    port: Annotated[int, typer.Option(help="The port in the links, if the service has no --url.")] = DEFAULT_PORT,
    staff: Annotated[
        list[str], typer.Option(metavar="NAME", help="Also make a link for a member of staff. Repeatable.")
    ] = [],  # noqa: B006
    student: Annotated[
        list[str], typer.Option(metavar="ID", help="Make a new link for this person in links.csv. Repeatable.")
    ] = [],  # noqa: B006
    renew: Annotated[bool, typer.Option("--renew", help="Make new links for everybody.")] = False,
    out: Annotated[Path, typer.Option(metavar="PATH", help="The table.")] = Path("links.csv"),
) -> None:
    """Write personal links for a mail merge.

    The table has the columns student, name, email and link. Each link signs one person in. Run the command again after
    a change of roster.csv: links that are in the table stay, and new students get one. Keep the table, because qdot
    stores only digests of the links and can't write them again. A new link, by --student or --renew, replaces the
    person's old one, which stops working at once.

    Examples:
      qdot serve links homework --staff "Grace Hopper"
          links for the class and for a teacher, into links.csv
      qdot serve links homework --student s001
          a new link for a student who passed on the old one
      qdot serve links homework --renew
          new links for everybody, because links.csv is lost
    """
    find_assets()  # reports missing pages before people get links to them
    _configure(folders, database, url, port=port)
    from qdot.grader.serve.class_list import find_folder_class
    from qdot.grader.serve.models import Person
    from qdot.grader.serve.personal_links import write_links
    from qdot.grader.serve.settings import find_options
    from qdot.grader.serve.sign_in import STAFF_PREFIX

    classroom, staff_ids = find_folder_class(), [f"{STAFF_PREFIX}{name}"[:100] for name in staff]
    for identifier, name in zip(staff_ids, staff, strict=True):
        classroom.people.get_or_create(student_id=identifier, defaults={"role": Person.Role.STAFF, "name": name})
    people = {person.student_id: person for person in classroom.people.filter(is_active=True).order_by("student_id")}
    if unknown := sorted(set(student) - set(people)):
        raise make_name_error("student", unknown[0], list(people)[:50])

    def needs_new_link(person: Person, is_in_table: bool) -> bool:
        return renew or person.student_id in student or (person.student_id in staff_ids and not is_in_table)

    has_address = url or port != DEFAULT_PORT
    summary = write_links(out, list(people.values()), needs_new_link, find_options().url if has_address else "")
    new_count = len(summary.new) + len(summary.replaced)
    print_result(f"{count_noun(summary.total, 'link')} in {out}, {new_count} new; send each person only their own link")
    if summary.replaced:
        note(f"the old links of {_write_people(summary.replaced)} no longer work")
    if summary.unknown:
        advice = "find an older copy, or make new ones with --student ID or --renew; the old ones then stop working"
        note(f"{out} lacks the links of {_write_people(summary.unknown)}: {advice}")


def _write_people(people: "list[Person]") -> str:
    return write_first([person.student_id for person in people], 5)


CourseOption = Annotated[
    int,
    typer.Option(metavar="NUMBER", help="A course of a platform (see `qdot serve connect`), not the folder's roster."),
]
FolderArgument = Annotated[Path, typer.Argument(metavar="DIR", help="The folder of the assignment.")]
FileArgument = Annotated[Path, typer.Argument(metavar="FILE", help="The backup, a zip.")]


def export(
    folder: FolderArgument,
    out: Annotated[Path, typer.Option(metavar="PATH", help="The new folder.")],
    database: DatabaseOption = "",
    course: CourseOption = 0,
) -> None:
    """Write a class as a folder for `qdot grade`.

    The folder has the roster, the overrides, the submissions, the secret and the other files of the assignment. Typed
    answers become notebooks, which get the same marks.

    Examples:
      qdot serve export homework --out homework-now
          then: qdot grade homework-now
    """
    _configure([folder], database)
    from qdot.grader.serve.exchange import export_class

    export_class(_find_class(course), load_assignment(folder).key, out)
    print_result(f"{out} contains the class; grade it with: qdot grade {out}")


def import_folder(
    folder: FolderArgument,
    submissions: Annotated[
        Path | None, typer.Argument(metavar="SUBMISSIONS", help="A folder or a platform's zip. Default: DIR/submitted.")
    ] = None,
    database: DatabaseOption = "",
    course: CourseOption = 0,
) -> None:
    """Store submissions from a folder in the database.

    Also stores overrides.csv. A running service grades the submissions. Anything that is stored already is skipped, so
    you can run the command again.

    Examples:
      qdot serve import homework moodle.zip
          what students have submitted elsewhere
    """
    _configure([folder], database)
    from qdot.grader.serve.exchange import import_class

    key = load_assignment(folder).key
    counts = import_class(_find_class(course), key, submissions or folder / "submitted")
    print_result(f"{count_noun(counts[0], 'new submission')}, {count_noun(counts[1], 'new override')}")


def backup(folders: FoldersArgument, out: BackupOption = Path("backup.zip"), database: DatabaseOption = "") -> None:
    """Write the database and the assignments into a zip.

    You don't need to stop the service. The zip contains the secret and everything that students have submitted: store
    it where nobody else can read it.

    Examples:
      qdot serve backup homework --out backup-1.zip
          for `qdot serve restore`
    """
    if out.exists():
        raise QdotError(f"{out} exists already; choose another name with --out")
    _configure(folders, database)
    from qdot.grader.serve.exchange import back_up

    back_up(out)
    print_result(f"{out} contains the database and the assignments; keep it secret")


def restore(file: FileArgument, folders: FoldersArgument, database: DatabaseOption = "") -> None:
    """Replace the database with a backup. Stop the service first.

    Files of the assignments that are missing in their folders are written, too; others stay. A folder may be new and
    have any name, but it can't have another secret or other problems. Everybody has to sign in again. The database may
    differ from that of the backup, for example PostgreSQL instead of SQLite.

    Examples:
      qdot serve restore backup.zip homework
          on the same machine or on a new one
    """
    require_extra("serve", "qdot serve")
    from qdot.grader.serve.backup_files import restore_files

    restore_files(file, folders)
    _configure(folders, database)
    from qdot.grader.serve.exchange import restore as restore_database
    from qdot.grader.serve.server import claim_database

    with claim_database():
        restore_database(file)
    print_result(f"the database now has the contents of {file}; start the service again")


def register(
    folders: FoldersArgument,
    platform: Annotated[str, typer.Option(metavar="NAME", help="canvas, moodle, brightspace, blackboard or sakai.")],
    site: Annotated[str, typer.Option(metavar="URL", help="Where people open the platform.")],
    client_id: Annotated[
        str, typer.Option(metavar="ID", help="The client ID that the platform shows once you have registered qdot.")
    ] = "",
    issuer: Annotated[str, typer.Option(metavar="URL", help="The platform's issuer, if it is not the usual one.")] = "",
    auth_url: Annotated[
        str, typer.Option(metavar="URL", help="The address for logins, if it is not the usual one.")
    ] = "",
    token_url: Annotated[
        str, typer.Option(metavar="URL", help="The address for access tokens, if it is not the usual one.")
    ] = "",
    keys_url: Annotated[
        str, typer.Option(metavar="URL", help="The address of the platform's keys, if it is not the usual one.")
    ] = "",
    database: DatabaseOption = "",
    url: UrlOption = "",
) -> None:
    """Register a learning platform (LTI 1.3).

    Without --client-id, the command starts the registration, and prints what to paste where. Most platforms need only
    one address, from which they register qdot themselves. Otherwise, run the command again with the client ID. The
    first course in which a teacher opens qdot is connected; `qdot serve connect` connects others.

    Examples:
      qdot serve register homework --url https://qdot.example.edu --platform moodle --site https://moodle.example.edu
          print what to paste into Moodle
      qdot serve register homework --platform canvas --site https://canvas.example.edu --client-id 10000000000001
          store the number that Canvas shows
    """
    if not url and not client_id:
        raise QdotError(
            "add --url, the address at which the platform and people reach qdot, as in https://qdot.example.edu"
        )
    address = urlsplit(url)
    if address.scheme == "http" and not re.fullmatch(r"localhost|127(\.\d+){3}|::1", address.hostname or ""):
        raise QdotError(f"--url {url!r}: a platform opens only addresses that begin with https://")
    _configure(folders, database, url)
    from qdot.grader.serve.lti import registering

    if client_id:
        copied_values = registering.CopiedValues(site, client_id, issuer, auth_url, token_url, keys_url)
        registering.finish_registration(platform, copied_values)
        print_result(f"{site} is registered; open qdot in a course as a teacher")
    else:
        command = _write_command("register", folders, database, url)
        registration = registering.begin_registration(platform, site)
        print_result(registering.describe_registration_steps(platform, registration, command))


def connect(
    folders: FoldersArgument,
    course: Annotated[list[int], typer.Option(metavar="NUMBER", help="Connect this course. Repeatable.")] = [],  # noqa: B006
    database: DatabaseOption = "",
) -> None:
    """List the courses in which qdot was opened, or connect one.

    The people of a connected course can use the service.

    Examples:
      qdot serve connect homework
          1  connected  Robotics A (https://moodle.example.edu)
          2  -          Robotics B (https://moodle.example.edu)
      qdot serve connect homework --course 2
    """
    _configure(folders, database)
    from qdot.grader.serve.lti.registering import connect_course
    from qdot.grader.serve.models import Classroom

    courses = {row.pk: row for row in Classroom.objects.filter(lti_context__isnull=False).order_by("pk")}
    if unknown := sorted(set(course) - set(courses)):
        raise QdotError(f"there is no course {unknown[0]}; without --course, the command lists them")
    for number in course:
        connect_course(courses[number])
    for number, row in courses.items():
        state = "connected" if row.is_connected else "-"
        platform = row.lti_context.deployment.registration if row.lti_context else ""
        print_result(f"{number:>3}  {state:9}  {row} ({platform})")
    if not courses:
        note("qdot was not opened in a course yet")
