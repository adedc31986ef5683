"""`make mutants`: the modules that compare answers, changed at one place each, and whether anything notices.

A mutant is a module with one small change: another comparison, operator, number, bound, a statement left out. It is
put in place of the module in a process of its own, in which the corpus, some pairs of pairs.py and the unit tests of
the comparison run until one fails. Nobody would notice a mistake where a mutant survives; mutants.md says of each
survivor why it changes no verdict. `python -m tests.tools.mutants --module exact --lines 60-90` does a part.
"""

import argparse
import ast
import doctest
import importlib
import importlib.abc
import importlib.util
import json
import os
import resource
import signal
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import islice
from types import CodeType, ModuleType
from typing import Any

import pytest

from tests.support import ROOT

MODULES = {
    "exact": ("exact", "identity"), "identity": ("trial", "identity", "decimals", "formulas"),
    "field": ("exact", "identity"), "angles": ("exact", "identity", "formulas"),
    "conditions": ("sets", "space", "conditions", "reasons", "formulas", "decimals"),
    "pieces": ("space", "conditions", "formulas"),
    "formulas": ("formulas", "reasons", "decimals"), "program": ("program", "identity", "conditions", "formulas"),
    "constants": ("claims", "conditions", "formulas"), "claims": ("claims", "conditions", "formulas"),
}  # fmt: skip
"""Modules, and the tests that are run on the mutants of each."""
LEFT_OUT = ("as_often_as_their_degree", "stalls_the_comparison", "test_corpus", "h449")
"""Tests that take long, and what is run without pytest already."""
PAIRS, EVERY = 300, 5
TIMES, BYTES = 3, 4 << 30
"""What a mutant may take: so many times the processor time of the module itself, and so much memory."""
BY = ("survived", "corpus", "pairs", "doctests", "tests", "crash")


# --- mutants ---

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
REMOVED = (ast.Expr, ast.AugAssign, ast.Assign, ast.Raise, ast.If, ast.Return, ast.Continue, ast.Break)


@dataclass(frozen=True)
class Mutant:
    """A module with one change: where, what was there and is there now, the compiled whole."""

    number: int
    line: int
    change: str
    code: CodeType


Put = Callable[[Any], None]


def _places(node: ast.AST, inside: bool = False) -> Iterator[tuple[ast.AST, Put, bool]]:
    """Every node that does something, with what puts another in its place; whether it stands inside a function."""
    for field, value in ast.iter_fields(node):
        if field in ("annotation", "returns", "decorator_list", "type_params"):
            continue
        within = inside or isinstance(node, ast.FunctionDef)
        for k, child in enumerate(value if isinstance(value, list) else [value]):
            if isinstance(child, ast.AST):
                put = (lambda new, to=value, k=k: to.__setitem__(k, new)) if isinstance(value, list) else (
                    lambda new, field=field: setattr(node, field, new))  # fmt: skip
                yield child, put, within
                yield from _places(child, within)


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


def _result(node: ast.Return) -> Iterator[ast.AST]:
    if node.value and ast.unparse(node.value) != "None":
        yield ast.Return(ast.Constant(None))


OTHERS: dict[type[ast.AST], Callable[[Any], Iterator[ast.AST]]] = {
    ast.Compare: _comparison, ast.BoolOp: _combination, ast.Constant: _constant, ast.Name: _other_name,
    ast.Attribute: _other_name, ast.If: _condition, ast.IfExp: _condition, ast.Call: _call, ast.Slice: _slice,
    ast.BinOp: _sum, ast.AugAssign: _change, ast.Return: _result, ast.UnaryOp: lambda node: iter([node.operand]),
}  # fmt: skip
"""What may stand in the place of a node of a kind."""


def _others(node: ast.AST, inside: bool) -> Iterator[ast.AST]:
    """What may stand in the place of a node, nothing among it where it is a statement of a function."""
    if type(node) in OTHERS:
        yield from OTHERS[type(node)](node)
    is_text = isinstance(node, ast.Expr) and isinstance(node.value, (ast.Constant, ast.Yield))
    if inside and isinstance(node, REMOVED) and not is_text:
        yield ast.Pass()


def _shown(node: ast.AST) -> str:
    return ast.unparse(ast.fix_missing_locations(node)).split("\n")[0]


def changes(tree: ast.Module) -> Iterator[tuple[ast.AST, ast.AST, Put]]:
    """Every node that may be changed, another for its place, and what puts one there; the first has to be put back."""
    for node, put, inside in list(_places(tree)):
        for other in _others(node, inside):
            yield node, ast.copy_location(other, node) if getattr(node, "lineno", 0) else other, put


def mutants(source: str, name: str = "<mutant>") -> Iterator[Mutant]:
    """Every mutant of a module's text."""
    tree, number = ast.parse(source), 0
    for node, other, put in changes(tree):
        put(other)
        with suppress(SyntaxError, ValueError):  # a line without the loop around it, and the like
            change = f"{_shown(node)} -> {_shown(other)}"
            yield Mutant(number, getattr(node, "lineno", 0), change, _compiled(tree, name))
            number += 1
        put(node)


def _compiled(tree: ast.Module, name: str) -> CodeType:
    return compile(ast.fix_missing_locations(tree), name, "exec")


# --- what may notice one ---


