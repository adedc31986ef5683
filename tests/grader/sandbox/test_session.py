"""What a notebook's session gives: values as text, IPython's habits, and stand-ins for plots and input."""

import json
import time
from typing import Any

import numpy as np
import pytest
import sympy as sp

from qdot.grader.sandbox.notebook_process.answer_formatting import format_value
from qdot.grader.sandbox.notebook_process.ipython import NON_PYTHON_MAGICS, translate_to_python
from qdot.grader.sandbox.sandbox import Run, Sandbox
from tests.support import DATA, ROOT, read_cases
from tests.support.suites import sample_for_suite

JUPYTER = json.loads((DATA / "jupyter_cells.json").read_text(encoding="utf-8"))
SETUP = "from sympy import Matrix, Symbol, sin\ntheta1 = Symbol('theta1')"


def run(sandbox: Sandbox, *cells: str) -> Run:
    return sandbox.run(cells, ["a", "b", "c"], setup=SETUP)


@pytest.mark.parametrize("case", JUPYTER["syntax and helpers"], ids=lambda case: case["cells"][0][:20])
def test_jupyter_syntax_and_helpers_work(sandbox: Sandbox, case: dict[str, Any]) -> None:
    result = run(sandbox, *case["cells"])
    assert (result.answers, result.cell_errors, result.failed_imports, result.end) == (case["answers"], {}, {}, "done")


@pytest.mark.parametrize("code", JUPYTER["display code"].values(), ids=JUPYTER["display code"])
def test_display_code_does_nothing(sandbox: Sandbox, code: str) -> None:
    result = run(sandbox, f"{code}\na = 1", "b = sin(theta1)")
    assert (result.answers, result.cell_errors, result.failed_imports) == ({"a": "1", "b": "sin(theta1)"}, {}, {})


HIDE_MATPLOTLIB = (
    "import sys, importlib.machinery as m\nreal = m.PathFinder.find_spec\n"
    "m.PathFinder.find_spec = classmethod(lambda c, n, p=None, t=None:"
    " None if n.startswith(('matplotlib', 'mpl_toolkits')) else real(n, p, t))"
)


@pytest.mark.parametrize(
    "is_hidden",
    [pytest.param(False, marks=pytest.mark.whole, id="with matplotlib"), pytest.param(True, id="without matplotlib")],
)
def test_plots_raise_no_error(sandbox: Sandbox, is_hidden: bool) -> None:
    first_cells = [HIDE_MATPLOTLIB if is_hidden else "", "%matplotlib inline\nimport matplotlib.pyplot as plt\na = 1"]
    last_cells = ["c = 'Finder' in str(plt.__spec__.loader)"]
    if not is_hidden:
        pytest.importorskip("matplotlib")
        last_cells += ["plt.savefig('x.png')\nb = open('x.png', 'rb').read()[1:4].decode()"]
    result = run(sandbox, *first_cells, *JUPYTER["plots"], *last_cells)
    assert (result.cell_errors, result.failed_imports) == ({}, {})
    assert result.answers == {"a": "1", "c": str(is_hidden)} | ({} if is_hidden else {"b": "PNG"})


def test_a_cell_continues_after_a_failed_import(sandbox: Sandbox) -> None:
    result = run(sandbox, "import numpy; import nosuchlibrary.linalg as la; a = 1\nb = 2", "c = la.expm(1)")
    assert result.answers == {"a": "1", "b": "2"}
    number, message = result.failed_imports[0]
    assert number == 1 and "No module named 'nosuchlibrary'; this library is not available for grading" in message
    assert result.cell_errors == {1: "NameError: name 'la' is not defined"} and result.stop_lines == {1: 1}


def test_a_broken_display_library_is_replaced_by_a_stand_in(sandbox: Sandbox) -> None:
    broken = "import os\nos.mkdir('plotly')\nopen('plotly/__init__.py', 'w').write('open(\"/etc/passwd\")')"
    result = run(
        sandbox,
        broken,
        "import plotly.express as px\nfrom plotly import graph_objects as go\npx.line(); go.Figure()\na = 1",
    )
    assert (result.answers, result.cell_errors, result.failed_imports) == ({"a": "1"}, {}, {})


def test_the_line_at_which_a_cell_stopped_is_recorded(sandbox: Sandbox) -> None:
    result = run(sandbox, "a = 1\n\n%who\nb = 1/0\nc = 2", "x = 1\ny = (", "def f():\n    return 1/0", "\nf()")
    assert result.stop_lines == {0: 4, 1: 2, 3: 2}


def test_an_error_caused_by_input_explains_that_input_is_empty(sandbox: Sandbox) -> None:
    result = run(sandbox, "a = float(input('L1?'))", "b = float('x')")
    assert "input() returns an empty string when a notebook is graded" in result.cell_errors[0]
    assert "input()" not in result.cell_errors[1]


