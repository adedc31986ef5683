"""What the two packages offer to programs and notebooks: there, documented, shown by examples, and loaded late."""

import inspect
import subprocess
import sys
from pathlib import Path

import pytest

from qdot import exercises, grader
from qdot.grader.docs import library_page
from tests.support import ROOT

OFFERED = [(package, name) for package in (exercises, grader) for name in package.__all__]


@pytest.mark.parametrize(("package", "name"), OFFERED, ids=lambda value: value if isinstance(value, str) else "")
def test_what_is_offered_is_there_and_says_what_it_is(package: object, name: str) -> None:
    what = getattr(package, name)
    assert name in dir(package)
    if inspect.isroutine(what):
        said = inspect.getdoc(what) or ""
        assert ">>> " in said, f"{name} has no example"
        assert what.__module__ not in ("exercises", "grader")


def test_what_is_not_offered_is_an_attribute_error() -> None:
    for package in (exercises, grader):
        with pytest.raises(AttributeError, match="has no attribute 'nothing_like_it'"):
            getattr(package, "nothing_like_it")  # noqa: B009


def test_a_package_loads_nothing_before_it_is_asked_for() -> None:
    """Who wants the version, or the file of a sandbox, waits for no algebra."""
    code = "import sys, exercises, grader; sys.exit('sympy' in sys.modules or 'numpy' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_no_name_is_that_of_a_module() -> None:
    """`from qdot.exercises import generate` would be the module, once somebody has imported it."""
    for package, name in OFFERED:
        folder = Path(str(inspect.getfile(package))).parent
        assert not (folder / f"{name}.py").exists() and not (folder / name / "__init__.py").exists(), name


def test_the_page_of_reference_is_up_to_date() -> None:
    page = (ROOT / "docs" / "library.md").read_text(encoding="utf-8")
    assert page == library_page(), "make docs"
    assert all(f"### `{name}`" in page for _, name in OFFERED)


def test_the_first_example_of_the_page_does_what_it_says() -> None:
    page = (ROOT / "docs" / "library.md").read_text(encoding="utf-8")
    code = page.split("```python\n")[1].split("```")[0]
    found: dict[str, object] = {}
    exec(compile(code, "docs/library.md", "exec"), found)
    assert repr(found["problem"]) == "Problem(elbow-3r/4: jacobian, determinant)"


def test_reprs_are_short() -> None:
    problem = exercises.generate("elbow-3r/4")
    part = problem["jacobian"]
    shown = [problem.chain, part, exercises.solve(problem.chain), exercises.certify(problem)]
    shown += [*grader.mark(problem, {"jacobian": "[[1, 2, 3]]*3"}), grader.judge(problem, part, "a1")]
    assert all(len(repr(one)) < 200 for one in shown), [repr(one) for one in shown if len(repr(one)) >= 200]
    assert repr(part) == "Part(jacobian: matrix 3 x 3, 2 points)"
