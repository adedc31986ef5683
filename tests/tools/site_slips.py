"""Classical slips in right answers, for the site's own tests: slips.json in site/tests, which `site_corpus` writes.

A slip is made in the answer as the worked solution writes it, entry by entry, by what students do and not by the
catalogue of mistakes. In pairs, two are made at once, each in entries of its own.
"""

import json
import re
from collections.abc import Callable, Iterator
from functools import partial
from itertools import combinations
from typing import Any

import numpy as np

from qdot.exercises.arm.derivation_graph import compute_numeric_stages
from qdot.exercises.common.stream import Stream
from qdot.exercises.formula.algebra import split_terms
from qdot.exercises.formula.parser import parse_formula
from qdot.exercises.formula.trees import Node, as_matrix, find_names, node_text
from qdot.exercises.generation import generate
from qdot.exercises.mistakes.configurations import sample_configurations
from qdot.exercises.problem.problem import Part, Problem, ProblemId
from qdot.exercises.reference_answers import Number
from qdot.exercises.site.keys import make_key
from qdot.exercises.site.record import MistakeSentences, make_arm_record
from qdot.exercises.writing.problem_texts import write_answer_code
from tests.tools.readers import part_json

KEPT = ("planar-2r", "planar-3r-pose", "elbow-3r")
FEW = 12
"""So many slips in each answer, or some more, are kept for the site's own tests."""
ASKED = (
    "position", "velocity", "jacobian", "geometric-jacobian", "determinant", "inverse-jacobian", "inverse-velocity",
    "joint-rates", "singular-angles",
)  # fmt: skip
WAVES = {"sin": "cos", "cos": "sin"}
LINEAR = 3
"""Rows of a geometric Jacobian for the velocity of P, the first ones."""
Rows = list[list[Node]]
Change = Callable[[Node], Node]


# --- what is changed in a tree ---


def everywhere(node: Node, change: Change) -> Node:
    """Return a tree in which every node has been changed, the inner ones first."""
    return change(Node(node.kind, tuple(everywhere(arg, change) for arg in node.args), node.value))


def in_one_place(node: Node, change: Change) -> Iterator[Node]:
    """Yield a tree in which one node is changed, for each one that changes."""
    new = change(node)
    if new != node:
        yield new
    for k, arg in enumerate(node.args):
        for one in in_one_place(arg, change):
            yield Node(node.kind, (*node.args[:k], one, *node.args[k + 1 :]), node.value)


def other_wave(node: Node) -> Node:
    """Return a sine for a cosine."""
    return Node("call", node.args, WAVES[node.value]) if node.kind == "call" and node.value in WAVES else node


def relative(node: Node) -> Node:
    """Return sin(theta2) for sin(theta1 + theta2), sin(theta2 + pi/6) for sin(theta1 + theta2 + pi/6)."""
    if node.kind == "call" and node.value in WAVES:
        terms = split_terms(node.args[0])
        turning = [k for k, term in enumerate(terms) if find_names(term)]
        if len(turning) > 1:
            kept = terms[turning[-1]]
            for constant in (term for term in terms if not find_names(term)):
                kept = kept + constant
            return Node("call", (kept,), node.value)
    return node


def without(node: Node, name: str) -> Node:
    """Return the other factor of a product in which a length is one."""
    if node.kind == "*":
        left, right = node.args
        if (left.kind, left.value) == ("name", name):
            return right
        if (right.kind, right.value) == ("name", name):
            return left
    return node


def other_sign(node: Node) -> Node:
    """Return a difference for a sum."""
    return Node({"+": "-", "-": "+"}[node.kind], node.args) if node.kind in ("+", "-") and node.args[1:] else node


def first_term(node: Node) -> Node:
    """Return what a sum begins with."""
    return node.args[0] if node.kind in ("+", "-") and not _is_angle(node) else node


def last_term(node: Node) -> Node:
    """Return what a sum ends with."""
    if node.kind not in ("+", "-") or _is_angle(node):
        return node
    return node.args[1] if node.kind == "+" else Node("neg", (node.args[1],))


