"""Compare the two parsers of answers, Python's and the site's: the tree of each text, and the verdict on each answer.

`python -m tests.tools.readers --count 5000` generates texts and answers from what students write (the same ones in
every run), gives them to both parsers, and prints where these differ. Messages may differ; acceptance, trees and
verdicts may not. Python's results for texts chosen by hand are stored for the site's own tests (`site_corpus`).
"""

import argparse
import json
import math
import subprocess
import sys
import unicodedata
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cache
from itertools import product
from typing import Any
from unittest.mock import patch

import sympy as sp

from qdot.exercises.arm.chain import Chain, Joint
from qdot.exercises.common.stream import Stream
from qdot.exercises.formula.parser import parse_formula
from qdot.exercises.formula.trees import Node, ParseError
from qdot.exercises.formula.vocabulary import VOCABULARY
from qdot.exercises.problem.credit import Credit
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.reference_answers import ConditionSet
from qdot.exercises.short_questions import ALL_QUESTIONS
from qdot.exercises.site.keys import make_key
from qdot.exercises.site.record import make_arm_record
from qdot.grader.marking import partial_credit
from tests.support import DATA, ROOT, read_cases
from tests.support.judging import judge_with_credit
from tests.support.problems import ask_question, get_problem
from tests.support.programs import require_program
from tests.tools.fuzz import SYMBOL_SETS, TOKENS, load_seed_texts, mutate

NODE = "install Node 20.19 or later"
SITE = ROOT / "site"

_REVOLUTE_JOINTS = tuple(Joint("R", sp.Symbol(f"theta{i}"), 0, sp.Symbol(f"a{i}", positive=True), 0) for i in (1, 2))
FAMILIES = ("planar-2r", "planar-3r", "elbow-3r", "polar-rp", "scara", "wrist-zyz")
TEXTBOOK_QUESTIONS = ("position", "jacobian", "determinant", "singular-angles", "lost-direction", "rank")
"""Questions about the planar 2R arm, whose formulas are short and whose singular angles are 0 and pi."""
QUESTION_NAMES = (
    "position", "velocity-component", "jacobian", "determinant", "gram-determinant", "inverse-velocity", "joint-rates",
    "least-norm-rates", "rank", "manipulability", "lost-direction", "self-motion", "singular-angles", "joint-torques",
)  # fmt: skip
"""Questions whose answers are compared: some for each form of typed answer."""

Reading = tuple[str, int]
Answer = tuple[int, str, str]


@dataclass
class Query:
    """Texts with the index of their symbols, and answers with the index of their problem and the name of their part."""

    readings: list[Reading] = field(default_factory=list)
    answers: list[Answer] = field(default_factory=list)

    def as_json(self) -> dict[str, Any]:
        symbols = [sorted(symbol_set) for symbol_set in SYMBOL_SETS]
        problems = list_problem_records()
        return {"symbols": symbols, "readings": self.readings, "problems": problems, "answers": self.answers}


@cache
def list_problems() -> tuple[Problem, ...]:
    """Return the problems whose answers are compared, with the parts that are typed as formulas or numbers."""
    arms = [get_problem(family, 0) for family in FAMILIES]
    plain_problem = ask_question("position", Chain("plain 2R", _REVOLUTE_JOINTS, ("vx", "vy")))
    parts = tuple(part for name in TEXTBOOK_QUESTIONS for part in ask_question(name, plain_problem.chain).parts)
    parts_of_arms = [tuple(part for part in arm.parts if part.kind in QUESTION_NAMES) for arm in arms]
    problems = (replace(arm, parts=arm_parts) for arm, arm_parts in zip(arms, parts_of_arms, strict=True))
    return (replace(plain_problem, parts=parts), *problems)


@cache
def list_problem_records() -> list[dict[str, Any]]:
    return [
        {
            "id": f"{problem.chain.name} {problem.id}",
            "robot": make_arm_record(problem)["robot"],
            "parts": [make_part_record(problem, part) for part in problem.parts],
        }
        for problem in list_problems()
    ]


