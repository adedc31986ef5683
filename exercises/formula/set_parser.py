"""Parse conditions on joints in any common notation, such as "theta3 = 0 or pi" and "{theta2: [0, pi]}".

The conditions describe a set of configurations, which is a union of pieces. A piece is a tuple of atoms that hold
simultaneously. An atom is either `expression = 0` or `joint = value`.
"""

import math
from collections.abc import Collection, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass
from fractions import Fraction
from itertools import product

import numpy as np

from qdot.exercises.formula.angles import find_linear_factors, find_multiple_of_pi
from qdot.exercises.formula.noise import remove_noise
from qdot.exercises.formula.program import compile_program, evaluate, evaluate_constant
from qdot.exercises.formula.trees import (
    ZERO,
    Node,
    ParseError,
    count_nodes,
    find_names,
    iterate_nodes,
    make_number,
    replace_names,
    split_signed_terms,
)
from qdot.exercises.formula.vocabulary import VOCABULARY

WHOLE_NUMBER_NAMES: tuple[str, ...] = tuple(VOCABULARY["whole_numbers"])
WHOLE_NUMBER_VALUES = tuple(make_number(k) if k >= 0 else -make_number(-k) for k in range(-6, 7))
"""The whole numbers from -6 to 6."""
_MAX_PIECES = 500
"""Maximum number of pieces of a set, so that a product of alternatives can't use up the memory."""
_MAX_NODES, _MAX_STEPS = 100_000, 6000
"""Maximum number of nodes after all whole numbers are inserted, and of steps of all pieces; each takes some seconds."""
_FIXED_COST = 10
"""A constant that is added to the number of nodes of each case, and to the number of steps of each piece."""
_TOO_LONG_MESSAGE = "the conditions are too long, or they contain too many integers"
_NO_JOINT_MESSAGE = "a value belongs to no joint; write theta1 = pi/3, for example"


@dataclass(frozen=True)
class Atom:
    """A condition: `expression` is zero or, if `joint` is given, `expression` is the value of this joint.

    Values of an angle that differ by 2 pi count as equal.
    """

    expression: Node
    joint: str | None = None


Piece = tuple[Atom, ...]
"""Atoms that hold simultaneously."""


def parse_pieces(node: Node, joints: Sequence[str]) -> list[Piece]:
    """Return the pieces of the set that a tree describes. Raises ParseError.

    The tree may consist of equations, `theta2 in {0, pi}`, `{theta2: [0, pi]}`, expressions that vanish, `and`, `or`,
    and lists of these. In `k*pi`, k stands for every whole number.
    """
    if node.kind in ("or", "list", "set"):
        return _parse_alternatives(node, joints)
    if node.kind == "and":
        if not any(find_names(arg) & set(joints) for arg in node.args):
            raise ParseError(_NO_JOINT_MESSAGE)
        return _refuse_two_values(_intersect([parse_pieces(arg, joints) for arg in node.args]))
    if node.kind == "dict":
        return _intersect([_parse_assignment(pair.args[0], pair.args[1], joints) for pair in node.args])
    if node.kind == "in":
        return _parse_assignment(node.args[0], node.args[1], joints)
    if node.kind == "eq":
        left_side, right_side = node.args
        if right_side.kind in ("list", "set"):
            return _parse_assignment(left_side, right_side, joints)
        for joint, value in ((left_side, right_side), (right_side, left_side)):
            if joint.kind == "name" and joint.value in joints and joint.value not in find_names(value):
                return _parse_assignment(joint, value, joints)
        return _parse_vanishing_expression(Node("-", (left_side, right_side)), joints)
    if node.kind == "name" and node.value in joints:
        raise ParseError(f"{node.value} has no value; write {node.value} = pi/3, for example")
    return _parse_vanishing_expression(node, joints)


def _refuse_two_values(pieces: list[Piece]) -> list[Piece]:
    """Return the pieces unchanged; raise ParseError if every piece gives a joint two values at once."""
    joints = [_find_joint_with_two_values(piece) for piece in pieces]
    if pieces and None not in joints:
        raise ParseError(f"{joints[0]} can't have two values at once; write {joints[0]} = 0 or {joints[0]} = pi/3")
    return pieces


