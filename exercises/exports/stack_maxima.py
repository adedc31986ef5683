"""Maxima functions for marking, which a STACK question defines among its variables if it needs them.

Formulas are compared by their values at a few points that the exporter samples. That takes milliseconds for any form
of an answer. STACK's AlgEquiv would prove equality entry by entry, which takes seconds each; STACK allows 30 in total.

    points          the values of all symbols at each point; only the configuration differs between the first two
    short, given    substitutions for short names such as c12, and for lengths with given numbers
    turning         the joints whose values are angles
    u, w            submitted and correct answer: a list of entries at each point, false if an entry is not a number
"""

from qdot.exercises.formula.printers.maxima import maxima_text
from qdot.exercises.problem.problem import Problem

MAX_JOINTS_IN_NAME = 6
"""Maximum number of joints in a short name for a sum of neighbouring angles, such as c123."""

COUNT_FUNCTION = "qdot_count(l) := length(sublist(l, lambda([x], is(x = true))));"
READ_FUNCTION = "qdot_read(x) := subst(append(short, given), x);"

FORMULA_FUNCTIONS = (
    COUNT_FUNCTION, READ_FUNCTION,
    ("qdot_number(x, p) := block([y: errcatch(float(subst(p, x)))], "
    "if y # [] and numberp(y[1]) then y[1] else false);"),
    ("qdot_values(x) := block([entries: if matrixp(x) then apply(append, args(x)) else [x]], "
    "makelist(makelist(qdot_number(f, p), f, entries), p, points));"),
    "qdot_close(x, y) := is(not (x = false) and abs(x - y) <= 1.0e-10*(1 + abs(y)));",
    ("qdot_agree(u, w) := makelist(is(qdot_count(makelist(qdot_close(u[m][i], w[m][i]), m, 1, length(w))) "
    "= length(w)), i, 1, length(w[1]));"),
    "qdot_same(u, x) := if qdot_count(qdot_agree(u, qdot_values(x))) = length(u[1]) then 1 else 0;",
    ("qdot_parallel(u, w, p) := if member(false, u) or abs(u[p]) < 1.0e-10 then false "
    "else is(qdot_count(makelist(qdot_close(u[i]*w[p]/u[p], w[i]), i, 1, length(w))) = length(w));"),
    ("qdot_along(u, w, p) := is(qdot_count(makelist(qdot_parallel(u[m], w[m], p), m, 1, length(w))) = length(w));"),
    ("qdot_signed(u, w) := if member(false, flatten(u)) then w else makelist(makelist("
    "if u[1][i]*w[1][i] < 0 then -w[m][i] else w[m][i], i, 1, length(w[m])), m, 1, length(w));"),
    ("qdot_amiss(u, w, agree, moving) := block([wrong: sublist(makelist(i, i, 1, length(agree)), "
    "lambda([i], not agree[i])), v, signs, k], if wrong = [] then return(0), "
    "u: makelist(makelist(p[i], i, wrong), p, u), w: makelist(makelist(p[i], i, wrong), p, w), "
    "v: qdot_signed(u, w), signs: if v = w then 0 else 1, "
    "if abs(v[1][1]) < 1.0e-10 or not qdot_along(u, v, 1) then 0 else (k: makelist(u[m][1]/v[m][1], m, 1, length(v)), "
    "if qdot_count(makelist(qdot_close(c, 1), c, k)) = length(k) then signs "
    "elseif qdot_close(k[1], k[2]) and length(sublist(wrong, lambda([i], member(i, moving)))) > 0 then signs + 1 "
    "else 0));"),
)  # fmt: skip
"""`qdot_amiss` returns 1 for wrong signs plus 1 for a wrong constant factor, or 0 if the answer has other errors.

`agree` says which entries are correct; `moving` are the indices of entries that depend on the configuration.
"""

NUMBER_FUNCTIONS = (COUNT_FUNCTION, READ_FUNCTION, "qdot_near(x, y, room) := is(abs(float(x) - y) <= room);")

_VALUE_COMPARISON = "is(abs(float(sin((rhs(c) - rhs(t))/2))) < 1.0e-9) else is(abs(float(rhs(c) - rhs(t))) < 1.0e-9)"
_MATCHED_VALUES = "makelist(is(qdot_count(makelist(qdot_fits(c, t), {0}, {1})) > 0), {2}, {3})"

SET_FUNCTIONS = (
    COUNT_FUNCTION, READ_FUNCTION,
    f"qdot_fits(c, t) := is(lhs(c) = lhs(t)) and (if member(lhs(t), turning) then {_VALUE_COMPARISON});",
    f"qdot_covered(claims, truth) := qdot_count({_MATCHED_VALUES.format('c', 'claims', 't', 'truth')});",
    ("qdot_beyond(claims, truth) := block([met: lambda([c], is(qdot_covered(truth, [c]) > 0)), found, others], "
    "found: map(lhs, sublist(claims, met)), others: map(lhs, sublist(claims, lambda([c], not met(c)))), "
    "length(sublist(others, lambda([q], member(q, found)))) "
    "+ length(unique(sublist(others, lambda([q], not member(q, found))))));"),
    ("qdot_set_share(found, beyond) := block([conditions: qdot_count(makelist(is(f[1] > 0), f, found)), share], "
    "share: apply(\"*\", makelist(if f[1] = f[2] then 1 elseif f[1] = 0 then 1/2 else 2/3, f, found))/2^beyond, "
    "if conditions = 0 or beyond > conditions then 0 elseif share = 1 then 1/2 else share);"),
)  # fmt: skip


def write_substitutions(problem: Problem) -> tuple[str, str]:
    """Return the lines that define the substitutions for a student's names: given lengths, sines and cosines."""
    given_values = (
        f"{name} = {maxima_text(info.value)}" for name, info in problem.symbols().items() if info.value is not None
    )
    short = (f"{name} = {meaning}" for name, meaning in list_short_names(problem).items())
    return f"given: [{', '.join(given_values)}];", f"short: [{', '.join(short)}];"


def list_short_names(problem: Problem) -> dict[str, str]:
    """Return short names for sines and cosines of angles and of sums of neighbouring angles, with their meanings."""
    symbols = problem.symbols()
    angles = {i: q for i, q in enumerate(problem.chain.q, 1) if q.name.startswith("theta")}
    meanings = {}
    for first in angles:
        for last in range(first, min(first + MAX_JOINTS_IN_NAME, 10)):
            run = range(first, last + 1)
            if not all(i in angles for i in run):
                break
            total, digits = " + ".join(angles[i].name for i in run), "".join(map(str, run))
            meanings.update({f"c{digits}": f"cos({total})", f"s{digits}": f"sin({total})"})
    return {name: meaning for name, meaning in meanings.items() if name not in symbols}
