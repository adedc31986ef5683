"""The commands for the web site: `qdot site build` and `qdot site serve`."""

import functools
import http.server
from http import HTTPStatus
from pathlib import Path
from typing import Annotated

import typer

from qdot.exercises.assignment.assignment import FEEDBACK_LEVELS, load_assignment
from qdot.exercises.assignment.certified_problems import FailedSlot
from qdot.exercises.common.console import check_choice, note, print_result, show_progress
from qdot.exercises.common.errors import QdotError, count_noun
from qdot.exercises.common.parallel import CORE_COUNT
from qdot.exercises.common.variation import VARIATION_STEPS
from qdot.exercises.exports.bank import iterate_bank
from qdot.exercises.exports.export_format import ExportRequest
from qdot.exercises.families import FAMILIES
from qdot.exercises.generation import look_up_family
from qdot.exercises.site.bank_problem import (
    ARMS_PER_STEP,
    MAX_ARMS,
    list_problems_of_families,
    list_problems_of_variants,
)
from qdot.exercises.site.build import SiteSpec, write_site
from qdot.exercises.site.command_reference import render_reference
from qdot.exercises.site.pages import find_docs_folder
from qdot.grader.cli.options import JobsOption, SiteConventionOption, SiteTwistOption, SiteVariationOption, name_option
from qdot.grader.grading.certify import find_failures

SITE_FOLDER = Path("qdot-site")
VARIANTS_PER_PROBLEM = 5
"""Default number of variants of each problem of an assignment."""
VARIANTS_HELP = f"{ARMS_PER_STEP} at each step of variation; {VARIANTS_PER_PROBLEM} for a problem"
FEEDBACK_HELP = f"Level of feedback: {', '.join(FEEDBACK_LEVELS)}. Default: the assignment's, else all."


def build_site(
    context: typer.Context,
    out: Annotated[Path, typer.Option(metavar="FOLDER", help="The folder to write the site into.")] = SITE_FOLDER,
    assignment: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Build a site for your own course, with the problems of this assignment."),
    ] = None,
    families: Annotated[
        str, name_option("Families separated by commas. Default: all.", names=FAMILIES, metavar="NAMES", separator=",")
    ] = "",
    variants: Annotated[
        int | None,
        typer.Option(min=1, max=MAX_ARMS, help="Arms per family, or variants per problem.", show_default=VARIANTS_HELP),
    ] = None,
    variation: SiteVariationOption = "",
    convention: SiteConventionOption = "",
    twist_order: SiteTwistOption = "",
    feedback: Annotated[str, name_option(FEEDBACK_HELP, names=FEEDBACK_LEVELS, metavar="LEVEL")] = "",
    jobs: JobsOption = CORE_COUNT,
) -> None:
    """Build the web site: pages and a bank of certified problems that a browser shows and grades.

    You can serve the folder with any file server or with GitHub Pages. A stopped build continues where it stopped. With
    --convention, all arms are described in that convention. With --assignment, the problems are variants of the
    assignment's, but never a student's own. The assignment's feedback level then applies to wrong answers, and the bank
    has solutions only if the level is "solutions". The page grades in the browser, so its bank contains values of the
    right answers.

    Examples:
      qdot site build
          all families, into qdot-site
      qdot site build --assignment homework --out course-site
          variants of your own assignment
    """
    if feedback:
        check_choice(feedback, FEEDBACK_LEVELS, "level of feedback")
    if assignment is None:
        names = [look_up_family(name.strip()).name for name in families.split(",") if name.strip()] or list(FAMILIES)
        titles = [(name, FAMILIES[name].title, FAMILIES[name].source) for name in names]
        arm_count = variants or ARMS_PER_STEP * (1 if variation else len(VARIATION_STEPS))
        problems = list_problems_of_families(names, arm_count, variation, convention, twist_order)
        course, default_level = "", FEEDBACK_LEVELS[-1]
    elif convention or twist_order:
        advice = 'for an assignment, set them in assignment.toml, as in convention = "screws"'
        raise QdotError(f"--convention and --twist-order apply to a site of families only; {advice}")
    else:
        loaded_assignment, text_question_names = load_assignment(assignment).without_text_questions()
        if text_question_names:
            note(f"the site leaves out {', '.join(text_question_names)}, because a person must mark these answers")
        titles = [(slot.name, slot.family.title, slot.family.source) for slot in loaded_assignment.slots]
        bank_assignment = loaded_assignment.with_variation(variation) if variation else loaded_assignment
        variant_count = variants or VARIANTS_PER_PROBLEM
        request = ExportRequest(bank_assignment, find_failures, variant_count, jobs=jobs, report=note)
        problems = list_problems_of_variants(list(iterate_bank(request)))
        course, default_level = loaded_assignment.title, loaded_assignment.feedback
    level, process_count = feedback or default_level, min(jobs, len(problems))
    commands = render_reference(context.find_root().command)
    site = SiteSpec(out, problems, titles, find_failures, process_count, commands, find_docs_folder(), course, level)
    failed_slots: list[FailedSlot] = []
    with show_progress("building the site", len(problems)) as counter:
        totals = write_site(site, counter.step, failed_slots.append)
    contents = f"{count_noun(totals['problems'], 'problem')} with {count_noun(totals['questions'], 'question')}"
    print_result(f"{contents} in {out}; to see them: qdot site serve {out}")
    for slot in failed_slots:
        note(str(slot))
    if failed_slots:
        family_names = ", ".join(dict.fromkeys(slot.family for slot in failed_slots))
        raise QdotError(
            f"the site lacks {count_noun(len(failed_slots), 'problem')} of {family_names}, because no attempt passed "
            "its certificate. All other problems are on the site. Please report it"
        )


def serve(
    folder: Annotated[Path, typer.Argument(metavar="FOLDER", help="A built site.")] = SITE_FOLDER,
    port: Annotated[int, typer.Option(min=0, max=65535, help="The port; 0 uses any free port.")] = 8000,
) -> None:
    """Serve a built site on this machine only, until Ctrl-C.

    Examples:
      qdot site serve
          open it at http://127.0.0.1:8000
    """
    if not (folder / "index.html").is_file():
        raise QdotError(f"there is no site in {folder}; 'qdot site build --out {folder}' builds one")
    handler = functools.partial(_QuietHandler, directory=str(folder))
    try:
        server = http.server.ThreadingHTTPServer(("127.0.0.1", port), handler)
    except OSError as error:
        raise QdotError(f"port {port} can't be used: {error.strerror}; choose another with --port") from None
    with server:
        print_result(f"the site is at http://127.0.0.1:{server.server_port}/; stop it with Ctrl-C")
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