def _find_joint_with_two_values(piece: Piece) -> str | None:
    """Return a joint to which a piece gives two different multiples of pi, or None."""
    values: dict[str, Fraction] = {}
    for atom in piece:
        multiple = find_multiple_of_pi(atom.expression) if atom.joint is not None else None
        if atom.joint is not None and multiple is not None and values.setdefault(atom.joint, multiple) != multiple:
            return atom.joint
    return None


def _parse_alternatives(node: Node, joints: Sequence[str]) -> list[Piece]:
    """Return the pieces of all entries of a list.

    A value without a joint belongs to the joint before it, as in theta3 = 0, pi, or (theta3, [0, pi]).
    """
    union: list[Piece] = []
    joint: Node | None = None
    for arg in node.args:
        is_condition = bool(find_names(arg) & set(joints)) or arg.kind in ("eq", "in", "and", "or", "dict")
        if is_condition:
            joint = _find_joint(arg, joints)
            # a label is a joint before its values, as in (theta3, [0, pi])
            is_label = joint is not None and arg.kind == "name" and len(node.args) == 2 and arg is node.args[0]
            if is_label and len(joints) == 2 and arg.value == joints[0] and node.args[1].kind not in ("list", "set"):
                meanings = f"it can be {joints[0]} and its value, or values of {joints[0]} and {joints[1]}"
                raise ParseError(f"a pair is ambiguous: {meanings}; write {joints[0]} = 0 or {joints[1]} = 0")
            # a label is no condition, but a joint without a value if another joint follows
            if not is_label or find_names(node.args[1]) & set(joints):
                union += parse_pieces(arg, joints)
        elif joint is not None:
            union += _parse_assignment(joint, arg, joints)
        else:
            raise ParseError(_NO_JOINT_MESSAGE)
    return union


def _find_joint(node: Node, joints: Sequence[str]) -> Node | None:
    """Return the joint to which a later value without a joint belongs; None if there is no such joint.

    It is the joint, or the sum of joints, that gets a value in an equation, or a joint that is named alone. Of several
    alternatives, the last one counts.
    """
    if node.kind == "or":
        return _find_joint(node.args[-1], joints)
    has_value = node.kind in ("eq", "in")
    joint = node.args[0] if has_value else node
    is_sum = has_value and find_names(joint) and find_names(joint) <= set(joints) and find_linear_factors(joint)
    return joint if is_sum or (joint.kind == "name" and joint.value in joints) else None


def _intersect(unions: Sequence[Sequence[Piece]]) -> list[Piece]:
    """Return the pieces of an intersection of unions: every combination of one piece from each union."""
    case_count = math.prod(len(pieces) for pieces in unions)
    if case_count > _MAX_PIECES:
        alternatives = f"{case_count} alternatives; at most {_MAX_PIECES} are allowed"
        raise ParseError(f"written out, the conditions are {alternatives}")
    return [sum(combination, ()) for combination in product(*unions)]


def _parse_assignment(joint: Node, values: Node, joints: Sequence[str]) -> list[Piece]:
    """Return a piece for each value of a joint, or for each value of an expression that is given as `joint`."""
    if joint.kind != "name" or joint.value not in joints:
        differences = (Node("-", (joint, value)) for value in _list_values(values))
        return [piece for difference in differences for piece in _parse_vanishing_expression(difference, joints)]
    cases = [case for value in _list_values(values) for case in _list_whole_number_cases(value)]
    compile_program(cases)  # raises ParseError unless each case is a single expression
    return [(Atom(case, str(joint.value)),) for case in cases]


def _list_values(values: Node) -> list[Node]:
    """Return the values as a flat list; [0, ±pi], for example, has three values."""
    if values.kind not in ("list", "set", "or"):
        return [values]
    return [value for arg in values.args for value in (arg.args if arg.kind == "set" else (arg,))]


def _parse_vanishing_expression(node: Node, joints: Sequence[str]) -> list[Piece]:
    """Return a piece for each factor of a product that vanishes, as in d3*sin(theta2) = 0."""
    expression = _strip_powers(node)
    compile_program([expression])  # raises ParseError unless it is a single expression
    factors, divisors = _split_product(expression, frozenset(joints))
    if len(factors) < 2 or not _vanishes_with_each_factor(factors, divisors, frozenset(joints)):
        return [(Atom(case),) for case in _list_whole_number_cases(expression)]
    return [
        (Atom(ZERO, str(factor.value)) if factor.kind == "name" and factor.value in joints else Atom(case),)
        for factor in factors
        for case in _list_whole_number_cases(factor)
    ]