def _is_angle(node: Node) -> bool:
    return all(name.startswith("theta") for name in find_names(node)) and not _has_wave(node)


def _has_wave(node: Node) -> bool:
    return node.kind == "call" or any(map(_has_wave, node.args))


def negated(node: Node) -> Node:
    return Node("neg", (node,))


def factors_lost(node: Node) -> Iterator[Node]:
    """Yield a product without one of its factors."""
    if node.kind == "neg":
        yield from map(negated, factors_lost(node.args[0]))
    elif node.kind == "*":
        left, right = node.args
        yield left
        yield right
        for one in factors_lost(left):
            yield Node("*", (one, right))


# --- slips in formulas ---


def in_formulas(part: Part, rows: Rows, kinds: str, lengths: list[str]) -> Iterator[tuple[str, Rows]]:
    """Yield slips by name in the entries of an answer."""
    changes: list[tuple[str, Change]] = [("relative angle", relative), ("sine for cosine", other_wave)]
    changes += [(f"length {name} missing", partial(without, name=name)) for name in lengths]
    for name, change in changes:
        yield f"{name}, throughout", [[everywhere(entry, change) for entry in row] for row in rows]
    if len(rows[0]) > 1:
        yield from _in_columns(rows, changes, lengths)
    changes += [
        ("sign of a term", partial(_unless_angle, change=other_sign)),
        ("term dropped", first_term),
        ("term dropped", last_term),
    ]
    yield from _in_entries(rows, changes)
    if len(rows) * len(rows[0]) > 1:
        yield "everything with the other sign", [[negated(entry) for entry in row] for row in rows]
    if part.kind == "geometric-jacobian":
        yield (
            "z x p in the wrong order",
            [
                [negated(e) if r < LINEAR and kinds[c] == "R" else e for c, e in enumerate(row)]
                for r, row in enumerate(rows)
            ],
        )
    if part.kind == "determinant":
        yield from (("factor missing", [[new]]) for new in factors_lost(rows[0][0]))


def _in_columns(rows: Rows, changes: list[tuple[str, Change]], lengths: list[str]) -> Iterator[tuple[str, Rows]]:
    for c in range(len(rows[0])):
        for name, change in changes:
            yield f"{name}, column", _with_column(rows, c, partial(everywhere, change=change))
        yield "sign of a column", _with_column(rows, c, negated)
        yield "column dropped", _with_column(rows, c, lambda _: Node("number", value=0))
        for length in lengths:
            lost = partial(everywhere, change=partial(_no_link, name=length))
            yield "contribution dropped", _with_column(rows, c, lost)
    if len(rows) > 1:
        yield "transposed", [list(column) for column in zip(*rows, strict=True)]


def _in_entries(rows: Rows, changes: list[tuple[str, Change]]) -> Iterator[tuple[str, Rows]]:
    for r, row in enumerate(rows):
        for c, entry in enumerate(row):
            for name, change in changes:
                for new in in_one_place(entry, change):
                    yield f"{name}, one place", _with(rows, r, c, new)
            if (entry.kind, entry.value) != ("number", 0):
                yield "sign of an entry", _with(rows, r, c, negated(entry))


def _unless_angle(node: Node, change: Change) -> Node:
    return node if _is_angle(node) else change(node)


def _no_link(node: Node, name: str) -> Node:
    """Return a sum without its terms that hold a length."""
    if node.kind in ("+", "-") and len(node.args) == 2:
        left, right = node.args
        if name in find_names(right):
            return left
        if name in find_names(left):
            return right if node.kind == "+" else negated(right)
    return node


def _with(rows: Rows, r: int, c: int, new: Node) -> Rows:
    return [[new if (i, j) == (r, c) else entry for j, entry in enumerate(row)] for i, row in enumerate(rows)]


def _with_column(rows: Rows, c: int, change: Change) -> Rows:
    return [[change(entry) if j == c else entry for j, entry in enumerate(row)] for row in rows]


