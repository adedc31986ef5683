"""Jupyter habits in the sandboxed process: display code does nothing, and the rest of the notebook counts."""

from collections.abc import Iterator

import pytest

from qdot.grader.sandbox.sandbox import Limits, Run, Sandbox

SETUP = "from sympy import Matrix, Symbol, sin\ntheta1 = Symbol('theta1')"


@pytest.fixture(scope="module")
def sandbox() -> Iterator[Sandbox]:
    with Sandbox(Limits(seconds=20, cell_seconds=4)) as sandbox:
        yield sandbox


def run(sandbox: Sandbox, *cells: str) -> Run:
    return sandbox.run(cells, ["a", "b", "c"], setup=SETUP)


@pytest.mark.parametrize(
    ("cells", "answers"),
    [
        (["files = !ls\na = files\n!rm -rf /", "sin?\n?cos\n%who\nb = 2"], {"a": "[]", "b": "2"}),
        (["1 + 1", "a = _", "5;", "6", "b = [_, __]", "c = [Out[1], _4]"], {"a": "2", "b": "[6, 2]", "c": "[2, 6]"}),
        (["for _ in range(3): pass", "7", "a = _"], {"a": "2"}),
        (["async def f(): return 7", "a = await f()\nb = 2", "await f()", "c = _"], {"a": "7", "b": "2", "c": "7"}),
        (["input('go on?')\na = 1"], {"a": "1"}),
        (["%%writefile helper.py\ndef f(x):\n    return x + 1", "from helper import f\na = f(1)"], {"a": "2"}),
        (["%%file h.py\nx = 1", "%%writefile -a h.py\ny = 2", "%run h\na = x + y"], {"a": "3"}),
        (["open('h.py', 'w').write('x = 4')", "import h\na = h.x"], {"a": "4"}),
        (["%%time\na = 1", "%time b = 2", "%%capture out\nc = 3"], {"a": "1", "b": "2", "c": "3"}),
        (["get_ipython().run_line_magic('matplotlib', 'inline')\na = 1"], {"a": "1"}),
        (
            ["get_ipython().run_cell_magic('time', '', 'a = 1\\n')", "get_ipython().magic('time b = 2')"],
            {"a": "1", "b": "2"},
        ),
        (["get_ipython().system('ls')\na = get_ipython().getoutput('ls')"], {"a": "[]"}),
        (["    a = 1\n    b = 2", ">>> c = 3"], {"a": "1", "b": "2", "c": "3"}),
        (["a = 'google.colab' in str(get_ipython())"], {"a": "False"}),
        (["try:\n    import nosuchlibrary\nexcept ImportError:\n    a = 1"], {"a": "1"}),
        (["import os\nos.mkdir('x'); os.chdir('x'); os.rmdir('../x')\na = 1", "b = 2"], {"a": "1", "b": "2"}),
        (
            ["from ipywidgets import interact\n@interact(t=1)\ndef f(t):\n    return 2*t\na = f(theta1)"],
            {"a": "2*theta1"},
        ),
    ],
)
def test_jupyter_syntax_and_helpers_work(sandbox: Sandbox, cells: list[str], answers: dict[str, str]) -> None:
    result = run(sandbox, *cells)
    assert (result.answers, result.cell_errors, result.failed_imports, result.end) == (answers, {}, {}, "done")


DISPLAY_CODE = {
    "IPython": "from IPython.display import display, Math, HTML\ndisplay(Math('x'), HTML('<b>'))",
    "all of IPython.display": "from IPython.display import *\ndisplay(Latex('x'))\nclear_output(wait=True)",
    "IPython itself": "import IPython\nIPython.get_ipython().events.x()\nIPython.version_info[:2] < (9, 1)",
    "a setting": "from IPython.core.interactiveshell import InteractiveShell as I\nI.ast_node_interactivity = 'all'",
    "SymPy's printing": "from sympy import init_printing\ninit_printing(use_latex='mathjax')\ninit_printing()",
    "widgets": "import ipywidgets as w\ns = w.FloatSlider(min=0, max=1)\ns.observe(print, 'value')\nw.HBox([s, s])",
    "a widget's class": "from ipywidgets import VBox\nclass W(VBox):\n    def f(self): self.x.y()\nW().f()",
    "plotly": "import plotly.graph_objects as go\nf = go.Figure()\nf.add_trace(go.Scatter(x=[1], y=[1]))\nf.show()",
    "seaborn": "import seaborn as sns\nsns.set_theme()",
    "Colab": "from google.colab import drive, files\ndrive.mount('/content/drive')\nfiles.upload()",
}


@pytest.mark.parametrize("library", DISPLAY_CODE)
def test_display_code_does_nothing(sandbox: Sandbox, library: str) -> None:
    result = run(sandbox, f"{DISPLAY_CODE[library]}\na = 1", "b = sin(theta1)")
    assert (result.answers, result.cell_errors, result.failed_imports) == ({"a": "1", "b": "sin(theta1)"}, {}, {})


PLOTS = [
    "fig, ax = plt.subplots()\nline, = ax.plot([0, 1], [0, 1])\nlow, high = ax.get_xlim()\nplt.show()",
    "fig, (ax1, ax2, ax3) = plt.subplots(1, 3)\nax3.grid(True)",
    "fig, axes = plt.subplots(2, 2)\naxes[0, 1].set_title('x')\nfor one in axes.flat: one.grid()",
    "with plt.style.context('classic'):\n    plt.plot([1, 2])\nplt.rcParams['figure.dpi'] = 100",
    "from matplotlib.animation import FuncAnimation\nFuncAnimation(plt.figure(), lambda i: i, frames=2)",
    "from mpl_toolkits.mplot3d import Axes3D\nax = plt.figure().add_subplot(projection='3d')",
    "import sympy\nsympy.plot(sin(theta1), show=False)",
    "from sympy.plotting import plot_parametric\nplot_parametric(sin(theta1), theta1, (theta1, 0, 1))",
]
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
    result = run(sandbox, *first_cells, *PLOTS, *last_cells)
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
