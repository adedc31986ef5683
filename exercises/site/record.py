"""A problem as the site's bank holds it: what is shown, the arm as a browser moves it, and keys by which it grades.

What a page shows at once has its formulas as MathML, so that nothing is typeset while it opens. Hints and solutions
have LaTeX in `<span class="tex">` (`<div class="tex">` on lines of their own), which the page typesets: MathML would
be ten times as long. Solutions are a record of their own, loaded when asked for.
"""

import html
from typing import Any

import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.derivation import TooLong, derive
from qdot.exercises.arm.difficulty import step
from qdot.exercises.figure import alt_text, figure_pose, figure_svg, part_alt, part_svg
from qdot.exercises.figure.pose import example_values
from qdot.exercises.formula.printers.python import python_text
from qdot.exercises.mistakes.catalogue import CATALOGUE
from qdot.exercises.notebook.notebook import solution_figure
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.problem.record import Json, robot_json
from qdot.exercises.questions.inversion import lengths_in_table
from qdot.exercises.quizzes import ASKED
from qdot.exercises.site.keys import key_of
from qdot.exercises.writing.languages import ENGLISH, Catalogue, catalogue
from qdot.exercises.writing.latex import symbol_latex, tex
from qdot.exercises.writing.markup import to_html
from qdot.exercises.writing.statement import answer_code, hints, option_text, prompt, statement, worked_solution


def site_record(problem: Problem) -> Json:
    """Return a problem without its solutions.

    {"id", "family", "title", "difficulty": 0 to 4, "statement", "figure": svg, "alt", "robot": as in `qdot show`, with
    "values": {name: metres or radians} for the letters in its table, "symbols": {name: {"role", "unit", "latex"}},
    "pose": {joint: rad or m} in which the figure shows it,
    "parts": [{"name", "kind", "title", "type", "shape", "points", "prompt", "names", "labels", "columns",
    "grid": [[LaTeX of what a row belongs to], [of a column]], "figure", "alt", "pose": the joint values and lengths
    that it gives or null, "hints", "options", "key": as in `keys`, its mistakes as [index into "said", number, …], what
    is behind its options as such indices}],
    "said": [[name, title, sentence, symbols of what is missing, if it is that]]}
    """
    chain, said = problem.chain, Said()
    return {
        "id": str(problem.id),
        "family": problem.id.family,
        "title": problem.title,
        "difficulty": step(chain),
        "statement": to_html(statement(problem, "")),
        "figure": figure_svg(chain),
        "alt": alt_text(chain),
        **arm_record(problem),
        "parts": [_part(problem, part, said) for part in problem.parts],
        "said": said.rows,
    }


def arm_record(problem: Problem) -> Json:
    """Return what the live arm is drawn from, as in `site_record`: {"robot", "symbols", "pose"}."""
    return {
        "robot": {**robot_json(problem.chain), "values": _values(problem.chain)},
        "symbols": _symbols(problem),
        "pose": figure_pose(problem.chain),
    }


def determinant_factors(chain: Chain) -> list[list[str]]:
    """Return the factors of det J that a pose changes, each in HTML and as it can be typed.

    There are none where J is not square, or det J is too long to be factored by hand.
    """
    derivation = derive(chain)
    if not derivation.is_square:
        return []
    try:
        (minor,) = derivation.generic_minors
    except TooLong:
        return []
    factors: list[list[str]] = []
    for factor, _ in minor.factors:
        _, shown = derivation.fill(factor).as_coeff_Mul()  # no number or sign before what has to vanish
        if shown.free_symbols & set(chain.q):
            factors.append([to_html(f"${tex(shown, chain)}$"), python_text(shown)])
    return factors


def translated_record(problem: Problem, record: Json, language: str) -> Json:
    """Return the texts of a problem in another language, to be put in place of those in its `record`.

    {"title", "statement", "parts": [{"name", "title", "prompt", "hints", "options"}], "said": as in the record}
    """
    words = catalogue(language)
    title = words.arm_title(problem.chain.title)
    return {
        "title": title[0].upper() + title[1:],
        "statement": to_html(statement(problem, "", language=language)),
        "parts": [
            {
                "name": part.name,
                "title": words.question(ASKED[part.kind].title),
                "prompt": to_html(prompt(problem, part, language)),
                "hints": [page(hint) for hint in hints(problem, part, language)],
                "options": _options(problem, part, language),
            }
            for part in problem.parts
        ],
        "said": [_said_in(words, *row) for row in record["said"]],
    }


def translated_solutions(problem: Problem, language: str) -> Json:
    """Return the worked solutions in another language: {"parts": [{"name", "solution"}]}."""
    parts = [{"name": part.name, "solution": page(worked_solution(problem, part, language))} for part in problem.parts]
    return {"parts": parts}


def _said_in(words: Catalogue, name: str, _: str, sentence: str, *missing: str) -> list[str]:
    mistake = CATALOGUE[name]
    title = words.mistake_title(name, mistake.title)
    return [name, title, words.mistake_said(name, mistake.says, mistake.where, sentence), *missing]


