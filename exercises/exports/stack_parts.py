"""A part as STACK asks and marks it: the input, Maxima for marking, the nodes of its response tree, question tests.

Formulas are compared by STACK's own algebraic equivalence, matrices entry by entry with the share of qdot, numbers
within their tolerance, sets of joint values modulo whole turns.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

import sympy as sp

from exercises.answers import LETTERS, Answer, Choice, ConditionSet, Direction, Forms, Number
from exercises.arm.singularity import Component
from exercises.credit import (
    AMISS,
    OWN,
    share_but_for_a_factor,
    share_of_columns,
    share_of_entries,
    share_of_set,
)
from exercises.exports.known_wrong import Known, domain_of, known_wrong, room_of, same_entries
from exercises.formula.expression import read
from exercises.formula.printers.maxima import maxima_matrix, maxima_text
from exercises.formula.scale import Factor, constant_factor
from exercises.formula.text import text_of
from exercises.problem import Part, Problem
from exercises.quizzes.options import blames_of

MOST = 6
"""Mistakes that a part's response tree knows: each costs a comparison of every wrong answer."""

_FITS = "is(abs(float(sin((rhs(c) - rhs(t))/2))) < 1.0e-9) else is(abs(float(rhs(c) - rhs(t))) < 1.0e-9)"
_MET = "makelist(is(qdot_count(makelist(qdot_fits(c, t, turning), {0}, {1})) > 0), {2}, {3})"

_RIGHT_ANGLES = ", ".join(
    f"{trig.__name__}({k}*%pi/12) = {maxima_text(sp.expand(sp.expand_trig(trig(sp.pi * k / 12))))}"
    for k in (1, 5, 7, 11)
    for trig in (sp.sin, sp.cos)
)
"""What Maxima does not know: sines and cosines of 15 degrees and the like, which offsets of joints bring in."""

FUNCTIONS = (
    f"known: [{_RIGHT_ANGLES}];",
    ("qdot_probe(x) := block([v: listofvars(x), found], "
    "found: errcatch(float(subst(makelist(v[i] = 0.31 + 0.47*i, i, 1, length(v)), x))), "
    "is(found = []) or is(abs(found[1]) < 1.0e-7) # false);"),
    "qdot_plain(x) := ratsimp(trigsimp(subst(known, trigexpand(x))));",
    ("qdot_entry(x, y) := if not qdot_probe(x - y) then false "
    "elseif is(algebraic_equivalence(x, y) = true) then true else is(qdot_plain(x - y) = 0);"),
    ("qdot_amiss(a, b, p, moving) := block([u, w, there, k, at], "
    "u: if matrixp(a) then apply(append, args(a)) else [a], w: if matrixp(b) then apply(append, args(b)) else [b], "
    "there: makelist(v = concat(v, \"moved\"), v, moving), "
    "if qdot_entry(u[p], 0) then 0 "
    "elseif qdot_count(makelist(qdot_entry(u[i], -w[i]), i, 1, length(w))) = length(w) then 1 "
    "elseif qdot_count(makelist(qdot_entry(u[i]*subst(there, w[p]), w[i]*subst(there, u[p])), i, 1, length(w))) "
    "< length(w) then 0 else (k: u[p]/w[p], at: makelist(v = 0.31, v, listofvars(k)), "
    "if is(float(subst(at, k)) < 0) then 2 else 1));"),
    ("qdot_same(a, b) := if not matrixp(b) then (if qdot_entry(a, b) then 1 else 0) else "
    "block([u: apply(append, args(a)), w: apply(append, args(b))], "
    "if is(qdot_count(makelist(qdot_entry(u[i], w[i]), i, 1, length(w))) = length(w)) then 1 else 0);"),
    "qdot_count(l) := length(sublist(l, lambda([x], is(x = true))));",
    "qdot_exact(x) := num_ensure_rational(subst(append(short, given), x));",
    "qdot_near(x, y, room) := is(abs(float(x) - y) <= room);",
    ("qdot_set_share(found, beyond) := block([total: apply(\"+\", map(first, found)), share], "
    "share: apply(\"*\", makelist(if f[1] = f[2] then 1 elseif f[1] = 0 then 1/2 else 2/3, f, found))/2^beyond, "
    "if total = 0 or (beyond > 1 and beyond >= total) then 0 elseif share = 1 then 1/2 else share);"),
    f"qdot_fits(c, t, turning) := is(lhs(c) = lhs(t)) and (if member(lhs(t), turning) then {_FITS});",
    f"qdot_covered(claims, truth, turning) := qdot_count({_MET.format('c', 'claims', 't', 'truth')});",
    f"qdot_beyond(claims, truth, turning) := length(claims) - qdot_count({_MET.format('t', 'truth', 'c', 'claims')});",
)  # fmt: skip
"""What marking calls, defined among the question variables."""


