"""Read and check an assignment folder: assignment.toml, roster.csv and the secret. Errors name file and line.

A slot is one [[problem]] of assignment.toml: each student gets a different problem in it. Problems are not stored,
because every command can generate them again from the secret, the student's identifier and the slot.
"""

import datetime
import hashlib
import os
import unicodedata
from collections.abc import Callable, Mapping, Sequence, Set
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from fractions import Fraction
from pathlib import Path
from typing import Any, Literal, NamedTuple, TypeVar

import pydantic

from qdot.exercises import generation
from qdot.exercises.arm.chain import DEFAULT_CONVENTION, DEFAULT_TWIST_ORDER
from qdot.exercises.arm.conventions import REGISTRY
from qdot.exercises.assignment.attempt_policy import AttemptPolicy, read_attempt_policy
from qdot.exercises.assignment.class_list import (
    LAST_NAME_KEY,
    PlatformClassList,
    get_cell_under_any_name,
    normalize_identifier,
    read_class_list,
)
from qdot.exercises.assignment.expected_forms import EXPECTED_FORMS
from qdot.exercises.assignment.front_page import FrontPage, read_front_page
from qdot.exercises.assignment.late_rule import LateRule, add_time_zone, read_late_rule
from qdot.exercises.assignment.replacements import Replacement, Replacements, read_replacements
from qdot.exercises.common.errors import ErrorList, KeyReason, QdotError, count_noun, find_most_similar, make_name_error
from qdot.exercises.common.files import is_changed_by_windows
from qdot.exercises.common.input_file import TomlFile, read_table, read_text, read_toml
from qdot.exercises.common.variation import DEFAULT_VARIATION, find_canonical_name
from qdot.exercises.families import Family
from qdot.exercises.families.robot_family import read_robot_family
from qdot.exercises.formula.equality import Rounding
from qdot.exercises.problem.credit import Credit, parse_credit_policy
from qdot.exercises.problem.problem import (
    ENGINE,
    TWIST_ORDER_HINT,
    Problem,
    ProblemId,
    normalize_convention,
    normalize_twist_order,
)
from qdot.exercises.problem.rounding import check_units, read_decimals
from qdot.exercises.questions import Question
from qdot.exercises.questions.custom import Definition, make_question
from qdot.exercises.questions.custom.definition import TEXT_ANSWER
from qdot.exercises.questions.custom.question import DefinitionEvaluator
from qdot.exercises.questions.custom.reader import read_definitions, read_question_file
from qdot.exercises.questions.custom.texts import check_formulas
from qdot.exercises.robots.library import find_robot_path
from qdot.exercises.robots.robot_file import read_robot_file
from qdot.exercises.short_questions import ALL_QUESTIONS
from qdot.exercises.singularities.difficulty import HARDEST_LEVEL
from qdot.exercises.writing.custom_texts import check_given_values, fill_text
from qdot.exercises.writing.languages import ENGLISH, load_catalogue
from qdot.exercises.writing.wording import Wording

Parsed = TypeVar("Parsed")

ASSIGNMENT_FILE = "assignment.toml"
QUESTION_FILE_EXTENSION = ".toml"
"""The extension of files of questions. In `questions`, a name with this ending stands for the questions in a file."""
SECRET_FILE = "secret.txt"  # noqa: S105 - a file's name
SECRET_VARIABLE = "QDOT_SECRET"  # noqa: S105 - a variable's name
_MISSING_FILE_HINT = "'qdot init' creates a folder with this file"
MISSING_ROSTER_HINT = "give your class list, as saved by Canvas, Moodle or a spreadsheet"
MIN_SECRET_LENGTH = 16
PREVIEW_SECRET = "secret of a preview"  # noqa: S105 - not secret, because no student gets the problems of a preview
MAX_QUESTION_POINTS = 1e6
"""The points of a question must be below this; more are certainly a mistake."""


class ProblemEntry(pydantic.BaseModel):
    """One [[problem]] of assignment.toml: each student gets a problem of this kind."""

    model_config = pydantic.ConfigDict(extra="forbid", strict=True)
    family: str | None = None
    """The family of arms. Each problem has either `family` or `robot`."""
    robot: str | None = None
    """A real robot or the file of your own arm, instead of a family."""
    questions: list[str] | str | None = None
    """The questions, in order. By default, all that apply to the arm, except
    [short questions](questions.md#short-questions-for-quizzes)."""
    points: list[float] | None = None
    """The points of each question. By default, the points that `qdot questions` lists."""
    difficulty: int | list[int] | None = None
    """How hard the arms are; each family has its own range of difficulty."""
    variation: str | list[str] | None = None
    """Overrides the assignment's `variation` for this problem."""
    convention: str | None = None
    """Overrides the assignment's `convention` for this problem. If neither is set, the file of your own arm decides."""
    twist_order: str | None = None
    """Overrides the assignment's `twist_order` for this problem."""
    decimals: int | str | dict[str, int | str] | None = None
    """How accurate decimals must be. By default, decimals in formulas must be exact."""
    credit: str | float | dict[str, str | float] | None = None
    """How partial credit is given, if not by the usual rules."""


FEEDBACK_LEVELS = ("outcome", "mistake", "counterexample", "values", "solutions")
"""Levels of feedback on a wrong answer, from least to most."""