def solutions_record(problem: Problem) -> Json:
    """Return the worked solutions, and of what det J is made, which would tell some of them.

    {"id", "factors": as in `determinant_factors`, "parts": [{"name", "solution", "figure", "typed"}]}
    """
    return {
        "id": str(problem.id),
        "factors": determinant_factors(problem.chain),
        "parts": [
            {
                "name": part.name,
                "solution": page(worked_solution(problem, part)),
                "figure": solution_figure(problem, part, f"{part.name}-solution"),
                "typed": answer_code(problem, part),
            }
            for part in problem.parts
        ],
    }


def page(text: str) -> str:
    """Return our Markdown as HTML with formulas left as LaTeX."""
    return to_html(text, _tex, whole=True)


def _tex(latex: str, block: bool) -> str:
    tag = "div" if block else "span"
    return f'<{tag} class="tex">{html.escape(latex)}</{tag}>'


def _symbols(problem: Problem) -> Json:
    prismatic = tuple(str(i) for i, joint in enumerate(problem.chain.joints, 1) if joint.kind == "P")
    symbols: Json = {}
    for name, info in problem.symbols().items():
        symbols[name] = {"role": info.role, "unit": info.unit, "latex": symbol_latex(name, prismatic)}
        if info.value is not None:
            symbols[name]["value"] = float(info.value)
    return symbols


def typed_names(problem: Problem, asked: str) -> list[str]:
    """Return the rates, velocities and forces that a prompt says an answer is in: a page offers signs of these."""
    roles = "rate", "velocity", "force"
    return [name for name, info in problem.symbols().items() if info.role in roles and f"`{name}`" in asked]


def _values(chain: Chain) -> Json:
    """Return numbers for the open lengths and angles of an arm, as it is drawn but for lengths that the table has, too.

    The statement says that none of them is equal.
    """
    taken = {float(abs(length)) for length in lengths_in_table(chain)}
    values: dict[str, float] = {}
    for symbol, value in example_values(chain).items():
        number = float(value)
        while any(abs(number - other) < SAME for other in taken):
            number = round(SHORTER * number, 3)
        values[symbol.name] = number
        taken.add(number)
    return values


LISTS = ("mistakes", "throughout", "precise")
"""Lists of mistakes in a key."""


class Said:
    """What is said of mistakes: each sentence once, for many answers are wrong in the same way."""

    def __init__(self) -> None:
        self.rows: list[list[str]] = []
        self._places: dict[tuple[str, ...], int] = {}

    def in_key(self, key: Json) -> Json:
        """Return a key as the bank has it: of each mistake an index in place of its words, and its numbers."""
        if "told" in key:
            return key | {"told": [[self._place(one) for one in behind] for behind in key["told"]]}
        lists = {name: [self._shortened(one) for one in key[name]] for name in LISTS if name in key}
        return key | lists

    def _shortened(self, mistake: Json) -> list[Any]:
        return [self._place(mistake), *next(mistake[name] for name in ("print", "values") if name in mistake)]

    def _place(self, mistake: Json) -> int:
        missing = [mistake["missing"]] if "missing" in mistake else []
        place = self._places.setdefault((mistake["says"], *missing), len(self.rows))
        if place == len(self.rows):
            self.rows.append([mistake["name"], mistake["title"], mistake["says"], *missing])
        return place


def _part(problem: Problem, part: Part, said: Said) -> Json:
    svg = part_svg(problem.chain, part, part.name)
    key = said.in_key(key_of(problem, part))
    asked = prompt(problem, part)
    return {
        "name": part.name,
        "kind": part.kind,
        "title": ASKED[part.kind].title,
        "type": part.type,
        "shape": None if part.shape is None else list(part.shape),
        "points": part.points,
        "prompt": to_html(asked),
        "names": typed_names(problem, asked),
        "labels": list(ASKED[part.kind].typed_labels(problem.chain, part)),
        "columns": list(ASKED[part.kind].columns(problem.chain)),
        "grid": _grid(problem.chain, part),
        "figure": svg,
        "alt": part_alt(problem.chain, part) if svg else "",
        "pose": _shown(problem.chain, part),
        "hints": [page(hint) for hint in hints(problem, part)],
        "options": _options(problem, part),
        "key": key,
    }


def _grid(chain: Chain, part: Part) -> list[list[str]]:
    """Return what the rows and the columns of an answer belong to, in LaTeX; nothing where the prompt tells none."""
    question = ASKED[part.kind]
    rows, columns = question.grid(chain)
    if part.shape is not None and part.shape[1] == 1:
        names = question.entry_names(chain, part) or question.labels(chain)
        rows = [name for name in names if r"\text" not in name]  # words of the prompt
    return [[_label(name, chain) for name in rows], [_label(name, chain) for name in columns]]


def _label(name: str, chain: Chain) -> str:
    return name if "_" in name else tex(sp.Symbol(name), chain)


SAME, SHORTER = 1e-9, 0.85
"""Metres below which two lengths are one, and what a letter's length is multiplied by where they are."""


def _shown(chain: Chain, part: Part) -> dict[str, float] | None:
    """Return what the arm beside a question is shown with: the joint values and letters of the table that it gives."""
    known = {symbol.name for symbol in (*chain.q, *example_values(chain))}
    return {name: value for name, value in part.details.shown_values(chain).items() if name in known} or None


def _options(problem: Problem, part: Part, language: str = ENGLISH) -> list[str] | None:
    count = len(part.answer.offered)
    return [to_html(option_text(problem, part, index, language)) for index in range(count)] or None
