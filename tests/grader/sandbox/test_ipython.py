"""Translating IPython cells to Python: the result is the same as IPython's own, and plain Python is unchanged."""

import time

import pytest

from qdot.grader.sandbox.notebook_process.ipython import NON_PYTHON_MAGICS, translate_to_python
from tests.support import ROOT
from tests.support.suites import sample_for_suite

CELLS = [
    "files = !ls", "a, b = !ls", "a[0] = !ls", "!ls -l | grep x", "!!ls", "sin?", "sin??", "a.b.c?", "x[0]?", "θ?",
    "?sin", "??sin", "*int*?", "%matplotlib inline", "%pip install scipy", "a = %timeit -o 1+1",
    "x = 5\nif x:\n    %matplotlib inline\n    y = 1", "for i in [1]:\n    !ls {i}\n",
    "def f():\n    return 1\n\nf?", "x = 1; y = 2\n%who", "x = a % b\n!ls", "x = [\n 1,\n # why?\n 2]\n%who",
    "  # c\nif 1:\n  %who\n  y = 1", "%load_ext autoreload\n%autoreload 2", "%%writefile helper.py\nimport x\n!a\n",
    "%%bash\nls", "\n\n%%html\n<b>", ">>> x = 1\n>>> y = 2", "In [1]: x = 1\nIn [2]: y = 2", "    x = 1\n    y = 2",
    "await f()",
]  # fmt: skip
PYTHON = [
    "x = (5\n%3)", 's = """\n%matplotlib inline\n!ls\nwhat?\n"""', "x = 5 # what?", "# why?\nx = 1", "print('a?')",
    "x = 1 \\\n  % 2", "  # c\nif 1:\n  y = 1", "", "\n", "!=".join("ab"),
]  # fmt: skip


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