class AssignmentFile(pydantic.BaseModel):
    """The content of assignment.toml."""

    model_config = pydantic.ConfigDict(extra="forbid", strict=True)
    title: str = pydantic.Field(pattern=r"\S")
    """The title that students see."""
    key: str = pydantic.Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9._-]*$", max_length=100)
    """The file name of the notebooks, without .ipynb. If you change it, released notebooks can't be graded."""
    due: datetime.datetime | None = None
    """The due date. The column `due` of roster.csv can set a different one for a student."""
    late: dict[str, Any] | None = None
    """Deductions for late work. By default, late work is labelled as late but loses no points."""
    attempts: str | dict[str, Any] = "last"
    """Which of a student's submissions counts, and how often students may answer online."""
    feedback: Literal["outcome", "mistake", "counterexample", "values", "solutions"] = "counterexample"
    """How much a feedback page shows about a wrong answer; only "solutions" shows worked solutions."""
    follow_through: float = pydantic.Field(default=0.8, ge=0, le=1)
    """The share of its points that an answer earns if it follows from the student's own wrong earlier answer."""
    hints: bool = False
    """Whether each question in the notebook has three hints."""
    practice: bool = False
    """Whether students can also practise [online](serve.md) on other problems of the same kind, without marks."""
    site: str = pydantic.Field(default="", pattern=r"^https?://[^\s<>()\"'\\?#]+$", max_length=500)
    """The address of [your site](site.md). Notebooks then link to its page "Check your notebook"."""
    sandbox: Literal["best", "strict"] = "best"
    """What to do on a machine that cannot fully sandbox student code."""
    variation: str | list[str] = DEFAULT_VARIATION
    """How much the arms of a class differ."""
    convention: str | None = None
    """The convention in which the arms are described. By default, standard DH tables."""
    twist_order: str | None = None
    """The order of the two halves of a twist, if the arms are described by screw axes."""
    paper: dict[str, Any] = {}
    """The front page of an exam on paper; see [Paper and screen](paper.md)."""
    question: dict[str, Any] = {}
    """Questions of your own, each in a table [question.NAME]; see [Write your own question](custom-questions.md)."""
    problem: list[ProblemEntry] = pydantic.Field(min_length=1)
    """One table for each problem, in the order of the notebook."""


IDENTIFIER_RULE = (
    "it must have at most 100 characters, must not start with '.' or '-', and must not contain / \\ : * ? \" < > |"
)
WINDOWS_NAME_RULE = (
    "on Windows, the name of a file must not end in '.' or be the name of a device (CON, PRN, AUX, NUL, COM1, LPT1, …)"
)


@dataclass(frozen=True)
class Student:
    """A student on the roster.

    `other_cells` are pairs (column, cell). `due_date` is for this student only. `last_name` is "" unless the roster has
    a column for it.
    """

    id: str
    name: str = ""
    email: str = ""
    other_cells: tuple[tuple[str, str], ...] = ()
    due_date: datetime.datetime | None = None
    last_name: str = ""


@dataclass(frozen=True)
class Slot:
    """A slot of the assignment, in which every student has a problem of the same family with the same questions.

    `points` is None if the questions have their default points. `band` is the minimum and maximum level of difficulty.
    `robot_digest` is a hash of the instructor's robot file, or "" for a family. `variation` is how much the arms differ
    from the chapter's arm. `convention` describes the arms, and `twist_order` is the order of a twist's two halves.
    `decimals` has the tolerance of each question that accepts rounded decimals. `credit` has the rules for partial
    credit that the assignment sets for single questions. `definitions` define the instructor's own questions that the
    slot asks.
    """

    name: str
    family: Family
    questions: tuple[str, ...]
    points: tuple[float, ...] | None
    band: tuple[int, int] | None = None
    robot_digest: str = ""
    variation: str = DEFAULT_VARIATION
    convention: str = ""
    twist_order: str = ""
    decimals: tuple[tuple[str, Rounding], ...] = ()
    credit: tuple[tuple[str, Credit], ...] = ()
    definitions: tuple[Definition, ...] = ()

    @property
    def max_points(self) -> tuple[float, ...]:
        """The points of each question, the same for every student."""
        return self.points or tuple(self.find_question(name).points for name in self.questions)

    def find_question(self, name: str) -> Question:
        """Return a question that the slot asks."""
        definitions = {definition.name: definition for definition in self.definitions}
        return make_question(definitions[name]) if name in definitions else ALL_QUESTIONS[name]

    @property
    def text_questions(self) -> frozenset[str]:
        """The questions that a person has to mark."""
        return frozenset(definition.name for definition in self.definitions if definition.answer == TEXT_ANSWER)

    def list_problem_settings(self) -> tuple[object, ...]:
        """Return the settings that determine the slot's problems, for digests."""
        definitions = "/".join(definition.digest for definition in self.definitions)
        # Digests of older versions did not have these settings, so they are left out if they are empty.
        newer_settings = filter(None, (self.convention, self.twist_order, definitions))
        settings = (self.name, self.family.name, self.questions, self.band, self.robot_digest, self.variation)
        return (*settings, *newer_settings)

    @property
    def points_by_question(self) -> dict[str, float]:
        """Maps each question of the slot, in order, to its points."""
        return dict(zip(self.questions, self.max_points, strict=True))

    def make_problem_id(self, secret: str, student: str, seed_number: int = 1) -> ProblemId:
        """Return the id of a student's problem in this slot; `seed_number` is explained in `replacements`."""
        seed_name = self.name if seed_number == 1 else f"{self.name}/{seed_number}"
        id_with_any_seed = self.make_id_from_seed(0)
        return generation.make_student_problem_id(secret, student, seed_name, id_with_any_seed)

    def make_id_from_seed(self, seed: int) -> ProblemId:
        """Return the id of the problem of this slot with a given seed."""
        return ProblemId(
            self.family.name, seed, self.questions, band=self.band, variation=self.variation,
            convention=self.convention, twist_order=self.twist_order,
        )  # fmt: skip

    def generate_problem(self, secret: str, student: str, seed_number: int = 1) -> Problem:
        """Return a student's problem in this slot."""
        return self.generate_from_seed(self.make_problem_id(secret, student, seed_number).seed)

    def generate_from_seed(self, seed: int) -> Problem:
        """Return the problem of this slot with a given seed.

        Raises QdotError, with the file, the line and the key, if an instructor's question can't be asked about the arm.
        """
        try:
            problem = generation.generate(
                self.make_id_from_seed(seed), points=self.points, family=self.family, definitions=self.definitions
            )
        except generation.InapplicableQuestion as error:
            definition = next(definition for definition in self.definitions if definition.name == error.name)
            raise QdotError(f"{definition.find_location(error.key)}: {error}") from None
        roundings, rules = dict(self.decimals), dict(self.credit)
        parts = tuple(
            replace(part, rounding=roundings.get(part.name, part.rounding), credit=rules.get(part.name, Credit()))
            for part in problem.parts
        )
        return replace(problem, parts=parts)


