"""On which line of its file an answer stands: of notebooks as they are written, saved again, and of other files."""

import json
from pathlib import Path
from typing import Any

import pytest

from qdot.exercises.assignment.assignment import Assignment, Student
from qdot.exercises.notebook.notebook import notebook_text, student_notebook
from qdot.grader.reports.answer_positions import line_of_answer
from tests.support.handing_in import PARTS, Cells, a_class, code, right_cells, text


@pytest.fixture(scope="module")
def assignment(tmp_path_factory: pytest.TempPathFactory) -> Assignment:
    return a_class(tmp_path_factory.mktemp("course") / "hw", [Student("ada")])


def as_lines(cells: Cells) -> Cells:
    """Return cells as Jupyter saves them: each line of a text a string of its own."""
    return [{**cell, "source": cell["source"].splitlines(keepends=True)} for cell in cells]


def written(path: Path, cells: Cells, **layout: Any) -> list[str]:
    path.write_text(json.dumps({"cells": cells, "metadata": {}, "nbformat": 4, "nbformat_minor": 5}, **layout))
    return path.read_text().split("\n")


def test_in_a_notebook_that_we_hand_out_each_answer_is_at_its_own_cell(assignment: Assignment, tmp_path: Path) -> None:
    """Prompts, hints and checks name the variables, too, on lines before and after."""
    path = tmp_path / "hw.ipynb"
    path.write_text(notebook_text(student_notebook("T", "hw", "ada", assignment.problems("ada"), hinted=True)))
    lines = path.read_text().split("\n")
    for part in PARTS:
        name = part.replace(".", "_")
        assert lines[line_of_answer(path, part) - 1].strip().startswith(f'"source": "{name} = ')
        assert any(name in line for line in lines[: line_of_answer(path, part) - 1])


def test_the_line_is_that_of_the_statement_once_jupyter_has_saved_it(assignment: Assignment, tmp_path: Path) -> None:
    cells = [text("write `p1_jacobian = [[…]]`\n\np1_jacobian = 1"), *right_cells(assignment, "ada")]
    cells[0]["metadata"] = {"cells": [{"source": "p1_jacobian = 2"}], "note": 'a "quoted" \\ text'}
    cells[-2]["source"] = "# my answer\np1_jacobian = 0\nA = 1 \\\n  + 2\np1_jacobian = A\nprint(p1_jacobian == A)"
    lines = written(tmp_path / "hw.ipynb", as_lines(cells), indent=1)
    assert lines[line_of_answer(tmp_path / "hw.ipynb", "p1.jacobian") - 1].strip() == '"p1_jacobian = A\\n",'


def test_without_a_statement_it_is_the_cell_and_then_the_first_line(assignment: Assignment, tmp_path: Path) -> None:
    cells = right_cells(assignment, "ada")
    cells[-1]["source"] = "I don't know\nreally"
    cells[-2]["source"] = ""
    lines = written(path := tmp_path / "hw.ipynb", as_lines(cells), indent=1)
    assert "I don't know" in lines[line_of_answer(path, "p1.determinant") - 1]
    begins = line_of_answer(path, "p1.jacobian")
    assert lines[begins - 1].strip() == "{" and '"cell_type"' in lines[begins]
    assert line_of_answer(path, "p9.twist") == 1
    written(path, cells)  # all of it on one line
    assert line_of_answer(path, "p1.position") == 1


def test_worksheets_scripts_and_markdown_have_lines_too(tmp_path: Path) -> None:
    old = tmp_path / "old.ipynb"
    sheet = {"cells": [{**code(""), "input": ["x = 1\n", "p1_position = x"]}]}
    del sheet["cells"][0]["source"]
    old.write_text(json.dumps({"worksheets": [sheet], "nbformat": 3}, indent=1))
    assert "p1_position" in old.read_text().split("\n")[line_of_answer(old, "p1.position") - 1]
    script = tmp_path / "mine.py"
    script.write_text("# p1_position = …\n\np1_position = 1\np1_jacobian = 2\n")
    assert (line_of_answer(script, "p1.position"), line_of_answer(script, "p1.jacobian")) == (3, 4)
    markdown = tmp_path / "mine.md"
    markdown.write_text("Set `p1_position = …`\n```python\np1_position = 1\n```\n")
    assert line_of_answer(markdown, "p1.position") == 3
    for name, content in (("a.ipynb", '{"cells": []}'.encode("utf-16")), ("b.ipynb", b""), ("c.pdf", b"%PDF")):
        (tmp_path / name).write_bytes(content)
        assert line_of_answer(tmp_path / name, "p1.position") == 1, "what is no text has a first line only"
