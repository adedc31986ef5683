"""How the documentation is arranged on the site: for whom a page is, in what order, and in one line what it says."""

import re
from dataclasses import dataclass
from pathlib import Path

OWN_PAGES = {"examples": "examples/index.html", "families": "arms.html"}
"""Pages of docs/ that the site has in another form, and where."""
COMMANDS = "commands"
GROUPS = {
    "For students": {
        "students": ("Your first answer", "Typing an answer, reading a verdict, handing in a notebook."),
        "hints": ("Hints", "Three for every question, from gentle to nearly there."),
        "questions": ("The questions", "What can be asked, with the chapter's equations."),
        "mistakes": ("Mistakes that are named", "What qdot recognises behind a wrong answer."),
    },
    "For instructors": {
        "install": ("Install qdot", "Any machine, without installing, extras, completion, upgrades."),
        "instructors": ("Your first class", "From an empty folder to graded notebooks."),
        "robots": ("Your own arm", "DH tables, standard and modified, axes, CSV, URDF."),
        "variation": ("Variation", "How far arms may differ, and how many students share an answer."),
        "grading": ("Grading a class", "Late work, attempts, overrides, whose mark moved and why."),
        "submissions": ("What students hand in", "Files and folders that are read, and how answers are found."),
        "report": ("The class at a glance", "Hard parts, mistakes, whether some variants were harder."),
        "gradebooks": ("Gradebooks", "Canvas, Moodle and Excel: marks back, rosters in."),
        "paper": ("Paper and screen", "Handouts, exams with a key, accessible PDF."),
        "site": ("The web site", "A site of your own to practise on."),
    },
    "Where you teach": {
        "outlets": ("Outlets", "One assignment for every platform, and what reads each."),
        "platforms": ("Quizzes on learning platforms", "Moodle, Canvas, QTI and notebooks."),
        "scorm": ("SCORM packages", "The assignment as a page that reports its score to any platform."),
        "moodle": ("Moodle, click by click", "A quiz restored, taken and marked, in pictures."),
        "stack": ("STACK questions", "Answers as formulas in Moodle."),
        "prairielearn": ("PrairieLearn", "A course that draws and marks by qdot."),
        "gradescope": ("Gradescope", "The autograder's zip."),
        "nbgrader": ("nbgrader", "A course whose autograde marks by qdot."),
        "otter": ("Otter-Grader", "An autograder that marks by qdot, by `otter assign`."),
        "ci": ("Grading in CI", "GitHub, GitLab, JUnit, pytest."),
        "container": ("The grader in a container", "Built and run with Podman or Docker; what makes it strict."),
        "many-submissions": ("Grading 100,000 submissions", "Dask, Slurm, Kubernetes, or the jobs of a CI."),
    },
    "How it works": {
        "judging": ("How an answer is judged", "Identity tested in numbers, and the bound on being wrong."),
        "partial-credit": ("What is right in part", "One rule for each type of answer, with examples."),
        "sandbox": ("Students' code, contained", "What a notebook may do, and who sees to it."),
        "structures": ("How many arms there are", "What random-2 to random-4 draw from."),
        "privacy": ("Data protection", "What is kept about students, where, how long; how it is removed."),
        "library": ("qdot as a library", "Problems and judgements in a program of your own."),
        "releasing": ("Releasing qdot", "The button, step by step; how a file is checked."),
        "dependencies": ("What qdot needs", "Every library: what for, licence, size, last release."),
        "promises": ("What stays as it is", "What you can build on, and what an upgrade changes."),
        COMMANDS: ("The command line", "Every command and option, from the program."),
    },
}  # fmt: skip
"""Groups of pages, their names with a title and a line each."""
OTHERS = "More"


@dataclass(frozen=True)
class Entry:
    """A page of the documentation as it is listed."""

    name: str
    title: str
    says: str


def arranged(docs: Path) -> dict[str, list[Entry]]:
    """Return the pages that there are, by group; what no group knows comes last, by its own heading."""
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