@dataclass(frozen=True)
class Assignment:
    """An assignment, its roster and its secret; `notes` warn the staff about probable errors.

    If a platform has exported roster.csv, `class_list` is that export. `replacements` lists the replaced problems.
    """

    folder: Path
    title: str
    key: str
    slots: tuple[Slot, ...]
    roster: tuple[Student, ...]
    secret: str
    due_date: datetime.datetime | None = None
    feedback: str = "counterexample"
    notes: tuple[str, ...] = ()
    follow_through: Fraction = Fraction(4, 5)
    hints: bool = False
    site: str = ""
    late_rule: LateRule | None = None
    attempt_policy: AttemptPolicy = field(default_factory=AttemptPolicy)
    sandbox: str = "best"
    class_list: PlatformClassList | None = None
    replacements: Replacements = field(default_factory=dict)
    front_page: FrontPage = field(default_factory=FrontPage)
    practice: bool = False

    def __repr__(self) -> str:
        return f"Assignment({self.key}: {len(self.slots)} problems, {len(self.roster)} students)"

    def find_student(self, identifier: str) -> Student:
        """Return the student with an identifier. Raises QdotError if the identifier isn't in the roster."""
        students = {student.id: student for student in self.roster}
        if identifier not in students:
            raise make_name_error("student", identifier, list(students)[:50])
        return students[identifier]

    @property
    def titles_by_part(self) -> dict[str, str]:
        """Maps each part, as in "p1.jacobian", to the title of its question, which may be the instructor's own."""
        return {f"{slot.name}.{name}": slot.find_question(name).title for slot in self.slots for name in slot.questions}

    def due_date_of(self, student: Student) -> datetime.datetime | None:
        """Return the due date of a student's work, with its time zone; None if there is none."""
        due_date = student.due_date or self.due_date
        zone = self.due_date.tzinfo if self.due_date else None
        return due_date and add_time_zone(due_date, zone)

    def with_variation(self, variation: str) -> "Assignment":
        """Return the assignment with another variation in all slots.

        Raises QdotError if a question of a slot does not apply to arms with this variation.
        """
        slots = tuple(replace(slot, variation=find_canonical_name(variation)) for slot in self.slots)
        for slot in slots:
            try:
                generation.check_questions(
                    slot.family, slot.questions, slot.band, slot.variation, slot.convention, slot.definitions
                )
            except QdotError as error:
                raise QdotError(f"{slot.name}, with variation {slot.variation}: {error}") from None
        return replace(self, slots=slots)

    def without_text_questions(self) -> tuple["Assignment", tuple[str, ...]]:
        """Return the assignment without the questions that a person has to mark, and the names of these questions."""
        text_names = {name for slot in self.slots for name in slot.text_questions}
        if not text_names:
            return self, ()
        slots = []
        for slot in self.slots:
            points = {name: value for name, value in slot.points_by_question.items() if name not in text_names}
            definitions = tuple(definition for definition in slot.definitions if definition.name in points)
            if points:
                slots.append(
                    replace(slot, questions=tuple(points), points=tuple(points.values()), definitions=definitions)
                )
        if not slots:
            raise QdotError(f"{self.folder / ASSIGNMENT_FILE}: a person has to mark every question of this assignment")
        return replace(self, slots=tuple(slots)), tuple(sorted(text_names))

    def generate_problems(self, student: str) -> list[tuple[str, Problem]]:
        """Return the student's problems, each with the name of its slot; they are the same on every machine."""
        return [(slot.name, slot.generate_from_seed(self.make_problem_id(slot, student).seed)) for slot in self.slots]

    def make_problem_id(self, slot: Slot, student: str) -> ProblemId:
        """Return the id of a student's problem in a slot."""
        return slot.make_problem_id(self.secret, student, self.seed_number_of(slot, student))

    def seed_number_of(self, slot: Slot, student: str) -> int:
        """Return the number of the seed of a student's problem in a slot: 1, unless redrawn.csv lists the problem."""
        replacement = self.replacements.get((student, slot.name))
        return replacement.seed_number if replacement is not None and replacement.family == slot.family.name else 1

    @property
    def marking_digest(self) -> str:
        """A short hash that changes whenever the rules for points change, except the penalty for late work."""
        return _compute_short_hash(repr((self.follow_through, [slot.credit for slot in self.slots])))

    @property
    def problems_digest(self) -> str:
        """A short hash that changes whenever the problems change, for example with the secret or the questions."""
        slots = [slot.list_problem_settings() for slot in self.slots]
        return _compute_short_hash(repr((ENGINE, self.secret, self.key, slots)))

    @property
    def notebook_digest(self) -> str:
        """A short hash that changes whenever the notebooks change: the problems, title, points, hints or site."""
        # Digests of older versions did not have the hints and the site, so they are left out if there are none.
        markers = (*(["hints"] if self.hints else []), *filter(None, [self.site]))
        slots = [(slot.points, slot.decimals, *slot.definitions) for slot in self.slots]
        return _compute_short_hash(repr((self.problems_digest, self.title, slots, *markers)))

    @property
    def secret_digest(self) -> str:
        """A short hash that shows with which assignment secret a notebook was made, without revealing the secret."""
        return _compute_short_hash(repr((self.secret, "mark", self.key)))

    def problems_digest_of(self, student: str) -> str:
        """Return the hash of a student's problems: `problems_digest`, or another one if a problem was replaced."""
        return self._hash_with_seed_numbers(self.problems_digest, student)

    def notebook_digest_of(self, student: str) -> str:
        """Return the hash of a student's notebook: `notebook_digest`, or another one if a problem was replaced."""
        return self._hash_with_seed_numbers(self.notebook_digest, student)

    def _hash_with_seed_numbers(self, digest: str, student: str) -> str:
        """Return a hash of a digest and of all seed numbers above 1, or the digest itself if there are none."""
        seed_numbers = [(slot.name, self.seed_number_of(slot, student)) for slot in self.slots]
        later_seed_numbers = [(slot_name, number) for slot_name, number in seed_numbers if number > 1]
        return _compute_short_hash(repr((digest, later_seed_numbers))) if later_seed_numbers else digest


