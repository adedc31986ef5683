"""Convert a problem to JSON for the site: its texts and figures, the data of the interactive arm, the keys for grading.

Texts that a page shows immediately have formulas as MathML, so that the page opens without typesetting. Hints and
solutions have LaTeX in `<span class="tex">`, or in `<div class="tex">` for displayed formulas. The page typesets them
later, because MathML would be ten times as long. `split_record` divides a record into the arm and each question.
"""

import html
import itertools
from collections.abc import Sequence
from typing import Any

import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.derivation.derivation import TooLong, derive
from qdot.exercises.figure.arm_figure import describe_part_figure, draw_figure_svg, draw_part_svg, find_figure_pose
from qdot.exercises.figure.pose import choose_example_values
from qdot.exercises.figure.words import describe_figure
from qdot.exercises.formula.printers.python import print_python
from qdot.exercises.mistakes.catalogue import CATALOGUE
from qdot.exercises.notebook.notebook import draw_singular_configurations
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.problem.record import Json, make_arm_json
from qdot.exercises.questions.inversion import list_table_lengths
from qdot.exercises.short_questions import question_of
from qdot.exercises.singularities.difficulty import rate_difficulty_level
from qdot.exercises.site.keys import make_key
from qdot.exercises.writing import problem_texts
from qdot.exercises.writing.custom_texts import translate_title
from qdot.exercises.writing.languages import ENGLISH, Catalogue, load_catalogue
from qdot.exercises.writing.latex import list_prismatic_joints, tex, write_symbol
from qdot.exercises.writing.markup import to_html

LENGTH_TOLERANCE, SHORTENING_FACTOR = 1e-9, 0.85
"""Difference in metres below which two lengths count as equal, and the factor that then shortens one of them."""


def make_site_record(problem: Problem) -> Json:
    """Return the record of a problem, without solutions.

    {"id", "family", "title", "difficulty": 0 to 4, "statement", "figure": svg, "alt", "robot": as in `qdot show`, with
    "values": {name: metres or radians} for the symbols in its table, "symbols": {name: {"role", "unit", "latex"}},
    "pose": {joint: rad or m}, the configuration in the figure,
    "parts": [{"name", "kind", "title", "type", "shape", "points", "prompt", "names", "labels", "columns",
    "grid": [[LaTeX labels of the rows], [of the columns]], "figure", "alt", "pose": the given joint values and lengths
    or null, "hints", "options", "key": as in `keys`, but each mistake as [index into "said", number, …], and each
    mistake that leads to an option as its index into "said"}],
    "said": [[name, title, sentence, missing symbols, if any]], one row for each mistake with a different sentence}
    """
    sentences = MistakeSentences()
    keys = [sentences.shorten_key(make_key(problem, part)) for part in problem.parts]
    return _make_record(problem, keys) | {"said": sentences.rows}


def make_asked_record(problem: Problem, has_hints: bool, language: str = ENGLISH) -> Json:
    """Return the record of a problem in a language, for a page whose answers are judged elsewhere.

    The record is as in `make_site_record`, but without "said" and without correct values. Each "key" has only the form
    of the answer: {"type", "units", "items": number of items to be matched}. A record in another language than English
    also has "lang".
    """
    record = _make_record(problem, [_describe_form(part) for part in problem.parts])
    if language != ENGLISH:
        texts = _translate_texts(problem, language)
        texts["parts"] = [part | text for part, text in zip(record["parts"], texts["parts"], strict=True)]
        record |= {"lang": language, "robot": record["robot"] | {"title": texts["title"]}, **texts}
    if not has_hints:
        record["parts"] = [part | {"hints": []} for part in record["parts"]]
    return record


_KEY_TYPES = {"number": "numbers", "singular": "configurations", "expression": "values", "matrix": "values"}
"""Maps each type of answer to the type of its key, unless both have the same name."""


