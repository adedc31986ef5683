"""Find which module imports which, by parsing the files without importing them."""

import ast
from collections.abc import Iterable
from functools import cache
from pathlib import Path

from tests.support import ROOT


def get_module_name(path: Path) -> str:
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(("qdot", *parts) if parts[0] in ("exercises", "grader") else parts).removesuffix(".__init__")


def find_module_file(name: str) -> Path | None:
    stem = ROOT.joinpath(*name.removeprefix("qdot.").split("."))
    return next((path for path in (stem.with_suffix(".py"), stem / "__init__.py") if path.is_file()), None)


@cache
def list_imported_names(path: Path) -> set[str]:
    """Return every dotted name that a module imports: modules, and names imported from them."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            names.add(node.module)
            names.update(f"{node.module}.{alias.name}" for alias in node.names)
    return names


def list_reached_files(names: Iterable[str]) -> set[Path]:
    """Return the files of the checkout that these modules import, directly or indirectly, including their own."""
    names_to_visit, files = list(names), set[Path]()
    while names_to_visit:
        name = names_to_visit.pop()
        path = find_module_file(name)
        if path is not None and path not in files:
            files.add(path)
            names_to_visit += [*list_imported_names(path), name.rpartition(".")[0]]
    return files