def _compute_short_hash(content: str) -> str:
    return hashlib.sha256(content.encode()).hexdigest()[:16]


def load_assignment(folder: Path, is_preview: bool = False) -> Assignment:
    """Read and check an assignment folder. Raises QdotError with all errors: the file, the line and the key of each.

    A preview needs only assignment.toml: without secret.txt and roster.csv, the assignment has a known secret and no
    students.

    >>> load_assignment(Path("docs/examples/course"), is_preview=True)
    Assignment(planar: 1 problems, 3 students)
    """
    _check_folder(folder)
    errors, roster_path = ErrorList(), folder / "roster.csv"
    file: TomlFile | None = None
    students: tuple[Student, ...] = ()
    class_list, secret, replacements = None, "", dict[tuple[str, str], Replacement]()
    with errors.collect():
        file = read_toml(folder / ASSIGNMENT_FILE, _MISSING_FILE_HINT, float)
    with errors.collect():
        if roster_path.exists() or not is_preview:
            students, class_list = read_roster(roster_path), read_class_list(roster_path)
    with errors.collect():
        secret = read_secret(folder, PREVIEW_SECRET if is_preview else "")
    with errors.collect():
        replacements = read_replacements(folder)
    if file is None:
        errors.raise_all()
    content, unusable_problems = _find_usable_content(file, errors)
    with errors.collect():
        _parse(file, ("key",), _check_assignment_key, content.key)
    with errors.collect():
        # A late rule needs a due date, so it can't be checked if the due date is wrong.
        has_wrong_due_date = "due" in file.content and content.due is None
        late_rule = None if has_wrong_due_date else _parse(file, ("late",), read_late_rule, content.late, content.due)
    with errors.collect():
        attempt_policy = _parse(file, ("attempts",), read_attempt_policy, content.attempts)
    # Cleared until they are checked, so that the slots don't inherit a wrong value and report it again.
    convention, content.convention = content.convention, None
    twist_order, content.twist_order = content.twist_order, None
    with errors.collect():
        _parse(file, ("convention",), normalize_convention, convention or DEFAULT_CONVENTION)
        content.convention = convention
    with errors.collect():
        _parse(file, ("twist_order",), normalize_twist_order, twist_order or DEFAULT_TWIST_ORDER)
        content.twist_order = twist_order
    with errors.collect():
        front_page = _parse(file, ("paper",), read_front_page, content.paper, folder)
    variation = DEFAULT_VARIATION
    with errors.collect():
        variation = _parse(file, ("variation",), find_canonical_name, content.variation)
    notes: list[str] = []
    slots = _read_slots(file, content, variation, notes, unusable_problems, errors)
    errors.raise_all()
    with file.locate_errors("twist_order"):
        uses_twist_order = any(_has_twist_order(slot.convention, slot.family) for slot in slots)
        if content.twist_order is not None and not uses_twist_order:
            raise QdotError(f"no arm of this assignment is described by screw axes; {TWIST_ORDER_HINT}")
    return Assignment(
        folder, content.title, content.key, tuple(slots), students, secret,
        content.due, content.feedback, tuple(notes), Fraction(str(content.follow_through)),
        content.hints, content.site, late_rule, attempt_policy, content.sandbox, class_list, replacements, front_page,
        content.practice,
    )  # fmt: skip


