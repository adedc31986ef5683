"""Read overrides.csv: points and comments that a person sets, and that apply to every later run.

The columns of this table are student, part (`p1.jacobian`; empty for the student's total), points and comment. The
optional column group names a group of equal wrong answers instead of a student. The line then applies to all students
in that group. A line with the optional column answer, copied from graded/to-mark.csv, applies only to this answer.
"""

import re
import unicodedata
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction

from qdot.exercises.assignment.assignment import Assignment
from qdot.exercises.common.console import escape_controls
from qdot.exercises.common.errors import QdotError, find_most_similar, make_name_error, write_first
from qdot.exercises.common.input_file import read_table
from qdot.grader.diagnosis.groups import KEY_LENGTH, KEY_LETTERS, format_group_key
from qdot.grader.grading.result import Override
from qdot.grader.marking.marking import compute_points, map_max_points, sum_points

OVERRIDES_FILE = "overrides.csv"
STUDENT_COLUMN = "student"
COLUMN_NAMES = (STUDENT_COLUMN, "part", "points", "comment")
"""The columns that overrides.csv always has; the optional columns follow."""
HEADER = ",".join(COLUMN_NAMES)
GROUP_COLUMN = "group"
"""An optional column: the group of equal wrong answers to which a line applies, instead of a student."""
ANSWER_COLUMN = "answer"
"""An optional column, as in graded/to-mark.csv: if filled in, the line applies to this free-text answer only.

A line that was copied from graded/to-mark.csv may have no points yet.
"""
TOTAL_PART = ""
"""The value of the column part that means a student's total."""


@dataclass(frozen=True)
class Overrides:
    """The contents of overrides.csv.

    `by_part` maps a student, a part and an answer (see `flatten_answer`) to an override; the answer is "" if the
    override applies to any answer. `by_group` maps the key of a group to the group's override.
    """

    by_part: Mapping[tuple[str, str, str], Override] = field(default_factory=dict)
    by_group: Mapping[str, Override] = field(default_factory=dict)

    def find(self, student: str, part: str, answer: str = "") -> Override | None:
        """Return the override of a student's part with this answer; None if there is none."""
        return self.by_part.get((student, part, flatten_answer(answer))) or self.by_part.get((student, part, ""))

    def has_marked_answer(self, student: str, part: str) -> bool:
        """Return whether a line marks one particular answer of this student to this part."""
        marked_parts = {(marked_student, marked_part) for marked_student, marked_part, answer in self.by_part if answer}
        return (student, part) in marked_parts


def flatten_answer(answer: str) -> str:
    """Return a free-text answer on a single line.

    It is as in graded/to-mark.csv, but without the quote that may be put before it there.
    """
    line = escape_controls(" ".join(answer.split()))
    return unicodedata.normalize("NFC", line).removeprefix("'")


NO_OVERRIDES = Overrides()


def read_overrides(assignment: Assignment) -> Overrides:
    """Return the overrides of an assignment from its overrides.csv; empty if the file is missing. Raises QdotError.

    Every line is checked against the roster and the assignment, so that no line is silently ignored. A group's members
    are known only after the whole class is graded; `describe_unused_groups` reports groups without members.
    """
    path = assignment.folder / OVERRIDES_FILE
    if not path.exists():
        return NO_OVERRIDES
    max_points = map_max_points(assignment)
    max_points[TOTAL_PART] = sum_points(max_points.values())
    students = [student.id for student in assignment.roster]
    by_part: dict[tuple[str, str, str], Override] = {}
    by_group: dict[str, Override] = {}
    first_lines: dict[tuple[str, str, str], int] = {}
    for line_number, cells in read_table(path, STUDENT_COLUMN, HEADER):
        location = f"{path}: line {line_number}"
        if not {"part", "points"} <= set(cells):
            raise QdotError(f"{location}: there is no cell for part or points; the columns are {HEADER}")
        columns = (*COLUMN_NAMES, GROUP_COLUMN, ANSWER_COLUMN)
        texts = [unicodedata.normalize("NFC", cells.get(name, "").strip()) for name in columns]
        student, part, points, comment, group, answer = texts
        if group and student:
            names = f"the student {student!r} and the group {group!r}"
            raise QdotError(
                f"{location}: this line names {names}; name only one of them, and leave the other cell empty"
            )
        if group:
            part, group = _parse_group(location, part, group, list(max_points))
        elif student not in students:
            raise QdotError(f"{location}: roster.csv has no student {student!r}")
        if part not in max_points:
            raise _make_unknown_part_error(location, part, list(max_points))
        target = f"the group {group!r}" if group else f"{part or 'the total'} of {student!r}"
        target_key = (student, group or part, answer)  # the key of a group begins with its part
        if target_key in first_lines:
            raise QdotError(f"{location}: {target} was already set on line {first_lines[target_key]}")
        first_lines[target_key] = line_number
        if group and not points and not comment:
            raise QdotError(
                f"{location}: there are neither points nor a comment for {target}; enter at least one of them"
            )
        if student and not points and not comment and ANSWER_COLUMN in cells:
            continue  # an answer that is not marked yet
        new_points = None if comment and not points else _parse_points(location, part, points, max_points[part])
        # The grader's points become known when the override is applied.
        if group:
            by_group[group] = Override(new_points, comment, previous_points=None, group=group)
        else:
            by_part[student, part, flatten_answer(answer)] = Override(new_points, comment, previous_points=None)
    return Overrides(by_part, by_group)


