"""Which module imports which: read from the texts, as nothing need be imported to know it."""

import ast
from collections.abc import Iterable
from functools import cache
from pathlib import Path

from tests.support import ROOT


def name_of(path: Path) -> str:
    """Return the dotted name of a module of the checkout, a package's without `__init__`."""
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(("qdot", *parts) if parts[0] in ("exercises", "grader") else parts).removesuffix(".__init__")


def path_of(name: str) -> Path | None:
    """Return the file of a module by its dotted name; None where the checkout has none."""
    stem = ROOT.joinpath(*name.removeprefix("qdot.").split("."))
    return next((path for path in (stem.with_suffix(".py"), stem / "__init__.py") if path.is_file()), None)


@cache
def imports(path: Path) -> set[str]:
    """Return every name that a module may import: of modules, and of what is imported from them."""
    found: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            found.add(node.module)
            found.update(f"{node.module}.{alias.name}" for alias in node.names)
    return found


def reached(names: Iterable[str]) -> set[Path]:
    """Return the files of the checkout that these modules import, directly or not, their own among them."""
    waiting, found = list(names), set[Path]()
    while waiting:
        name = waiting.pop()
        path = path_of(name)
        if path is not None and path not in found:
            found.add(path)
            waiting += [*imports(path), name.rpartition(".")[0]]
    return found