def _describe_form(part: Part) -> Json:
    """Return the form of an answer, as in `make_asked_record`."""
    key_type = _KEY_TYPES.get(part.type, part.type)
    return {"type": key_type, "units": list(part.answer.expected_units), "items": len(part.answer.matched_items)}


def _make_record(problem: Problem, keys: Sequence[Json]) -> Json:
    """Return the record of a problem, as in `make_site_record`, with these keys and without "said"."""
    chain, statement = problem.chain, problem_texts.write_statement(problem, "", is_movable=True)
    parts = [_make_part_record(problem, part) | {"key": key} for part, key in zip(problem.parts, keys, strict=True)]
    return {
        "id": str(problem.id), "family": problem.id.family, "title": problem.title,
        "difficulty": rate_difficulty_level(chain), "statement": to_html(statement), "figure": draw_figure_svg(chain),
        "alt": describe_figure(chain), **make_arm_record(problem), "parts": parts,
    }  # fmt: skip


def make_arm_record(problem: Problem) -> Json:
    """Return the data of the interactive arm, as in `make_site_record`: {"robot", "symbols", "pose"}."""
    robot = {**make_arm_json(problem.chain), "values": _choose_values(problem.chain)}
    return {"robot": robot, "symbols": _list_symbols(problem), "pose": find_figure_pose(problem.chain)}


def split_record(record: Json, texts: Json, solutions: Json | None) -> dict[str, Json]:
    """Map the ending of each of a problem's file names ("" for the arm, else "/QUESTION") to the file's content.

    - `record`: the problem, as in `make_site_record`
    - `texts`: the same record, or its texts in another language
    - `solutions`: the worked solutions in the language of the texts; None if students may not see them

    A question is a part with {"said": {index: row} of the mistakes in its key, "solved": its solution}. The arm has the
    "factors" of det J.
    """
    arm = {name: value for name, value in texts.items() if name not in ("parts", "said")}
    files = {"": arm | {"factors": solutions["factors"]} if solutions and "factors" in solutions else arm}
    for index, (part, part_texts) in enumerate(zip(record["parts"], texts["parts"], strict=True)):
        rows = {str(row_index): texts["said"][row_index] for row_index in _list_sentence_indices(part["key"])}
        solution = {"solved": solutions["parts"][index]} if solutions else {}
        files[f"/{part['kind']}"] = {**part_texts, "said": rows, **solution}
    return files


def _list_sentence_indices(key: Json) -> list[int]:
    """Return the indices into "said" of all mistakes in an answer's key."""
    mistakes = [mistake for name in MISTAKE_LIST_NAMES for mistake in key.get(name, ())]
    return sorted({mistake[0] for mistake in mistakes} | set(itertools.chain(*key.get("option_mistakes", ()))))


def list_determinant_factors(chain: Chain) -> list[list[str]]:
    """Return the factors of det J with joint variables, each as HTML and in the notation for typing.

    Return an empty list if J is not square, or if det J is too long to be factored by hand.
    """
    derivation = derive(chain)
    if not derivation.is_square:
        return []
    try:
        (minor,) = derivation.symbolic_minors
    except TooLong:
        return []
    factors: list[list[str]] = []
    for factor, _ in minor.factors:
        _, shown_factor = derivation.substitute_values(factor).as_coeff_Mul()  # without the numeric coefficient
        if shown_factor.free_symbols & set(chain.q):
            factors.append([to_html(f"${tex(shown_factor, chain)}$"), print_python(shown_factor)])
    return factors


def translate_record(problem: Problem, record: Json, language: str) -> Json:
    """Return the texts of a problem in another language, which replace the texts in its `record`.

    {"title", "statement", "parts": [{"name", "title", "prompt", "hints", "options"}], "said": as in the record}
    """
    messages = load_catalogue(language)
    translated_sentences = [_translate_sentence(messages, *row) for row in record["said"]]
    return _translate_texts(problem, language) | {"said": translated_sentences}


