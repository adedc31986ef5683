r"""Formulas as the textbook prints them: c_1, s_{12}, decimals for lengths, dotted joint rates.

The order of terms and factors is decided here, by what a reader expects and never by SymPy's internal order: joint
angles before constants, a_1 + a_2 c_2 + a_3 c_{23} by the last joint that occurs, c_1 before the bracket that it
multiplies but \cos\varphi_1 behind it, rates and velocities behind their coefficients, by index.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache, lru_cache

import sympy as sp

from exercises.arm.chain import Chain
from exercises.formula.text import ByText

Key = tuple[object, ...]

_FUNCTIONS = {
    sp.sin: r"\sin", sp.cos: r"\cos", sp.tan: r"\tan", sp.asin: r"\arcsin", sp.acos: r"\arccos", sp.atan: r"\arctan",
    sp.atan2: r"\text{atan2}", sp.log: r"\ln", sp.exp: r"\exp", sp.sign: r"\text{sign}",
}  # fmt: skip
_NAMED = re.compile(r"(theta|alpha|beta|qd|[a-zA-Z])(\d*)")
_COMPONENT = re.compile(r"[vwfm][xyz]")
_RATE = re.compile(r"qd\d+")
_ANGLE = re.compile(r"\\varphi'*_\{(\d+)\}")
"""The name of a symbol that stands for an angle."""


@cache
def symbol_latex(name: str, prismatic: tuple[str, ...] = ()) -> str:
    r"""Return a symbol's LaTeX; `prismatic` are the numbers of the prismatic joints, whose rates are \dot d.

    >>> symbol_latex("theta12"), symbol_latex("qd2", ("2",)), symbol_latex("wx"), symbol_latex("fx")
    ('\\theta_{12}', '\\dot{d}_{2}', '\\omega_{x}', 'f_{x}')
    """
    if _COMPONENT.fullmatch(name):
        return (r"\omega" if name[0] == "w" else name[0]) + f"_{{{name[1]}}}"
    match = _NAMED.fullmatch(name)
    if match is None:
        return str(sp.latex(sp.Symbol(name)))
    letter, index = match.groups()
    if letter == "qd":
        letter = r"\dot{d}" if index in prismatic else r"\dot{\theta}"
    elif letter in ("theta", "alpha", "beta"):
        letter = "\\" + letter
    return f"{letter}_{{{index}}}" if index else letter


def decimal(value: sp.Expr) -> str | None:
    """Return a terminating decimal's digits, as in "0.35", or None for any other number."""
    if not value.is_Rational:
        return None
    denominator = int(value.q)
    for prime in (2, 5):
        while denominator % prime == 0:
            denominator //= prime
    if denominator != 1:
        return None
    if value.is_Integer:
        return str(value)
    return f"{float(value):.12f}".rstrip("0").rstrip(".")


# --- order ---


def natural(name: str) -> Key:
    """Return a key that sorts names by their letters, then by their numbers: a2 before a10."""
    match = re.fullmatch(r"(.*?)(\d*)", name)
    assert match is not None
    return (match.group(1), int(match.group(2) or -1))


def _wave_key(wave: sp.Expr) -> Key:
    """Sort sines and cosines by the last joint in them, by how many joints they sum, cosines first."""
    joints = sorted(joint for s in wave.args[0].free_symbols for joint in _joints(s))
    return (max(joints, default=0), -len(joints), joints, isinstance(wave, sp.sin), ByText(wave))


def _joints(symbol: sp.Symbol) -> list[int]:
    """Return the joint that a symbol belongs to, or those whose angles are summed in a named angle."""
    named = _ANGLE.fullmatch(symbol.name)
    return [int(digit) for digit in named.group(1)] if named else [_index(symbol)]


def _index(symbol: sp.Symbol) -> int:
    digits = re.sub(r"\D", "", symbol.name)
    return int(digits) if digits else 0


@lru_cache(maxsize=4096)
def _term_key(term: sp.Expr) -> Key:
    """Sort the terms of a sum: by rate or velocity, then by the sines and cosines in them, then by their symbols."""
    moving = sorted(_moving_key(s) for s in term.free_symbols if _moves(s))
    waves = sorted(_wave_key(wave)[:4] for wave in term.atoms(sp.sin, sp.cos))
    names = sorted(natural(s.name) for s in term.free_symbols)
    joint_first = not any(name[0] == "theta" for name in names)
    if not waves and not moving and names:
        return ([], [], joint_first, False, names, ByText(term))
    return (moving, waves, joint_first, term.is_number, names, ByText(term))


