"""What qdot offers to programs and notebooks: there, documented, shown by examples, and loaded late."""

import inspect
import subprocess
import sys
from pathlib import Path

import pytest

import qdot
from tests.support import ROOT
from tests.tools.reference_pages import library_page


@pytest.mark.parametrize("name", qdot.__all__)
def test_what_is_offered_is_there_and_says_what_it_is(name: str) -> None:
    what = getattr(qdot, name)
    assert name in dir(qdot)
    if inspect.isroutine(what):
        said = inspect.getdoc(what) or ""
        assert ">>> " in said, f"{name} has no example"


def test_what_is_not_offered_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="has no attribute 'nothing_like_it'"):
        getattr(qdot, "nothing_like_it")  # noqa: B009


def test_a_package_loads_nothing_before_it_is_asked_for() -> None:
    """Who wants the version, or the file of a sandbox, waits for no algebra."""
    code = "import sys, qdot; sys.exit('sympy' in sys.modules or 'numpy' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_no_name_is_that_of_a_module() -> None:
    """`from qdot import exercises` would be the module, once somebody has imported it."""
    folder = Path(qdot.__file__).parent
    assert not {path.stem for path in folder.iterdir()} & set(qdot.__all__)


def test_the_page_of_reference_is_up_to_date() -> None:
    page = (ROOT / "docs" / "library.md").read_text(encoding="utf-8")
    assert page == library_page(), "make docs"
    assert all(f"### `{name}`" in page for name in qdot.__all__)


def test_the_first_example_of_the_page_does_what_it_says() -> None:
    page = (ROOT / "docs" / "library.md").read_text(encoding="utf-8")
    code = page.split("```python\n")[1].split("```")[0]
    found: dict[str, object] = {}
    exec(compile(code, "docs/library.md", "exec"), found)
    assert repr(found["problem"]) == "Problem(elbow-3r/4: jacobian, determinant)"


def test_reprs_are_short() -> None:
    problem = qdot.generate("elbow-3r/4")
    part = problem["jacobian"]
    shown = [problem.chain, part, qdot.solve(problem.chain), qdot.certify(problem)]
    shown += [*qdot.mark(problem, {"jacobian": "[[1, 2, 3]]*3"}), qdot.judge(problem, part, "a1")]
    assert all(len(repr(one)) < 200 for one in shown), [repr(one) for one in shown if len(repr(one)) >= 200]
    assert repr(part) == "Part(jacobian: matrix 3 x 3, 2 points)"