@dataclass(frozen=True)
class Node:
    """A node of a response tree: what is compared, and note, score and feedback where it is the same."""

    test: str
    left: str
    right: str
    note: str
    score: str
    says: str = ""
    options: str = ""


@dataclass(frozen=True)
class Case:
    """An answer of the question tests, and the score (None: not marked at all) and note that it must get."""

    title: str
    value: str
    score: float | None
    note: str


@dataclass(frozen=True)
class StackPart:
    """A part in STACK's terms; `otherwise` is said (in CASText) where no node knows the answer."""

    part: Part
    number: int
    kind: str
    model: str
    words: str
    variables: tuple[str, ...] = ()
    marking: tuple[str, ...] = ()
    nodes: tuple[Node, ...] = ()
    cases: tuple[Case, ...] = ()
    otherwise: str = ""
    score: str = "0"
    hint: str = ""
    box: int = 15
    checked: bool = True
    """Whether STACK tells the student that the answer is of another type than is due."""

    @property
    def tree(self) -> str:
        """The name of the response tree."""
        return f"prt{self.number}"


def asked(problem: Problem, part: Part, number: int) -> StackPart | str:
    """Return a part as STACK asks it, or why STACK can't."""
    return part.answer.told_to(_Asking(problem, part, number))


@dataclass(frozen=True)
class _Asking(Forms["StackPart | str"]):
    """How STACK asks for each form of answer, or why it can't."""

    problem: Problem
    part: Part
    number: int

    def formulas(self, answer: Answer) -> "StackPart | str":
        return _formulas(self.problem, self.part, self.number)

    def numbers(self, answer: Number) -> "StackPart | str":
        return _numbers(self.problem, self.part, self.number)

    def conditions(self, answer: ConditionSet) -> "StackPart | str":
        return _values(self.problem, self.part, self.number)

    def direction(self, answer: Direction) -> "StackPart | str":
        return "directions in numbers are not asked" if answer.is_in_numbers else _direction(self.part, self.number)

    def one_of(self, answer: Choice) -> "StackPart | str":
        return _choice(self.part, self.number)

    def letters(self, answer: Answer) -> "StackPart | str":
        return "letters of several options are not asked; the outlets with quizzes ask them"


