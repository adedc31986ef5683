"""Find what a module imports, by parsing its file without importing it."""

import ast
from functools import cache
from pathlib import Path

from tests.support import ROOT


def get_module_name(path: Path) -> str:
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(("qdot", *parts) if parts[0] in ("exercises", "grader") else parts).removesuffix(".__init__")


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