def make_part_record(problem: Problem, part: Part) -> dict[str, Any]:
    """Return a part in the form of the site's bank, with the fields that judging needs."""
    question, key = ALL_QUESTIONS[part.kind], make_key(problem, part, with_mistakes=False)
    labels, columns = list(question.list_names_to_type(problem.chain, part)), list(question.name_columns(problem.chain))
    return {"name": part.name, "kind": part.kind, "labels": labels, "columns": columns, "key": key}


# --- Python's reader ---


def write_tree(text: str, symbols: frozenset[str]) -> str | None:
    """Return the tree of a text in the form of `format_canonical`; None if the text is refused."""
    try:
        return format_canonical(parse_formula(text, symbols))
    except ParseError:
        return None


def format_canonical(tree: Node) -> str:
    """Return a tree as a text in the form (kind inner inner), with unchanged names and exact numbers.

    >>> format_canonical(parse_formula("2*a1 + sin(0.50)"))
    '(+ (* #2 a1) (call sin #5e-1))'
    """
    parts: list[str] = []
    unvisited_nodes: list[Node | None] = [tree]
    while unvisited_nodes:  # no recursion: a long sum is a deep tree
        node = unvisited_nodes.pop()
        if node is None:
            parts.append(")")
        elif node.kind == "name":
            parts.append(f" {node.value}")
        elif node.kind in ("number", "decimal"):
            parts.append(f" {_write_exact_number(node)}")
        else:
            parts.append(f" ({node.kind}{f' {node.value}' if node.kind == 'call' else ''}")
            unvisited_nodes += [None, *reversed(node.args)]
    return "".join(parts)[1:]


def _write_exact_number(node: Node) -> str:
    value: Fraction = node.value
    if node.kind == "number":
        return f"#{value.numerator}"
    digits, places = value.numerator, 0
    while digits % value.denominator:  # for a decimal, some power of ten gives an integer
        digits, places = digits * 10, places + 1
    digits //= value.denominator
    while digits and digits % 10 == 0:
        digits, places = digits // 10, places - 1
    return f"#{digits}e{-places if digits else 0}"


def judge_answer(problem: int, name: str, text: str) -> tuple[str, float]:
    """Return the outcome of an answer, and its share of the points under the default rules."""
    return judge_part(list_problems()[problem], find_part(problem, name), text, f"readers/{text!a}")


def judge_part(problem: Problem, part: Part, text: str, seed: str) -> tuple[str, float]:
    part_by_entries = replace(part, credit=Credit("entries"))  # the site gives no credit for factors or known mistakes
    with patch.object(partial_credit, "_credit_terms", return_value=None):  # nor for terms of sums
        judgement = judge_with_credit(problem, part_by_entries, text, seed)
    return judgement.outcome.value, round(judgement.share, 9)


def find_part(problem: int, name: str) -> Part:
    return next(part for part in list_problems()[problem].parts if part.name == name)


# --- the site's reader ---


def ask_site(query: Query) -> dict[str, Any]:
    """Return the results of the site's reader and grader from one Node process; skip the test without Node."""
    node = require_program("node", NODE)
    if not (SITE / "node_modules" / "vite").is_dir():
        require_program("the site's libraries", "cd site && npm ci")
    process = subprocess.run(
        [node, "tools/readings.mjs"], cwd=SITE, input=json.dumps(query.as_json()), capture_output=True, text=True
    )
    assert process.returncode == 0, process.stderr[-2000:]
    result: dict[str, Any] = json.loads(process.stdout)
    return result


def find_differences(query: Query) -> Iterator[str]:
    """Yield a line for each text and each answer on which the readers differ.

    If the browser accepts an answer but says that it is not sure, the grader may find the answer wrong.
    """
    site_result = ask_site(query)
    for (text, k), site_tree in zip(query.readings, site_result["readings"], strict=True):
        python_tree = write_tree(text, SYMBOL_SETS[k])
        if python_tree != site_tree:
            yield f"{text!a} with symbols {k}: Python {python_tree}, site {site_tree}"
    for (problem, name, text), site_verdict in zip(query.answers, site_result["verdicts"], strict=True):
        site_outcome, site_share, is_sure = site_verdict
        python_outcome, python_share = judge_answer(problem, name, text)
        is_unsure = site_outcome == "correct" and not is_sure and python_outcome in ("wrong", "partial")
        if is_unsure and not isinstance(find_part(problem, name).answer, ConditionSet):
            continue
        if (site_outcome, round(site_share, 6)) != (python_outcome, round(python_share, 6)):
            site_text = f"{site_outcome} {site_share:g}{'' if is_sure else ', unsure'}"
            results = f"Python {python_outcome} {python_share:g}, site {site_text}"
            yield f"{list_problems()[problem].id} {name} {text!a}: {results}"


