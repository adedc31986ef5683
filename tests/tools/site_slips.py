"""Put classical mistakes into right answers for site/tests/slips.json, which `site_corpus` writes.

A slip changes some entries of the solution's answer, as students do; it does not use the catalogue of mistakes. A pair
combines two slips in different entries.
"""

import json
import re
from collections.abc import Callable, Iterator
from functools import partial
from itertools import combinations
from typing import Any

import numpy as np

from qdot.exercises.common.stream import Stream
from qdot.exercises.derivation.graph import compute_numeric_stages
from qdot.exercises.formula.algebra import split_terms
from qdot.exercises.formula.parser import parse_formula
from qdot.exercises.formula.trees import Node, as_matrix, find_names, format_tree
from qdot.exercises.generation import generate
from qdot.exercises.mistakes.configurations import sample_configurations
from qdot.exercises.problem.problem import Part, Problem, ProblemId
from qdot.exercises.reference_answers import Number
from qdot.exercises.site.keys import make_key
from qdot.exercises.site.record import MistakeSentences, make_arm_record
from qdot.exercises.writing.problem_texts import write_answer_code
from tests.tools.readers import part_json

STORED_FAMILIES = ("planar-2r", "planar-3r-pose", "elbow-3r")
FEW = 12
"""The approximate number of slips of each answer that are stored for the site's own tests."""
QUESTION_NAMES = (
    "position", "velocity", "jacobian", "geometric-jacobian", "determinant", "inverse-jacobian", "inverse-velocity",
    "joint-rates", "singular-angles",
)  # fmt: skip
WAVES = {"sin": "cos", "cos": "sin"}
LINEAR = 3
"""The number of rows of a geometric Jacobian for the velocity of P, which come first."""
Rows = list[list[Node]]
Change = Callable[[Node], Node]


# --- what is changed in a tree ---


def change_everywhere(node: Node, change: Change) -> Node:
    """Return a tree with every node changed, inner nodes first."""
    return change(Node(node.kind, tuple(change_everywhere(arg, change) for arg in node.args), node.value))


def change_one_place(node: Node, change: Change) -> Iterator[Node]:
    """Yield a tree with one changed node, for each node that the change affects."""
    new = change(node)
    if new != node:
        yield new
    for k, arg in enumerate(node.args):
        for changed_arg in change_one_place(arg, change):
            yield Node(node.kind, (*node.args[:k], changed_arg, *node.args[k + 1 :]), node.value)


def swap_wave(node: Node) -> Node:
    """Replace a sine by a cosine, or the reverse."""
    return Node("call", node.args, WAVES[node.value]) if node.kind == "call" and node.value in WAVES else node


def make_relative(node: Node) -> Node:
    """Return sin(theta2) for sin(theta1 + theta2), sin(theta2 + pi/6) for sin(theta1 + theta2 + pi/6)."""
    if node.kind == "call" and node.value in WAVES:
        terms = split_terms(node.args[0])
        joint_terms = [k for k, term in enumerate(terms) if find_names(term)]
        if len(joint_terms) > 1:
            angle = terms[joint_terms[-1]]
            for constant in (term for term in terms if not find_names(term)):
                angle = angle + constant
            return Node("call", (angle,), node.value)
    return node


def drop_factor(node: Node, name: str) -> Node:
    """If one factor of a product is the named length, return the other factor."""
    if node.kind == "*":
        left, right = node.args
        if (left.kind, left.value) == ("name", name):
            return right
        if (right.kind, right.value) == ("name", name):
            return left
    return node


def change_sign(node: Node) -> Node:
    """Replace a sum by a difference, or the reverse."""
    return Node({"+": "-", "-": "+"}[node.kind], node.args) if node.kind in ("+", "-") and node.args[1:] else node


def keep_first_term(node: Node) -> Node:
    """Return the first term of a sum."""
    return node.args[0] if node.kind in ("+", "-") and not _is_angle(node) else node


def keep_last_term(node: Node) -> Node:
    """Return the last term of a sum."""
    if node.kind not in ("+", "-") or _is_angle(node):
        return node
    return node.args[1] if node.kind == "+" else Node("neg", (node.args[1],))