def _moves(symbol: sp.Symbol) -> bool:
    return bool(_RATE.fullmatch(symbol.name) or _COMPONENT.fullmatch(symbol.name))


def _moving_key(symbol: sp.Symbol) -> Key:
    order = ("vx", "vy", "vz", "wx", "wy", "wz")
    return (1, order.index(symbol.name)) if symbol.name in order else (0, _index(symbol))


def _factor_key(factor: sp.Expr) -> Key:
    r"""Sort the factors of a product: numbers, symbols, c_1 and s_1, brackets, \cos\varphi_1, rates and velocities."""
    base = factor.base if factor.is_Pow else factor
    if base.is_number:
        return (0, ByText(factor))
    if base.is_Symbol:
        return (5, _moving_key(base)) if _moves(base) else (1, natural(base.name))
    if isinstance(base, (sp.sin, sp.cos)):
        return (2 if joint_sum(base.args[0]) is not None else 4, _wave_key(base))
    return (3, base.is_Add, ByText(factor))


def _place_in_sum(term: sp.Expr, negative: bool) -> int:
    """Sort a sum of waves: constants that are added, the waves, constants that are subtracted."""
    if term.atoms(sp.sin, sp.cos) or any(map(_moves, term.free_symbols)):
        return 1
    return 2 if negative else 0


# --- printing ---


@dataclass(frozen=True)
class _Signed:
    """A printed term: whether it is subtracted, and its size."""

    negative: bool
    body: str