# --- generating texts ---

TEXTS = json.loads((DATA / "typed_texts.json").read_text(encoding="utf-8"))
SETS, ANYTHING, LIMITS, WORDS, STARTS, ENDS = (
    TEXTS[name] for name in ("sets", "anything", "limits and former differences", "replacements", "starts", "ends")
)
"""Sets of configurations, which are wrong for most arms; answers to any question; limits; and changes in an answer."""

_NEAR_PI = (
    *(f"{turns * math.pi:.{digits}g}" for turns in (1, -1, 3) for digits in range(2, 18)),
    *(f"{degrees:.{digits}g}°" for degrees in (180.0, 179.99999, 179.9) for digits in (3, 8)),
    *(f"pi {sign} 1e-{power}" for sign in "+-" for power in range(2, 16)), "22/7", "355/113", "103993/33102",
    "3141592653589793/10**15", "0.5*2*pi", "1.5*2*pi/3", "acos(-1)", "2*acos(0)", "3.1416 rad", "180 deg", "π", "3.15",
)  # fmt: skip
_NEAR_ZERO = ("0.0", "-0", *(f"1e-{power}" for power in range(2, 17)), *(f"-2.5e-{power}" for power in range(2, 17)))
DECIMALS = (
    *(form.format(value) for value in _NEAR_PI for form in (
        "theta2=0, theta2={}", "theta2 = {}", "{{theta2: [{}, 0]}}", "theta2 = 0 or {}",
        "theta2 = 0, theta2 = {0}, theta1 = {0}",
    )),
    *(form.format(value) for value in _NEAR_ZERO for form in ("theta2 = {}, pi", "{{theta2: [3.14159265358979, {}]}}")),
)  # fmt: skip
"""Values of an angle in decimals and fractions: right, right except for rounding, and wrong."""