def _is_angle(node: Node) -> bool:
    return all(name.startswith("theta") for name in find_names(node)) and not _has_wave(node)


def _has_wave(node: Node) -> bool:
    return node.kind == "call" or any(map(_has_wave, node.args))


def negate(node: Node) -> Node:
    return Node("neg", (node,))


def drop_each_factor(node: Node) -> Iterator[Node]:
    """Yield a product without one of its factors."""
    if node.kind == "neg":
        yield from map(negate, drop_each_factor(node.args[0]))
    elif node.kind == "*":
        left, right = node.args
        yield left
        yield right
        for remaining in drop_each_factor(left):
            yield Node("*", (remaining, right))


# --- slips in formulas ---


def list_formula_slips(part: Part, rows: Rows, kinds: str, lengths: list[str]) -> Iterator[tuple[str, Rows]]:
    """Yield slips by name in the entries of an answer."""
    changes: list[tuple[str, Change]] = [("relative angle", make_relative), ("sine for cosine", swap_wave)]
    changes += [(f"length {name} missing", partial(drop_factor, name=name)) for name in lengths]
    for name, change in changes:
        yield f"{name}, throughout", [[change_everywhere(entry, change) for entry in row] for row in rows]
    if len(rows[0]) > 1:
        yield from _in_columns(rows, changes, lengths)
    changes += [
        ("sign of a term", partial(_unless_angle, change=change_sign)),
        ("term dropped", keep_first_term),
        ("term dropped", keep_last_term),
    ]
    yield from _in_entries(rows, changes)
    if len(rows) * len(rows[0]) > 1:
        yield "everything with the other sign", [[negate(entry) for entry in row] for row in rows]
    if part.kind == "geometric-jacobian":
        yield (
            "z x p in the wrong order",
            [
                [negate(e) if r < LINEAR and kinds[c] == "R" else e for c, e in enumerate(row)]
                for r, row in enumerate(rows)
            ],
        )
    if part.kind == "determinant":
        yield from (("factor missing", [[new]]) for new in drop_each_factor(rows[0][0]))


def _in_columns(rows: Rows, changes: list[tuple[str, Change]], lengths: list[str]) -> Iterator[tuple[str, Rows]]:
    for c in range(len(rows[0])):
        for name, change in changes:
            yield f"{name}, column", _change_column(rows, c, partial(change_everywhere, change=change))
        yield "sign of a column", _change_column(rows, c, negate)
        yield "column dropped", _change_column(rows, c, lambda _: Node("number", value=0))
        for length in lengths:
            lost = partial(change_everywhere, change=partial(_drop_terms, name=length))
            yield "contribution dropped", _change_column(rows, c, lost)
    if len(rows) > 1:
        yield "transposed", [list(column) for column in zip(*rows, strict=True)]


def _in_entries(rows: Rows, changes: list[tuple[str, Change]]) -> Iterator[tuple[str, Rows]]:
    for r, row in enumerate(rows):
        for c, entry in enumerate(row):
            for name, change in changes:
                for new in change_one_place(entry, change):
                    yield f"{name}, one place", _replace_entry(rows, r, c, new)
            if (entry.kind, entry.value) != ("number", 0):
                yield "sign of an entry", _replace_entry(rows, r, c, negate(entry))


def _unless_angle(node: Node, change: Change) -> Node:
    return node if _is_angle(node) else change(node)


def _drop_terms(node: Node, name: str) -> Node:
    """Return a sum without the terms that contain a length."""
    if node.kind in ("+", "-") and len(node.args) == 2:
        left, right = node.args
        if name in find_names(right):
            return left
        if name in find_names(left):
            return right if node.kind == "+" else negate(right)
    return node


def _replace_entry(rows: Rows, r: int, c: int, new: Node) -> Rows:
    return [[new if (i, j) == (r, c) else entry for j, entry in enumerate(row)] for i, row in enumerate(rows)]


def _change_column(rows: Rows, c: int, change: Change) -> Rows:
    return [[change(entry) if j == c else entry for j, entry in enumerate(row)] for row in rows]


# --- slips in numbers and in sets ---