def split_question_name(name: str) -> tuple[str, str]:
    """Split a name in `questions` into a file name and the name of a question; either of them may be "".

    >>> split_question_name("../statics.toml#torque"), split_question_name("statics.toml"), split_question_name("rank")
    (('../statics.toml', 'torque'), ('statics.toml', ''), ('', 'rank'))
    """
    file_name, _, question = name.partition("#")
    return (file_name, question) if file_name.lower().endswith(QUESTION_FILE_EXTENSION) else ("", name)


def _read_all_definitions(file: TomlFile, content: AssignmentFile) -> tuple[dict[str, Definition], dict[str, TomlFile]]:
    """Return the instructor's questions by name, and the file of each: assignment.toml, or a file named by a problem.

    In `content`, the name of a file is replaced by the names of its questions. Raises QdotError.
    """
    definitions = read_definitions(file, ALL_QUESTIONS)
    files = dict.fromkeys(definitions, file)
    for index, entry in enumerate(content.problem):
        if not isinstance(entry.questions, list):
            continue
        names: list[str] = []
        for name in entry.questions:
            file_name, chosen_name = split_question_name(name)
            if not file_name:
                with file.locate_errors("problem", index, "questions"):
                    if "/" in name or "." in name:
                        raise QdotError(f"{name!r} is not a question; the name of a file of questions ends in .toml")
                names.append(name)
                continue
            with file.locate_errors("problem", index, "questions"):
                if "://" in file_name:
                    raise QdotError(f"{file_name} is a web address; download the file, and write its path")
                question_file, new_definitions = read_question_file(file.path.parent / file_name, ALL_QUESTIONS)
                if chosen_name and chosen_name not in new_definitions:
                    raise make_name_error("question", chosen_name, tuple(new_definitions))
                if chosen_name:
                    new_definitions = {chosen_name: new_definitions[chosen_name]}
                for new_name, definition in new_definitions.items():
                    if definitions.get(new_name, definition) != definition:
                        other_place = files[new_name].describe_value("question", new_name)
                        place = question_file.describe_value("question", new_name)
                        raise QdotError(f"two questions have the same name ({other_place}; {place}); rename one")
            definitions |= new_definitions
            files |= dict.fromkeys(new_definitions, question_file)
            names += new_definitions
        entry.questions = names
    return definitions, files


def _asks_only_built_in_questions(content: AssignmentFile, entry: ProblemEntry) -> bool:
    """Return whether a problem asks none of the instructor's own questions."""
    names = entry.questions if isinstance(entry.questions, list) else []
    return not any(name in content.question or split_question_name(name)[0] for name in names)


def _parse(file: TomlFile, key_path: Sequence[str | int], parse: Callable[..., Parsed], *values: object) -> Parsed:
    """Return the result of `parse` for the values of a key; add the file, the line and the key to a QdotError."""
    with file.locate_errors(*key_path):
        return parse(*values)


def _check_assignment_key(key: str) -> None:
    if key.lower().endswith(".ipynb"):
        raise QdotError(f'leave out .ipynb: key = "{key[: -len(".ipynb")]}"')
    if is_changed_by_windows(key):
        raise QdotError(f'it names the notebooks\' files; {WINDOWS_NAME_RULE}; write, for example, key = "velocity"')


def _check_folder(folder: Path) -> None:
    """Raise QdotError if the path is not a folder, or if it is a subfolder of an assignment folder."""
    parent_folder = folder / ".." if folder.name in ("", "..") else folder.parent
    if folder.exists() and not (folder / ASSIGNMENT_FILE).exists() and (parent_folder / ASSIGNMENT_FILE).is_file():
        raise QdotError(f"{folder} is inside an assignment folder; give that folder, {parent_folder}")
    if folder.is_file():
        raise QdotError(f"{folder} is a file; give the assignment's folder")
    if not folder.is_dir():
        siblings = [file.parent.name for file in folder.parent.glob(f"*/{ASSIGNMENT_FILE}")]
        similar = find_most_similar(folder.name, siblings)
        advice = f"did you mean {folder.with_name(similar)}?" if similar else f"'qdot init {folder}' creates one"
        raise QdotError(f"{folder} is not a folder; {advice}")


class _UsableContent(NamedTuple):
    """The usable content of assignment.toml, and the indices (from 0) of the problems that can't be used."""

    content: AssignmentFile
    unusable_problems: Set[int]


