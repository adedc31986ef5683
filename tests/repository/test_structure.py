"""The house's rules that a machine can check: folders say what is in them, guides name what is there."""

import ast
import re
import subprocess
from functools import cache
from pathlib import Path

import pytest

from tests.support import ROOT
from tests.support.imports import get_module_name, list_imported_names
from tests.support.programs import GIT, require_program

MODULES = sorted((*ROOT.glob("exercises/**/*.py"), *ROOT.glob("grader/**/*.py")))


@cache
def text_of(path: Path) -> str:
    return path.read_text(encoding="utf-8")


@cache
def tree_of(path: Path) -> ast.Module:
    return ast.parse(text_of(path))


PACKAGES = sorted(path for path in MODULES if path.name == "__init__.py")
REGISTRIES = ("__init__.py", "catalogue.py", "registry.py", "formats.py")
"""Modules of a package that list others by importing them: a new family or export format needs no second line."""


def mapped(package: Path) -> list[str]:
    """Return the modules and folders on the map in a package's docstring, in its order."""
    rows = re.findall(r"(?m)^    (\w+/?(?:, \w+/?)*)  +\S", ast.get_docstring(tree_of(package), clean=False) or "")
    return [name for row in rows for name in row.split(", ")]


@pytest.mark.parametrize("package", PACKAGES, ids=get_module_name)
def test_a_package_says_what_is_in_it(package: Path) -> None:
    """In the map of its docstring: without it, a newcomer has to open every file."""
    folder, on_map = package.parent, mapped(package)
    there = {path.stem for path in folder.glob("*.py") if not path.stem.startswith("__")}
    there |= {f"{path.parent.name}/" for path in folder.glob("*/__init__.py")}
    listed = {name for path in folder.glob("*.py") if path.name in REGISTRIES for name in list_imported_names(path)}
    assert sorted(set(on_map) - there) == [], "these are not there"
    missing = [name for name in there - set(on_map) if f"{get_module_name(package)}.{name}" not in listed]
    assert sorted(missing) == [], f"the docstring of {get_module_name(package)} doesn't say what these are"


def test_contributing_has_every_folder_on_its_map_and_is_short() -> None:
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    for package in PACKAGES:
        folder = package.parent.relative_to(ROOT)
        name = folder.as_posix()
        # A folder in such a folder is on the map of that one's docstring.
        assert len(folder.parts) > 2 or f"`{name}/`" in text, f"CONTRIBUTING.md doesn't say what {name}/ is"
    assert len(text.encode()) < 12_000, "it is to be read in five minutes: decisions go to docs/decisions/"


GUIDES = [ROOT / "CONTRIBUTING.md", ROOT / "tests" / "README.md", *sorted(ROOT.glob("docs/decisions/*.md"))]
GUIDES += sorted(ROOT.glob("docs/adding/*.md"))


@pytest.mark.parametrize("guide", GUIDES, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_what_a_guide_names_is_there(guide: Path) -> None:
    """Links, files by their path from the top, and targets of make."""
    text = guide.read_text(encoding="utf-8")
    links = [guide.parent / link for link in re.findall(r"\]\((?!http)([^)#]+)", text)]
    found = re.findall(r"`((?:exercises|grader|templates|tests|docs|site)/[\w./-]*\w)/?`", text)
    files = [ROOT / name for name in found if not re.search(r"NAME|CODE|^site/dist", name)]
    assert [path.relative_to(ROOT).as_posix() for path in (*links, *files) if not path.exists()] == []
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    targets = re.findall(r"`make ([a-z-]+)", text)
    assert [target for target in targets if f"\n{target}:" not in makefile] == []


def test_the_index_of_decisions_has_them_all() -> None:
    folder = ROOT / "docs" / "decisions"
    listed = re.findall(r"(?m)^- \[[^\]]+\]\(([\w-]+\.md)\)", (folder / "README.md").read_text(encoding="utf-8"))
    assert sorted(listed) == sorted(path.name for path in folder.glob("*.md") if path.name != "README.md")


def test_a_module_opens_with_what_it_is() -> None:
    assert [get_module_name(path) for path in MODULES if not ast.get_docstring(tree_of(path))] == []


def calls_of(path: Path) -> set[str]:
    """Return the names of all functions and methods that a module calls."""
    return {
        node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
        for node in ast.walk(tree_of(path))
        if isinstance(node, ast.Call)
    }


def test_students_text_is_never_executed_outside_the_contained_process() -> None:
    contained = [ROOT / "grader" / "sandbox" / "contained" / name for name in ("session.py", "runner.py")]
    others = [path for path in MODULES if path not in contained]
    executing = {"eval", "exec", "parse_expr", "lambdify"}
    assert {get_module_name(path): found for path in others if (found := calls_of(path) & executing)} == {}
    pickling = [path for path in others if "pickle" in list_imported_names(path)]
    assert [
        path for path in pickling if path != ROOT / "exercises" / "assignment" / "store.py"
    ] == []  # signed with the secret


def test_no_text_speaks_of_what_is_not_in_the_repository() -> None:
    """Of documents that somebody had beside it."""
    elsewhere = re.compile(r"shared recipe|\bcli\.md|\.\./shared")
    assert [get_module_name(path) for path in MODULES if elsewhere.search(text_of(path))] == []


def test_no_tracked_text_names_a_machine_or_a_registry() -> None:
    require_program("git", GIT)
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=False)
    if listed.returncode:
        return  # not a checkout
    pattern = re.compile(
        r"(?<![A-Za-z0-9_.~])/(?:work|farm|home|Users|root)/|index" + r"-url|registry" + r" *= *\"http"
    )
    found = {}
    for name in listed.stdout.splitlines():
        path = ROOT / name
        if path.is_file() and path.name != Path(__file__).name:
            found[name] = pattern.findall(path.read_text(encoding="utf-8", errors="replace"))
    assert {name: texts for name, texts in found.items() if texts} == {}
