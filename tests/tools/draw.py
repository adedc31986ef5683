"""Mistakes for `make planted`, drawn anew: `python -m tests.tools.draw --seed 21 > tests/tools/planted.json`.

Modules are drawn by the square root of their length, so that short ones have their turn; in each, one change of
tests.tools.mutants that a type checker would let pass, or one of `SCRIPTS` in a script of the site.
"""

import argparse
import ast
import json
import random
import re
import sys
from collections.abc import Callable, Iterator

from tests.support import ROOT
from tests.tools.mutants import changes

SHARES = {"exercises": 36, "grader": 14, "site/src": 10}
"""How many are drawn from each part of the house."""
SCRIPTS = (
    (r" === ", " !== "), (r" !== ", " === "), (r" < ", " <= "), (r" < ", " > "), (r" > ", " >= "), (r" > ", " < "),
    (r" <= ", " < "), (r" >= ", " > "), (r" \+ ", " - "), (r" - ", " + "), (r" \* ", " / "), (r" && ", " || "),
    (r" \|\| ", " && "), (r"\btrue\b", "false"), (r"\bfalse\b", "true"), (r"Math\.min", "Math.max"),
    (r"Math\.max", "Math.min"), (r"Math\.sin", "Math.cos"), (r"Math\.cos", "Math.sin"), (r"if \((?!!)", "if (!"),
)  # fmt: skip
"""What is put in the place of what in a line of a script."""

Drawn = dict[str, object]


def in_python(text: str) -> list[Drawn]:
    """Return every change of a module that can be written into its text."""
    tree = ast.parse(text)
    inside = {id(node) for function in ast.walk(tree) if isinstance(function, ast.FunctionDef)
              for statement in function.body for node in ast.walk(statement)}  # fmt: skip
    joined = {id(node) for part in ast.walk(tree) if isinstance(part, ast.JoinedStr) for node in ast.walk(part)}
    found: list[Drawn] = []
    for node, other, _ in changes(tree):
        if id(node) in inside - joined and not isinstance(node, (ast.Return, ast.Assign)):
            found += _written(text, node, other)
    return found


def _written(text: str, node: ast.AST, other: ast.AST) -> Iterator[Drawn]:
    """Yield the lines of a node with another in its place, where they can be compiled."""
    if isinstance(node, (ast.If, ast.IfExp)) and isinstance(other, (ast.If, ast.IfExp)):
        node, other = node.test, other.test
    if not isinstance(node, (ast.expr, ast.stmt)) or node.end_lineno is None:
        return
    new = ast.unparse(ast.fix_missing_locations(other))
    if isinstance(other, ast.expr) and not isinstance(other, (ast.Name, ast.Slice)):
        new = f"({new})"
    rows, first, last = text.split("\n"), node.lineno - 1, node.end_lineno
    head = rows[first].encode()[: node.col_offset].decode()
    tail = rows[last - 1].encode()[node.end_col_offset :].decode()
    try:
        compile("\n".join([*rows[:first], head + new + tail, *rows[last:]]), "drawn", "exec")
    except SyntaxError:
        return
    yield {
        "line": node.lineno,
        "old": "\n".join(rows[first:last]),
        "new": head + new + tail,
        "what": new.split("\n")[0],
    }


def in_script(text: str) -> list[Drawn]:
    """Return every change of a script, none in comments, types, imports and texts."""
    found = []
    for k, row in enumerate(text.split("\n"), 1):
        if row.strip().startswith(("//", "*", "/*", "import", "export type", "export interface", "type ")):
            continue
        code = row.split(" // ")[0]
        for pattern, new in SCRIPTS:
            for at in re.finditer(pattern, code):
                if not any(code[: at.start()].count(quote) % 2 for quote in "\"'`"):
                    changed = row[: at.start()] + new + row[at.end() :]
                    found.append(
                        {"line": k, "old": row, "new": changed, "what": f"{at.group().strip()} -> {new.strip()}"}
                    )
    return found


def spread(folder: str, count: int, rng: random.Random) -> Iterator[Drawn]:
    """Draw `count` changes from the modules of a folder."""
    made: Callable[[str], list[Drawn]] = in_script if folder.startswith("site") else in_python
    texts = {
        path: path.read_text("utf-8")
        for path in sorted((ROOT / folder).rglob("*"))
        if path.suffix in (".py", ".ts", ".tsx")
    }
    able = {path: found for path, text in texts.items() if (found := made(text))}
    weights = [len(texts[path].split("\n")) ** 0.5 for path in able]
    step = sum(weights) / count
    at, passed = rng.random() * step, 0.0
    for (path, found), weight in zip(able.items(), weights, strict=True):
        passed += weight
        while passed > at:
            yield {"path": path.relative_to(ROOT).as_posix(), **rng.choice(found)}
            at += step


def main() -> None:
    """Print a list."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seed", type=int, required=True)
    rng = random.Random(parser.parse_args().seed)
    drawn = [one for folder, count in SHARES.items() for one in spread(folder, count, rng)]
    listed = [{"number": k, **one} for k, one in enumerate(drawn)]
    sys.stdout.write(json.dumps(listed, indent=1, ensure_ascii=False) + "\n")


if __name__ == "__main__":
    main()
