"""Jupyter habits in the sandboxed process: display code does nothing, and the rest of the notebook counts."""

import json
from typing import Any

import pytest

from qdot.grader.sandbox.sandbox import Run, Sandbox
from tests.support import DATA

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
