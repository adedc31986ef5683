"""Cells as IPython reads them: our rules give what its own library gives, and leave Python alone."""

import time

import pytest

from qdot.grader.sandbox.contained.ipython import NON_PYTHON_MAGICS, translate_to_python
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
def test_the_library_reads_a_cell_as_we_do_and_what_is_python_already_comes_back(cell: str) -> None:
    from IPython.core.inputtransformer2 import TransformerManager

    theirs = TransformerManager().transform_cell(cell)  # type: ignore[no-untyped-call]
    assert translate_to_python(cell).strip("\n") == theirs.strip("\n")
    assert translate_to_python(translate_to_python(cell)) == translate_to_python(cell)
    assert cell not in PYTHON or translate_to_python(cell) == cell


def test_code_of_the_project_comes_back_as_it_is() -> None:
    paths = sample_for_suite(
        sorted(path for name in ("exercises", "grader", "tests") for path in (ROOT / name).rglob("*.py")), 60
    )
    assert len(paths) > 50
    assert [path for path in paths if translate_to_python(text := path.read_text(encoding="utf-8")) != text] == []


@pytest.mark.parametrize(
    "cell", ["a = 1\n!pip install \\\n  x\nb = 2", "%time a = 1\n?b\nb = 2\n\n%who", "%%time\n%a\nb = 2"]
)
def test_every_statement_stays_on_its_line(cell: str) -> None:
    """The grader counts lines in what it was handed."""
    before, after = cell.split("\n"), translate_to_python(cell).split("\n")
    assert len(before) == len(after)
    assert before.index("b = 2") == after.index("b = 2")


def test_a_cell_below_a_magic_is_run_unless_it_is_no_python() -> None:
    assert translate_to_python("%%time\nx = 1\n%who") == "pass\nx = 1\nget_ipython().run_line_magic('who', '')"
    assert translate_to_python("%%time\n%%capture out\nx = 1") == "pass\npass\nx = 1"
    for name in NON_PYTHON_MAGICS:
        assert translate_to_python(f"%%{name}\nx = 1") == f"get_ipython().run_cell_magic({name!r}, '', 'x = 1\\n')"
    assert translate_to_python("%time x = 1\n  %time") == "x = 1\n  pass"


@pytest.mark.parametrize(
    "cell",
    ["(\n", "\n", "'''\n", "!", "=\t", "a?", " ", "%x\n", "if 1:\n", "x = \\\n", "*", "a" * 10 + "!?\n", "%%time\n"],
)
def test_a_hostile_cell_is_read_in_no_time(cell: str) -> None:
    """The grader reads cells of 30,000 characters by these rules, too."""
    begun, many = time.process_time(), cell * (30_000 // len(cell))
    for hostile in (many, f"!x\n{many}", f"sin?\n{cell * 10_000}?"):
        translate_to_python(hostile)
    assert time.process_time() - begun < 6
