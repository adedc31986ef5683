"""Assignments for the real programs: ready-made sets, one on a PUMA, one with all questions, one on a textbook arm."""

from collections.abc import Iterable
from pathlib import Path

from qdot.exercises.assignment.assignment import Assignment, Student, load_assignment
from qdot.exercises.assignment.release import init_assignment
from qdot.exercises.assignment.sets import DEFAULT_SET, SETS
from qdot.exercises.exports.export_format import ExportedFile, ExportRequest
from qdot.exercises.generation import list_applicable_questions, list_questions_of_family, sample_chain
from qdot.exercises.problem.problem import ProblemId
from qdot.exercises.questions import QUESTIONS
from qdot.exercises.short_questions import SHORT_QUESTIONS
from qdot.grader.grading.certify import find_failures
from qdot.grader.marking.marking import compute_earned_share
from tests.support.gallery import CHAPTER_ARMS, GALLERY, GALLERY_FOLDER

PUMA_560 = "puma-560"
FAMILIES = ("elbow-3r", "planar-2r", "planar-3r", "polar-rp", "scara", PUMA_560)
"""The families of the assignment with every question; each question is asked about the first family that it suits."""
PLAIN, PUMA, EVERYTHING, TEXTBOOK = "plain", "puma", "everything", "textbook"
SECRET = "0123456789abcdef"


def make_assignment(folder: Path, kind: str) -> Assignment:
    """Make an assignment for two students: PLAIN, PUMA, EVERYTHING, TEXTBOOK, or a ready-made set by name.

    PLAIN is the default set.
    """
    students = (Student("ada", "Ada Lovelace", "ada@example.org"), Student("hen", "Henri Poincaré", "hp@example.org"))
    init_assignment(
        folder, f"Arms & <signs>: {kind}", kind, students, SECRET, problem_set=SETS.get(kind, SETS[DEFAULT_SET])
    )
    writers = {PUMA: _write_puma_problem, EVERYTHING: _write_all_problems, TEXTBOOK: _write_textbook_problem}
    write_problems = writers.get(kind)
    if write_problems is not None:
        head = f'title = "Arms & <signs>: {kind}"\nkey = "{kind}"\nhints = true\n'
        (folder / "assignment.toml").write_text(head + write_problems(), encoding="utf-8")
    return load_assignment(folder)


def make_request(folder: Path, kind: str, variants: int = 1) -> ExportRequest:
    return ExportRequest(
        make_assignment(folder, kind), find_failures, variant_count=variants, has_solutions=True,
        compute_earned_share=compute_earned_share,
    )  # fmt: skip


def _write_puma_problem() -> str:
    return _write_problem(PUMA_560, [name for name in list_questions_of_family(PUMA_560) if name in QUESTIONS])


def _write_textbook_problem() -> str:
    """Return a problem on the planar arm with two links, whose formulas are the same for all students."""
    questions = ["position", "determinant", "singular-angles", "speed", "joint-rates"]
    return _write_problem("planar-2r", questions) + 'variation = "chapter"\n'


def _write_all_problems() -> str:
    remaining, tables = [*QUESTIONS, *SHORT_QUESTIONS], []
    for family in FAMILIES:
        applicable = {
            *list_questions_of_family(family),
            *list_applicable_questions(sample_chain(ProblemId(family, 0)), SHORT_QUESTIONS),
        }
        family_questions = [name for name in remaining if name in applicable]
        remaining = [name for name in remaining if name not in applicable]
        for names in ([name for name in family_questions if name in group] for group in (QUESTIONS, SHORT_QUESTIONS)):
            tables += [_write_problem(family, names)] * bool(names)
    tables += [_write_problem(family, [str(GALLERY_FOLDER / f"{name}.toml")], name) for name, family in GALLERY.items()]
    return "".join(tables)


def _write_problem(family: str, questions: list[str], gallery_name: str = "") -> str:
    quoted_names = ", ".join(f'"{name}"' for name in questions)
    variation = 'variation = "chapter"\n' if gallery_name in CHAPTER_ARMS else ""
    return f'[[problem]]\nfamily = "{family}"\n{variation}questions = [{quoted_names}]\n'


def write_files(files: Iterable[ExportedFile], folder: Path) -> list[Path]:
    paths = []
    for file in files:
        paths.append(folder / file.path)
        paths[-1].parent.mkdir(parents=True, exist_ok=True)
        paths[-1].write_bytes(file.content if isinstance(file.content, bytes) else file.content.encode())
    return paths
