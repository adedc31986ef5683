"""Write results as JUnit XML, which GitLab, Jenkins, Artemis and most other CI systems show: a test for every part.

A test has the classname KEY.STUDENT and a name such as "p1.jacobian: title". No two tests have the same classname and
name, because GitLab drops duplicates. A part that lacks points is a failure; a part that qdot failed to grade is an
error.
"""

import xml.etree.ElementTree as ET
from collections.abc import Sequence

from qdot.exercises.assignment.assignment import Assignment
from qdot.grader.grading.result import Result
from qdot.grader.marking.marking import format_points
from qdot.grader.reports.answer_display import make_visible
from qdot.grader.reports.grades_table import has_points
from qdot.grader.reports.part_rows import PartRow, make_part_rows

MAX_ATTRIBUTE_LENGTH = 300
"""Maximum number of characters of a message in an attribute; the element's text has the whole message."""


def write_junit_xml(assignment: Assignment, results: Sequence[Result]) -> str:
    """Return the text of the XML file, with a test suite for every student."""
    student_rows = [(result, make_part_rows(result, assignment)) for result in results]
    all_rows = [row for _, rows in student_rows for row in rows]
    root = ET.Element("testsuites", {"name": assignment.key, **_count_tests(all_rows)})
    for result, rows in student_rows:
        classname = f"{assignment.key}.{result.student}"
        suite = ET.SubElement(root, "testsuite", {"name": classname, **_count_tests(rows)})
        properties = ET.SubElement(suite, "properties")
        points_by_name = {"score": result.score} if has_points(result) else {}
        for name, points in (points_by_name | {"max_score": result.max_score}).items():
            ET.SubElement(properties, "property", {"name": name, "value": format_points(points)})
        for row in rows:
            test = ET.SubElement(suite, "testcase", {"classname": classname, "name": f"{row.part}: {row.title}"})
            if not row.has_full_points:
                message = make_visible(f"{row.points_text} points, {row.description}")
                tag = "error" if row.points is None else "failure"
                attributes = {"message": message[:MAX_ATTRIBUTE_LENGTH], "type": row.outcome}
                ET.SubElement(test, tag, attributes).text = message
    ET.indent(root, " ")
    return ET.tostring(root, encoding="unicode", xml_declaration=False) + "\n"


def _count_tests(rows: Sequence[PartRow]) -> dict[str, str]:
    """Return the attributes of an element that count its tests, failures and errors."""
    errors = sum(row.points is None for row in rows)
    failures = sum(not row.has_full_points for row in rows) - errors
    return {"tests": str(len(rows)), "failures": str(failures), "errors": str(errors), "skipped": "0"}