def describe_unused_groups(assignment: Assignment, overrides: Overrides, class_groups: Sequence[str]) -> list[str]:
    """Return a note on each group in overrides.csv that contains no answer.

    `class_groups` are the keys of all groups of the class.
    """
    notes = []
    for group in (group for group in overrides.by_group if group not in class_groups):
        part, letters = group.split("/")
        part_groups = [key for key in class_groups if key.split("/")[0] == part]
        similar_letters = find_most_similar(letters, [key.split("/")[1] for key in part_groups])
        hint = f" (did you mean {format_group_key(part, similar_letters)!r}?)" if similar_letters else ""
        listing = f"groups of {part}: {write_first(part_groups, MAX_GROUPS_LISTED)}; `qdot report` shows all groups"
        known_groups = listing if part_groups else f"no answer to {part} is in a group"
        warning = f"the group {group!r}{hint} has no answers in this class, so its line has no effect yet"
        notes.append(f"{assignment.folder / OVERRIDES_FILE}: {warning}; {known_groups}")
    return notes


MAX_GROUPS_LISTED = 8
"""Maximum number of groups listed in a note."""


def _parse_group(location: str, part: str, group: str, part_names: Sequence[str]) -> tuple[str, str]:
    """Return the part and the key of the group that a line names. Raises QdotError.

    If the line also names the part, `group` may contain just the letters of the key. `location` is the file and the
    line, for messages.
    """
    part_of_group, _, letters = group.rpartition("/")
    if not re.fullmatch(f"[{KEY_LETTERS}]{{{KEY_LENGTH}}}", letters.lower()) or not (part_of_group or part):
        expected_form = f"a part and {KEY_LENGTH} letters, as in {format_group_key(part_names[0], 'kqvxwz')}"
        raise QdotError(f"{location}: group = {group!r}: expected a key that `qdot report` shows, {expected_form}")
    if part_of_group and part_of_group not in part_names:
        raise _make_unknown_part_error(location, part_of_group, part_names)
    if part_of_group and part and part_of_group != part:
        contradiction = f"the group {group!r} belongs to {part_of_group}, but the line names {part}"
        raise QdotError(f"{location}: {contradiction}; leave part empty")
    named_part = part_of_group or part
    return named_part, format_group_key(named_part, letters.lower())


def _make_unknown_part_error(location: str, part: str, all_names: Sequence[str]) -> QdotError:
    part_names = tuple(name for name in all_names if name != TOTAL_PART)
    return QdotError(f"{location}: {make_name_error('part', part, part_names)}; empty means the student's total")


def _parse_points(location: str, part: str, text: str, max_points: float) -> float:
    """Parse the points of a line: a number, or a percentage of the maximum `max_points`. Raises QdotError."""
    number_text = text.replace(",", ".")  # a spreadsheet that separates cells by semicolons may write a decimal comma
    percentage = re.fullmatch(r"(\d+(?:\.\d{1,4})?) ?%", number_text)
    if percentage and Fraction(percentage[1]) <= 100:
        return compute_points(max_points, share=1.0, factor=Fraction(percentage[1]) / 100)
    if not re.fullmatch(r"\d+(\.\d{1,4})?", number_text):
        forms = f"a number from 0 to {max_points:g} with at most four decimals, as in 1.5, or a percentage, as in 50 %"
        raise QdotError(f"{location}: points = {text!r}: expected {forms}")
    if float(number_text) > max_points:
        raise QdotError(f"{location}: points = {text}: {part or 'the total'} has at most {max_points:g} points")
    return float(number_text)
