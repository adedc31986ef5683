"""Export to the real programs: the set of `qdot init`, an assignment with PUMA, and one with every question."""

from pathlib import Path

from qdot.exercises.assignment.assignment import Assignment, Student, load_assignment
from qdot.exercises.assignment.release import init_assignment
from qdot.exercises.assignment.sets import DEFAULT_SET, SETS
from qdot.exercises.exports.export_format import ExportRequest
from qdot.exercises.generation import list_applicable_questions, list_questions_of_family, sample_chain
from qdot.exercises.problem.problem import ProblemId
from qdot.exercises.questions import QUESTIONS
from qdot.exercises.short_questions import SHORT_QUESTIONS
from qdot.grader.grading.certify import find_failures
from tests.support.gallery import CHAPTER_ARMS, GALLERY, GALLERY_FOLDER

PUMA_560 = "puma-560"
FAMILIES = ("elbow-3r", "planar-2r", "planar-3r", "polar-rp", "scara", PUMA_560)
"""The families of the assignment with every question; each question is asked of the first family that it suits."""
PLAIN, PUMA, EVERYTHING = "plain", "puma", "everything"
SECRET = "0123456789abcdef"


def assignment(folder: Path, which: str) -> Assignment:
    """Make an assignment of two students: PLAIN, PUMA, EVERYTHING, or a ready-made set by its name."""
    students = (Student("ada", "Ada Lovelace", "ada@example.org"), Student("hen", "Henri Poincaré", "hp@example.org"))
    init_assignment(
        folder, f"Arms & <signs>: {which}", which, students, SECRET, problem_set=SETS.get(which, SETS[DEFAULT_SET])
    )
    problems = {PUMA: _puma, EVERYTHING: _everything}.get(which)
    if problems is not None:
        head = f'title = "Arms & <signs>: {which}"\nkey = "{which}"\nhints = true\n'
        (folder / "assignment.toml").write_text(head + problems(), encoding="utf-8")
    return load_assignment(folder)


def order(folder: Path, which: str, variants: int = 1) -> ExportRequest:
    """Return the order of such an export."""
    return ExportRequest(assignment(folder, which), find_failures, variant_count=variants, has_solutions=True)


def _puma() -> str:
    return _problem(PUMA_560, [name for name in list_questions_of_family(PUMA_560) if name in QUESTIONS])


def _everything() -> str:
    remaining, problems = [*QUESTIONS, *SHORT_QUESTIONS], []
    for family in FAMILIES:
        applicable = {
            *list_questions_of_family(family),
            *list_applicable_questions(sample_chain(ProblemId(family, 0)), SHORT_QUESTIONS),
        }
        asked = [name for name in remaining if name in applicable]
        remaining = [name for name in remaining if name not in applicable]
        for names in ([name for name in asked if name in group] for group in (QUESTIONS, SHORT_QUESTIONS)):
            problems += [_problem(family, names)] * bool(names)
    problems += [_problem(family, [str(GALLERY_FOLDER / f"{name}.toml")], name) for name, family in GALLERY.items()]
    return "".join(problems)


def _problem(family: str, questions: list[str], gallery_name: str = "") -> str:
    asked = ", ".join(f'"{name}"' for name in questions)
    variation = 'variation = "chapter"\n' if gallery_name in CHAPTER_ARMS else ""
    return f'[[problem]]\nfamily = "{family}"\n{variation}questions = [{asked}]\n'