def list_rate_slips(problem: Problem, part: Part) -> Iterator[tuple[str, list[float]]]:
    """Yield slips in joint rates."""
    assert isinstance(part.answer, Number)
    right = np.array([float(value) for value in part.answer.reference])
    is_revolute = np.array([joint.is_revolute for joint in problem.chain.joints])
    yield "rates in degrees per second", [*np.where(is_revolute, np.degrees(right), right)]
    yield "everything with the other sign", [*-right]
    for k in range(len(right)):
        yield "sign of a rate", [*np.where(np.arange(len(right)) == k, -right, right)]
    yield "rates in reverse order", [*right[::-1]]
    values = sample_configurations(problem.chain, part, problem.domain, 1, Stream("slips"))
    J = compute_numeric_stages(problem.chain, values)["jacobian"][..., 0].real
    task_velocity = J @ right
    yield "transposed J for its inverse", [*(J.T @ task_velocity)]
    if J.shape[0] == J.shape[1]:
        yield "not divided by det J", [*(np.linalg.det(J) * right)]
    angles = {name: np.radians(value) if name.startswith("theta") else value for name, value in values.items()}
    degrees = {name: np.degrees(value) if name.startswith("theta") else value for name, value in values.items()}
    for name, wrong_values in (("degrees put in for radians", degrees), ("radians taken for degrees", angles)):
        wrong_jacobian = compute_numeric_stages(problem.chain, wrong_values)["jacobian"][..., 0].real
        if wrong_jacobian.shape[0] == wrong_jacobian.shape[1] and abs(np.linalg.det(wrong_jacobian)) > 1e-6:
            yield name, [*np.linalg.solve(wrong_jacobian, task_velocity)]


def list_set_slips(text: str, joints: list[str]) -> Iterator[tuple[str, str]]:
    """Yield slips in conditions."""
    conditions = [
        re.sub(r"^Eq\((.*), (.*)\)$", r"\1 = \2", condition_text) for condition_text in _split_conditions(text)
    ]
    for k, condition in enumerate(conditions):
        rest = [*conditions[:k], *conditions[k + 1 :]]
        if rest:
            yield "condition left out", f"[{', '.join(rest)}]"
        if condition.endswith("= pi"):
            yield "degrees for radians", f"[{', '.join([*rest, condition.replace('pi', '180')])}]"
            yield "quarter turn", f"[{', '.join([*rest, condition.replace('pi', 'pi/2')])}]"
        for joint in joints:
            for other_joint in joints:
                if joint != other_joint and joint in condition and len(joints) > 1:
                    new = condition.replace(joint, other_joint)
                    yield "another joint", f"[{', '.join([*rest, new])}]"
    straight = [condition_text for condition_text in conditions if re.fullmatch(r"theta\d = (0|pi)", condition_text)]
    for joint in dict.fromkeys(condition_text[:6] for condition_text in straight):
        rest = [
            condition_text
            for condition_text in conditions
            if condition_text[:6] != joint or condition_text not in straight
        ]
        yield "sine for cosine", f"[{', '.join([*rest, f'{joint} = pi/2', f'{joint} = -pi/2'])}]"


def _split_conditions(text: str) -> list[str]:
    """Return the items of a bracketed list as texts."""
    conditions, depth, start = [], 0, 1
    for index, letter in enumerate(text):
        depth += (letter in "[(") - (letter in ")]")
        if (depth == 1 and letter == ",") or (depth == 0 and letter == "]"):
            conditions.append(" ".join(text[start:index].split()))
            start = index + 1
    return [condition for condition in conditions if condition]


# --- all slips ---


def slips(problem: Problem, part: Part, in_pairs: bool = False) -> list[tuple[str, str]]:
    """Return slips by name with the typed answer; equal answers occur once."""
    text = write_answer_code(problem, part)
    names_by_text: dict[str, str] = {}
    if in_pairs:
        return _combine_slips(problem, part, text) if part.type not in ("singular", "number") else []
    if part.type == "singular":
        for name, typed in list_set_slips(text.replace("Matrix", ""), [q.name for q in problem.chain.q]):
            names_by_text.setdefault(typed, name)
    elif part.type == "number":
        for name, values in list_rate_slips(problem, part):
            names_by_text.setdefault(str([float(f"{value:.5g}") for value in values]), name)
    else:
        rows, all_slips = _in_formulas(problem, part, text)
        right = _write_rows(rows)
        for name, new in all_slips:
            if (typed := _write_rows(new)) != right:
                names_by_text.setdefault(typed, name)
    return [(name, typed) for typed, name in names_by_text.items()]