def _find_usable_content(file: TomlFile, errors: ErrorList) -> _UsableContent:
    """Return the usable content of assignment.toml, so that it can be checked even if other parts have errors.

    Misspelt or missing keys and wrong values are added to `errors` and left out of the content.
    """
    with errors.collect():
        file.check_keys((), tuple(AssignmentFile.model_fields), ("title", "key", "problem"))
    problems, problem_keys = file.content.get("problem"), tuple(ProblemEntry.model_fields)
    # Keys that may stand below a [[problem]] by mistake; `question` isn't one of them, because it is a table.
    top_level_keys = [name for name in AssignmentFile.model_fields if name != "question"]
    for index, table in enumerate(problems if isinstance(problems, list) else []):
        if isinstance(table, dict) and isinstance(table.get("question"), dict):
            with errors.collect(), file.locate_errors("problem", index, "question"):
                raise QdotError("write [question.NAME], without the word problem")
        elif isinstance(table, dict):
            with errors.collect():
                file.check_keys(("problem", index), problem_keys, (), top_level_keys)
    try:
        return _UsableContent(AssignmentFile.model_validate(file.content), frozenset())
    except pydantic.ValidationError as error:
        # A problem can be checked without its droppable keys, but not without its other keys.
        wrong_keys, droppable_keys, unusable_problems = set[str | int](), set[tuple[int, str]](), set[int]()
        for validation_error in error.errors():
            location = validation_error["loc"]
            key_path = location[:3] if location[0] == "problem" else location[:1]  # problem, index, key
            match key_path:
                case "problem", int(index), str(key) if key in ("points", "difficulty", "decimals", "credit"):
                    droppable_keys.add((index, key))
                case "problem", int(index), *_:
                    unusable_problems.add(index)
                case _:
                    wrong_keys.add(key_path[0])
            if validation_error["type"] not in ("extra_forbidden", "missing"):  # check_keys has reported these
                with errors.collect(), file.locate_errors(*key_path):
                    raise QdotError(EXPECTED_FORMS.get(str(key_path[-1]), EXPECTED_FORMS["problem"])) from None
    usable_content = {key: value for key, value in file.content.items() if key not in wrong_keys}
    entries = usable_content.get("problem", [{}])  # the model requires a problem, so an unusable one is a placeholder
    usable_content["problem"] = [
        {} if i in unusable_problems else {k: value for k, value in entry.items() if (i, k) not in droppable_keys}
        for i, entry in enumerate(entries)
    ]
    if "problem" in wrong_keys:
        unusable_problems.add(0)
    content = AssignmentFile.model_validate({"title": "-", "key": "key", **usable_content})
    return _UsableContent(content, unusable_problems)


def _read_slots(
    file: TomlFile, content: AssignmentFile, variation: str, notes: list[str], unusable_problems: Set[int],
    errors: ErrorList,
) -> list[Slot]:  # fmt: skip
    """Return the slots of all problems, except `unusable_problems`; add all errors to `errors`.

    If some of the instructor's questions have errors, all problems that ask the instructor's questions are left out,
    too.
    """
    slots: list[Slot] = []
    definitions, definition_files = dict[str, Definition](), dict[str, TomlFile]()
    has_all_definitions = False
    with errors.collect():
        definitions, definition_files = _read_all_definitions(file, content)
        has_all_definitions = True
    for index, entry in enumerate(content.problem):
        if index in unusable_problems or not (has_all_definitions or _asks_only_built_in_questions(content, entry)):
            continue
        with errors.collect():
            slot = _read_slot(file, content, index, variation, notes, definitions, definition_files)
            _parse(file, ("problem", index, "decimals"), _check_tolerances, slot, entry.decimals)
            slots.append(slot)
    return slots


def _read_slot(
    file: TomlFile, content: AssignmentFile, index: int, default_variation: str, notes: list[str],
    definitions: Mapping[str, Definition], definition_files: Mapping[str, TomlFile],
) -> Slot:  # fmt: skip
    """Return the slot of the [[problem]] at an index. Raises QdotError with all errors.

    `default_variation` is the assignment's, which the slot may override. Warnings about an instructor's robot and
    questions are appended to `notes`.
    """
    entry = content.problem[index]

    def parse(key: str, function: Callable[..., Parsed], *values: object) -> Parsed:
        return _parse(file, ("problem", index, key), function, *values)

    errors = ErrorList()
    with errors.collect():
        with file.locate_errors("problem", index):
            if (entry.family is None) == (entry.robot is None):
                raise QdotError(
                    'each [[problem]] needs either a family, as in family = "planar-2r", or a robot, as in robot = '
                    '"my-arm.toml"'
                )
        if entry.family is not None:
            family = parse("family", generation.look_up_family, entry.family)
            robot_digest = ""
        else:
            family, robot_digest = parse("robot", _read_robot, str(entry.robot), file.path.parent, notes)
    with errors.collect():
        variation = parse("variation", find_canonical_name, entry.variation or default_variation)
    with errors.collect():
        convention = entry.convention or content.convention or ""
        normalized_convention = parse("convention", normalize_convention, convention) if convention else ""
    with errors.collect():
        band = parse("difficulty", _read_band, entry.difficulty)
    errors.raise_all()
    # Normalising turns the default convention into "". For a robot, "" would mean the convention in the robot's file.
    if not robot_digest:
        convention = normalized_convention
    with errors.collect():
        twist_order = parse(
            "twist_order", _choose_twist_order, entry.twist_order, content.twist_order, family, convention
        )
    with errors.collect():
        if band is not None:  # without questions, this checks only that the family has arms of this difficulty
            parse("difficulty", generation.check_questions, family, (), band, variation, convention)
    questions_key = "family" if entry.questions is None else "questions"  # the key that error messages name
    with errors.collect():
        questions = parse(questions_key, _choose_questions, family, entry.questions, convention)
    errors.raise_all()
    asked_definitions = tuple(definitions[name] for name in questions if name in definitions)
    for definition in asked_definitions:
        definition_file = definition_files[definition.name]
        with errors.collect(), ExitStack() as stack:
            if definition_file is not file:
                stack.enter_context(file.locate_errors("problem", index, questions_key))
            stack.enter_context(definition_file.locate_errors("question", definition.name))
            notes += check_definition_on_family(definition, family, band, variation, convention)
    errors.raise_all()
    with errors.collect():
        parse(
            questions_key, generation.check_questions, family, questions, band, variation, convention,
            tuple(definitions.values()),  # all of them, for the suggestion if a name is misspelt
        )  # fmt: skip
    points = None if entry.points is None else tuple(entry.points)
    with errors.collect():
        parse("points", _check_points, points, len(questions))
    with errors.collect():
        decimals = parse("decimals", read_decimals, entry.decimals, questions)
    with errors.collect():
        credit = parse("credit", parse_credit_policy, entry.credit, questions)
    errors.raise_all()
    return Slot(
        f"p{index + 1}", family, questions, points, band, robot_digest, variation, convention, twist_order,
        decimals=decimals, credit=credit, definitions=asked_definitions,
    )  # fmt: skip


