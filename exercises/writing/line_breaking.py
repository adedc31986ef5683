r"""Estimate the width of formulas, and break wide formulas into several lines to fit a page.

Equations that are separated by \qquad get a line each, and so do the right sides after several equals signs. If a line
is still too wide, products are broken at a multiplication sign, and sums before a plus or minus. Wide entries of a
matrix get names, which are explained below the matrix.
"""

from collections.abc import Sequence
from functools import lru_cache
from itertools import chain, pairwise, zip_longest

from qdot.exercises.formula import layout
from qdot.exercises.formula.layout import Layout, Pieces, make_row

Lines = list[Pieces]
EquationSides = list[tuple[Pieces, Pieces]]
"""Lines of equations, each as its left side (empty on continued lines) and its right side with the equals sign."""
EntryNames = dict[Pieces, Pieces]
"""Maps entries of the matrices in a formula to their names."""

OPERATOR_WIDTHS = {"=": 1.05, "+": 0.95, "−": 0.95, "×": 0.95, "≠": 1.05, "≈": 1.05, ",": 0.45, "det": 1.2}
"""Widths of operators, including the space around them; all widths are in em."""
LETTER_WIDTHS = {**dict.fromkeys("mwMWOθωφψ", 0.8), **dict.fromkeys("ijlt.'|()[]", 0.33), ",": 0.45}
"""Widths of wide and narrow letters."""
LETTER_WIDTH, SIGN_WIDTH, SCRIPT_SCALE, COLUMN_GAP = 0.54, 0.4, 0.71, 0.85
"""The widths of other letters and signs, the size of scripts and of entries relative to the formula, and the gap
between columns."""
FRACTION_MARGIN, ROOT_WIDTH, FUNCTION_MARGIN = 0.2, 0.9, 0.17
"""Widths added to a fraction for its bar, to a root for its sign, and to a function's name for the space around it."""
INDENT_WIDTH = 1.0
"""Width of the space, or of the equals sign, before a broken line."""
MAX_OVERWIDTH = 1.2
"""A term is broken inside brackets only if it is more than this many times as wide as a line; else it is shrunk."""
MAX_BRACKET_DEPTH = 4
"""Maximum depth of nested brackets inside which a sum may be broken."""
MAX_UNBREAKABLE_SHARE = 0.6
"""Maximum width of an unbreakable piece of an inline formula, as a fraction of the line's width."""
_CROSS, _OPEN, _CLOSE = (Layout("sign", sign) for sign in "×()")


@lru_cache(maxsize=2048)
def estimate_width(formula: Layout, scale: float = 1.0) -> float:
    r"""Return the estimated width of a formula in em; fractions, which are smaller in a matrix, are scaled by `scale`.

    >>> from qdot.exercises.formula.latex import parse_latex
    >>> letter, half, total = map(parse_latex, (r"a_{1}", r"\frac{a_{1}}{2}", r"a_{1} + a_{2}"))
    >>> estimate_width(letter) < estimate_width(half) + 0.3 < estimate_width(total)
    True
    """
    kind, text, inner = formula
    if kind == "row":
        return _add_widths(inner, scale)
    if kind == "script":
        return estimate_width(inner[0]) + SCRIPT_SCALE * max(estimate_width(inner[1]), estimate_width(inner[2]))
    if kind == "fraction":
        return FRACTION_MARGIN + scale * max(estimate_width(inner[0], scale), estimate_width(inner[1], scale))
    if kind == "accent":
        return estimate_width(inner[0])
    if kind in ("matrix", "aligned"):
        cell_size, brackets = (SCRIPT_SCALE, 2 * SIGN_WIDTH) if kind == "matrix" else (1.0, 0.0)
        rows = ([estimate_width(cell, cell_size) for cell in cells.inner] for cells in inner)
        return brackets + sum(max(column) + COLUMN_GAP for column in zip_longest(*rows, fillvalue=0.0))
    if kind in ("root", "fenced"):
        sign_width = ROOT_WIDTH if kind == "root" else SIGN_WIDTH * len(text.replace(".", ""))
        return estimate_width(inner[0], scale) + sign_width
    return _estimate_leaf_width(kind, text)


def is_too_wide_inline(formula: Layout, max_width: float) -> bool:
    """Return whether an inline formula has a piece, such as a fraction, too wide for lines of `max_width` (em)."""
    return any(estimate_width(piece) > MAX_UNBREAKABLE_SHARE * max_width for piece in formula.inner)


def is_taller_than_line(formula: Layout) -> bool:
    """Return whether a formula is higher than a line of text because it has a fraction, a root or tall brackets."""
    return formula.kind in ("fraction", "fenced", "root") or any(map(is_taller_than_line, formula.inner))


def _add_widths(pieces: Sequence[Layout], scale: float = 1.0) -> float:
    return sum(estimate_width(piece, scale) for piece in pieces)