def _in_formulas(problem: Problem, part: Part, text: str) -> tuple[Rows, Iterator[tuple[str, Rows]]]:
    """Return the entries of an answer, and the slips in them."""
    rows = as_matrix(parse_formula(text, problem.domain.roles))
    kinds = "".join(joint.kind for joint in problem.chain.joints)
    lengths = sorted(str(symbol) for symbol in problem.chain.parameters)
    return rows, list_formula_slips(part, rows, kinds, lengths)


def _combine_slips(problem: Problem, part: Part, text: str) -> list[tuple[str, str]]:
    """Return combinations of two kinds of slips in different entries, if possible in different columns."""
    rows, all_slips = _in_formulas(problem, part, text)
    by_kind: dict[str, list[tuple[frozenset[tuple[int, int]], Rows]]] = {}
    for name, new in all_slips:
        if len(new) != len(rows):
            continue
        changed = frozenset((r, c) for r, row in enumerate(rows) for c, entry in enumerate(row) if new[r][c] != entry)
        if changed and changed != frozenset((r, c) for r, row in enumerate(rows) for c in range(len(row))):
            by_kind.setdefault(find_kind(name), []).append((changed, new))
    pairs = []
    for (first_kind, first_slips), (second_kind, second_slips) in combinations(by_kind.items(), 2):
        disjoint = [(a, x, y) for a, x in first_slips for b, y in second_slips if not a & b]
        by_columns = [
            (a, x, y) for a, x in first_slips for b, y in second_slips if not {c for _, c in a} & {c for _, c in b}
        ]
        for first_entries, first, second in (by_columns or disjoint)[:1]:
            both = [
                [first[r][c] if (r, c) in first_entries else e for c, e in enumerate(row)]
                for r, row in enumerate(second)
            ]
            pairs.append((f"{first_kind} & {second_kind}", _write_rows(both)))
    return pairs


def find_kind(slip: str) -> str:
    """Return a slip's kind, which is its name without the name of a length.

    >>> find_kind("length a2 missing, column")
    'length missing, column'
    """
    return re.sub(r" \w+ missing", " missing", slip)


def _write_rows(rows: Rows) -> str:
    if len(rows) == len(rows[0]) == 1:
        return format_tree(rows[0][0])
    return f"[{', '.join('[' + ', '.join(map(format_tree, row)) + ']' for row in rows)}]"


def make_problem(family: str, variation: str) -> Problem:
    """Return the problem of a family in which slips are made."""
    return generate(ProblemId(family, 1, (), variation=variation))


def problem_json(
    family: str, variation: str = "chapter", max_count: int | None = None, in_pairs: bool = False
) -> dict[str, Any]:
    """Return a problem in the form of the bank, with typed answers: {"id", "robot", "parts", "said", "slips"}."""
    problem = make_problem(family, variation)
    sentences = MistakeSentences()
    parts, typed = [], []
    for part in problem.parts:
        if part.kind not in QUESTION_NAMES:
            continue
        key = sentences.shorten_key(make_key(problem, part))
        parts.append(part_json(problem, part) | {"key": key})
        all_slips = slips(problem, part, in_pairs)
        step = max(1, len(all_slips) // max_count) if max_count else 1
        typed += [[part.name, name, text] for name, text in all_slips[::step]]
    return {
        "id": str(problem.id),
        "robot": make_arm_record(problem)["robot"],
        "parts": parts,
        "said": sentences.rows,
        "slips": typed,
    }


def slips_text() -> str:
    """Return the file's text: some slips of some families, and some pairs, with one problem on each line."""
    pairs = (problem_json(name, max_count=FEW, in_pairs=True)["slips"] for name in STORED_FAMILIES)
    stored = (
        problem_json(name, max_count=FEW) | {"pairs": pair_slips}
        for name, pair_slips in zip(STORED_FAMILIES, pairs, strict=True)
    )
    return "[\n" + ",\n".join(map(json.dumps, stored)) + "\n]\n"