class _Instead(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    """Gives a module another code."""

    def __init__(self, name: str, code: CodeType) -> None:
        self.name, self.code = name, code

    def find_spec(self, fullname: str, path: object, target: object = None) -> Any:
        return importlib.util.spec_from_loader(fullname, self) if fullname == self.name else None

    def exec_module(self, module: ModuleType) -> None:
        module.__file__ = self.code.co_filename
        exec(self.code, module.__dict__)


Prepared = tuple[list[dict[str, Any]], list[tuple[Any, ...]]]


def prepared() -> Prepared:
    """The corpus, and pairs as plain data; afterwards nothing of qdot is imported any more."""
    lines = (ROOT / "tests" / "data" / "corpus.jsonl").read_text(encoding="utf-8").splitlines()
    pairs = importlib.import_module("tests.tools.pairs").pairs
    made = [
        (pair.answer, pair.reference, dict(pair.domain.roles), pair.seed, pair.due)
        for pair in islice(pairs(PAIRS * EVERY), 0, None, EVERY)
    ]
    importlib.import_module("hypothesis")
    for name in [name for name in sys.modules if name.split(".")[0] in ("exercises", "grader", "tests")]:
        del sys.modules[name]
    return [case for case in map(json.loads, lines) if case["id"] not in LEFT_OUT], made


def noticed(module: str, known: Prepared) -> int:
    """Run everything on the modules as they are imported now; return what failed, as a place in BY."""
    from exercises.formula.identity import Domain
    from grader.compare import compare_line
    from grader.verdict import Outcome
    from tests.support.judging import judge_expression

    cases, made = known
    for case in cases:
        found = compare_line(json.dumps(case), 1)
        bound = (found["certificate"] or {}).get("bound")
        if (found["outcome"] == "correct") != case["correct"] or found["outcome"] == "ungraded":
            return 1
        if bound is not None and bound >= 1e-15:
            return 1
    for answer, reference, roles, seed, due in made:
        if (judge_expression(answer, reference, Domain(roles), seed).outcome is Outcome.CORRECT) != due:
            return 2
    if doctest.testmod(sys.modules[full_name(module)]).failed:
        return 3
    files = [str(next(ROOT.glob(f"tests/**/test_{name}.py"))) for name in MODULES[module]]
    skipped = " and ".join(f"not {name}" for name in LEFT_OUT)
    options = ["-x", "-q", "-p", "no:xdist", "-p", "no:cacheprovider", "--no-header", "-k", skipped]
    options += ["-W", "ignore::pytest.PytestAssertRewriteWarning"]  # hypothesis is imported already
    return 4 if pytest.main([*options, *files]) else 0


def full_name(module: str) -> str:
    """The dotted name of one of MODULES."""
    return f"grader.{module}" if module == "formulas" else f"exercises.formula.{module}"


def path_of(module: str) -> str:
    """The file of one of MODULES."""
    return full_name(module).replace(".", "/") + ".py"


def run(module: str, mutant: CodeType | None, known: Prepared, seconds: int) -> int:
    """Start a process for a mutant, which may take some seconds of processor time; return its id."""
    if child := os.fork():
        return child
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    os.dup2(1, 2)
    resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds + 1))
    resource.setrlimit(resource.RLIMIT_AS, (BYTES, BYTES))
    result = 5
    with suppress(BaseException):
        if mutant is not None:
            sys.meta_path.insert(0, _Instead(full_name(module), mutant))
        result = noticed(module, known)
    os._exit(result)


def verdict_of(status: int) -> str:
    """What ended a process."""
    if os.WIFSIGNALED(status):
        return "time" if os.WTERMSIG(status) in (signal.SIGXCPU, signal.SIGKILL) else "crash"
    return BY[min(os.WEXITSTATUS(status), len(BY) - 1)]


def tried(
    module: str, todo: Sequence[Mutant], known: Prepared, jobs: int, seconds: int
) -> Iterator[tuple[Mutant, str]]:
    """Every mutant with what noticed it, as they end."""
    waiting = list(todo)[::-1]
    running: dict[int, Mutant] = {}
    while waiting or running:
        while waiting and len(running) < jobs:
            mutant = waiting.pop()
            running[run(module, mutant.code, known, seconds)] = mutant
        ended, status = os.wait()
        yield running.pop(ended), verdict_of(status)


def main() -> int:
    """Try the mutants, and print those that nothing notices."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--module", action="append", choices=MODULES)
    parser.add_argument("--every", type=int, default=1, help="only one mutant in so many")
    parser.add_argument("--lines", default="1-9999", help="only these lines, as in 20-45")
    parser.add_argument("--jobs", type=int, default=1)
    options = parser.parse_args()
    low, high = map(int, options.lines.split("-"))
    os.environ["OPENBLAS_NUM_THREADS"] = "1"  # one thread may fork
    known = prepared()
    for module in options.module or MODULES:
        path = ROOT / path_of(module)
        found = [one for one in mutants(path.read_text(encoding="utf-8"), str(path)) if low <= one.line <= high]
        start = time.perf_counter()
        _, status, used = os.wait4(run(module, None, known, 600), 0)
        if status:
            sys.stderr.write(f"{module}: something fails without a mutation: {verdict_of(status)}\n")
            return 2
        counts: Counter[str] = Counter()
        seconds = int(TIMES * used.ru_utime) + 2
        for mutant, by in tried(module, found[:: options.every], known, options.jobs, seconds):
            counts[by] += 1
            if by == "survived":
                sys.stdout.write(f"{module}.py:{mutant.line}: {mutant.change}\n")
                sys.stdout.flush()
        told = ", ".join(f"{n} {by}" for by, n in counts.most_common())
        took = f"{time.perf_counter() - start:.0f} s"
        sys.stdout.write(f"{module}: {sum(counts.values())} of {len(found)} mutants in {took}: {told}\n")
        sys.stdout.flush()
    return 0


if __name__ == "__main__":
    sys.exit(main())