# --- slips in numbers and in sets ---


def in_rates(problem: Problem, part: Part) -> Iterator[tuple[str, list[float]]]:
    """Yield slips in joint rates."""
    assert isinstance(part.answer, Number)
    right = np.array([float(value) for value in part.answer.reference])
    turning = np.array([joint.is_revolute for joint in problem.chain.joints])
    yield "rates in degrees per second", [*np.where(turning, np.degrees(right), right)]
    yield "everything with the other sign", [*-right]
    for k in range(len(right)):
        yield "sign of a rate", [*np.where(np.arange(len(right)) == k, -right, right)]
    yield "rates in reverse order", [*right[::-1]]
    values = sample_configurations(problem.chain, part, problem.domain, 1, Stream("slips"))
    J = compute_numeric_stages(problem.chain, values)["jacobian"][..., 0].real
    wanted = J @ right
    yield "transposed J for its inverse", [*(J.T @ wanted)]
    if J.shape[0] == J.shape[1]:
        yield "not divided by det J", [*(np.linalg.det(J) * right)]
    angles = {name: np.radians(v) if name.startswith("theta") else v for name, v in values.items()}
    degrees = {name: np.degrees(v) if name.startswith("theta") else v for name, v in values.items()}
    for name, given in (("degrees put in for radians", degrees), ("radians taken for degrees", angles)):
        other = compute_numeric_stages(problem.chain, given)["jacobian"][..., 0].real
        if other.shape[0] == other.shape[1] and abs(np.linalg.det(other)) > 1e-6:
            yield name, [*np.linalg.solve(other, wanted)]


def in_sets(text: str, joints: list[str]) -> Iterator[tuple[str, str]]:
    """Yield slips in conditions."""
    conditions = [re.sub(r"^Eq\((.*), (.*)\)$", r"\1 = \2", each) for each in _conditions(text)]
    for k, condition in enumerate(conditions):
        rest = [*conditions[:k], *conditions[k + 1 :]]
        if rest:
            yield "condition left out", f"[{', '.join(rest)}]"
        if condition.endswith("= pi"):
            yield "degrees for radians", f"[{', '.join([*rest, condition.replace('pi', '180')])}]"
            yield "quarter turn", f"[{', '.join([*rest, condition.replace('pi', 'pi/2')])}]"
        for one in joints:
            for other in joints:
                if one != other and one in condition and len(joints) > 1:
                    new = condition.replace(one, other)
                    yield "another joint", f"[{', '.join([*rest, new])}]"
    straight = [each for each in conditions if re.fullmatch(r"theta\d = (0|pi)", each)]
    for joint in dict.fromkeys(each[:6] for each in straight):
        rest = [each for each in conditions if each[:6] != joint or each not in straight]
        yield "sine for cosine", f"[{', '.join([*rest, f'{joint} = pi/2', f'{joint} = -pi/2'])}]"


def _conditions(text: str) -> list[str]:
    """Return what is listed in brackets, as it is written there."""
    found, depth, start = [], 0, 1
    for place, letter in enumerate(text):
        depth += (letter in "[(") - (letter in ")]")
        if (depth == 1 and letter == ",") or (depth == 0 and letter == "]"):
            found.append(" ".join(text[start:place].split()))
            start = place + 1
    return [each for each in found if each]


# --- all of it ---


def slips(problem: Problem, part: Part, in_pairs: bool = False) -> list[tuple[str, str]]:
    """Return slips by name, each with the answer as it is typed; those that are typed alike once."""
    text = write_answer_code(problem, part)
    found: dict[str, str] = {}
    if in_pairs:
        return _pairs(problem, part, text) if part.type not in ("singular", "number") else []
    if part.type == "singular":
        for name, typed in in_sets(text.replace("Matrix", ""), [q.name for q in problem.chain.q]):
            found.setdefault(typed, name)
    elif part.type == "number":
        for name, values in in_rates(problem, part):
            found.setdefault(str([float(f"{value:.5g}") for value in values]), name)
    else:
        rows, every = _in_formulas(problem, part, text)
        right = _typed(rows)
        for name, new in every:
            if (typed := _typed(new)) != right:
                found.setdefault(typed, name)
    return [(name, typed) for typed, name in found.items()]