class _Printer:
    """Print SymPy trees; a term comes as sign and size, so that signs can be moved out of brackets and back."""

    def __init__(self, prismatic: tuple[str, ...]) -> None:
        self.prismatic = prismatic

    def text(self, expression: sp.Expr) -> str:
        terms = self.terms(expression)
        first = ("-" if terms[0].negative else "") + terms[0].body
        return first + "".join(f" {'-' if term.negative else '+'} {term.body}" for term in terms[1:])

    def terms(self, expression: sp.Expr, flip: bool = False) -> list[_Signed]:
        """Return the terms of a sum in reading order, with all signs changed if `flip`."""
        found = sorted(sp.Add.make_args(expression), key=_term_key)
        printed = [(term, self.product(term)) for term in found]
        if flip:
            printed = [(term, _Signed(not shown.negative, shown.body)) for term, shown in printed]
        if any(term.atoms(sp.sin, sp.cos) or any(map(_moves, term.free_symbols)) for term in found):
            # 0.12 + a_2 c_2, but a_1 c_1 - 0.6: a constant stands first unless it is subtracted
            printed.sort(key=lambda pair: _place_in_sum(pair[0], pair[1].negative))
        else:  # theta_2 - theta_1 + pi/3, d_2 + 0.33: numbers last, what is subtracted behind what is added
            printed.sort(key=lambda pair: (pair[0].is_number, pair[1].negative))
        return [shown for _, shown in printed]

    def product(self, expression: sp.Expr) -> _Signed:
        """Return a product, its sign outside and no bracket that starts with a minus where that can be helped."""
        if expression.is_Add:
            return _Signed(False, self.text(expression))
        coefficient, rest = expression.as_coeff_Mul()
        if rest == 1:
            return self.number(coefficient)
        negative = bool(coefficient.is_negative)
        above: list[sp.Expr] = []
        below: list[sp.Expr] = []
        for factor in sorted(sp.Mul.make_args(rest), key=_factor_key):
            if factor.is_Pow and factor.exp.could_extract_minus_sign():
                below.append(1 / factor)
            else:
                above.append(factor)
        flips, negative = self.signs(above + below, negative)
        up, down = self.coefficient(abs(coefficient), rest, bool(below))
        numerator = [*up, *self.factors(above, flips, alone=not up and len(above) == 1 and bool(below or down))]
        denominator = [*down, *self.factors(below, flips, alone=not down and len(below) == 1)]
        shown = " ".join(numerator) or "1"
        if not denominator:
            return _Signed(negative, shown)
        return _Signed(negative, self.fraction(shown, " ".join(denominator), rest.is_number))

    @staticmethod
    def fraction(numerator: str, denominator: str, small: bool) -> str:
        return rf"\{'tfrac' if small else 'frac'}{{{numerator}}}{{{denominator}}}"

    def signs(self, factors: Sequence[sp.Expr], negative: bool) -> tuple[set[sp.Expr], bool]:
        """Choose the brackets whose signs are changed, and return them with the sign that is left outside."""
        flips: set[sp.Expr] = set()
        for factor in factors:
            if not factor.is_Add:
                continue
            shown = self.terms(factor)
            if all(term.negative for term in shown) or (negative and shown[0].negative):
                flips.add(factor)
                negative = not negative
        return flips, negative

    def factors(self, factors: Sequence[sp.Expr], flips: set[sp.Expr], alone: bool) -> list[str]:
        """Return the printed factors; a sum is bracketed unless it stands alone above or below a fraction line."""
        shown = [self.factor(factor, factor in flips, alone) for factor in factors]
        for k, factor in enumerate(factors[:-1]):
            follows_angle = re.search(r"varphi'*_\{\d+\}$", shown[k]) is not None
            if follows_angle and any(map(_moves, factors[k + 1].free_symbols)) and factor.atoms(sp.sin, sp.cos):
                shown[k] += r"\,"  # \cos\varphi_1 \dot\theta_1 is not the cosine of a product
        return shown

    def factor(self, factor: sp.Expr, flip: bool = False, alone: bool = False) -> str:
        if factor.is_Add:
            terms = self.terms(factor, flip)
            first = ("-" if terms[0].negative else "") + terms[0].body
            inside = first + "".join(f" {'-' if term.negative else '+'} {term.body}" for term in terms[1:])
            return inside if alone else _bracketed(inside)
        if factor.is_Pow:
            return self.power(factor.base, factor.exp)
        if factor.is_Symbol:
            return symbol_latex(factor.name, self.prismatic)
        if factor is sp.pi:
            return r"\pi"
        if factor.is_number and factor.is_Rational:
            return self.number(factor).body
        if isinstance(factor, sp.Abs):
            return rf"\left|{self.text(factor.args[0])}\right|"
        if factor.func in _FUNCTIONS:
            return self.call(factor, "")
        return str(sp.latex(factor))

    def power(self, base: sp.Expr, exponent: sp.Expr) -> str:
        if exponent == sp.Rational(1, 2):
            return rf"\sqrt{{{self.text(base)}}}"
        if exponent.could_extract_minus_sign():
            return self.product(sp.Pow(base, exponent)).body
        if isinstance(base, (sp.sin, sp.cos, sp.tan)):
            return self.call(base, f"^{{{self.text(exponent)}}}")
        shown = self.factor(base)
        if base.is_Add or base.is_Symbol or (base.is_Integer and base > 0):
            return f"{shown}^{{{self.text(exponent)}}}"
        return f"{_bracketed(shown)}^{{{self.text(exponent)}}}"

    def call(self, expression: sp.Expr, power: str) -> str:
        word = _FUNCTIONS[expression.func]
        if isinstance(expression, (sp.sin, sp.cos)):
            short = joint_sum(expression.args[0])
            if short is not None:
                return f"{word[1]}_{{{short}}}{power}"
            if _ANGLE.fullmatch(str(expression.args[0])):
                return f"{word}{power} {expression.args[0]}"
        return f"{word}{power}{_bracketed(', '.join(self.text(arg) for arg in expression.args))}"

    def number(self, value: sp.Expr) -> _Signed:
        negative, size = bool(value.is_negative), abs(value)
        if size.is_Float:
            return _Signed(negative, _float_digits(size))
        if not size.is_Rational:
            return _Signed(False, self.factor(value))
        digits = decimal(size)
        if digits is not None:
            return _Signed(negative, digits)
        inverse = decimal(1 / size)
        shown = ("1", inverse) if inverse is not None and size > 1 else (str(size.p), str(size.q))
        return _Signed(negative, self.fraction(*shown, small=True))

    def coefficient(self, value: sp.Expr, rest: sp.Expr, is_fraction: bool) -> tuple[list[str], list[str]]:
        """Return what a number contributes above and below the line: 0.35 for 7/20, below the line for 20/7."""
        if value == 1:
            return [], []
        if not value.is_Rational:
            return [self.number(value).body], []
        direct, inverse = decimal(value), decimal(1 / value)
        if not (rest.is_number or rest.atoms(sp.Pow) & _roots(rest)):
            shorter = direct is None or (is_fraction and value > 1 and len(str(inverse)) <= len(direct))
            if inverse is not None and shorter:
                return [], [inverse]
            if direct is not None:
                return [direct], []
        return ([str(value.p)] if value.p != 1 else []), ([str(value.q)] if value.q != 1 else [])