def _translate_texts(problem: Problem, language: str) -> Json:
    """Return the texts of a problem in another language, as in `translate_record`, without "said"."""
    messages = load_catalogue(language)
    title = messages.translate_arm_title(problem.chain.title)
    parts = []
    for part in problem.parts:
        shown_hints = [write_html_with_latex(hint) for hint in problem_texts.write_hints(problem, part, language)]
        texts: Json = {"name": part.name, "title": translate_title(question_of(part), messages)}
        texts |= {"prompt": to_html(problem_texts.write_prompt(problem, part, language)), "hints": shown_hints}
        parts.append(texts | {"options": _list_options(problem, part, language)})
    html_statement = to_html(problem_texts.write_statement(problem, "", language=language, is_movable=True))
    return {"title": title[0].upper() + title[1:], "statement": html_statement, "parts": parts}


def translate_solutions(problem: Problem, language: str) -> Json:
    """Return the worked solutions in another language: {"parts": [{"name", "solution"}]}."""
    parts = [
        {"name": part.name, "solution": write_html_with_latex(problem_texts.write_solution(problem, part, language))}
        for part in problem.parts
    ]
    return {"parts": parts}


def _translate_sentence(messages: Catalogue, name: str, _: str, sentence: str, *missing: str) -> list[str]:
    """Return a row of `MistakeSentences` in another language."""
    mistake = CATALOGUE[name]
    translation = messages.translate_mistake_sentence(name, mistake.message, mistake.chapter_reference, sentence)
    return [name, messages.translate_mistake_title(name, mistake.title), translation, *missing]


def make_solutions_record(problem: Problem) -> Json:
    """Return the worked solutions, and the factors of det J, which would reveal some of them.

    {"id", "factors": as in `list_determinant_factors`, "parts": [{"name", "solution", "figure", "typed"}]}
    """
    parts = []
    for part in problem.parts:
        solution = write_html_with_latex(problem_texts.write_solution(problem, part))
        figure = draw_singular_configurations(problem, part, f"{part.name}-solution")
        typed_answer = problem_texts.write_answer_code(problem, part)
        parts.append({"name": part.name, "solution": solution, "figure": figure, "typed": typed_answer})
    return {"id": str(problem.id), "factors": list_determinant_factors(problem.chain), "parts": parts}


def write_html_with_latex(text: str) -> str:
    """Return Markdown as HTML, with formulas left as LaTeX."""
    return to_html(text, _make_latex_element, joins_punctuation=True)


def _make_latex_element(latex: str, is_displayed: bool) -> str:
    tag = "div" if is_displayed else "span"
    return f'<{tag} class="tex">{html.escape(latex)}</{tag}>'


def _list_symbols(problem: Problem) -> Json:
    """Map the name of each symbol to its role, its unit, its LaTeX and, if it is known, its value."""
    symbols: Json = {}
    for name, info in problem.symbols.items():
        latex = write_symbol(name, list_prismatic_joints(problem.chain))
        symbols[name] = {"role": info.role, "unit": info.unit, "latex": latex}
        if info.value is not None:
            symbols[name]["value"] = float(info.value)
    return symbols


def find_mentioned_names(problem: Problem, prompt_text: str) -> list[str]:
    """Return the names of rates, velocities and loads that a prompt mentions; the page has a button for each."""
    names = (name for name, info in problem.symbols.items() if info.role in ("rate", "velocity", "force", "moment"))
    return [name for name in names if f"`{name}`" in prompt_text]


def _choose_values(chain: Chain) -> Json:
    """Return the values of the symbolic lengths and angles of an arm, as in its figure.

    A length that equals another length is changed, because the statement says that all lengths are different.
    """
    used_lengths = {float(abs(length)) for length in list_table_lengths(chain)}
    values: dict[str, float] = {}
    for symbol, value in choose_example_values(chain).items():
        number = float(value)
        while any(abs(number - length) < LENGTH_TOLERANCE for length in used_lengths):
            number = round(SHORTENING_FACTOR * number, 3)
        values[symbol.name] = number
        used_lengths.add(number)
    return values