_QUOTIENTS = {"tan": ("sin", "cos"), "cot": ("cos", "sin"), "sec": ("", "cos"), "csc": ("", "sin")}
"""Maps each function that is a quotient to the functions in its numerator ("" for 1) and in its denominator."""


def _split_product(node: Node, joints: AbstractSet[str]) -> tuple[list[Node], list[Node]]:
    """Return the different factors and divisors of a product that may vanish, without their powers."""
    is_power = node.kind == "^" and node.args[1].kind in ("number", "decimal") and node.args[1].value != 0
    if is_power or node.kind == "neg" or (node.kind == "call" and node.value == "abs"):
        factors, divisors = _split_product(node.args[0], joints)
        return (divisors, factors) if is_power and node.args[1].value < 0 else (factors, divisors)
    if node.kind in ("*", "/"):
        (factors, divisors), other_split = (_split_product(arg, joints) for arg in node.args)
        other_factors, other_divisors = other_split if node.kind == "*" else other_split[::-1]
        return list(dict.fromkeys(factors + other_factors)), list(dict.fromkeys(divisors + other_divisors))
    if _is_nonzero_constant(node, joints):
        return [], []
    if node.kind == "call" and node.value in _QUOTIENTS:
        factors, divisors = ([Node("call", node.args, name)] if name else [] for name in _QUOTIENTS[node.value])
        return factors, divisors
    return [node], []


def _is_nonzero_constant(node: Node, joints: AbstractSet[str]) -> bool:
    """Return whether a constant surely differs from zero, unlike 0, a1 - a2, cos(alpha1), and the whole number k."""
    if not find_names(node):
        value = evaluate_constant(node)
        return value is not None and abs(value) > 1e-9
    parts = list(iterate_nodes(node))
    kinds, functions = {part.kind for part in parts}, {part.value for part in parts if part.kind == "call"}
    may_cancel = "-" in kinds or {"+", "neg"} <= kinds
    may_vanish = may_cancel or any(_is_zero(part) or part.value == "I" for part in parts)
    is_known = functions <= {"sqrt", "abs"} and not find_names(node) & (joints | set(WHOLE_NUMBER_NAMES))
    return is_known and not may_vanish


def _vanishes_with_each_factor(factors: Sequence[Node], divisors: Sequence[Node], joints: AbstractSet[str]) -> bool:
    """Return whether a quotient surely vanishes at almost all zeros of each of its factors, and only there.

    For example, tan(theta1)*cos(theta1), 0*sin(theta1) and (theta1 - theta1)*sin(theta2) do not. Each divisor must be a
    joint variable, or the sine or cosine of a sum of joint variables. It must differ from zero at almost all zeros of
    the factors.
    """
    are_suitable = all(
        find_names(factor) & joints and _is_defined_everywhere(factor, joints) and _is_nonzero_somewhere(factor)
        for factor in factors
    )
    pairs = product(divisors, factors)
    return are_suitable and all(_is_nonzero_at_zeros(divisor, factor, joints) for divisor, factor in pairs)


def _is_nonzero_somewhere(node: Node) -> bool:
    """Return whether an expression differs from zero at an arbitrary configuration, so it is not zero everywhere."""
    values = {name: np.array([0.618033988 * k]) for k, name in enumerate(sorted(find_names(node)), start=1)}
    value, magnitude = evaluate(compile_program([node]), values, point_count=1)
    return bool(abs(value[0, 0]) > 1e-12 * magnitude[0, 0])


def _is_nonzero_at_zeros(divisor: Node, factor: Node, joints: AbstractSet[str]) -> bool:
    """Return whether a divisor surely differs from zero at almost all zeros of a factor."""
    angles = _list_summed_names(divisor.args[0] if _is_sine_or_cosine(divisor) else divisor)
    if not angles or not set(angles) <= joints:
        return False
    if _is_sine_or_cosine(factor) and divisor.args == factor.args:  # a sine and a cosine of the same angle
        return divisor != factor
    other_angles = _list_summed_names(factor.args[0]) if _is_sine_or_cosine(factor) else []
    return not set(angles) <= find_names(factor) or bool(set(other_angles) - set(angles))