def _roots(expression: sp.Expr) -> set[sp.Expr]:
    return {factor for factor in sp.Mul.make_args(expression) if factor.is_Pow and factor.is_number}


def _bracketed(inside: str) -> str:
    r"""Return text in brackets, that grow only where there is something tall inside."""
    if r"\frac" in inside or r"\sqrt" in inside:
        return rf"\left({inside}\right)"
    return f"({inside})"


def _float_digits(value: sp.Float) -> str:
    digits, _, power = f"{float(value):.10g}".partition("e")
    return rf"{digits} \cdot 10^{{{int(power)}}}" if power else digits


def joint_sum(angle: sp.Expr) -> str | None:
    """Return "12" for theta1 + theta2, and None for an angle that the shorthand can't say."""
    digits = []
    for term in sp.Add.make_args(angle):
        match = re.fullmatch(r"theta(\d)", str(term))
        if match is None:
            return None
        digits.append(match.group(1))
    return "".join(sorted(digits))


@dataclass(frozen=True)
class AngleNames:
    r"""Short names, as in \varphi_{12}, for angles that c_{12} can't say.

    `waves` says each sine and cosine with symbols of these names, `meanings` says what these symbols are.
    """

    waves: Mapping[sp.Expr, sp.Expr]
    meanings: Mapping[sp.Symbol, sp.Expr]


def angle_names(links: Sequence[sp.Expr], *matrices: sp.Matrix) -> AngleNames:
    r"""Name the angles in the sines and cosines of `matrices`, preferably as those of the links.

    SymPy has -cos(theta1 + pi/3) for cos(theta1 - 2 pi/3); where the latter is a link's angle, it is what is named.

    >>> t1, (a1, phi) = sp.Symbol("theta1"), sp.symbols(r"a1 \varphi_{1}")
    >>> names = angle_names([t1 - 2 * sp.pi / 3], sp.Matrix([a1 * sp.cos(t1 - 2 * sp.pi / 3)]))
    >>> names.meanings, (a1 * sp.cos(t1 - 2 * sp.pi / 3)).xreplace(names.waves) == a1 * sp.cos(phi)
    ({\varphi_{1}: theta1 - 2*pi/3}, True)
    """
    found = {wave.args[0] for matrix in matrices for wave in matrix.atoms(sp.sin, sp.cos)}
    waves: dict[sp.Expr, sp.Expr] = {}
    meanings: dict[sp.Symbol, sp.Expr] = {}
    for angle in sorted(found, key=lambda a: (len(a.free_symbols), ByText(a))):
        if joint_sum(angle) is not None or not angle.free_symbols:
            continue
        meaning, sense, rest = _as_link(angle, links) or (angle, 1, sp.S.Zero)
        name = next((symbol for symbol, other in meanings.items() if other == meaning), None) or _new(meaning, meanings)
        meanings[name] = meaning
        waves |= {wave(angle): wave(sense * name + rest) for wave in (sp.sin, sp.cos)}
    return AngleNames(waves, meanings)


def _as_link(angle: sp.Expr, links: Sequence[sp.Expr]) -> tuple[sp.Expr, int, sp.Expr] | None:
    """Return a link's angle, a sense and quarter turns that make up `angle`, or None."""
    for link in links:
        for sense in (1, -1):
            rest = sp.expand(angle - sense * link)
            if (2 * rest / sp.pi).is_Integer:
                return link, sense, rest
    return None