def test_symbols_exist_before_the_first_cell_and_may_be_reassigned(sandbox: Sandbox) -> None:
    assert run(sandbox, "a = sin(theta1)", "theta1 = 5", "b = theta1").answers == {"a": "sin(theta1)", "b": "5"}
    assert run(sandbox, "a = theta1").answers == {"a": "theta1"}


def test_stand_ins_and_magics_are_no_way_out_of_the_sandbox(sandbox: Sandbox) -> None:
    """A stand-in's savefig writes no file, and magics obey the audit hook."""
    cells = [
        "import plotly, os\nplotly.figure().savefig('x.png')\na = os.path.exists('x.png')",
        "b = plotly.figure()",
        "%%writefile /tmp/outside.txt\nx",
        "%run /etc/passwd",
    ]
    result = run(sandbox, *cells)
    assert result.answers == {"a": "False"} and sorted(result.cell_errors) == [2, 3]
    assert all("may not open" in error for error in result.cell_errors.values())
    assert "nothing is displayed when a notebook is graded" in result.unreadable_reasons["b"]


X, Y = sp.symbols("x y")
VALUES = [
    (sp.Poly(X**2 + Y, X), "x**2 + y"), (sp.sinc(X), "sin(x)/x"), (sp.Point(1, X), "[1, x]"),
    (sp.Derivative(X**2, X), "2*x"), (sp.Determinant(sp.Matrix([[X, 1], [Y, 2]])), "2*x - y"),
    (sp.Eq(sp.Matrix([X, Y]), sp.Matrix([1, 2])), "[Eq(x, 1), Eq(y, 2)]"),
    (np.array([[1.5, 0], [0, 2]]), "[[1.5, 0.0], [0.0, 2.0]]"),
    (sp.ImmutableDenseNDimArray([X, 1]), "[x, 1]"), ("a1*s1", "a1*s1"),
]  # fmt: skip


@pytest.mark.parametrize(("value", "text"), VALUES)
def test_values_are_formatted_as_typed_text(value: Any, text: str) -> None:
    assert format_value(value) == text


def test_a_matrix_symbol_is_rejected() -> None:
    with pytest.raises(TypeError, match="a MatrixSymbol has no entries"):
        format_value(sp.MatrixSymbol("J", 2, 2))


CELLS = read_cases("sandbox")["cells_of_ipython"]
PYTHON = read_cases("sandbox")["cells_of_python"]


@pytest.mark.parametrize("cell", [*CELLS, *PYTHON])
def test_translation_agrees_with_ipython_and_leaves_python_unchanged(cell: str) -> None:
    from IPython.core.inputtransformer2 import TransformerManager

    expected = TransformerManager().transform_cell(cell)  # type: ignore[no-untyped-call]
    assert translate_to_python(cell).strip("\n") == expected.strip("\n")
    assert translate_to_python(translate_to_python(cell)) == translate_to_python(cell)
    assert cell not in PYTHON or translate_to_python(cell) == cell


def test_this_projects_own_code_is_unchanged() -> None:
    paths = sample_for_suite(
        sorted(path for name in ("exercises", "grader", "tests") for path in (ROOT / name).rglob("*.py")), 60
    )
    assert len(paths) > 50
    assert [path for path in paths if translate_to_python(text := path.read_text(encoding="utf-8")) != text] == []


@pytest.mark.parametrize(
    "cell", ["a = 1\n!pip install \\\n  x\nb = 2", "%time a = 1\n?b\nb = 2\n\n%who", "%%time\n%a\nb = 2"]
)
def test_translation_keeps_line_numbers(cell: str) -> None:
    """The grader reports lines of the submitted cell."""
    before, after = cell.split("\n"), translate_to_python(cell).split("\n")
    assert len(before) == len(after)
    assert before.index("b = 2") == after.index("b = 2")


def test_the_body_of_a_cell_magic_runs_if_it_is_python() -> None:
    assert translate_to_python("%%time\nx = 1\n%who") == "pass\nx = 1\nget_ipython().run_line_magic('who', '')"
    assert translate_to_python("%%time\n%%capture out\nx = 1") == "pass\npass\nx = 1"
    for name in NON_PYTHON_MAGICS:
        assert translate_to_python(f"%%{name}\nx = 1") == f"get_ipython().run_cell_magic({name!r}, '', 'x = 1\\n')"
    assert translate_to_python("%time x = 1\n  %time") == "x = 1\n  pass"


@pytest.mark.parametrize(
    "cell",
    ["(\n", "\n", "'''\n", "!", "=\t", "a?", " ", "%x\n", "if 1:\n", "x = \\\n", "*", "a" * 10 + "!?\n", "%%time\n"],
)
def test_hostile_cells_are_translated_in_linear_time(cell: str) -> None:
    """Translate cells of 30,000 characters that could make a careless parser quadratic."""
    start, repeated = time.process_time(), cell * (30_000 // len(cell))
    for hostile in (repeated, f"!x\n{repeated}", f"sin?\n{cell * 10_000}?"):
        translate_to_python(hostile)
    assert time.process_time() - start < 6
