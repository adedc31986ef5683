"""Write a student's answer for the feedback page: as text and, if possible, typeset as a formula.

The formula is what qdot parsed and judged. The page shows only the text of an answer that can't be parsed, is too long
or too deeply nested to be typeset, or is not a formula.
"""

import re
from dataclasses import dataclass

from qdot.exercises.common.errors import shorten
from qdot.exercises.formula.notation import find_units
from qdot.exercises.formula.parser import parse_formula
from qdot.exercises.formula.printers.mathml import print_mathml
from qdot.exercises.formula.program import compile_program, evaluate
from qdot.exercises.formula.trees import Node, count_nodes
from qdot.exercises.formula.units import parse_unit
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.reference_answers import LETTERS, TRUE_FALSE, Number
from qdot.exercises.writing.latex import list_prismatic_joints
from qdot.exercises.writing.line_breaking import estimate_width, fit_formula
from qdot.exercises.writing.markup import to_html
from qdot.exercises.writing.problem_texts import write_option
from qdot.exercises.writing.typeset import TooDeep, typeset
from qdot.grader.judging.answer_parser import ParsedAnswer
from qdot.grader.judging.expected_form import read_answer
from qdot.grader.judging.functions import FUNCTION_TEXT

MAX_TYPESET_CHARACTERS, MAX_TYPESET_NODES = 4000, 2000
"""Maximum numbers of characters and of tree nodes that are typeset; a larger formula would be unreadable."""
MAX_SHOWN_CHARACTERS = 2000
"""Maximum number of characters shown of an answer's text."""
MAX_FORMULA_WIDTH = 40.0
"""Maximum width of a formula on the page, in em; a wider formula is broken into lines or, if need be, scrolls."""
MIN_FORMULA_SIZE = 80
"""Minimum size of a wide formula, as a percentage of the normal size, before it scrolls."""

MAX_ROUNDED_LENGTH = 12
"""A long decimal is shown rounded to 14 significant digits if, without trailing zeros, it then has at most this many
characters."""

_LONG_DECIMAL = re.compile(r"(?<![\w.])\d{1,6}\.\d{15,19}(?![\w.])")
_NAMESPACE = ' xmlns="http://www.w3.org/1998/Math/MathML"'
FORMULA_TYPES = ("expression", "matrix", "singular", "number", "direction")
"""The types of answers that are formulas; others are shown as text."""

# ASCII controls become Unicode's pictures of them; other controls, lone surrogates and non-characters become "�".
_VISIBLE_CONTROLS = {code: 0x2400 + code for code in range(32) if chr(code) not in "\t\n"} | {0x7F: 0x2421}
_VISIBLE_CONTROLS |= dict.fromkeys((*range(0x80, 0xA0), *range(0xD800, 0xE000), 0xFFFE, 0xFFFF), 0xFFFD)


@dataclass(frozen=True)
class ShownAnswer:
    """An answer on the page, as HTML and as text; one of them is empty if the other suffices.

    `is_verbatim` is False if the text is qdot's description of a function instead of the student's text.
    """

    text: str
    html: str = ""
    is_verbatim: bool = True


def show_answer(problem: Problem, part: Part, text: str) -> ShownAnswer:
    """Return an answer as text and, if possible, as the parsed formula or the chosen options."""
    readable_text = text if len(text) > MAX_TYPESET_CHARACTERS else _hide_rounding_errors(text)
    visible_text = make_visible(shorten(readable_text, MAX_SHOWN_CHARACTERS))
    if readable_text == FUNCTION_TEXT:
        return ShownAnswer(visible_text, is_verbatim=False)
    if part.answer.offered_options:
        options = _write_chosen_options(problem, part, readable_text)
        is_letter = len(readable_text) == 1  # the option's HTML begins with it, too
        return ShownAnswer("" if options and is_letter else visible_text, options)
    if part.type not in FORMULA_TYPES or len(readable_text) > MAX_TYPESET_CHARACTERS:
        return ShownAnswer(visible_text)
    parsed = read_answer(problem, part, readable_text)
    is_number = part.type == Number.type and parsed.refusal is None
    tree = _convert_to_si_units(parsed) if is_number else parsed.tree
    try:
        return ShownAnswer(visible_text, "" if tree is None else _typeset_html(problem, part, tree))
    except TooDeep:
        return ShownAnswer(visible_text)


def _convert_to_si_units(parsed: ParsedAnswer) -> Node | None:
    """Return the tree of a numeric answer, with values such as 17 cm/s converted to SI units."""
    units = [parse_unit(unit) for _, unit, _ in find_units(parsed.text)]
    if any(parsed.is_blank) or not any(unit is not None and unit.conversion for unit in units):
        return parsed.tree
    values = evaluate(compile_program(parsed.entries), {}, 1).values[:, 0].real
    numbers = [f"{value:.6g}" for value in values]
    return parse_formula(numbers[0] if len(numbers) == 1 else f"[{', '.join(numbers)}]")


def _hide_rounding_errors(text: str) -> str:
    """Return an answer without the rounding errors that Python added to its decimals when it ran the notebook.

    >>> _hide_rounding_errors("a1 + 0.12249999999999998 + 3.14159265358979")
    'a1 + 0.1225 + 3.14159265358979'
    """

    def round_decimal(match: re.Match[str]) -> str:
        rounded_text = f"{float(match[0]):.14g}"
        return rounded_text if len(rounded_text) <= MAX_ROUNDED_LENGTH and "e" not in rounded_text else match[0]

    return _LONG_DECIMAL.sub(round_decimal, text)


def make_visible(text: str) -> str:
    """Return a text with visible symbols instead of control characters, so that the text can stand on any page."""
    return text.translate(_VISIBLE_CONTROLS)


def _typeset_html(problem: Problem, part: Part, node: Node) -> str:
    """Return a parsed answer as MathML. Raises TooDeep if the answer is too long or too deeply nested."""
    if count_nodes(node) > MAX_TYPESET_NODES:
        raise TooDeep("the answer is too long to be typeset")
    formula = typeset(node, list_prismatic_joints(problem.chain), part.answer.is_set, part.answer.expected_units)
    fitted_layout = fit_formula(formula, MAX_FORMULA_WIDTH)
    size = max(MIN_FORMULA_SIZE, min(100, int(100 * MAX_FORMULA_WIDTH / max(estimate_width(fitted_layout), 1.0))))
    mathml = print_mathml(fitted_layout, is_displayed=True, percent=size)
    # Write characters instead of character references, and drop an <mrow> around a single element.
    mathml = re.sub(r"&#x0*([0-9A-F]{3,5});", lambda code: chr(int(code[1], 16)), mathml)
    return re.sub(r"<mrow>(<m[ino]>[^<]*</m[ino]>)</mrow>", r"\1", mathml.replace(_NAMESPACE, "", 1))


def _write_chosen_options(problem: Problem, part: Part, text: str) -> str:
    """Return, as HTML, the options that a student chose, with their letters (and items in a matching question)."""
    indices, items = list(read_answer(problem, part, text).chosen_indices), part.answer.matched_items
    prefixes = [f"{item}: " for item in items]
    if len(indices) != len(items):  # the question has no items, or the student did not match all of them
        indices = list(dict.fromkeys(indices))
        prefixes = [""] * len(indices)
    if part.answer.offered_options == TRUE_FALSE:
        return "".join(TRUE_FALSE[index] for index in indices)
    pairs = zip(prefixes, indices, strict=True)
    return "".join(to_html(f"{prefix}**{LETTERS[k]}.** {write_option(problem, part, k)}") for prefix, k in pairs)