def _new(angle: sp.Expr, names: Mapping[sp.Symbol, sp.Expr]) -> sp.Symbol:
    name = rf"\varphi_{{{''.join(map(str, sorted(_index(symbol) for symbol in angle.free_symbols)))}}}"
    while sp.Symbol(name) in names:
        name = name.replace(r"\varphi", r"\varphi'", 1)
    return sp.Symbol(name)


def tex(expression: sp.Expr | sp.Matrix, chain: Chain | None = None, angles: AngleNames | None = None) -> str:
    r"""Return the LaTeX of an expression or matrix in the textbook's notation, with names for angles if given.

    >>> t1, t2, a1 = sp.symbols("theta1 theta2 a1")
    >>> tex(-a1 * sp.sin(t1) - sp.Rational(2, 5) * sp.cos(t1 + t2 + sp.pi / 6))
    '-a_{1} s_{1} - 0.4 \\cos(\\theta_{1} + \\theta_{2} + \\tfrac{\\pi}{6})'
    """
    prismatic = () if chain is None else tuple(q.name[1:] for q in chain.q if q.name.startswith("d"))
    expression = sp.sympify(expression)
    if angles is not None:
        expression = expression.xreplace(angles.waves)
    if not isinstance(expression, sp.MatrixBase):
        return _printed(expression, prismatic)
    rows = (" & ".join(_printed(entry, prismatic) for entry in expression.row(r)) for r in range(expression.rows))
    return r"\begin{bmatrix} " + r" \\ ".join(rows) + r" \end{bmatrix}"


@lru_cache(maxsize=1024)
def _printed(expression: sp.Expr, prismatic: tuple[str, ...]) -> str:
    """Return the LaTeX of an expression; kept, for many are shown again: in a step, its result, and another part."""
    return _Printer(prismatic).text(expression)


LINE = 64
"""Signs that a line of a formula may have before it is broken; a page takes some more, and a fraction counts less."""


def tex_lines(expression: sp.Expr, chain: Chain | None = None, angles: AngleNames | None = None) -> str:
    """Return the LaTeX of a sum for the right side of an aligned formula, broken between its terms where it is long."""
    lines, room = [""], LINE
    for term in re.split(r" (?=[+-] )", _outer(tex(expression, chain, angles))):
        size = len(re.sub(r"\\[a-z]+|[{}_^\\, ]", "", term))
        if lines[-1] and size > room:
            lines.append("")
            room = LINE
        lines[-1] = f"{lines[-1]} {term}".lstrip()
        room -= size
    return r" \\ & \quad ".join(line.replace(_HIDDEN, " ") for line in lines)


_HIDDEN = "\0"


def _outer(text: str) -> str:
    """Return a formula with the blanks inside brackets and braces hidden: what is left separates its terms."""
    depth, out = 0, []
    for sign in text:
        depth += (sign in "({") - (sign in ")}")
        out.append(_HIDDEN if sign == " " and depth else sign)
    return "".join(out)


def tex_length(value: sp.Expr) -> str:
    r"""Return a length for a table or sentence; one that ends in a number has its unit.

    >>> tex_length(sp.Symbol("d2") + sp.Rational(33, 100))
    'd_{2} + 0.33\\,\\text{m}'
    """
    value = sp.sympify(value)
    constant = sp.Add(*(term for term in sp.Add.make_args(value) if term.is_number))
    return tex(value) + (r"\,\text{m}" if constant != 0 and decimal(constant) is not None else "")


def tex_angle(value: sp.Expr) -> str:
    r"""Return an angle, constants in degrees.

    >>> tex_angle(sp.Symbol("theta2") + sp.pi / 2)
    '\\theta_{2} + 90^\\circ'
    """
    terms = sp.Add.make_args(sp.expand(value))
    constant = sp.Add(*(term for term in terms if term.is_number))
    rest = sp.expand(value - constant)
    degrees = sp.deg(constant)
    shown = decimal(abs(degrees)) if degrees.is_Rational else None
    if shown is None:  # an angle such as atan(4) or 0.7, which is no simple number of degrees
        return tex(value) + (r"\,\text{rad}" if constant.is_Rational else "")
    if rest == 0:
        return "0" if constant == 0 else f"{'-' if degrees < 0 else ''}{shown}^\\circ"
    if constant == 0:
        return tex(rest)
    return f"{tex(rest)} {'-' if degrees < 0 else '+'} {shown}^\\circ"