def _is_sine_or_cosine(node: Node) -> bool:
    return node.kind == "call" and node.value in ("sin", "cos")


def _list_summed_names(node: Node) -> list[str]:
    """Return the names in a sum or difference of different names, such as theta1 + theta2; [] for anything else."""
    parts = list(iterate_nodes(node))
    names = [str(part.value) for part in parts if part.kind == "name"]
    is_sum = all(part.kind in ("name", "+", "-", "neg") for part in parts)
    return names if is_sum and len(set(names)) == len(names) else []


def _is_defined_everywhere(node: Node, joints: AbstractSet[str]) -> bool:
    """Return whether an expression surely has a value in all configurations, unlike tan(theta1) and 1/d2."""
    for part in iterate_nodes(node):
        has_numeric_exponent = part.kind == "^" and part.args[1].kind in ("number", "decimal")
        may_be_negative_power = part.kind == "^" and not (has_numeric_exponent and part.args[1].value > 0)
        may_divide_by_zero = part.kind == "/" and bool(find_names(part.args[1]) & joints)
        is_other_function = part.kind == "call" and part.value not in ("sin", "cos", "abs")
        if may_be_negative_power or may_divide_by_zero or is_other_function:
            return False
    return True


def _strip_powers(node: Node) -> Node:
    """Return X for sqrt(X), X^4, -X or X - 0, which have the same zeros, but not always derivatives at them."""
    inner = node
    while True:  # no recursion: X - 0 - 0 ... may be a deep tree
        if inner.kind == "-" and _is_zero(inner.args[0]):  # the answer was 0 = X
            inner = inner.args[1]
            continue
        is_minus_zero = inner.kind == "-" and _is_zero(inner.args[1])
        is_power = inner.kind == "^" and inner.args[1].kind in ("number", "decimal") and inner.args[1].value > 0
        has_same_zeros = is_minus_zero or is_power or inner.kind == "neg"
        if has_same_zeros or (inner.kind == "call" and inner.value in ("sqrt", "abs")):
            inner = inner.args[0]
        else:
            return inner


def _is_zero(node: Node) -> bool:
    return node.kind in ("number", "decimal") and not node.value


def _list_whole_number_cases(node: Node) -> list[Node]:
    """Return the different trees that result if each name of a whole number in a node becomes a number from -6 to 6.

    Multiples of pi that differ by 2 pi are not different, so every value of k*pi/6 is included.
    """
    whole_numbers = [name for name in WHOLE_NUMBER_NAMES if name in find_names(node)]
    combinations = product(WHOLE_NUMBER_VALUES, repeat=len(whole_numbers))
    cases = [replace_names(node, dict(zip(whole_numbers, values, strict=True))) for values in combinations]
    different_cases: dict[tuple[Fraction | None, int], Node] = {}
    for index, case in enumerate(cases):
        multiple = find_multiple_of_pi(case)
        different_cases[multiple, index if multiple is None else 0] = case
    return list(different_cases.values())


def solve_for_angle(atom: Atom, angles: Collection[str]) -> Atom:
    """Return a sum of angles that vanishes, such as theta1 + theta2, as a value of one angle: theta1 = -theta2.

    Values of an angle that differ by 2 pi are equal. So theta1 + theta2 may be any multiple of 2 pi; but 2 theta1 = pi
    means only pi/2. If no angle can be isolated, as in 2 theta1 + 3 theta2, the sine of half the sum vanishes instead.
    Other atoms are returned unchanged.
    """
    expression = atom.expression
    if atom.joint is not None:
        expression = Node("-", (Node("name", value=atom.joint), expression))
    factors = _find_angle_factors(expression, angles)
    if not factors or factors.keys() == {atom.joint}:
        return atom
    divisor = _compute_greatest_common_divisor(factors.values())
    for angle, factor in factors.items():
        if abs(factor) == divisor:
            value = Node("/", (replace_names(expression, {angle: ZERO}), make_number(divisor)))
            return Atom(-value if factor > 0 else value, angle)
    return Atom(make_half_sine(Node("/", (expression, make_number(divisor)))))


