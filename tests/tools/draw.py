"""Mistakes for `make planted`, drawn anew: `python -m tests.tools.draw --seed 21 > tests/tools/planted.json`.

Modules are chosen by the square root of their length, so that short ones are chosen, too. In each, one comparison,
operator, number, bound or statement is changed or left out, or one of `SCRIPTS` in a script of the site.
"""

import argparse
import ast
import json
import random
import re
import sys
from collections.abc import Callable, Iterator
from typing import Any

from tests.support import ROOT

COMPARISONS: dict[type[ast.cmpop], tuple[type[ast.cmpop], ...]] = {
    ast.Lt: (ast.LtE, ast.Gt), ast.LtE: (ast.Lt, ast.Gt), ast.Gt: (ast.GtE, ast.Lt), ast.GtE: (ast.Gt, ast.Lt),
    ast.Eq: (ast.NotEq,), ast.NotEq: (ast.Eq,), ast.Is: (ast.IsNot,), ast.IsNot: (ast.Is,),
    ast.In: (ast.NotIn,), ast.NotIn: (ast.In,),
}  # fmt: skip
OPERATORS: dict[type[ast.operator], type[ast.operator]] = {
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult, ast.FloorDiv: ast.Mult,
    ast.Mod: ast.FloorDiv, ast.Pow: ast.Mult, ast.BitAnd: ast.BitOr, ast.BitOr: ast.BitAnd, ast.LShift: ast.RShift,
}  # fmt: skip
OTHER_NAMES = {"min": "max", "max": "min", "any": "all", "all": "any", "minimum": "maximum", "maximum": "minimum"}

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


def _comparison(node: ast.Compare) -> Iterator[ast.AST]:
    for k, op in enumerate(node.ops):
        for other in COMPARISONS[type(op)]:
            yield ast.Compare(node.left, [*node.ops[:k], other(), *node.ops[k + 1 :]], node.comparators)


def _combination(node: ast.BoolOp) -> Iterator[ast.AST]:
    yield ast.BoolOp(ast.Or() if isinstance(node.op, ast.And) else ast.And(), node.values)
    for k in range(len(node.values)):
        left = node.values[:k] + node.values[k + 1 :]
        yield ast.BoolOp(node.op, left) if len(left) > 1 else left[0]


def _constant(node: ast.Constant) -> Iterator[ast.AST]:
    value = node.value
    if isinstance(value, bool):
        yield ast.Constant(not value)
    elif isinstance(value, (int, float)):
        whole = isinstance(value, int) or value in range(100)
        larger, smaller = (value + 1, value - 1) if whole else (2 * value, value / 2)
        yield from (ast.Constant(larger), ast.Constant(smaller))


def _other_name(node: ast.Name | ast.Attribute) -> Iterator[ast.AST]:
    if isinstance(node, ast.Name) and node.id in OTHER_NAMES:
        yield ast.Name(OTHER_NAMES[node.id], node.ctx)
    elif isinstance(node, ast.Attribute) and node.attr in OTHER_NAMES:
        yield ast.Attribute(node.value, OTHER_NAMES[node.attr], node.ctx)


def _condition(node: ast.If | ast.IfExp) -> Iterator[ast.AST]:
    if not isinstance(node.test, (ast.Compare, ast.BoolOp, ast.UnaryOp)):
        yield type(node)(ast.UnaryOp(ast.Not(), node.test), node.body, node.orelse)  # type: ignore[arg-type]


def _call(node: ast.Call) -> Iterator[ast.AST]:
    if ast.unparse(node.func) in ("abs", "np.abs"):
        yield node.args[0]


def _slice(node: ast.Slice) -> Iterator[ast.AST]:
    if node.lower:
        yield ast.Slice(None, node.upper, node.step)
    if node.upper:
        yield ast.Slice(node.lower, None, node.step)


def _sum(node: ast.BinOp) -> Iterator[ast.AST]:
    if type(node.op) in OPERATORS:
        yield ast.BinOp(node.left, OPERATORS[type(node.op)](), node.right)


def _change(node: ast.AugAssign) -> Iterator[ast.AST]:
    if type(node.op) in OPERATORS:
        yield ast.AugAssign(node.target, OPERATORS[type(node.op)](), node.value)


ALTERNATIVES: dict[type[ast.AST], Callable[[Any], Iterator[ast.AST]]] = {
    ast.Compare: _comparison, ast.BoolOp: _combination, ast.Constant: _constant, ast.Name: _other_name,
    ast.Attribute: _other_name, ast.If: _condition, ast.IfExp: _condition, ast.Call: _call, ast.Slice: _slice,
    ast.BinOp: _sum, ast.AugAssign: _change, ast.UnaryOp: lambda node: iter([node.operand]),
}  # fmt: skip
"""What may stand in the place of a node of each kind."""
REMOVED = (ast.Expr, ast.AugAssign, ast.Raise, ast.If, ast.Continue, ast.Break)
"""Statements that may be left out."""


def alternatives(node: ast.AST) -> Iterator[ast.AST]:
    """Yield what may stand in the place of a node: another of its kind, or `pass` for a statement."""
    if type(node) in ALTERNATIVES:
        yield from ALTERNATIVES[type(node)](node)
    is_text = isinstance(node, ast.Expr) and isinstance(node.value, (ast.Constant, ast.Yield))
    if isinstance(node, REMOVED) and not is_text:
        yield ast.Pass()


def in_python(text: str) -> list[Drawn]:
    """Return every change of a module, inside its functions, that can be written into its text."""
    tree = ast.parse(text)
    inside = {id(node): node for function in ast.walk(tree) if isinstance(function, ast.FunctionDef)
              for statement in function.body for node in ast.walk(statement)}  # fmt: skip
    for part in ast.walk(tree):
        text_parts = ast.walk(part) if isinstance(part, ast.JoinedStr) else []
        types = ast.walk(part.annotation) if isinstance(part, (ast.AnnAssign, ast.arg)) and part.annotation else []
        for node in (*text_parts, *types):
            inside.pop(id(node), None)
    return [
        drawn
        for node in inside.values()
        for other in alternatives(node)
        for drawn in _written(text, node, ast.copy_location(other, node))
    ]


def _written(text: str, node: ast.AST, other: ast.AST) -> Iterator[Drawn]:
    """Yield the lines of a node with another in its place; they may not compile."""
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
    yield {
        "line": node.lineno,
        "old": "\n".join(rows[first:last]),
        "new": head + new + tail,
        "what": new.split("\n")[0],
    }


def compiles(text: str, change: Drawn) -> bool:
    """Return whether a module of Python still compiles with a change."""
    rows, first = text.split("\n"), int(str(change["line"])) - 1
    changed = [*rows[:first], *str(change["new"]).split("\n"), *rows[first + str(change["old"]).count("\n") + 1 :]]
    try:
        compile("\n".join(changed), "changed", "exec")
    except SyntaxError:
        return False
    return True


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
            shuffled = rng.sample(found, len(found))
            valid = (change for change in shuffled if path.suffix != ".py" or compiles(texts[path], change))
            yield {"path": path.relative_to(ROOT).as_posix(), **next(valid)}
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