@lru_cache(maxsize=2048)
def _estimate_leaf_width(kind: str, text: str) -> float:
    if kind == "space":
        return layout.SPACES[text]
    if kind == "sign" or text in OPERATOR_WIDTHS:
        return OPERATOR_WIDTHS.get(text, SIGN_WIDTH)
    margin = FUNCTION_MARGIN if kind == "function" else 0.0
    return margin + sum(LETTER_WIDTHS.get(letter, LETTER_WIDTH) for letter in text)


def fit_formula(formula: Layout, max_width: float) -> Layout:
    """Return a displayed formula; if it is wider than `max_width` (em), it is broken into lines as far as possible."""
    if estimate_width(formula) <= max_width:
        return formula
    rows = _split_equations(formula, max_width)
    left_width = max(_add_widths(left) for left, _ in rows)  # the right sides are aligned below each other
    names: EntryNames = {}
    lines = [line for left, right in rows for line in _break_equation(left, right, max_width - left_width, names)]
    cells = tuple(make_row(make_row(*left), make_row(*right)) for left, right in lines)
    return make_row(Layout("aligned", "apart" if len(lines) > 1 else "", cells))


def _split_equations(formula: Layout, max_width: float) -> EquationSides:
    """Return the equations in a formula; equations on the same line of an aligned formula stay together if they fit."""
    if len(formula.inner) != 1 or formula.inner[0].kind != "aligned":
        return [_split_at_equals(piece) for piece in layout.split_at(formula.inner, layout.QQUAD)]
    rows: EquationSides = []
    for line in formula.inner[0].inner:
        cells = [cell.inner for cell in line.inner]
        pairs = list(zip(cells[::2], cells[1::2], strict=False)) or [((), cells[0])]  # a single cell is a right side
        left, right = pairs[0]
        if not left and right[:1] != (layout.EQUALS,) and rows:  # a line that continues the previous sum
            rows[-1] = (rows[-1][0], (*rows[-1][1], *(right[1:] if right[:1] == (layout.QUAD,) else right)))
            continue
        joined_equations = layout.join_pieces((layout.QUAD,), [(*a, *b) for a, b in pairs])
        if len(pairs) > 1 and _add_widths(joined_equations) <= max_width - 2 * INDENT_WIDTH:
            pairs = [(left, joined_equations[len(left) :])]
        rows += pairs
    return rows


def _split_at_equals(equation: Pieces) -> tuple[Pieces, Pieces]:
    left, *right_sides = layout.split_at(equation, layout.EQUALS)
    return (left, (layout.EQUALS, *layout.join_pieces((layout.EQUALS,), right_sides))) if right_sides else ((), left)


def _break_equation(left: Pieces, right: Pieces, max_width: float, names: EntryNames) -> EquationSides:
    """Return the lines of an equation whose right side may be `max_width` (em) wide."""
    if _add_widths(right) <= max_width - INDENT_WIDTH:
        return [(left, right)]
    sign = right[:1] if right[:1] == (layout.EQUALS,) else ()
    available_width = max_width - (2 if sign else 1) * INDENT_WIDTH
    lines: EquationSides = []
    for index, side in enumerate(layout.split_at(right[1:], layout.EQUALS) if sign else [right]):
        broken_lines = _break_side(side, available_width, names)
        lines.append((() if index else left, (*sign, *broken_lines[0])))
        lines += [((), (layout.QUAD, *line)) for line in broken_lines[1:]]
    return lines


def _break_side(side: Pieces, max_width: float, names: EntryNames) -> Lines:
    """Return a side of an equation, broken into lines between factors, before signs or inside matrices.

    `names` are the names that entries of matrices have in the whole formula; new names are added.
    """
    if _add_widths(side) <= max_width:
        return [side]
    for factors, sign in ((layout.split_at(side, _CROSS), _CROSS), (_split_matrices(side), layout.DOT)):
        if len(factors) > 1:
            # 1.5 em are for the sign and the space around it
            lines_by_factor = [_break_side(factor, max_width - 1.5, names) for factor in factors]
            continued_lines = ([(layout.EMPTY, sign, *lines[0]), *lines[1:]] for lines in lines_by_factor[1:])
            return [*lines_by_factor[0], *chain.from_iterable(continued_lines)]
    terms = layout.split_terms(side)
    lines = _break_fraction(side, max_width) if len(terms) == 1 else []
    if not lines and (len(terms) == 1 or any(_is_wide_matrix(piece, max_width) for piece in side)):
        lines = _name_entries(side, max_width, names)
    return lines or fill_lines(_split_wide_terms(terms, max_width), max_width)


def _split_matrices(product_pieces: Pieces) -> Lines:
    """Split a product of matrices into factors that each end with a matrix; return other formulas unsplit."""
    ends = [k + 1 for k, piece in enumerate(product_pieces) if _find_matrix(piece)][:-1]
    return [product_pieces[start:end] for start, end in pairwise((0, *ends, len(product_pieces)))]


