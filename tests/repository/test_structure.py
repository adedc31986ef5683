"""Structural rules: packages list their modules, guides name existing files, student text is never executed."""

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
def read_text(path: Path) -> str:
    return path.read_text(encoding="utf-8")


PACKAGES = sorted(path for path in MODULES if path.name == "__init__.py")
REGISTRIES = ("__init__.py", "catalogue.py", "registry.py", "formats.py")
"""Modules of a package that list others by importing them: a new family or export format needs no second line."""


def list_mapped(package: Path) -> list[str]:
    """Return the modules and folders listed in a package's docstring, in order."""
    docstring = ast.get_docstring(ast.parse(read_text(package)), clean=False) or ""
    rows = re.findall(r"(?m)^    (\w+/?(?:, \w+/?)*)  +\S", docstring)
    return [name for row in rows for name in row.split(", ")]


@pytest.mark.parametrize("package", PACKAGES, ids=get_module_name)
def test_a_package_docstring_lists_its_modules(package: Path) -> None:
    """Without the list, a newcomer has to open every file."""
    folder, mapped = package.parent, list_mapped(package)
    existing = {path.stem for path in folder.glob("*.py") if not path.stem.startswith("__")}
    existing |= {f"{path.parent.name}/" for path in folder.glob("*/__init__.py")}
    listed = {name for path in folder.glob("*.py") if path.name in REGISTRIES for name in list_imported_names(path)}
    assert sorted(set(mapped) - existing) == [], "these are not there"
    missing = [name for name in existing - set(mapped) if f"{get_module_name(package)}.{name}" not in listed]
    assert sorted(missing) == [], f"the docstring of {get_module_name(package)} doesn't say what these are"


def test_contributing_lists_every_folder_and_is_short() -> None:
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    for package in PACKAGES:
        folder = package.parent.relative_to(ROOT)
        name = folder.as_posix()
        # Deeper folders are listed in the docstring of their parent.
        assert len(folder.parts) > 2 or f"`{name}/`" in text, f"CONTRIBUTING.md doesn't say what {name}/ is"
    assert len(text.encode()) < 12_000, "it is to be read in five minutes: decisions go to docs/decisions/"


GUIDES = [ROOT / "CONTRIBUTING.md", ROOT / "tests" / "README.md", *sorted(ROOT.glob("docs/decisions/*.md"))]
GUIDES += [*sorted(ROOT.glob("docs/adding/*.md")), ROOT / "README.md", ROOT / "SECURITY.md"]
GUIDES += [ROOT / "docs" / name for name in ("privacy.md", "compatibility.md")]


@pytest.mark.parametrize("guide", GUIDES, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_a_guide_names_existing_files_and_targets(guide: Path) -> None:
    """Check links, paths from the top folder, and make targets."""
    text = guide.read_text(encoding="utf-8")
    links = [guide.parent / link for link in re.findall(r"\]\((?!http)([^)#]+)", text)]
    names = re.findall(r"`((?:exercises|grader|templates|tests|docs|site)/[\w./-]*\w)/?`", text)
    files = [ROOT / name for name in names if not re.search(r"NAME|CODE|^site/dist", name)]
    assert [path.relative_to(ROOT).as_posix() for path in (*links, *files) if not path.exists()] == []
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    targets = re.findall(r"(?m)(?:`|^    )make ([a-z-]+)", text)
    assert [target for target in targets if f"\n{target}:" not in makefile] == []


def test_the_index_lists_all_decisions() -> None:
    folder = ROOT / "docs" / "decisions"
    listed = re.findall(r"(?m)^- \[[^\]]+\]\(([\w-]+\.md)\)", (folder / "README.md").read_text(encoding="utf-8"))
    assert sorted(listed) == sorted(path.name for path in folder.glob("*.md") if path.name != "README.md")


def find_calls(path: Path) -> set[str]:
    return {
        node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
        for node in ast.walk(ast.parse(read_text(path)))
        if isinstance(node, ast.Call)
    }


def test_student_text_is_executed_only_in_the_sandboxed_process() -> None:
    sandboxed_modules = [ROOT / "grader/sandbox/notebook_process" / name for name in ("session.py", "runner.py")]
    executing = {"eval", "exec", "parse_expr", "lambdify"}
    named = re.compile(rf"\b({'|'.join(executing)}|pickle)\b")
    other_modules = [path for path in MODULES if path not in sandboxed_modules and named.search(read_text(path))]
    assert [get_module_name(path) for path in other_modules if find_calls(path) & executing] == []
    pickling = [path for path in other_modules if "pickle" in list_imported_names(path)]
    assert pickling == [ROOT / "exercises" / "assignment" / "store.py"]  # signed with the secret


def test_no_text_refers_to_documents_outside_the_repository() -> None:
    """Look for the names of documents that are not part of the repository."""
    elsewhere = re.compile(r"shared recipe|\bcli\.md|\.\./shared")
    assert [get_module_name(path) for path in MODULES if elsewhere.search(read_text(path))] == []


def test_no_tracked_text_names_a_machine_or_a_registry() -> None:
    require_program("git", GIT)
    pattern = r"(^|[^A-Za-z0-9_.~])/(work|farm|home|Users|root)/|index" + "-url|registry" + ' *= *"http'
    search = ["git", "grep", "-nIE", pattern, "--", ".", f":!tests/repository/{Path(__file__).name}"]
    searched = subprocess.run(search, cwd=ROOT, capture_output=True, text=True, check=False)
    assert searched.returncode in (1, 128), searched.stdout  # 1: nothing is found, 128: not a checkout
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=False).stdout
    links = [path for name in listed.splitlines() if (path := ROOT / name).is_symlink()]
    assert [path for path in links if path.readlink().is_absolute()] == []
