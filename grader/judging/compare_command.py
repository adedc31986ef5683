"""Compare a student's text with a reference as the grader does, and return a judgement (`qdot compare`)."""

import contextlib
import hashlib
import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.json_form import to_jsonable
from qdot.exercises.common.time_limit import OutOfTime
from qdot.exercises.formula.equality import Domain, choose_default_role
from qdot.exercises.formula.parser import MAX_DEPTH, parse_formula, parse_reference
from qdot.exercises.formula.trees import Node, ParseError, as_matrix, find_names, iterate_nodes
from qdot.grader.judging.answer_parser import read_conditions, read_formula, read_matrix
from qdot.grader.judging.formulas import group_by_joints, judge_angles, judge_expression, judge_matrix, judge_singular
from qdot.grader.judging.verdict import Judgement, Outcome
from qdot.grader.sandbox.time_budgets import Budget

COMPARISON_TYPES = ("expression", "matrix", "angles", "singular")
"""The types of answers that can be compared: a formula, a matrix, a set of angles, a set of singular configurations."""


def compare(answer_type: str, student: str, reference: Any, joints: Sequence[str] = ()) -> Judgement:
    """Compare a student's text with a reference; `answer_type` is one of COMPARISON_TYPES.

    The reference is a text, a list of texts, or a list of rows of texts. A symbol's name determines its role: theta* is
    an angle; a*, d* and L* are lengths; any other name stands for any number. Raises QdotError if the reference can't
    be parsed or the type is unknown.
    """
    if answer_type not in COMPARISON_TYPES:
        raise QdotError(f"type {answer_type!r} is not one of {', '.join(COMPARISON_TYPES)}")
    texts = _flatten_reference(reference)
    try:
        trees = [parse_formula(text) for text in texts]
    except ParseError as error:
        raise QdotError(f"the reference can't be parsed: {error}") from None
    domain = _make_default_domain(trees, student, joints)
    # The texts are parsed again with the names of all symbols, including those of the student's text.
    trees = [parse_reference(text, frozenset(domain.roles)) for text in texts]
    seed = hashlib.sha256(repr((answer_type, student, reference)).encode("utf-8", "surrogatepass")).hexdigest()
    if answer_type == "expression":
        parsed = read_formula(student, domain)
        return parsed.refusal or judge_expression(parsed, trees[0], domain, seed)
    if answer_type == "matrix":
        rows = _parse_rows(reference, frozenset(domain.roles))
        parsed = read_matrix(student, (len(rows), len(rows[0])), domain)
        return parsed.refusal or judge_matrix(parsed, rows, domain, seed)
    parsed = read_conditions(student, domain)
    if answer_type == "angles":
        angles = Node("set", tuple(trees)) if len(trees) > 1 else trees[0]
        return parsed.refusal or judge_angles(parsed, angles, domain, seed)
    variables = joints or sorted(name for name in domain.roles if name.startswith("theta"))
    return parsed.refusal or judge_singular(parsed, group_by_joints(trees, variables), variables, domain, seed)


def _flatten_reference(reference: Any) -> list[str]:
    """Return all texts of a reference in one list. Raises QdotError if the reference has another form."""
    if isinstance(reference, str) and reference.strip():
        return [reference]
    if isinstance(reference, (int, float)) and not isinstance(reference, bool):
        return [repr(reference)]
    if isinstance(reference, list) and reference:
        return [text for item in reference for text in _flatten_reference(item)]
    raise QdotError(f"the reference must be a text, a list of texts or a list of rows, not {str(reference)[:60]!r}")


def _parse_rows(reference: Any, symbol_names: frozenset[str]) -> list[list[Node]]:
    """Return the reference for a matrix as rows of trees. Raises QdotError if the rows have different lengths."""
    if isinstance(reference, str):
        try:
            return as_matrix(parse_formula(reference, symbol_names))
        except ParseError as error:
            raise QdotError(f"the reference is not a matrix: {error}") from None
    listed_rows = reference if isinstance(reference, list) else [reference]
    rows = [row if isinstance(row, list) else [row] for row in listed_rows]
    if len({len(row) for row in rows}) != 1:
        raise QdotError("the rows of the reference have different lengths")
    return [[parse_reference(str(entry), symbol_names) for entry in row] for row in rows]