def _check_tolerances(slot: Slot, setting: int | str | Mapping[str, int | str]) -> None:
    """Raise QdotError if a tolerance has a different unit from the answer to a built-in question."""
    instructor_names = {definition.name for definition in slot.definitions}
    names = tuple(name for name, rounding in slot.decimals if rounding.absolute and name not in instructor_names)
    if names:
        parts = replace(slot, questions=names, points=None).generate_from_seed(0).parts
        check_units(setting, slot.questions, {part.name: part.answer for part in parts})


def check_definition_on_family(
    definition: Definition, family: Family, band: tuple[int, int] | None = None, variation: str = DEFAULT_VARIATION,
    convention: str = "",
) -> list[str]:  # fmt: skip
    """Check an instructor's question on one arm of a family, for example that its texts can be filled in.

    Return warnings. Raise QdotError if a check fails, for example because the answer, a number, does not depend on the
    given values; its message begins with the key.
    """
    try:
        generation.check_questions(family, (definition.name,), band, variation, convention, (definition,))
    except generation.InapplicableQuestion as error:
        raise QdotError(f"{error.key or definition.answer_key}: {error}") from None
    except QdotError as error:
        raise QdotError(f"{definition.answer_key}: {error}") from None
    identity = ProblemId(family.name, 0, (definition.name,), variation=variation, convention=convention)
    problem = generation.generate(identity, family=family, definitions=(definition,))
    evaluator = DefinitionEvaluator(definition)
    if (number_error := evaluator.find_objection_to_numbers(problem.chain)) is not None:
        raise QdotError(f"{number_error} (for an arm of {family.name})")
    if (unit_error := evaluator.find_wrong_unit(problem.chain)) is not None:
        raise QdotError(f"unit: for {family.name}, {unit_error}")
    for texts in definition.texts:
        wording = Wording(problem.chain, load_catalogue(texts.language))
        for key, text in texts.list_texts():
            try:
                filled_text = fill_text(text, problem.parts[0], wording)
                check_formulas(filled_text)
                if key == "prompt":
                    check_given_values(filled_text, problem.parts[0], wording)
            except QdotError as error:
                prefix = "" if texts.language == ENGLISH else f"{texts.language}."
                raise QdotError(f"{prefix}{key}: {error}") from None
    for option in definition.options:
        try:
            if not option.is_formula:
                check_formulas(fill_text(option.content, problem.parts[0], Wording(problem.chain)))
        except QdotError as error:
            raise QdotError(f"options: {error}") from None
    warnings = evaluator.list_warnings(problem.chain)
    pairs = [(warning, warning.key if isinstance(warning, KeyReason) else "") for warning in warnings]
    return [f"{definition.find_location(key)}: for {family.name}, {warning}" for warning, key in pairs]


def _choose_twist_order(setting: str | None, default: str | None, family: Family, convention: str) -> str:
    """Return the twist order of a slot; "" for arms described by tables, and if a robot's file decides.

    `setting` is the slot's own order, and `default` is the assignment's order. Raises QdotError.
    """
    chosen_order = setting or default or ""
    normalized_order = normalize_twist_order(chosen_order) if chosen_order else ""
    if _has_twist_order(convention, family):
        return chosen_order if family.is_robot else normalized_order
    if setting is not None:
        raise QdotError(f"its arms are described by tables; {TWIST_ORDER_HINT}")
    return ""


def _has_twist_order(convention: str, family: Family) -> bool:
    """Return whether arms are described by their axes, so that their twists have an order.

    The convention "" means the default: for a family, the default convention; for a robot, the convention in its file.
    """
    default = DEFAULT_CONVENTION if family.chapter_arm is None else family.chapter_arm.convention
    return bool(REGISTRY[convention or default].twist_orders)


def _choose_questions(family: Family, setting: list[str] | str | None, convention: str) -> tuple[str, ...]:
    """Return the questions that a problem asks. Raises QdotError if the setting is not valid for the family."""
    if isinstance(setting, str) and setting != "quiz":
        raise QdotError(EXPECTED_FORMS["questions"])
    if family.has_varied_structure and (not setting or setting == "quiz"):
        raise QdotError(
            'its arms are of many kinds; list questions that apply to all of them, as in questions = ["jacobian"]'
        )
    if setting == []:
        raise QdotError("the list is empty; leave the key out to use all questions that apply")
    if isinstance(setting, list) and "quiz" in setting:
        raise QdotError(
            'write "quiz" alone and without brackets, as in questions = "quiz"; put other questions into another '
            "[[problem]], or list the short questions by name"
        )
    if setting is None:
        return generation.list_questions_of_family(family, convention)
    return generation.select_quiz_questions(family, convention) if setting == "quiz" else tuple(setting)