def _compute_greatest_common_divisor(factors: Collection[Fraction]) -> Fraction:
    """Return the largest number such that all factors are whole multiples of it."""
    denominator = math.lcm(*(factor.denominator for factor in factors))
    return Fraction(math.gcd(*(int(factor * denominator) for factor in factors)), denominator)


def make_half_sine(difference: Node) -> Node:
    """Return sin(difference / 2), which vanishes if two angles are equal modulo 2 pi."""
    return Node("call", (Node("/", (difference, make_number(2))),), "sin")


def split_zeros(piece: Piece, angles: Collection[str]) -> list[Piece]:
    """Split a piece at the zeros of each sine and cosine, such as 0 and pi for sin(theta1 + theta2) = 0."""
    return list(product(*(_list_zeros(atom, angles) for atom in piece)))


def _list_zeros(atom: Atom, angles: Collection[str]) -> list[Atom]:
    """Return an atom for each zero of a sine or cosine of joints; return any other atom unchanged."""
    function, arguments = atom.expression.value, atom.expression.args
    if atom.joint is not None or atom.expression.kind != "call" or function not in ("sin", "cos"):
        return [atom]
    if _compute_greatest_common_divisor(_find_angle_factors(arguments[0], angles).values()) != 1:
        return [atom]
    pi = Node("name", value="pi")
    values = (ZERO, pi) if function == "sin" else (pi / 2, -pi / 2)
    return [solve_for_angle(Atom(arguments[0] - value), angles) for value in values]


def _find_angle_factors(expression: Node, angles: Collection[str]) -> dict[str, Fraction]:
    """Return the factor of each angle in a sum of multiples of angles and of terms without angles.

    Return {} for any other expression.
    """
    factors: dict[str, Fraction] = {}
    for term, sign in split_signed_terms(expression):
        names = find_names(term).intersection(angles)
        coefficients = find_linear_factors(term) if names else {}
        if not names <= set(coefficients):
            return {}
        for name in sorted(names):
            factors[name] = factors.get(name, Fraction(0)) + sign * coefficients[name]
    return {name: factor for name, factor in factors.items() if factor}


def is_tied(atom: Atom, piece: Piece, joints: Sequence[str]) -> bool:
    """Return whether an atom's joint is tied to other joints, as q1 in "q1 = q2 and c1 = 0".

    The value of a tied joint contains joints, and another atom contains the tied joint.
    """
    depends_on_joints = bool(find_names(atom.expression) & set(joints))
    other_atoms = (other_atom for other_atom in piece if other_atom is not atom)
    return depends_on_joints and any(
        atom.joint in (other_atom.joint, *find_names(other_atom.expression)) for other_atom in other_atoms
    )


def parse_typed_set(node: Node, joints: Sequence[str]) -> list[Piece]:
    """Return the pieces of a typed answer. Raises ParseError, also if the pieces would take too long to check."""
    conditions = remove_noise(node)
    if _count_nodes_of_cases(conditions) > _MAX_NODES:
        raise ParseError(_TOO_LONG_MESSAGE)
    pieces, total_steps = parse_pieces(conditions, joints), 0
    for piece in pieces:
        steps = _FIXED_COST + sum(len(compile_program([atom.expression]).steps) for atom in piece)
        is_searched = any(atom.joint is None or is_tied(atom, piece, joints) for atom in piece)
        total_steps += steps if is_searched else steps // 10  # a joint with a value needs no search
        if total_steps > _MAX_STEPS:
            raise ParseError(f"the conditions, with their {len(pieces)} alternatives, are too long")
    return pieces


def _count_nodes_of_cases(node: Node) -> int:
    """Return the total number of nodes in all cases of all conditions."""
    alternatives = ("list", "set", "or")
    node_count, stack = 0, [node]
    while stack:  # no recursion: a long sum is a deep tree
        current_node = stack.pop()
        kinds = {arg.kind for arg in current_node.args}
        if current_node.kind in (*alternatives, "and", "dict", "pair", "in") or kinds.intersection(alternatives):
            stack.extend(current_node.args)
        else:
            whole_numbers = find_names(current_node) & set(WHOLE_NUMBER_NAMES)
            node_count += (_FIXED_COST + count_nodes(current_node)) * len(WHOLE_NUMBER_VALUES) ** len(whole_numbers)
    return node_count
