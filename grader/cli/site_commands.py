"""The commands of the web site: `qdot site build`, `qdot site serve`."""

import functools
import http.server
from http import HTTPStatus
from pathlib import Path
from typing import Annotated

import typer

from qdot.exercises.assignment.assignment import FEEDBACK, Assignment, load_assignment
from qdot.exercises.assignment.draws import FailedSlot
from qdot.exercises.assignment.release import CORE_COUNT
from qdot.exercises.common.console import SiteVariationOption, note, progress, say
from qdot.exercises.common.errors import QdotError, unknown_name
from qdot.exercises.common.variation import VARIATION_STEPS
from qdot.exercises.exports.bank import iterate_bank
from qdot.exercises.exports.export_format import ExportRequest as BankOrder
from qdot.exercises.families import FAMILIES
from qdot.exercises.generation import look_up_family
from qdot.exercises.site.build import SiteSpec, write_site
from qdot.exercises.site.pages import docs_folder
from qdot.exercises.site.reference import render_reference
from qdot.exercises.site.supply import (
    ARMS_PER_STEP,
    MAX_ARMS,
    BankProblem,
    FrameConvention,
    problems_of_families,
    problems_of_variants,
)
from qdot.grader.cli.options import JobsOption, SiteConventionOption, SiteTwistOrderOption, name_option
from qdot.grader.grading.certify import find_failures

SITE_FOLDER = Path("qdot-site")
VARIANTS_PER_PROBLEM = 5
"""Default number of variants of each problem of an assignment."""


def build_site(
    context: typer.Context,
    out: Annotated[Path, typer.Option(metavar="FOLDER", help="Where to write_site it.")] = SITE_FOLDER,
    assignment: Annotated[
        Path | None, typer.Option(metavar="DIR", help="A site for your own course: the problems of this assignment.")
    ] = None,
    families: Annotated[
        str, name_option("Names with commas between; default: all.", names=FAMILIES, metavar="NAMES", between=",")
    ] = "",
    variants: Annotated[
        int | None,
        typer.Option(
            min=1,
            max=MAX_ARMS,
            help="Arms of each family, or variants of a problem.",
            show_default=f"{ARMS_PER_STEP} at every step of variation; {VARIANTS_PER_PROBLEM} of a problem",
        ),
    ] = None,
    variation: SiteVariationOption = "",
    convention: SiteConventionOption = "",
    twist_order: SiteTwistOrderOption = "",
    feedback: Annotated[
        str,
        name_option(
            f"How much is told: {', '.join(FEEDBACK)}. Default: the assignment's, else all.",
            names=FEEDBACK,
            metavar="LEVEL",
        ),
    ] = "",
    jobs: JobsOption = CORE_COUNT,
) -> None:
    """Build the web site: pages and a bank of certified problems that a browser shows and grades.

    Any file server can serve the folder, or GitHub Pages; there is nothing to install on it. What is up to date is
    kept, so that a build that was stopped goes on where it was. With --convention, all arms are told as a course of
    another book has them. With --assignment, the problems are variants of the
    assignment's, none of which a student has, and what is told of a wrong answer is what its feedback says; the bank
    has solutions only where that is "solutions". The page judges by itself, with right values in its bank.

    Examples:
      qdot site build
          all families, into qdot-site
      qdot site build --assignment homework --out course-site
          variants of your own assignment
    """
    if feedback and feedback not in FEEDBACK:
        raise unknown_name("level of feedback", feedback, list(FEEDBACK))
    loaded = None if assignment is None else load_assignment(assignment)
    frames = convention, twist_order
    if loaded is None:
        problems, titles = _problems_of_families(families, variants, variation, frames)
    else:
        problems, titles = _problems_of_assignment(loaded, variants or VARIANTS_PER_PROBLEM, variation, frames, jobs)
    course = "" if loaded is None else loaded.title
    level = feedback or (FEEDBACK[-1] if loaded is None else loaded.feedback)
    commands = render_reference(context.find_root().command)
    order = SiteSpec(
        out, problems, titles, find_failures, min(jobs, len(problems)), commands, docs_folder(), course, level
    )
    left_out: list[FailedSlot] = []
    with progress("building the site", len(problems)) as counter:
        totals = write_site(order, counter.step, left_out.append)
    say(f"{totals['problems']} problems with {totals['questions']} questions in {out}; see them: qdot site serve {out}")
    for slot in left_out:
        note(str(slot))
    if left_out:
        named = ", ".join(dict.fromkeys(slot.family for slot in left_out))
        raise QdotError(
            f"not on the site, as no draw passed its certificate: {len(left_out)} of {named}. All others are on it; "
            "please report it"
        )


SiteProblems = tuple[list[BankProblem], list[tuple[str, str, str]]]
"""The problems of a site, and the names, titles and sources of its chapters."""


def _problems_of_families(families: str, variants: int | None, variation: str, frames: FrameConvention) -> SiteProblems:
    names = [look_up_family(name.strip()).name for name in families.split(",") if name.strip()] or list(FAMILIES)
    titles = [(name, FAMILIES[name].title, FAMILIES[name].source) for name in names]
    count = variants or ARMS_PER_STEP * (1 if variation else len(VARIATION_STEPS))
    return problems_of_families(names, count, variation, *frames), titles


def _problems_of_assignment(
    assignment: Assignment, variants: int, variation: str, frames: FrameConvention, jobs: int
) -> SiteProblems:
    if any(frames):
        raise QdotError(
            "--convention and --twist-order are for a site of families; an assignment says them itself, as in "
            'convention = "screws" in assignment.toml'
        )
    if variation:
        assignment = assignment.with_variation(variation)
    problems = list(iterate_bank(BankOrder(assignment, find_failures, variants, jobs=jobs, report=note)))
    titles = [(slot.name, slot.family.title, slot.family.source) for slot in assignment.slots]
    return problems_of_variants(problems), titles


def serve(
    folder: Annotated[Path, typer.Argument(metavar="FOLDER", help="A built site.")] = SITE_FOLDER,
    port: Annotated[int, typer.Option(min=0, max=65535, help="0: any that is free.")] = 8000,
) -> None:
    """Show a built site in the browser of this machine, until Ctrl-C; nobody else can reach it.

    Examples:
      qdot site serve
          look at it at http://127.0.0.1:8000
    """
    if not (folder / "index.html").is_file():
        raise QdotError(f"there is no site in {folder}; 'qdot site build --out {folder}' makes one")
    handler = functools.partial(_QuietHandler, directory=str(folder))
    try:
        server = http.server.ThreadingHTTPServer(("127.0.0.1", port), handler)
    except OSError as error:
        raise QdotError(f"port {port} can't be used: {error.strerror}; choose another with --port") from None
    with server:
        say(f"the site is at http://127.0.0.1:{server.server_port}/ until Ctrl-C")
        server.serve_forever()


class _QuietHandler(http.server.SimpleHTTPRequestHandler):
    """Serves files without logging, and sends the site's own page for missing files, as web hosts do."""

    error_content_type = "text/html; charset=utf-8"

    def send_error(self, code: int, message: str | None = None, explain: str | None = None) -> None:
        """Send the site's own page if a file is missing; send the usual page for other errors."""
        page = Path(self.directory) / "404.html"
        if code == HTTPStatus.NOT_FOUND and page.is_file():
            self.error_message_format = page.read_text(encoding="utf-8").replace("%", "%%")
        super().send_error(code, message, explain)

    def log_message(self, format: str, *args: object) -> None:
        pass