def share_of(problem: Problem, part: Part, answer: sp.Matrix, equal: Sequence[bool]) -> float:
    """Return the share of formulas that are not all right, as `qdot grade` marks them but for lost factors."""
    if all(equal):
        return 1.0
    credit = part.credit or OWN
    if credit.by == "whole":
        return 0.0
    reference = part.answer.as_matrix()
    share = Fraction(0)
    if part.shape is not None:
        _, zeros = _counted(reference)
        columns = reference.cols
        right = {(k // columns + 1, k % columns + 1) for k, same in enumerate(equal) if same}
        if credit.by == "columns" and columns > 1:
            share = share_of_columns([set(group) <= right for group in _columns(reference)])
        else:
            share = share_of_entries(equal, [(k // columns + 1, k % columns + 1) in zeros for k in range(len(equal))])
        varying = _varying(problem, reference)
        if varying and not set(varying) & right:
            share = Fraction(0)
    if _pivot(problem, reference) is not None and (factor := _factor(problem, answer, reference)) is not None:
        off = share_but_for_a_factor(is_sign_wrong=factor.is_negative, is_constant_wrong=factor.is_other)
        share = max(share, off)
    return float(share * credit.worth)


def _factor(problem: Problem, answer: sp.Matrix, reference: sp.Matrix) -> Factor | None:
    domain = domain_of(problem)
    own, due = ([read(text_of(entry), domain.roles) for entry in matrix] for matrix in (answer, reference))
    return constant_factor(own, due, domain, set(domain.roles) - problem.constants, f"stack/{problem.id}")


def _varying(problem: Problem, reference: sp.Matrix) -> "Places":
    """Return the places of entries that depend on the configuration or its velocity."""
    return [
        (i + 1, j + 1)
        for i in range(reference.rows)
        for j in range(reference.cols)
        if any(symbol.name not in problem.constants for symbol in reference[i, j].free_symbols)
    ]


def _pivot(problem: Problem, reference: sp.Matrix) -> int | None:
    """Return an entry by which a constant factor is told, counted from 1; None where a single number is due."""
    filled = [k for k, entry in enumerate(reference, 1) if entry != 0]
    return None if not filled or (len(filled) == 1 and not _varying(problem, reference)) else filled[0]


Places = list[tuple[int, int]]


def _counted(reference: sp.Matrix) -> tuple[Places, Places]:
    """Return the places of entries that count, those that are not zero if there are any, and of the zeros."""
    places = [(i + 1, j + 1) for i in range(reference.rows) for j in range(reference.cols)]
    filled = [(i, j) for i, j in places if reference[i - 1, j - 1] != 0]
    return (filled, [place for place in places if place not in filled]) if filled else (places, [])


def _columns(reference: sp.Matrix) -> list[Places]:
    """Return the places of each column that is not all zeros."""
    return [
        [(i + 1, j + 1) for i in range(reference.rows)]
        for j in range(reference.cols)
        if any(entry != 0 for entry in reference.col(j))
    ]


def _listed(places: Sequence[object]) -> str:
    return str([list(place) if isinstance(place, tuple) else place for place in places])


# --- formulas ---


def _formulas(problem: Problem, part: Part, number: int) -> StackPart:
    k, single, reference = number, part.shape is None, part.answer.as_matrix()
    model = _shown(reference, single)
    marking = [f"said{k}: qdot_exact(ans{k});"]
    score, otherwise = "0", ""
    if (part.credit or OWN).by != "whole":
        lines, otherwise = _in_part(problem, part, reference, k)
        marking += lines
        score = f"share{k}"
    known = known_wrong(problem, part, MOST)
    marking.append(f"same{k}: qdot_same(said{k}, ta{k});")
    nodes = [Node("AlgEquiv", f"same{k}", "1", f"prt{k}-right", "1")]
    cases = [Case("the reference", f"ta{k}", 1.0, f"prt{k}-right")]
    variables = [f"ta{k}: {model};"]
    for index, wrong in enumerate(known, 1):
        name = f"wrong{k}_{index}"
        variables.append(f"{name}: {_shown(wrong.answer, single)};")
        marking.append(f"like{k}_{index}: if same{k} = 1 then 0 else qdot_same(said{k}, {name});")
        nodes.append(Node("AlgEquiv", f"like{k}_{index}", "1", f"prt{k}-{wrong.mistake}", score, wrong.says))
        assert isinstance(wrong.answer, sp.MatrixBase)
        note = f"prt{k}-{wrong.mistake}"
        cases.append(Case(wrong.title, name, share_of(problem, part, wrong.answer, wrong.equal), note))
    unusual = _unusual(problem, reference)
    if unusual is not None:
        cases.append(Case("another form of the reference", _shown(unusual, single), 1.0, f"prt{k}-right"))
    nothing = reference * 0 + sp.ones(*reference.shape) * sp.Integer(7)
    share = share_of(problem, part, nothing, same_entries(problem, nothing, reference))
    cases.append(Case("nobody's mistake", _shown(nothing, single), share, f"prt{k}-other"))
    words = "a formula" if single else f"one formula in each of the {reference.rows} × {reference.cols} boxes"
    longest = max(len(maxima_text(entry)) for entry in reference)
    return StackPart(
        part, k, "algebraic" if single else "matrix", f"ta{k}", words, tuple(variables), tuple(marking), tuple(nodes),
        tuple(cases), otherwise, score, box=min(60, max(8, longest)) if single or reference.cols == 1
        else min(24, max(6, longest)),
    )  # fmt: skip


def _shown(matrix: sp.Matrix, single: bool) -> str:
    return maxima_text(matrix[0]) if single else maxima_matrix(matrix)


def _in_part(problem: Problem, part: Part, reference: sp.Matrix, k: int) -> tuple[list[str], str]:
    """Return the lines that work out the share of formulas that are right in part, and what is said of them."""
    lines, said = ([f"share{k}: 0;"], "") if part.shape is None else _entries(problem, part, reference, k)
    pivot = _pivot(problem, reference)
    if pivot is None:
        return lines, said
    moving = sorted({symbol.name for symbol in reference.free_symbols} | {q.name for q in problem.chain.q})
    moving = [name for name in moving if name not in problem.constants]
    worth = (part.credit or OWN).worth
    lines += [
        f"amiss{k}: qdot_amiss(said{k}, ta{k}, {pivot}, [{', '.join(moving)}]);",
        f"share{k}: max(share{k}, if amiss{k} = 0 then 0 else {worth}*(1 - {AMISS}*amiss{k}));",
    ]
    factor = "It is right but for its sign, a constant factor, or both."
    return lines, said + f'[[if test="amiss{k}>0"]]<p>{factor}</p>[[/if]]'


def _entries(problem: Problem, part: Part, reference: sp.Matrix, k: int) -> tuple[list[str], str]:
    """Return the lines that work out the share of a matrix, and what is said of it."""
    credit = part.credit or OWN
    counted, zeros = _counted(reference)
    same = f"qdot_entry(said{k}[p[1], p[2]], ta{k}[p[1], p[2]])"
    worth = "" if credit.worth == 1 else f"*{credit.worth}"
    if credit.by == "columns" and reference.cols > 1:
        groups = [[list(place) for place in group] for group in _columns(reference)]
        lines = [
            f"right{k}: qdot_count(makelist(is(qdot_count(makelist({same}, p, c)) = length(c)), c, {groups}));",
            f"share{k}: min(right{k}, {len(groups) - 1})/{len(groups)}{worth};",
            *_unless_constant(problem, reference, k),
        ]
        return lines, f"<p>{{@right{k}@}} of {len(groups)} columns are right.</p>"
    spoiled = f"{len(zeros)} - qdot_count(makelist({same}, p, {_listed(zeros)}))" if zeros else "0"
    lines = [
        f"right{k}: qdot_count(makelist({same}, p, {_listed(counted)}));",
        f"spoiled{k}: {spoiled};",
        f"share{k}: max(0, min(right{k} - spoiled{k}, {len(counted) - 1}))/{len(counted)}{worth};",
        *_unless_constant(problem, reference, k),
    ]
    which = f"{len(counted)} entries that are not zero" if zeros else f"{len(counted)} entries"
    also = f"; {{@spoiled{k}@}} of {len(zeros)} zeros are answered with something else" if zeros else ""
    return lines, f"<p>{{@right{k}@}} of {which} are right{also}.</p>"


def _unless_constant(problem: Problem, reference: sp.Matrix, k: int) -> list[str]:
    """Return the line that gives nothing where no entry is right that depends on the configuration."""
    varying = _varying(problem, reference)
    same = f"qdot_entry(said{k}[p[1], p[2]], ta{k}[p[1], p[2]])"
    found = f"qdot_count(makelist({same}, p, {_listed(varying)}))"
    return [f"share{k}: if share{k} > 0 and {found} = 0 then 0 else share{k};"] if varying else []


def _unusual(problem: Problem, reference: sp.Matrix) -> sp.Matrix | None:
    """Return the reference in a form that few would write, proved to be the same; None where there is none."""
    first = next((q for q in problem.chain.q if q.name.startswith("theta")), None)
    if first is None:
        return None
    one = sp.sin(first) ** 2 + sp.cos(first) ** 2
    expanded = reference.applyfunc(lambda entry: sp.expand_trig(entry) * one if entry != 0 else entry)
    return expanded if all(same_entries(problem, expanded, reference)) else None


def _direction(part: Part, number: int) -> StackPart:
    """Compare cross products with an entry of the reference that is not zero, and take the zero vector for none."""
    answer = part.of(Direction)
    reference, k = answer.reference, number
    pivot = next(i for i, entry in enumerate(reference, 1) if entry != 0)
    n = len(reference)
    marking = (
        f"said{k}: qdot_exact(ans{k});",
        f"zeros{k}: qdot_count(makelist(qdot_entry(said{k}[i, 1], 0), i, 1, {n}));",
        (
            f"along{k}: qdot_count(makelist(qdot_entry(said{k}[i, 1]*ta{k}[{pivot}, 1], "
            f"ta{k}[i, 1]*said{k}[{pivot}, 1]), i, 1, {n}));"
        ),
        f"right{k}: if zeros{k} < {n} and along{k} = {n} then 1 else 0;",
    )
    note = f"prt{k}-right"
    cases = (
        Case("the reference", f"ta{k}", 1.0, note),
        Case("another form of the reference", f"-3*ta{k}", 1.0, note),
        Case("nobody's mistake", maxima_matrix(reference * 0), 0.0, f"prt{k}-other"),
    )
    return StackPart(
        part, k, "matrix", f"ta{k}", "a vector; any multiple of it but zero is as good",
        (f"ta{k}: {maxima_matrix(reference)};",), marking, (Node("AlgEquiv", f"right{k}", "1", note, "1"),), cases,
    )  # fmt: skip


# --- numbers ---


def _numbers(problem: Problem, part: Part, number: int) -> StackPart:
    answer, k = part.of(Number), number
    single, n = len(answer.reference) == 1, len(answer.reference)
    room = [sp.Rational(f"{allowed:.12g}") for allowed in room_of(part)]
    known = known_wrong(problem, part, MOST)
    truth = sp.Matrix([sp.Rational(f"{float(value):.12g}") for value in answer.reference])
    value = f"said{k}" if single else f"said{k}[i, 1]"
    lines = [f"said{k}: subst(append(short, given), ans{k});", f"room{k}: {[maxima_text(r) for r in room]};"]
    lines = [line.replace("'", "") for line in lines]

    def near(matrix: str) -> str:
        other = f"float({matrix})" if single else f"float({matrix}[i, 1])"
        return f"qdot_count(makelist(qdot_near({value}, {other}, room{k}[i]), i, 1, {n}))"

    zeros = [abs(float(v)) <= answer.allowed(part.rounding)[1] for v in answer.reference]
    lines += [f"right{k}: {near(f'ta{k}')};", *_share_of_numbers(part, zeros, k)]
    variables = [f"ta{k}: {_floats(truth, single)};"]
    score = f"share{k}"
    right = (
        Node("NumAbsolute", f"said{k}", f"ta{k}", f"prt{k}-right", "1", options=maxima_text(room[0]))
        if single
        else Node("AlgEquiv", f"right{k}", str(n), f"prt{k}-right", "1")
    )
    nodes, cases = [right], [Case("the reference", f"ta{k}", 1.0, f"prt{k}-right")]
    for index, wrong in enumerate(known, 1):
        name = f"wrong{k}_{index}"
        variables.append(f"{name}: {_floats(wrong.answer, single)};")
        lines.append(f"like{k}_{index}: {near(name)};")
        nodes.append(Node("AlgEquiv", f"like{k}_{index}", str(n), f"prt{k}-{wrong.mistake}", score, wrong.says))
        cases.append(Case(wrong.title, name, _share_of_typed(part, wrong, zeros), f"prt{k}-{wrong.mistake}"))
    off = truth + sp.Matrix([50 * r for r in room])
    inside = truth + sp.Matrix([r / 2 for r in room])
    cases.append(Case("off by half of what is allowed", _floats(inside, single), 1.0, f"prt{k}-right"))
    if not any(_meets(off, wrong, room) for wrong in known):
        cases.append(Case("nobody's mistake", _floats(off, single), 0.0, f"prt{k}-other"))
    unit = "; ".join(dict.fromkeys(unit for unit in answer.units if unit))
    words = ("a number" if single else f"{n} numbers") + (f", in {unit}, without the unit" if unit else "")
    otherwise = "" if single else f"<p>{{@right{k}@}} of {n} numbers are right.</p>"
    return StackPart(
        part, k, "numerical" if single else "matrix", f"ta{k}", words, tuple(variables), tuple(lines), tuple(nodes),
        tuple(cases), otherwise, score, box=12, checked=False,
    )  # fmt: skip


def _share_of_numbers(part: Part, zeros: Sequence[bool], k: int) -> list[str]:
    """Return the lines that work out the share of numbers that are not all right."""
    n = len(zeros)
    if n == 1 or (part.credit or OWN).by == "whole":
        return [f"share{k}: 0;"]
    counted = [i for i, zero in enumerate(zeros, 1) if not zero] or list(range(1, n + 1))
    spoiled = [i for i in range(1, n + 1) if i not in counted]

    def near(sign: str, which: Sequence[int]) -> str:
        return f"qdot_count(makelist(qdot_near(said{k}[i, 1], {sign}float(ta{k}[i, 1]), room{k}[i]), i, {which}))"

    share = (
        f"max(0, min({near('', counted)} - ({len(spoiled)} - {near('', spoiled)}), {len(counted) - 1}))/{len(counted)}"
    )
    lines = [f"share{k}: {share};"]
    if all(part.answer.units_due) and not all(zeros):
        lines.append(f"share{k}: if {near('-', list(range(1, n + 1)))} = {n} then {1 - AMISS} else share{k};")
    worth = (part.credit or OWN).worth
    return lines if worth == 1 else [*lines, f"share{k}: share{k}*{worth};"]


def _share_of_typed(part: Part, wrong: Known, zeros: Sequence[bool]) -> float:
    """Return the share of numbers that a mistake gives."""
    credit = part.credit or OWN
    if len(zeros) == 1 or credit.by == "whole":
        return 0.0
    share = share_of_entries(wrong.equal, zeros)
    assert isinstance(wrong.answer, sp.MatrixBase)
    pairs = zip(wrong.answer, part.answer.as_matrix(), room_of(part), strict=True)
    if all(part.answer.units_due) and not all(zeros) and all(abs(float(a + b)) <= room for a, b, room in pairs):
        share = 1 - AMISS
    return float(share * credit.worth)


def _floats(matrix: sp.Matrix | tuple[Component, ...], single: bool) -> str:
    assert isinstance(matrix, sp.MatrixBase)
    values = [f"{float(value):.12g}" for value in matrix]
    values = [
        f"{mantissa}*10^({power})" if power else mantissa for mantissa, _, power in (v.partition("e") for v in values)
    ]
    return values[0] if single else f"matrix({', '.join(f'[{value}]' for value in values)})"


def _meets(values: sp.Matrix, wrong: Known, room: Sequence[sp.Expr]) -> bool:
    assert isinstance(wrong.answer, sp.MatrixBase)
    return all(abs(a - b) <= 2 * r for a, b, r in zip(values, wrong.answer, room, strict=True))


# --- options and sets ---


def _choice(part: Part, number: int) -> StackPart:
    answer, k = part.of(Choice), number
    options = [
        f'[{i}, {"true" if i - 1 == answer.correct else "false"}, "{LETTERS[i - 1]}"]'
        for i in range(1, len(answer.options) + 1)
    ]
    right = answer.correct + 1
    nodes = [Node("AlgEquiv", f"ans{k}", str(right), f"prt{k}-right", "1")]
    cases = [Case("the reference", str(right), 1.0, f"prt{k}-right")]
    for i in range(len(answer.options)):
        if i != answer.correct:
            blames = blames_of(part, i)
            says = " ".join(dict.fromkeys(blame.sentence for blame in blames))
            note = f"prt{k}-{LETTERS[i]}" + "".join(f"-{name}" for name in dict.fromkeys(b.mistake for b in blames))
            nodes.append(Node("AlgEquiv", f"ans{k}", str(i + 1), note, "0", says))
            cases.append(Case(f"option {LETTERS[i]}", str(i + 1), 0.0, note))
    return StackPart(
        part, k, "radio", f"ta{k}", "the letter of the right option", (f"ta{k}: [{', '.join(options)}];",), (),
        tuple(nodes), tuple(cases), checked=False,
    )  # fmt: skip


def _values(problem: Problem, part: Part, number: int) -> StackPart | str:
    """Ask for a set of equations, a joint on the left and its value on the right."""
    answer, k = part.of(ConditionSet), number
    if not all(_is_of_values(component) for component in answer.components):
        return "its singular configurations are no values of single joints, which STACK could judge fairly"
    joints = [q.name for q in problem.chain.q]
    turning = [name for name in joints if name.startswith("theta")]

    def equations(components: tuple[Component, ...], turns: int = 0) -> str:
        pairs = [pair for component in components for pair in component.solutions or ()]
        shown = [
            f"{joint} = {maxima_text(value + 2 * sp.pi * (turns if joint.name in turning else 0))}"
            for joint, values in pairs
            for value in values
        ]
        return "{" + ", ".join(dict.fromkeys(shown)) + "}"

    found = [
        f"[qdot_covered(said{k}, args({equations((component,))}), turning{k}), {_count(component)}]"
        for component in answer.components
    ]
    lines = [
        f"said{k}: if setp(ans{k}) or listp(ans{k}) then args(ans{k}) else [ans{k}];",
        f"said{k}: qdot_exact(said{k});",
        f"turning{k}: [{', '.join(turning)}];",
        f"right{k}: qdot_covered(said{k}, args(ta{k}), turning{k});",
        f"beyond{k}: qdot_beyond(said{k}, args(ta{k}), turning{k});",
        f"share{k}: qdot_set_share([{', '.join(found)}], beyond{k});",
    ]
    worth = (part.credit or OWN).worth if (part.credit or OWN).by != "whole" else 0
    lines += [] if worth == 1 else [f"share{k}: share{k}*{worth};"]
    total = len([pair for c in answer.components for _, values in c.solutions or () for pair in values])
    nodes = [Node("AlgEquiv", f"[right{k}, beyond{k}]", f"[{total}, 0]", f"prt{k}-right", "1")]
    variables = [f"ta{k}: {equations(answer.components)};"]
    cases = [Case("the reference", f"ta{k}", 1.0, f"prt{k}-right")]
    truth = _claims(answer.components)
    for index, wrong in enumerate(known_wrong(problem, part, 2 * MOST), 1):
        assert isinstance(wrong.answer, tuple)
        if len(nodes) > MOST or not all(_is_of_values(component) for component in wrong.answer):
            continue
        name, note = f"wrong{k}_{index}", f"prt{k}-{wrong.mistake}"
        variables.append(f"{name}: {equations(wrong.answer)};")
        against = f"(said{k}, args({name}), turning{k})"
        lines.append(f"like{k}_{index}: [qdot_covered{against} - length({name}), qdot_beyond{against}];")
        claimed = _claims(wrong.answer)
        each = [_claims((component,)) for component in answer.components]
        share = float(share_of_set([(len(claimed & due), len(due)) for due in each], len(claimed - truth)) * worth)
        nodes.append(Node("AlgEquiv", f"like{k}_{index}", "[0, 0]", note, f"share{k}", wrong.says))
        cases.append(Case(wrong.title, name, share, note))
    cases.append(Case("another form of the reference", equations(answer.components, 1), 1.0, f"prt{k}-right"))
    cases.append(Case("nobody's mistake", f"{{{joints[0]} = 1/7}}", 0.0, f"prt{k}-other"))
    words = (
        "a set of equations, each with a joint variable on the left and one value of it on the right (angles in "
        f"radians, one turn), as in {{{joints[-1]} = 1/2, {joints[-1]} = pi/3}}; every value counts"
    )
    return StackPart(
        part, k, "algebraic", f"ta{k}", words, tuple(variables), tuple(lines), tuple(nodes), tuple(cases),
        f"<p>{{@right{k}@}} of the configurations are there, and {{@beyond{k}@}} of your values are not singular or "
        "not as they are asked for.</p>", f"share{k}", box=50,
    )  # fmt: skip


def _count(component: Component) -> int:
    """Return how many values a component gives."""
    return len(_claims((component,)))


def _is_of_values(component: Component) -> bool:
    """Tell whether a component gives values, which are numbers, of one joint alone."""
    return (
        component.solutions is not None
        and len(component.solutions) == 1
        and not any(value.free_symbols for value in component.solutions[0][1])
    )


def _claims(components: tuple[Component, ...]) -> set[tuple[str, float]]:
    """Return joints and values, rounded, angles within one turn."""
    claims = set()
    for component in components:
        for joint, values in component.solutions or ():
            for value in values:
                number = float(value)
                turned = number % (2 * float(sp.pi)) if joint.name.startswith("theta") else number
                claims.add((joint.name, round(turned, 9) % round(2 * float(sp.pi), 9)))
    return claims


def without_rounding(part: Part) -> Part:
    """Return a part of formulas as STACK judges it: decimals mean what they say."""
    return replace(part, rounding=None) if part.answer.is_exact else part
