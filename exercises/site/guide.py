"""The order of the documentation on the site: pages in groups by reader, each with a line on its content."""

import re
from dataclasses import dataclass
from pathlib import Path


def _(message: str) -> str:
    """Mark a text as a message, which is translated when it is shown."""
    return message


OWN_PAGES = {"examples": "examples/index.html", "families": "arms.html"}
"""Pages of docs/ that the site has in another form, and their paths there."""
COMMANDS = "commands"
GROUPS = {
    _("For students"): {
        "students": (_("Your first answer"), _("Typing an answer, reading a verdict, handing in a notebook.")),
        "hints": (_("Hints"), _("Three for every question, from gentle to nearly there.")),
        "questions": (_("The questions"), _("What can be asked, with the chapter's equations.")),
        "mistakes": (_("Mistakes that are named"), _("What qdot recognises behind a wrong answer.")),
    },
    _("For instructors"): {
        "install": (_("Install qdot"), _("Any machine, without installing, extras, completion, upgrades.")),
        "instructors": (_("Your first class"), _("From an empty folder to graded notebooks.")),
        "robots": (_("Your own arm"), _("DH tables, standard and modified, axes, CSV, URDF.")),
        "variation": (_("Variation"), _("How far arms may differ, and how many students share an answer.")),
        "grading": (_("Grading a class"), _("Late work, attempts, overrides, whose mark moved and why.")),
        "submissions": (_("What students hand in"), _("Files and folders that are read, and how answers are found.")),
        "report": (_("The class at a glance"), _("Hard parts, mistakes, whether some variants were harder.")),
        "gradebooks": (_("Gradebooks"), _("Canvas, Moodle and Excel: marks back, rosters in.")),
        "paper": (_("Paper and screen"), _("Handouts, exams with a key, accessible PDF.")),
        "site": (_("The web site"), _("A site of your own to practise on.")),
    },
    _("Where you teach"): {
        "outlets": (_("Outlets"), _("One assignment for every platform, and what reads each.")),
        "platforms": (_("Quizzes on learning platforms"), _("Moodle, Canvas, QTI and notebooks.")),
        "scorm": (_("SCORM packages"), _("The assignment as a page that reports its score to any platform.")),
        "moodle": (_("Moodle, click by click"), _("A quiz restored, taken and marked, in pictures.")),
        "stack": (_("STACK questions"), _("Answers as formulas in Moodle.")),
        "prairielearn": (_("PrairieLearn"), _("A course that draws and marks by qdot.")),
        "gradescope": (_("Gradescope"), _("The autograder's zip.")),
        "nbgrader": (_("nbgrader"), _("A course whose autograde marks by qdot.")),
        "otter": (_("Otter-Grader"), _("An autograder that marks by qdot, by otter assign.")),
        "ci": (_("Grading in CI"), _("GitHub, GitLab, JUnit, pytest.")),
        "container": (_("The grader in a container"), _("Built and run with Podman or Docker; what makes it strict.")),
        "scaling": (_("Grading 100,000 submissions"), _("Dask, Slurm and Kubernetes.")),
    },
    _("How it works"): {
        "judging": (_("How an answer is judged"), _("Identity tested in numbers, and the bound on being wrong.")),
        "partial-credit": (_("What is right in part"), _("One rule for each type of answer, with examples.")),
        "sandbox": (_("Students' code, contained"), _("What a notebook may do, and who sees to it.")),
        "structures": (_("How many arms there are"), _("What random-2 to random-4 draw from.")),
        "privacy": (_("Data protection"), _("What is kept about students, where, how long; how it is removed.")),
        "library": (_("qdot as a library"), _("Problems and judgements in a program of your own.")),
        "releasing": (_("Releasing qdot"), _("The button, step by step; how a file is checked.")),
        "dependencies": (_("What qdot needs"), _("Every library: what for, licence, size, last release.")),
        "promises": (_("What stays as it is"), _("What you can build on, and what an upgrade changes.")),
        COMMANDS: (_("The command line"), _("Every command and option, from the program.")),
    },
}  # fmt: skip
"""Groups of pages, their names with a title and a line each."""
OTHERS = _("More")


@dataclass(frozen=True)
class Entry:
    """A page of the documentation in a list."""

    name: str
    title: str
    says: str


def arrange_pages(docs: Path) -> dict[str, list[Entry]]:
    """Return the existing pages by group; pages without a group come last, with their own headings."""
    there = {path.stem: path for path in sorted(docs.glob("*.md")) if path.stem not in OWN_PAGES}
    groups = {
        group: [Entry(name, *about) for name, about in pages.items() if name in there or name == COMMANDS]
        for group, pages in GROUPS.items()
    }
    known = {entry.name for entries in groups.values() for entry in entries}
    groups[OTHERS] = [Entry(name, _heading(path), "") for name, path in there.items() if name not in known]
    return {group: entries for group, entries in groups.items() if entries}


def _heading(path: Path) -> str:
    match = re.search(r"^# (.+)$", path.read_text(encoding="utf-8"), re.MULTILINE)
    return match.group(1) if match else path.stem