def _check_points(points: tuple[float, ...] | None, question_count: int) -> None:
    if points is not None and len(points) != question_count:
        counts = f"{count_noun(len(points), 'number')} for {count_noun(question_count, 'question')}"
        advice = EXPECTED_FORMS["points"].removesuffix("[1, 2]")  # this example may have the wrong length
        raise QdotError(f"{counts}; {advice}{[1] * question_count}")
    if points is not None and any(not 0 < number < MAX_QUESTION_POINTS for number in points):
        raise QdotError(EXPECTED_FORMS["points"])


def _read_robot(name: str, folder: Path, notes: list[str]) -> tuple[Family, str]:
    """Return the family of a robot file, and the digest of the file; append warnings about the robot to `notes`."""
    path = find_robot_path(name, folder)
    robot = read_robot_file(path)
    notes += robot.notes
    return read_robot_family(path, robot), _compute_short_hash(path.read_text(encoding="utf-8", errors="replace"))


def _read_band(difficulty: int | list[int] | None) -> tuple[int, int] | None:
    """Return the minimum and maximum difficulty of a slot; None if it sets none. Raises QdotError."""
    if difficulty is None:
        return None
    limits = [difficulty, difficulty] if isinstance(difficulty, int) else difficulty
    if len(limits) != 2 or not 0 <= limits[0] <= limits[1] <= HARDEST_LEVEL:
        raise QdotError(EXPECTED_FORMS["difficulty"])
    return limits[0], limits[1]


def read_roster(path: Path, missing_hint: str = _MISSING_FILE_HINT) -> tuple[Student, ...]:
    """Return the students in a roster, which is a table with a column `student` or an export from Canvas or Moodle.

    If there is no such file, the message contains `missing_hint`. Raises QdotError with all errors.
    """
    students: list[Student] = []
    lines: dict[str, int] = {}
    errors = ErrorList()
    for number, cells in read_roster_table(path, missing_hint):
        location = f"{path}: line {number}"
        identifier = normalize_identifier(cells["student"])
        with errors.collect():
            _check_identifier(location, identifier)
            folded_identifier = identifier.casefold()  # many file systems treat names that differ only in case as one
            if lines.setdefault(folded_identifier, number) != number:
                raise QdotError(f"{location}: student {identifier!r} is already on line {lines[folded_identifier]}")
        identity_columns = ("student", "name", "email", LAST_NAME_KEY)
        other_cells = tuple((column, cell) for column, cell in cells.items() if column not in identity_columns)
        due_date = None
        with errors.collect():
            due_date = _parse_due_date(location, cells.get("due", "").strip())
        name, email = cells.get("name", "").strip(), get_cell_under_any_name(cells, "email")
        last_name = cells.get(LAST_NAME_KEY) or get_cell_under_any_name(cells, "last name")
        name = name or f"{get_cell_under_any_name(cells, 'first name')} {last_name}".strip()
        students.append(Student(identifier, name, email, other_cells, due_date, last_name))
    errors.raise_all()
    if not students:
        raise QdotError(f"{path}: the roster is empty; add one student per line below the header")
    return tuple(students)


def read_roster_table(path: Path, missing_hint: str = _MISSING_FILE_HINT) -> list[tuple[int, dict[str, str]]]:
    """Return the lines of a roster or an export: the number of each line, and its cells by column. Raises QdotError."""
    class_list = read_class_list(path)
    return class_list.roster_lines if class_list else read_table(path, "student", "student,name,email", missing_hint)


def _parse_due_date(location: str, text: str) -> datetime.datetime | None:
    """Return the date in a cell `due` of the roster; None if the cell is empty."""
    if not text:
        return None
    try:
        if ":" in text:  # without a time, fromisoformat would return the midnight at which the day begins
            return datetime.datetime.fromisoformat(text)
    except ValueError:
        pass
    expected_form = "expected a date with a time, as in 2027-01-20T23:59:00+01:00, or nothing"
    raise QdotError(f"{location}: due = {text!r}: {expected_form}")


def _check_identifier(location: str, identifier: str) -> None:
    if not identifier:
        raise QdotError(f"{location}: the first cell, the student's identifier, is empty")
    has_control_character = any(unicodedata.category(character).startswith("C") for character in identifier)
    has_forbidden_character = has_control_character or not set(identifier).isdisjoint('/\\:*?"<>|')
    is_unusable = has_forbidden_character or identifier.startswith((".", "-")) or len(identifier) > 100
    if is_unusable or is_changed_by_windows(identifier):
        rule = IDENTIFIER_RULE if is_unusable else WINDOWS_NAME_RULE
        advice = f"can't be an identifier, because qdot names folders after it; {rule}"
        raise QdotError(f"{location}: {identifier!r} {advice}")


def read_secret(folder: Path, default: str = "") -> str:
    """Return the assignment's secret, from its file or from the environment.

    If there is none, return `default`. Raises QdotError if the default is "", too.
    """
    path = folder / SECRET_FILE
    secret, source = os.environ.get(SECRET_VARIABLE, "").strip() or default, f"${SECRET_VARIABLE}"
    if path.exists():
        secret, source = read_text(path).strip(), str(path)
    elif not secret:
        raise QdotError(
            f"{path}: file not found; without the secret, qdot can't regenerate the students' problems. Restore the "
            f"file that 'qdot init' created (always have a copy of it), or set {SECRET_VARIABLE}"
        )
    if len(secret) < MIN_SECRET_LENGTH:
        length = count_noun(len(secret), "character")
        raise QdotError(f"{source}: the secret has {length}; it needs at least {MIN_SECRET_LENGTH}")
    return secret
