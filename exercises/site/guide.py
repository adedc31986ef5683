"""List the documentation in the order of the site: pages in groups by reader, each with a line on its content."""

import re
from dataclasses import dataclass
from pathlib import Path


def _(message: str) -> str:
    """Return a message unchanged; the call marks it for translation."""
    return message


OWN_PAGES = {"examples": "examples/index.html", "families": "arms.html"}
"""Pages of docs/ that the site has in another form, and their paths there."""
COMMANDS = "commands"
GROUPS = {
    _("For students"): {
        "students": (_("Your first answer"), _("Type an answer, read your feedback, submit a notebook.")),
        "hints": (_("Hints"), _("Three for each question, from gentle to nearly there.")),
        "questions": (_("The questions"), _("What can be asked, with the chapter's equations.")),
        "mistakes": (_("Known mistakes"), _("What qdot recognises in a wrong answer.")),
    },
    _("For instructors"): {
        "install": (_("Install qdot"), _("On any machine; extras, completion, upgrades.")),
        "instructors": (_("Your first class"), _("From an empty folder to graded notebooks.")),
        "robots": (_("Your own arm"), _("Standard and modified DH tables, screw axes, CSV, URDF.")),
        "variation": (_("Variation"), _("How much arms differ, and how many students share an answer.")),
        "grading": (_("Grading a class"), _("Late work, attempts, overrides, whose mark moved and why.")),
        "submissions": (_("Submissions"), _("Which files and downloads qdot reads, and how it finds answers.")),
        "report": (_("The report"), _("Hard parts, common mistakes, whether some variants were harder.")),
        "gradebooks": (_("Gradebooks"), _("Marks for Canvas, Moodle and Excel; rosters from them.")),
        "paper": (_("Paper and screen"), _("Handouts, exams with a key, accessible PDF.")),
        "site": (_("The web site"), _("Your own site to practise on.")),
    },
    _("Where you teach"): {
        "export_formats": (_("Export formats"), _("One assignment for every platform, and which programs read it.")),
        "platforms": (_("Quizzes on learning platforms"), _("Moodle, Canvas and QTI.")),
        "scorm": (_("SCORM packages"), _("A page that reports its score to any platform.")),
        "moodle": (_("Moodle, click by click"), _("Restore a quiz, take it, see the marks, in pictures.")),
        "stack": (_("STACK questions"), _("Answers as formulas in Moodle.")),
        "prairielearn": (_("PrairieLearn"), _("A course that generates and grades with qdot.")),
        "gradescope": (_("Gradescope"), _("The autograder zip.")),
        "nbgrader": (_("nbgrader"), _("A course that autogrades with qdot.")),
        "otter": (_("Otter-Grader"), _("An autograder that grades with qdot.")),
        "ci": (_("Grading in CI"), _("GitHub, GitLab, JUnit.")),
        "container": (_("The grader in a container"), _("Build and run it with Podman or Docker.")),
        "scaling": (_("Large classes"), _("What grading costs; Dask, Slurm and Kubernetes.")),
    },
    _("How it works"): {
        "judging": (_("How an answer is judged"), _("How formulas are compared, and how unlikely an error is.")),
        "partial-credit": (_("Partial credit"), _("The rules, with examples.")),
        "sandbox": (_("The sandbox"), _("What student code can do, and what prevents the rest.")),
        "structures": (_("How many arms there are"), _("What random-2 to random-4 choose from.")),
        "privacy": (_("Privacy"), _("What is stored about students, where and how long; how to remove it.")),
        "library": (_("qdot as a library"), _("Use qdot in a program of your own.")),
        "releasing": (_("Releasing qdot"), _("Step by step; how to verify a file.")),
        "dependencies": (_("Dependencies"), _("Every library: purpose, licence, size, last release.")),
        "compatibility": (_("Compatibility"), _("What you can build on, and what an upgrade changes.")),
        COMMANDS: (_("The command line"), _("Every command and option.")),
    },
}  # fmt: skip
"""Groups of pages: for each page of docs/, its title and a line on its content."""
OTHER_PAGES = _("More")


@dataclass(frozen=True)
class DocumentationEntry:
    """A page of the documentation in a list: its name in docs/, its title, and a line on its content."""

    name: str
    title: str
    summary: str


def arrange_pages(docs: Path) -> dict[str, list[DocumentationEntry]]:
    """Return the existing pages by group; pages without a group come last, with their own headings."""
    paths = {path.stem: path for path in sorted(docs.glob("*.md")) if path.stem not in OWN_PAGES}
    groups = {
        group: [
            DocumentationEntry(name, *title_and_line)
            for name, title_and_line in pages.items()
            if name in paths or name == COMMANDS
        ]
        for group, pages in GROUPS.items()
    }
    grouped_names = {entry.name for entries in groups.values() for entry in entries}
    groups[OTHER_PAGES] = [
        DocumentationEntry(name, _heading(path), "") for name, path in paths.items() if name not in grouped_names
    ]
    return {group: entries for group, entries in groups.items() if entries}


def _heading(path: Path) -> str:
    match = re.search(r"^# (.+)$", path.read_text(encoding="utf-8"), re.MULTILINE)
    return match.group(1) if match else path.stem
