"""The public names of qdot: they exist, are documented with examples, and are loaded late."""

import inspect
import subprocess
import sys
from pathlib import Path

import pytest

import qdot
from tests.support import ROOT
from tests.tools.reference_pages import library_page


@pytest.mark.parametrize("name", qdot.__all__)
def test_every_public_name_exists_and_has_an_example(name: str) -> None:
    item = getattr(qdot, name)
    assert name in dir(qdot)
    if inspect.isroutine(item):
        docstring = inspect.getdoc(item) or ""
        assert ">>> " in docstring, f"{name} has no example"


def test_an_unknown_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="has no attribute 'nothing_like_it'"):
        getattr(qdot, "nothing_like_it")  # noqa: B009


def test_importing_qdot_loads_no_algebra() -> None:
    """The version and the sandbox's files are available without waiting for SymPy."""
    code = "import sys, qdot; sys.exit('sympy' in sys.modules or 'numpy' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_no_public_name_is_a_module() -> None:
    """Otherwise `from qdot import NAME` would give the module once it is imported."""
    folder = Path(qdot.__file__).parent
    assert not {path.stem for path in folder.iterdir()} & set(qdot.__all__)


def test_the_reference_page_is_up_to_date() -> None:
    page = (ROOT / "docs" / "library.md").read_text(encoding="utf-8")
    assert page == library_page(), "make docs"
    assert all(f"### `{name}`" in page for name in qdot.__all__)


def test_the_first_example_of_the_reference_page_runs() -> None:
    page = (ROOT / "docs" / "library.md").read_text(encoding="utf-8")
    code = page.split("```python\n")[1].split("```")[0]
    namespace: dict[str, object] = {}
    exec(compile(code, "docs/library.md", "exec"), namespace)
    assert repr(namespace["problem"]) == "Problem(elbow-3r/4: jacobian, determinant)"


def test_reprs_are_short() -> None:
    problem = qdot.generate("elbow-3r/4")
    part = problem["jacobian"]
    items = [problem.chain, part, qdot.solve(problem.chain), qdot.certify(problem)]
    items += [*qdot.mark(problem, {"jacobian": "[[1, 2, 3]]*3"}), qdot.judge(problem, part, "a1")]
    assert all(len(repr(item)) < 200 for item in items), [repr(item) for item in items if len(repr(item)) >= 200]
    assert repr(part) == "Part(jacobian: matrix 3 x 3, 2 points)"
