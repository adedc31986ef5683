"""Conditions as they are written, read as a union of pieces: "theta3 = 0 or pi", "{theta2: [0, pi]}", "k*pi".

A set is a union of pieces, a piece is a list of atoms that hold together, and an atom is either `expression = 0` or
`joint = value`.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import product

from qdot.exercises.formula.constants import turns_of
from qdot.exercises.formula.program import compile_program
from qdot.exercises.formula.trees import Node, ReadError, names, replaced
from qdot.exercises.formula.vocabulary import VOCABULARY

WHOLE_NUMBERS: tuple[str, ...] = tuple(VOCABULARY["whole_numbers"])
_SIX = tuple(Node("number", value=Fraction(k)) for k in range(7))
WHOLE = (*(Node("neg", (k,)) for k in _SIX[:0:-1]), *_SIX)
"""The whole numbers from -6 to 6."""
_MOST_PIECES = 500


@dataclass(frozen=True)
class Atom:
    """One condition: `zero` vanishes (joint is None), or `joint` has the value `zero` (modulo 2 pi for an angle)."""

    zero: Node
    joint: str | None = None


Piece = tuple[Atom, ...]


def pieces(node: Node, joints: Sequence[str]) -> list[Piece]:
    """Return the union of pieces that a tree stands for.

    Understood: equations, `theta2 in {0, pi}`, `{theta2: [0, pi]}`, a bare expression (that vanishes), `and`, `or`,
    lists of these, `k*pi` for every whole number k. Raises ReadError.
    """
    if node.kind in ("or", "list", "set"):
        return _alternatives(node, joints)
    if node.kind == "and":
        if not any(names(arg) & set(joints) for arg in node.args):
            raise ReadError("a value stands there without a joint; write it as in theta1 = pi/3")
        return _at_once(_together([pieces(arg, joints) for arg in node.args]))
    if node.kind == "dict":
        return _together([_assigned(pair.args[0], pair.args[1], joints) for pair in node.args])
    if node.kind == "in":
        return _assigned(node.args[0], node.args[1], joints)
    if node.kind == "eq":
        left, right = node.args
        if right.kind in ("list", "set"):
            return _assigned(left, right, joints)
        for own, other in ((left, right), (right, left)):
            if own.kind == "name" and own.value in joints and own.value not in names(other):
                return _assigned(own, other, joints)
        return _vanishing(Node("-", (left, right)))
    if node.kind == "name" and node.value in joints:
        raise ReadError(f"{node.value} stands alone; say what it is, as in {node.value} = pi/3")
    return _vanishing(node)


def _at_once(union: list[Piece]) -> list[Piece]:
    """Return pieces that can hold; raise ReadError where each gives one joint two values at once."""
    twice = [_given_twice(piece) for piece in union]
    if union and None not in twice:
        raise ReadError(f"{twice[0]} can't have two values at once; write {twice[0]} = 0 or {twice[0]} = pi/3")
    return union


def _given_twice(piece: Piece) -> str | None:
    """Return the joint that a piece gives two values that are not the same."""
    values: dict[str, object] = {}
    for atom in piece:
        turns = None if atom.joint is None else turns_of(atom.zero)
        if atom.joint is not None and turns is not None and values.setdefault(atom.joint, turns) != turns:
            return atom.joint
    return None


def _alternatives(node: Node, joints: Sequence[str]) -> list[Piece]:
    """Return the union of a list; a bare value belongs to the joint before it: theta3 = 0, pi, or (theta3, [0, pi])."""
    union: list[Piece] = []
    joint: Node | None = None
    for arg in node.args:
        says_more = bool(names(arg) & set(joints)) or arg.kind in ("eq", "in", "and", "or", "dict")
        if says_more:
            joint = _joint_of(arg, joints)
            is_label = joint is not None and arg.kind == "name" and len(node.args) == 2 and arg is node.args[0]
            if is_label and len(joints) == 2 and arg.value == joints[0] and node.args[1].kind not in ("list", "set"):
                raise ReadError(
                    f"a pair may be a joint and its value, or the values of {joints[0]} and {joints[1]}; write "
                    f"{joints[0]} = 0 or {joints[1]} = 0"
                )
            if not is_label or names(node.args[1]) & set(joints):
                union += pieces(arg, joints)
        elif joint is not None:
            union += _assigned(joint, arg, joints)
        else:
            raise ReadError("a value stands there without a joint; write it as in theta1 = pi/3")
    return union


def _joint_of(node: Node, joints: Sequence[str]) -> Node | None:
    """Return the joint that an equation or membership assigns, the last of alternatives, or a joint's bare name."""
    if node.kind == "or":
        return _joint_of(node.args[-1], joints)
    own = node.args[0] if node.kind in ("eq", "in") else node
    return own if own.kind == "name" and own.value in joints else None


def _together(sets: Sequence[Sequence[Piece]]) -> list[Piece]:
    """Return the pieces of an intersection: every combination of one piece of each set."""
    count = math.prod(len(pieces_) for pieces_ in sets)
    if count > _MOST_PIECES:
        raise ReadError(f"the conditions make {count} cases; more than {_MOST_PIECES} are not read")
    return [sum(combination, ()) for combination in product(*sets)]


def _assigned(joint: Node, values: Node, joints: Sequence[str]) -> list[Piece]:
    listed = _listed(values)
    if joint.kind != "name" or joint.value not in joints:
        return [piece for value in listed for piece in _vanishing(Node("-", (joint, value)))]
    union: list[Piece] = []
    for value in listed:
        for plain in _whole_number_cases(value):
            compile_program([plain])
            union.append((Atom(plain, str(joint.value)),))
    return union


def _listed(values: Node) -> list[Node]:
    """Return each of the values: of [0, ±pi], three."""
    if values.kind not in ("list", "set", "or"):
        return [values]
    return [value for arg in values.args for value in (arg.args if arg.kind == "set" else (arg,))]


def _vanishing(node: Node) -> list[Piece]:
    node = _bare(node)
    compile_program([node])
    return [(Atom(case),) for case in _whole_number_cases(node)]


def _bare(node: Node) -> Node:
    """Return what vanishes where an expression does, X of sqrt(X) or X^4: they lack the slope that a search needs."""
    while True:
        less_nothing = node.kind == "-" and node.args[1].kind in ("number", "decimal") and not node.args[1].value
        is_power = node.kind == "^" and node.args[1].kind in ("number", "decimal") and node.args[1].value > 0
        if less_nothing or is_power or node.kind == "neg" or (node.kind == "call" and node.value in ("sqrt", "abs")):
            node = node.args[0]
        else:
            return node


def _whole_number_cases(node: Node) -> list[Node]:
    """Return the cases of a whole number k: all there are modulo whole turns of a value k*pi/6, or coarser."""
    free = [name for name in WHOLE_NUMBERS if name in names(node)]
    cases = [node]
    for name in free:
        cases = [replaced(case, name, whole) for case in cases for whole in WHOLE]
    turns = [turns_of(case) for case in cases]
    return list({(turn, index if turn is None else 0): cases[index] for index, turn in enumerate(turns)}.values())


def is_tied(atom: Atom, piece: Piece, joints: Sequence[str]) -> bool:
    """Tell whether a joint's value follows other joints and another condition names the joint: q1 = q2 and c1 = 0."""
    follows = bool(names(atom.zero) & set(joints))
    return follows and any(atom.joint in names(one.zero) | {one.joint} for one in piece if one is not atom)