MISTAKE_LIST_NAMES = ("mistakes", "throughout", "precise")
"""The names of the lists of mistakes in a key for grading (`keys`)."""


class MistakeSentences:
    """Collects the sentences on mistakes, each only once, because many answers share a mistake.

    Each of the `rows` has a mistake's name, title and sentence, and the missing symbols, if any.
    """

    def __init__(self) -> None:
        self.rows: list[list[str]] = []
        self._indices: dict[tuple[str, ...], int] = {}

    def shorten_key(self, key: Json) -> Json:
        """Return a key for the bank, in which an index into `rows` replaces the texts of each mistake."""
        if "option_mistakes" in key:
            indices = [list(map(self._add_sentence, mistakes)) for mistakes in key["option_mistakes"]]
            return key | {"option_mistakes": indices}
        return key | {name: list(map(self._shorten_mistake, key[name])) for name in MISTAKE_LIST_NAMES if name in key}

    def _shorten_mistake(self, mistake: Json) -> list[Any]:
        """Return a mistake as the index of its sentence, followed by its fingerprint or its values."""
        return [self._add_sentence(mistake), *next(mistake[name] for name in ("print", "values") if name in mistake)]

    def _add_sentence(self, mistake: Json) -> int:
        """Return the index of a mistake's sentence in `rows`, which gets a new row if the sentence is new."""
        missing = [mistake["missing"]] if "missing" in mistake else []
        index = self._indices.setdefault((mistake["says"], *missing), len(self.rows))
        if index == len(self.rows):
            self.rows.append([mistake["name"], mistake["title"], mistake["says"], *missing])
        return index


def _make_part_record(problem: Problem, part: Part) -> Json:
    """Return the record of a part, as in `make_site_record`, without its key."""
    chain, question, prompt_text = problem.chain, question_of(part), problem_texts.write_prompt(problem, part)
    svg, hints = draw_part_svg(chain, part, part.name), problem_texts.write_hints(problem, part)
    return {
        "name": part.name, "kind": part.kind, "title": question.title, "type": part.type,
        "shape": part.shape and list(part.shape), "points": part.points, "prompt": to_html(prompt_text),
        "names": find_mentioned_names(problem, prompt_text), "labels": list(question.list_names_to_type(chain, part)),
        "columns": list(question.name_columns(chain)), "grid": _list_labels(chain, part), "figure": svg,
        "alt": describe_part_figure(chain, part) if svg else "", "pose": _find_given_pose(chain, part),
        "hints": list(map(write_html_with_latex, hints)), "options": _list_options(problem, part),
    }  # fmt: skip


def _list_labels(chain: Chain, part: Part) -> list[list[str]]:
    """Return the labels of an answer's rows and columns in LaTeX; empty if the prompt has no labels."""
    question = question_of(part)
    rows, columns = question.label_rows_and_columns(chain)
    if part.shape is not None and part.shape[1] == 1:
        names = question.name_entries(chain, part.details) or question.list_labels(chain)
        rows = [name for name in names if r"\text" not in name]  # words are in the prompt already
    return [[_write_label(name, chain) for name in rows], [_write_label(name, chain) for name in columns]]


def _write_label(name: str, chain: Chain) -> str:
    return name if "_" in name else tex(sp.Symbol(name), chain)


def _find_given_pose(chain: Chain, part: Part) -> dict[str, float] | None:
    """Return the joint values and lengths that a question gives, for the arm beside it; None if there are none."""
    shown_names = {symbol.name for symbol in (*chain.q, *choose_example_values(chain))}
    return {name: value for name, value in part.details.list_shown_values(chain).items() if name in shown_names} or None


def _list_options(problem: Problem, part: Part, language: str = ENGLISH) -> list[str] | None:
    """Return the options of a question as HTML, None for a question without options."""
    count = len(part.answer.offered_options)
    return [to_html(problem_texts.write_option(problem, part, index, language)) for index in range(count)] or None