def _is_wide_matrix(piece: Layout, max_width: float) -> bool:
    return _find_matrix(piece) is not None and estimate_width(piece) > max_width


def _find_matrix(piece: Layout) -> Layout | None:
    """Return the matrix if a piece is a matrix or a power of a matrix; otherwise None."""
    base = layout.get_script_base(piece)
    return base if base.kind == "matrix" else None


def _break_fraction(formula_pieces: Pieces, max_width: float) -> Lines:
    """Return the lines of a wide fraction, as 1 over the denominator times the numerator; none for other formulas."""
    sign_count = 1 if formula_pieces[:1] == (layout.MINUS,) else 0
    sign, unsigned_pieces = formula_pieces[:sign_count], formula_pieces[sign_count:]
    if len(unsigned_pieces) != 1 or unsigned_pieces[0].text != "frac":
        return []
    numerator, denominator = (side.inner for side in unsigned_pieces[0].inner)
    factor = Layout("number", "1")
    is_bracketed = len(numerator) > 3 and (numerator[1], numerator[-1]) == (_OPEN, _CLOSE)
    if is_bracketed and numerator[0].kind == "number":  # 0.5 (a + b)
        factor, numerator = numerator[0], numerator[2:-1]
    first_line, *other_lines = fill_lines(layout.split_terms(numerator), max_width - _add_widths(denominator))
    opening_pieces = (*sign, layout.make_fraction((factor,), denominator), _OPEN)
    return [(*opening_pieces, *first_line), *other_lines[:-1], (*other_lines[-1], _CLOSE)] if other_lines else []


def _split_wide_terms(terms: Sequence[Pieces], max_width: float) -> list[Pieces]:
    """Return terms; terms that are too wide are split inside their outer brackets, and then inside inner brackets."""
    narrow_terms: list[Pieces] = []
    for term in terms:
        pieces, inner_terms = term, [term]
        for depth in range(1, MAX_BRACKET_DEPTH + 1):
            if all(_add_widths(inner_term) <= MAX_OVERWIDTH * max_width for inner_term in inner_terms):
                break
            pieces = _open_brackets(pieces, max_width)
            inner_terms = layout.split_terms(pieces, depth)
        narrow_terms += inner_terms
    return narrow_terms


def _open_brackets(pieces: Pieces, max_width: float) -> Pieces:
    """Replace wide brackets that grow with their content by plain brackets, inside which a line can be broken."""
    opened_pieces: list[Layout] = []
    for piece in pieces:
        if piece.kind == "fenced" and piece.text == "()" and estimate_width(piece) > max_width / 2:
            opened_pieces += (_OPEN, *_open_brackets(layout.list_row_pieces(piece.inner[0]), max_width), _CLOSE)
        else:
            opened_pieces.append(piece)
    return tuple(opened_pieces)


def fill_lines(terms: Sequence[Pieces], max_width: float) -> Lines:
    """Return lines of terms, each filled as far as `max_width` (em) permits."""
    lines, line_width = [terms[0]], _add_widths(terms[0])
    for term in terms[1:]:
        term_width = _add_widths(term)
        if line_width + term_width <= max_width - INDENT_WIDTH:
            lines[-1] += term
            line_width += term_width
        else:
            lines.append((layout.EMPTY, *term))
            line_width = term_width
    return lines


def _name_entries(side: Pieces, max_width: float, names: EntryNames) -> Lines:
    """Return the lines of a wide matrix with names m_1, m_2, … for its wide entries, and of these entries.

    Returns no lines if the side has no matrix or no wide entry.
    """
    index = next((k for k, piece in enumerate(side) if _find_matrix(piece)), None)
    if index is None:
        return []
    matrix_piece = side[index]
    matrix = _find_matrix(matrix_piece)
    assert matrix is not None
    rows = [[cell.inner for cell in cells.inner] for cells in matrix.inner]
    new_names: EntryNames = {}
    for entry in (entry for cells in rows for entry in cells):
        if _add_widths(entry) > max_width / (len(rows[0]) + 1) and entry not in names:
            subscript = make_row(*layout.make_digits(str(len(names) + 1)))
            names[entry] = new_names[entry] = (layout.make_script(Layout("letter", "m"), subscript),)
    if not any(entry in names for cells in rows for entry in cells):
        return []
    named_matrix = layout.make_matrix([[names.get(entry, entry) for entry in cells] for cells in rows], matrix.text)
    is_power = matrix_piece.kind == "script"
    named_piece = layout.make_script(named_matrix, *matrix_piece.inner[1:]) if is_power else named_matrix
    lines = _break_side((*side[:index], named_piece, *side[index + 1 :]), max_width, names)
    for entry, name in new_names.items():
        entry_width = max_width - 4.0  # the name and the equals sign are narrower
        first_line, *other_lines = _break_side(entry, entry_width, names)
        lines += [(*name, layout.EQUALS, *first_line), *((layout.QUAD, *line) for line in other_lines)]
    return lines