def _make_default_domain(reference_nodes: Sequence[Node], student: str, joints: Sequence[str]) -> Domain:
    """Return the default sampling range of each joint, and of each symbol in the reference and the student's text."""
    symbols = set().union(*(find_names(node) for node in reference_nodes), joints)
    with contextlib.suppress(ParseError):  # the judgement will report what can't be parsed
        symbols |= find_names(parse_formula(student, symbols))
    return Domain({name: choose_default_role(name) for name in sorted(symbols)})


def compare_line(line: str, line_number: int) -> dict[str, Any]:
    """Judge the request in one line of a batch, and return the response in the form of docs/schemas/compare.json.

    Raises QdotError if the line is not a valid request.
    """
    try:
        request = json.loads(line)
    except (ValueError, RecursionError) as error:
        raise QdotError(f"line {line_number} is not JSON: {error}") from None
    if not isinstance(request, dict):
        raise QdotError(
            f"line {line_number}: a request must be an object with reference and student (and type, id, joints)"
        )
    if missing_keys := [key for key in ("reference", "student") if key not in request]:
        names = " and ".join(missing_keys)
        raise QdotError(f"line {line_number}: {names} missing; a request must have reference and student")
    return {"id": request.get("id"), **describe_judgement(judge_request(request, line_number))}


def compare_lines(lines: Iterable[str], errors: list[str]) -> Iterator[str]:
    """Yield one line of JSON for each nonempty line of a batch. Errors in invalid requests are added to `errors`."""
    for line_number, line in enumerate(lines, 1):
        if not line.strip():
            continue
        try:
            response = json.dumps(compare_line(line, line_number), ensure_ascii=False)
        except (QdotError, RecursionError) as error:  # a deeply nested id of a request raises RecursionError
            reason = str(error) if isinstance(error, QdotError) else f"line {line_number}: its id is nested too deeply"
            errors.append(reason)
            content = describe_judgement(Judgement(Outcome.UNGRADED, 0.0, reason))
            response = json.dumps({"id": None, **content}, ensure_ascii=False)
        yield response


def judge_request(request: Mapping[str, Any], line_number: int) -> Judgement:
    """Return the judgement on the request in a line. Raises QdotError if the request is invalid.

    If qdot's own code fails or takes too long, the outcome is UNGRADED.
    """
    joints = request.get("joints") or ()
    if not isinstance(joints, (list, tuple)) or not all(isinstance(joint, str) for joint in joints):
        raise QdotError(f'line {line_number}: joints must be a list of names, such as ["theta1", "theta2"]')
    budget = Budget(30.0)
    try:
        with budget.spend(), np.errstate(all="ignore"):
            reference = request["reference"]
            answer_type = str(request.get("type") or guess_type(write_as_text(reference)))
            return compare(answer_type, write_as_text(request["student"]), reference, joints)
    except QdotError as error:
        raise QdotError(f"line {line_number}: {error}") from None
    except OutOfTime:
        reason = f"the comparison takes longer than {budget.seconds:g} s of processor time"
    except Exception as error:  # a failure of qdot is reported and is never a verdict
        reason = f"qdot failed: {type(error).__name__}: {error}"[:300]
    return Judgement(Outcome.UNGRADED, 0.0, reason)


def write_as_text(answer: Any, depth: int = 0) -> str:
    """Return an answer (a text, a number, or nested lists of texts and numbers) as one text; "" for null."""
    if answer is None:
        return ""
    # The contents of deeper lists are left out. The brackets are still too deep, so the parser refuses the text.
    if isinstance(answer, list):
        items = answer if depth <= MAX_DEPTH else []
        return "[" + ", ".join(write_as_text(item, depth + 1) for item in items) + "]"
    return answer if isinstance(answer, str) else repr(answer)


def guess_type(reference: str) -> str:
    """Guess the type of a reference: matrix for a list, angles for a set, singular for conditions, else expression.

    >>> [guess_type(text) for text in ("theta2 = 0, theta2 = pi", "[a1*c1, a1*s1]", "{0, pi}", "a1*s2")]
    ['singular', 'matrix', 'angles', 'expression']
    """
    types = {"list": "matrix", "set": "angles"}
    try:
        tree = parse_formula(reference)
    except ParseError:
        return "expression"
    is_condition = any(node.kind in ("eq", "in", "or", "and", "dict") for node in iterate_nodes(tree))
    return "singular" if is_condition else types.get(tree.kind, "expression")


def describe_judgement(judgement: Judgement) -> dict[str, Any]:
    """Return the outcome, reason and certificate as data for JSON."""
    certificate = to_jsonable(judgement.certificate)
    return {"outcome": judgement.outcome.value, "reason": judgement.reason, "certificate": certificate}
