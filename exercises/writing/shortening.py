r"""Sums of sines and cosines that are one of them, written as that one.

\sqrt{3}/4 \cos\varphi + 1/4 \sin\varphi is 1/2 \cos\theta where \varphi is \theta and 30 degrees: a constant that a
table adds to a joint variable makes two terms of what was one. No value changes, and what is short stays as it is.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import lru_cache
from itertools import combinations

import sympy as sp

from qdot.exercises.formula.order import joint_sum

IsSaid = Callable[[sp.Expr], bool]
"""Whether an angle may stand in a formula: it is plain, or it has a name."""


@lru_cache(maxsize=4096)
def in_plain_angles(expression: sp.Expr) -> sp.Expr:
    """Return an expression with sums A cos + B sin of an angle and a constant as one sine or cosine of the angle.

    >>> t2, a1 = sp.symbols("theta2 a1")
    >>> in_plain_angles(sp.sqrt(3) * sp.cos(t2 + sp.pi / 6) / 4 + sp.sin(t2 + sp.pi / 6) / 4)
    cos(theta2)/2
    >>> in_plain_angles(a1 * sp.cos(t2 + sp.pi / 6) + sp.sin(t2 + sp.pi / 6))
    a1*cos(theta2 + pi/6) + sin(theta2 + pi/6)
    """
    if not any(_turned(trig.args[0]) for trig in expression.atoms(sp.sin, sp.cos)):
        return expression
    return _everywhere(expression, _one_turned_back)


def added_up(expression: sp.Expr, is_said: IsSaid) -> sp.Expr:
    """Return an expression in which the addition theorems are used wherever the sum, or difference, `is_said`.

    >>> t1, t2, a1 = sp.symbols("theta1 theta2 a1")
    >>> added_up(a1 * sp.sin(t1) * sp.cos(t2) + a1 * sp.cos(t1) * sp.sin(t2), lambda angle: True)
    a1*sin(theta1 + theta2)
    """
    if len(expression.atoms(sp.sin, sp.cos)) < 4:
        return expression
    return _everywhere(expression, lambda total: _one_added_up(total, is_said))


def with_squares(expression: sp.Expr) -> sp.Expr:
    """Return an expression in which sin^2 + cos^2 = 1 is used where it makes one term of two.

    >>> t2, a1 = sp.symbols("theta2 a1")
    >>> with_squares(a1 - a1 * sp.sin(t2) ** 2), with_squares(sp.sin(t2) ** 2 + sp.cos(t2) ** 2)
    (a1*cos(theta2)**2, 1)
    """
    if not any(isinstance(power.base, (sp.sin, sp.cos)) for power in expression.atoms(sp.Pow)):
        return expression
    return _everywhere(expression, _one_square)


def _one_square(total: sp.Expr) -> sp.Expr | None:
    """Return a sum with two of its terms as one, or None where there are none."""
    terms = set(total.args)
    for term in total.args:
        for square in sp.Mul.make_args(term):
            base, power = square.as_base_exp()
            if power != 2 or not isinstance(base, (sp.sin, sp.cos)):
                continue
            rest, other = term / square, (sp.cos if isinstance(base, sp.sin) else sp.sin)(base.args[0]) ** 2
            if -rest in terms:
                return total - term + rest - rest * other
            if rest * other in terms:
                return total - term - rest * other + rest
    return None


def with_plain_numbers(expression: sp.Expr) -> sp.Expr:
    """Return an expression with its numbers multiplied out where that makes them shorter.

    >>> root = sp.sqrt(3)
    >>> with_plain_numbers(sp.Symbol("a1") - root * (sp.Rational(1, 20) - 9 * root / 40) / 2 + root / 40)
    a1 + 27/80
    """
    if not expression.args or expression.is_Function:
        return expression
    if expression.is_number:
        plain = sp.expand(expression)
        return plain if sp.count_ops(plain) < sp.count_ops(expression) else expression
    if expression.is_Add:
        number = sp.Add(*(term for term in expression.args if term.is_number))
        others = (with_plain_numbers(term) for term in expression.args if not term.is_number)
        return sp.Add(with_plain_numbers(number), *others)
    args = tuple(map(with_plain_numbers, expression.args))
    return expression if args == expression.args else expression.func(*args)


def _everywhere(expression: sp.Expr, once: Callable[[sp.Expr], sp.Expr | None]) -> sp.Expr:
    """Return an expression with each of its sums as `once` makes it, until that finds nothing any more."""
    if not expression.args or expression.is_Function:
        return expression
    args = tuple(_everywhere(arg, once) for arg in expression.args)
    whole = expression if args == expression.args else expression.func(*args)
    while whole.is_Add and (shorter := once(whole)) is not None:
        whole = shorter
    return whole


def _turned(angle: sp.Expr) -> bool:
    """Whether a constant that is no quarter turn is added to joint variables, whose sum is plain without it."""
    rest, turn = _taken_apart(angle)
    return turn != 0 and (turn / sp.pi).is_Rational and (joint_sum(rest) or joint_sum(-rest)) is not None


def _taken_apart(angle: sp.Expr) -> tuple[sp.Expr, sp.Expr]:
    """Return what joints turn of an angle, and the constant."""
    turn, rest = angle.as_independent(sp.Symbol, as_Add=True)
    return rest, turn


def _factors(term: sp.Expr) -> tuple[sp.Expr, list[sp.Expr]]:
    """Return the number before a term, with its roots, and the other factors."""
    number, rest = term.as_independent(sp.Symbol, as_Add=False)
    return number, list(sp.Mul.make_args(rest))


def _trigs(factors: list[sp.Expr]) -> Iterator[tuple[sp.Expr, sp.Expr]]:
    """Yield each sine or cosine among factors, and the product of the others."""
    for i, factor in enumerate(factors):
        if isinstance(factor, (sp.sin, sp.cos)) and factor.free_symbols:
            yield factor, sp.Mul(*factors[:i], *factors[i + 1 :])


def _one_turned_back(total: sp.Expr) -> sp.Expr | None:
    """Return a sum with some of its terms as one, or None where no angle makes them one."""
    groups: dict[tuple[sp.Expr, sp.Expr], list[tuple[sp.Expr, sp.Expr, sp.Expr]]] = {}
    for term in total.args:
        number, factors = _factors(term)
        for trig, others in _trigs(factors):
            rest, _ = _taken_apart(trig.args[0])
            groups.setdefault((rest, others), []).append((term, number, trig))
    for (rest, others), terms in groups.items():
        if len(terms) < 2 or not any(_turned(trig.args[0]) for *_, trig in terms):
            continue
        c, s = sp.S.Zero, sp.S.Zero
        for _, number, trig in terms:
            _, turn = _taken_apart(trig.args[0])
            cosine, sine = sp.cos(turn), sp.sin(turn)
            c += number * (cosine if isinstance(trig, sp.cos) else sine)
            s += number * (-sine if isinstance(trig, sp.cos) else cosine)
        c, s = sp.expand(c), sp.expand(s)
        if (c == 0 or s == 0) and not c.is_Add and not s.is_Add:
            one = (c * sp.cos(rest) + s * sp.sin(rest)) * others
            return total - sp.Add(*(term for term, *_ in terms)) + one
    return None


def _one_added_up(total: sp.Expr, is_said: IsSaid) -> sp.Expr | None:
    """Return a sum with two of its terms as one by an addition theorem, or None where none applies."""
    for use in _uses(total):
        if is_said(use.trig.args[0]):
            return total - sp.Add(*use.terms) + use.factor * use.trig
    return None


@dataclass(frozen=True)
class _Use:
    """Two terms of a sum that an addition theorem makes one, `factor` times `trig`.

    `theorem` is the function that comes out, and whether its angle is a difference, as in "cos-".
    """

    terms: tuple[sp.Expr, sp.Expr]
    factor: sp.Expr
    trig: sp.Expr
    theorem: str


def _uses(total: sp.Expr) -> Iterator[_Use]:
    """Yield the pairs of terms of a sum that an addition theorem makes one."""
    products: dict[tuple[frozenset[sp.Expr], sp.Expr], list[tuple[sp.Expr, sp.Expr, dict[sp.Expr, type]]]] = {}
    for term in sp.Add.make_args(total):
        number, factors = _factors(term)
        waves = [factor for factor in factors if isinstance(factor, (sp.sin, sp.cos)) and factor.free_symbols]
        for one, other in combinations(waves, 2):
            kinds = {one.args[0]: one.func, other.args[0]: other.func}
            left = sp.Mul(*(factor for factor in factors if factor not in (one, other)))
            if len(kinds) == 2:
                products.setdefault((frozenset(kinds), left), []).append((term, number, kinds))
    for (angles, left), terms in products.items():
        first, second = sorted(angles, key=sp.default_sort_key)
        for (term, number, kinds), (other, size, others) in combinations(terms, 2):
            if any(kinds[angle] is others[angle] for angle in angles) or number not in (size, -size):
                continue
            is_cosine = kinds[first] is kinds[second]  # cos cos and sin sin
            is_difference = (number == size) == is_cosine
            leading = number if kinds[first] is (sp.cos if is_cosine else sp.sin) else size
            function = sp.cos if is_cosine else sp.sin
            trig = function(first - second if is_difference else first + second)
            factor, made = trig.as_coeff_Mul()
            if made.free_symbols:
                theorem = f"{function.__name__}{'-' if is_difference else '+'}"
                yield _Use((term, other), leading * factor * left, made, theorem)


@dataclass(frozen=True)
class Theorem:
    """An addition theorem that is used: "cos-" and the like, and whether its angle has a "quarter" or "half" turn."""

    name: str
    turn: str


def theorem_used(line: sp.Expr, result: sp.Expr, meant: Callable[[sp.Expr], sp.Expr]) -> Theorem | None:
    """Return the one theorem by which a line becomes its result, both as they are shown; None where there are several.

    `meant` says what is shown of a sine or cosine of shown angles.
    """
    waves = result.atoms(sp.sin, sp.cos)
    used = []
    for use in _uses(sp.expand(line)):
        sign, shown = meant(use.trig).as_coeff_Mul()
        if shown in waves:
            is_sine = use.theorem.startswith("sin")
            is_half = not is_sine and sign.is_negative  # a minus before a sine: the angles change places
            turn = "quarter" if isinstance(shown, sp.sin) is not is_sine else "half" if is_half else ""
            used.append(Theorem(use.theorem, turn))
    return used[0] if len(set(used)) == 1 else None