def make_query(count: int, seed: str) -> Query:
    """Return `count` texts, and a quarter as many answers, generated from what students write."""
    rng = Stream(f"readers/{seed}")
    texts = [text for text in (*load_seed_texts(), *list_known_texts()) if len(text) < 300]
    fixed_texts = (*list_known_texts(), *SETS, *ANYTHING)
    query = Query([(text, k) for text in fixed_texts for k in range(len(SYMBOL_SETS))][: count // 4])
    while len(query.readings) < count:
        text = rng.choice(texts) if rng.integer_below(3) else _combine_words(rng)
        for _ in range(rng.integer_below(3)):
            text = _replace_some(text, rng.choice(WORDS), rng)
        for _ in range(rng.integer_below(3)):
            text = mutate(text, rng, TOKENS, max_length=600)
        text += rng.choice(ENDS) if rng.integer_below(5) == 0 else ""
        query.readings.append((text, rng.integer_below(len(SYMBOL_SETS))))
    while len(query.answers) < count // 4:
        query.answers.append(_make_answer(rng))
    return query


def _combine_words(rng: Stream) -> str:
    """Return a random sequence of words and signs of the vocabulary, and of characters of all scripts."""
    return "".join(
        rng.choice(_list_all_words()) if rng.integer_below(12) else _choose_character(rng)
        for _ in range(1 + rng.integer_below(12))
    )


@cache
def _list_all_words() -> tuple[str, ...]:
    words = (word for name in VOCABULARY if name not in ("about", "patterns") for word in _list_words(VOCABULARY[name]))
    return (*TOKENS, *words)


def _list_words(table: Any) -> Iterator[str]:
    if isinstance(table, str):
        yield table if len(table) < 20 else ""
    elif isinstance(table, dict):
        yield from table
        yield from _list_words(list(table.values()))
    elif isinstance(table, list):
        for entry in table:
            yield from _list_words(entry)


def _choose_character(rng: Stream) -> str:
    """Return a character of Unicode 3.2, which every Python and every Node handles alike."""
    while True:
        character = chr(rng.integer_below(0x2300 if rng.integer_below(3) else 0xFFFF))
        if unicodedata.ucd_3_2_0.category(character) not in ("Cn", "Cs"):
            return character


def make_stored_query() -> Query:
    """Return the texts and answers whose trees and verdicts are stored for the site's own tests."""
    short_texts = [text for text in (*list_known_texts(), *load_seed_texts()) if len(text) < 300]
    texts = (*short_texts, *SETS, *ANYTHING, *LIMITS)
    query = Query([(text, k) for text in dict.fromkeys(texts) for k in range(len(SYMBOL_SETS))])
    for k, problem in enumerate(list_problems()):
        for part in problem.parts:
            right_texts = list_right_answers(k, part.name)
            answers = list(right_texts)
            if k == 0:
                answers += [*ANYTHING, *(right_texts[0].replace(old, new) for old, new in WORDS)]
                answers += [f"{start}{right_texts[0]}{end}" for start, end in product(STARTS[3:], ENDS[:2])]
            if isinstance(part.answer, ConditionSet):
                answers += (*SETS, *DECIMALS) if k == 0 else SETS[:: len(list_problems())]
            query.answers += [(k, part.name, text) for text in dict.fromkeys(answers)]
    return query


def list_known_texts() -> list[str]:
    notations = read_cases("notations")
    fixed_texts = [*notations["positions"], *notations["matrices"], *(text for text, _ in notations["refused"])]
    return [*fixed_texts, *(text for texts in notations["writings"].values() for text in texts)]


def _make_answer(rng: Stream) -> Answer:
    k = rng.integer_below(len(list_problems()))
    part = rng.choice(list_problems()[k].parts)
    is_set = isinstance(part.answer, ConditionSet)
    text = rng.choice(SETS) if is_set and rng.integer_below(3) else rng.choice(list_right_answers(k, part.name))
    if rng.integer_below(12) == 0:
        text = rng.choice(ANYTHING)
    for _ in range(rng.integer_below(3)):
        text = _replace_some(text, rng.choice(WORDS), rng)
    if rng.integer_below(4) == 0:
        text = rng.choice(STARTS) + text + rng.choice(ENDS)
    if rng.integer_below(4) == 0:
        text = mutate(text, rng, TOKENS, max_length=600)
    return (k, part.name, text)


def _replace_some(text: str, pair: Sequence[str], rng: Stream) -> str:
    old, new = pair
    count = text.count(old)
    if count == 0 or rng.integer_below(2):
        return text.replace(old, new)
    texts_between = text.split(old)
    index = 1 + rng.integer_below(count)
    return old.join(texts_between[:index]) + new + old.join(texts_between[index:])


@cache
def list_right_answers(problem: int, name: str) -> Sequence[str]:
    part = find_part(problem, name)
    texts = [part.answer.write_code(), part.answer.as_typed()]
    if isinstance(part.answer, ConditionSet):
        return [*texts, ", ".join(part.answer.list_pieces()), *part.answer.list_pieces()]
    if part.answer.is_symbolic:
        matrix = part.answer.as_matrix()
        texts.append(sp.latex(matrix if matrix.shape != (1, 1) else matrix[0, 0]))
    return list(dict.fromkeys(texts))


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=2000, help="number of texts; a quarter as many answers")
    parser.add_argument("--seed", default="1", help="another seed gives other texts")
    options = parser.parse_args()
    query = make_query(options.count, options.seed)
    lines = list(find_differences(query))
    sys.stdout.writelines(f"{line}\n" for line in lines)
    sys.stdout.write(f"{len(query.readings)} texts, {len(query.answers)} answers: {len(lines)} differences\n")
    return 1 if lines else 0


if __name__ == "__main__":
    sys.exit(main())