def _in_formulas(problem: Problem, part: Part, text: str) -> tuple[Rows, Iterator[tuple[str, Rows]]]:
    """Return the entries of an answer, and the slips in them."""
    rows = as_matrix(parse_formula(text, problem.domain.roles))
    kinds = "".join(joint.kind for joint in problem.chain.joints)
    lengths = sorted(str(symbol) for symbol in problem.chain.parameters)
    return rows, in_formulas(part, rows, kinds, lengths)


def _pairs(problem: Problem, part: Part, text: str) -> list[tuple[str, str]]:
    """Return two slips at once, of each two kinds the first in entries of their own, in columns of their own if any."""
    rows, every = _in_formulas(problem, part, text)
    by_kind: dict[str, list[tuple[frozenset[tuple[int, int]], Rows]]] = {}
    for name, new in every:
        if len(new) != len(rows):
            continue
        changed = frozenset((r, c) for r, row in enumerate(rows) for c, entry in enumerate(row) if new[r][c] != entry)
        if changed and changed != frozenset((r, c) for r, row in enumerate(rows) for c in range(len(row))):
            by_kind.setdefault(kind_of(name), []).append((changed, new))
    found = []
    for (one, some), (other, others) in combinations(by_kind.items(), 2):
        apart = [(a, x, y) for a, x in some for b, y in others if not a & b]
        by_columns = [(a, x, y) for a, x in some for b, y in others if not {c for _, c in a} & {c for _, c in b}]
        for mine, first, second in (by_columns or apart)[:1]:
            both = [[first[r][c] if (r, c) in mine else e for c, e in enumerate(row)] for r, row in enumerate(second)]
            found.append((f"{one} & {other}", _typed(both)))
    return found


def kind_of(slip: str) -> str:
    """Return a slip's kind: its name without a length's.

    >>> kind_of("length a2 missing, column")
    'length missing, column'
    """
    return re.sub(r" \w+ missing", " missing", slip)


def _typed(rows: Rows) -> str:
    if len(rows) == len(rows[0]) == 1:
        return node_text(rows[0][0])
    return f"[{', '.join('[' + ', '.join(map(node_text, row)) + ']' for row in rows)}]"


def asked(family: str, variation: str) -> Problem:
    """Return the problem of a family in which slips are made."""
    return generate(ProblemId(family, 1, (), variation=variation))


def problem_json(
    family: str, variation: str = "chapter", most: int | None = None, in_pairs: bool = False
) -> dict[str, Any]:
    """Return a problem as the bank has it, with what is typed: {"id", "robot", "parts", "said", "slips"}."""
    problem = asked(family, variation)
    said = MistakeSentences()
    parts, typed = [], []
    for part in problem.parts:
        if part.kind not in ASKED:
            continue
        key = said.shorten_key(make_key(problem, part))
        parts.append(part_json(problem, part) | {"key": key})
        every = slips(problem, part, in_pairs)
        step = max(1, len(every) // most) if most else 1
        typed += [[part.name, name, text] for name, text in every[::step]]
    return {
        "id": str(problem.id),
        "robot": make_arm_record(problem)["robot"],
        "parts": parts,
        "said": said.rows,
        "slips": typed,
    }


def slips_text() -> str:
    """Return the file's text: some slips of some families, and some in pairs, a problem a line."""
    pairs = (problem_json(name, most=FEW, in_pairs=True)["slips"] for name in KEPT)
    kept = (problem_json(name, most=FEW) | {"pairs": two} for name, two in zip(KEPT, pairs, strict=True))
    return "[\n" + ",\n".join(map(json.dumps, kept)) + "\n]\n"
