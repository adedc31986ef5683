"""The feedback page: it shows every outcome, is accessible, and is safe for any answer."""

import re
import time
import xml.etree.ElementTree as ET
from collections import Counter
from collections.abc import Callable
from dataclasses import fields, replace
from html.parser import HTMLParser
from itertools import pairwise
from pathlib import Path

import pytest
import sympy as sp

from qdot.exercises.arm.chain import CONVENTIONS
from qdot.exercises.assignment.assignment import Assignment, Student
from qdot.exercises.formula.equality import EntryDifference, SetDifference
from qdot.exercises.generation import generate
from qdot.exercises.problem.problem import Problem
from qdot.exercises.reference_answers import Choice, Matrix
from qdot.exercises.writing.markup import to_html
from qdot.exercises.writing.problem_texts import write_prompt
from qdot.exercises.writing.render import find_template_folder
from qdot.grader.grading.attempt import make_part_result
from qdot.grader.grading.result import CountingSubmission, Override, ProblemResult, Result
from qdot.grader.judging.functions import FUNCTION_TEXT
from qdot.grader.judging.verdict import Outcome
from qdot.grader.marking.marking import WRONG_OR_PARTIAL, mark, sum_points
from qdot.grader.reports.answer_display import show_answer
from qdot.grader.reports.counterexample_table import format_decimal, make_counterexample_table
from qdot.grader.reports.feedback import compute_page_fingerprint, make_feedback_page
from qdot.grader.reports.graded_folder import write_reports
from qdot.grader.sandbox.notebook_process.function_answers import TABLE_PREFIX
from tests.support import read_data
from tests.support.results import change_part
from tests.support.submitting import make_class
from tests.support.suites import sample_for_suite

TOML = read_data("assignments/feedback.toml")
FAMILY_PAIR = ("planar-2r", "elbow-3r")
VOID = {"meta", "link", "br", "hr", "img", "path", "circle", "use", "rect", "polyline", "polygon", "mspace"}
Answers = Callable[[str, str, str], str | None]
"""A function from slot, part and right answer to the submitted answer, or None."""


class Page(HTMLParser):
    """A parsed page: its elements with their text. An AssertionError says that elements do not nest."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[tuple[str, dict[str, str]]] = []
        self.elements: list[tuple[str, dict[str, str], list[str]]] = []
        self.inside: list[list[str]] = []
        self.feed(text)
        self.close()
        assert not self.open

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        attributes = {name: value or "" for name, value in attrs}
        assert len(attributes) == len(attrs), (tag, attrs)
        self.elements.append((tag, attributes, []))
        if tag not in VOID:
            self.open.append((tag, attributes))
            self.inside.append(self.elements[-1][2])

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, {name: value or "" for name, value in attrs}, []))

    def handle_endtag(self, tag: str) -> None:
        if tag in VOID:
            return
        assert self.open, tag
        assert self.open[-1][0] == tag, (self.open[-3:], tag)
        self.open.pop()
        self.inside.pop()

    def handle_data(self, data: str) -> None:
        for texts in self.inside:
            texts.append(data)

    @property
    def text(self) -> str:
        """The visible text."""
        return " ".join(text for _, text in self.all("body"))

    def all(self, *tags: str) -> list[tuple[dict[str, str], str]]:
        return [
            (attributes, " ".join("".join(texts).split())) for tag, attributes, texts in self.elements if tag in tags
        ]


@pytest.fixture(scope="module")
def assignment(tmp_path_factory: pytest.TempPathFactory) -> Assignment:
    students = [Student("s1", "A. <b>"), Student("s2")]
    return make_class(tmp_path_factory.mktemp("class") / "hw", students, 'feedback = "values"\n' + TOML)


def write_right_answer(problem: Problem, name: str) -> str:
    part = next(part for part in problem.parts if part.name == name)
    content = part.answer.as_json()
    return str(content).replace("'", "") if part.type != "singular" else f"[{', '.join(content)}]"


def make_result(assignment: Assignment, answers: Answers = lambda slot, part, code: code) -> Result:
    problems = list[ProblemResult]()
    for slot, problem in assignment.generate_problems("s1"):
        names = [part.name for part in problem.parts]
        answer_texts = {name: answers(slot, name, write_right_answer(problem, name)) for name in names}
        submitted = {name: text for name, text in answer_texts.items() if text is not None}
        verdicts = mark(problem, submitted, secret=assignment.secret, functions_seed="points")
        parts = tuple(make_part_result(slot, verdict) for verdict in verdicts)
        problems.append(ProblemResult(str(problem.id), slot, parts))
    marked = [part for problem in problems for part in problem.parts]
    return Result(
        student="s1", assignment="hw", submission=CountingSubmission("hw.ipynb", "0", None), late=None,
        score=sum_points(part.points for part in marked), max_score=sum_points(part.max_points for part in marked),
        notes=("<i>told</i>",), problems=tuple(problems),
    )  # fmt: skip


def choose_answer(slot: str, part: str, code: str) -> str | None:
    changed: dict[tuple[str, str], str | None] = {
        ("p1", "position"): f"-({code.strip('[]')}, 1)", ("p1", "jacobian"): code.replace("sin", "cos", 1),
        ("p1", "determinant"): f"2*({code})", ("p1", "singular-angles"): "{theta2: [0, 1]}",
        ("p1", "joint-rates"): "[1/0, 2]", ("p2", "twist"): None, ("p2", "joint-effect"): "A" if code != "A" else "B",
        ("p2", "lost-direction"): "[1, 2]",
    }  # fmt: skip
    return changed.get((slot, part), code)


@pytest.fixture(scope="module")
def mixed_result(assignment: Assignment) -> Result:
    result = make_result(assignment, choose_answer)
    reason = "qdot failed on this answer (E: <x>)"
    result = change_part(result, "p2.rank", outcome=Outcome.UNGRADED, points=None, reason=reason)
    assert {part.outcome for part in result.parts.values()} == set(Outcome) - {Outcome.CORRECT}
    right_part = make_result(assignment).parts["p1.position"]
    values = {field.name: getattr(right_part, field.name) for field in fields(right_part)}
    return change_part(result, "p1.position", **values)


def make_page(assignment: Assignment, result: Result) -> tuple[str, Page]:
    text = make_feedback_page(assignment, assignment.roster[0], result)
    return text, Page(text)


def test_every_outcome_is_shown_as_a_word_and_a_sign(assignment: Assignment, mixed_result: Result) -> None:
    text, page = make_page(assignment, mixed_result)
    for part_result in mixed_result.parts.values():
        assert f'class="part {part_result.outcome}"' in text
    words = [text_of_span for attrs, text_of_span in page.all("span") if attrs.get("class") == "word"]
    assert len(set(words)) == 5
    # Each word is in the contents and at its part.
    assert Counter(words) == Counter({word: 2 * words[9:].count(word) for word in words})
    assert "points so far" in text and "No mark yet" not in text
    assert "<i>" not in text and "&lt;i&gt;told" in text and "A. &lt;b&gt;" in text
    assert "Worked solution" not in text
    for slot, problem in assignment.generate_problems("s1"):
        for part in problem.parts:
            assert to_html(write_prompt(problem, part)) in text, (slot, part.name)
    assert len([attrs for attrs, _ in page.all("details") if attrs.get("class") == "asked"]) == 9


def test_followed_entries_are_marked_and_parts_are_numbered(tmp_path: Path) -> None:
    """Use relative angles in the position, and in the Jacobian that follows from it."""
    assignment = make_class(tmp_path / "hw", [Student("s1")], f'variation = "chapter"\n{TOML}')
    wrong = {
        "position": "[a1*cos(theta1) + a2*cos(theta2), a1*sin(theta1) + a2*sin(theta2)]",
        "jacobian": "[[-a1*sin(theta1), -a2*sin(theta2)], [a1*cos(theta1), a2*cos(theta2)]]",
    }
    result = make_result(assignment, lambda slot, part, code: wrong.get(part, code))
    text, page = make_page(assignment, result)
    jacobian = result.parts["p1.jacobian"]
    assert (jacobian.followed_from, jacobian.follows) == ("position", ((True, True), (True, True)))
    assert [cell for attrs, cell in page.all("td") if attrs.get("class") == "follows"] == ["↪follows"] * 4
    assert "or follow from 1.1" in text and "'position'" not in text


def test_the_page_links_the_first_part_to_correct_of_each_problem(assignment: Assignment, mixed_result: Result) -> None:
    """A wrong part comes before an unanswered one, and a problem without either has no link."""
    _, page = make_page(assignment, mixed_result)
    [links] = [text for attrs, text in page.all("p") if attrs.get("class") == "review"]
    first, second = "1.2 Jacobian by differentiation (partly right)", "2.2 Velocity caused by one joint (wrong)"
    assert links == f"First question to look at in each problem: {first}, {second}"
    assert make_page(assignment, make_result(assignment))[0].count('class="review"') == 0
    reason = "the cell with this answer stopped at line 1, x = y (NameError: name 'y' is not defined)"
    crashed = change_part(mixed_result, "p1.position", outcome=Outcome.MISSING, answer=None, reason=reason)
    text, _ = make_page(assignment, crashed)
    assert '</a> (stopped with an error), <a href="#part-2-2">' in text


def test_tables_are_captioned_by_convention(tmp_path: Path) -> None:
    """A short sheet has no table of contents."""
    problem_toml = '[[problem]]\nfamily = "planar-2r"\nquestions = ["position"]\nconvention = "{}"\n'
    problems = "".join(map(problem_toml.format, CONVENTIONS))
    assignment = make_class(tmp_path / "hw", [Student("s1")], f'title = "T"\nkey = "hw"\n{problems}')
    text, page = make_page(assignment, make_result(assignment))
    captions = [caption for attrs, caption in page.all("caption") if attrs.get("class") == "unseen"]
    assert captions == ["Denavit–Hartenberg parameters"] * 2 + ["Joint axes at home"]
    assert "<nav" not in text and "<figure" in text


def test_counterexamples_are_in_tables_and_not_repeated_in_reasons(
    assignment: Assignment, mixed_result: Result
) -> None:
    text, page = make_page(assignment, mixed_result)
    assert all(caption in text for caption in ("in your answer, but not singular", "singular, but not in your answer"))
    tables = [table_text for attrs, table_text in page.all("table") if attrs.get("class") == "differs"]
    examples = [
        part.certificate.counterexample
        for part in mixed_result.parts.values()
        if part.outcome in WRONG_OR_PARTIAL and part.certificate and part.certificate.counterexample
    ]
    assert len(tables) == len(examples) >= 4
    for table, example in zip(tables, examples, strict=True):
        points = (example.missing, example.surplus) if isinstance(example, SetDifference) else (example.at,)
        for configuration in points:
            for name, value in (configuration or {}).items():
                unit = {"t": " rad", "q": ""}.get(name[0], " m")
                assert f"{format_decimal(value if abs(value) > 1e-12 else 0.0)}{unit}" in table, (table, name)
        for number in () if isinstance(example, SetDifference) else (example.yours, example.expected):
            assert number is None or isinstance(number, str) or format_decimal(number) in table
    reasons = re.findall(r'<article class="part (?:wrong|partial)".*?<p class="reason">(.*?)</p>', text, re.DOTALL)
    assert len(reasons) >= 5
    assert not [reason for reason in reasons if re.search(r"yours|expected|= -?\d", reason)]
    direction_table = next(table for table in tables if "Correct for your entry 1" in table)
    assert "Your answer2 " in direction_table


def test_two_values_are_shown_with_enough_digits_to_differ(assignment: Assignment) -> None:
    problem = assignment.generate_problems("s1")[0][1]
    part = problem.parts[2]

    def format_pair(yours: float | str, expected: float | str) -> tuple[str, ...]:
        example = EntryDifference(0, {"theta1": 0.5}, yours, expected)
        table = make_counterexample_table(problem, part, example)
        assert table is not None
        assert table.symbol_rows[0].cells == ("0.5 rad (28.65°)",)
        return tuple(row.cells[0] for row in table.result_rows)

    assert format_pair(0.25, -0.5) == ("0.25", "−0.5")
    assert format_pair(0.500001, 0.500002) == ("0.500001", "0.500002")
    assert format_pair("0.3 + -0.2i", 1e-7) == ("0.3 − 0.2 i", "1·10⁻⁷")
    assert format_pair("0.3 + 0.2i", "(0.3 - 0.25j)") == ("0.3 + 0.2 i", "0.3 − 0.25 i")
    assert format_pair("undefined or too large", 1.0) == ("undefined or too large", "1")
    assert format_pair("3.14159265358979", "3.14159265358980") == ("3.14159265358979", "3.14159265358980")
    assert format_pair("blank", 0.0) == ("left blank", "0")
    assert make_counterexample_table(problem, part, EntryDifference(0, {"k": 1.0}, 1.0, None)) is None


def test_sets_have_a_column_for_missing_and_surplus(assignment: Assignment) -> None:
    problem = assignment.generate_problems("s1")[0][1]
    point, nearby = {"theta1": 0.5, "theta2": 1.25}, {"theta1": 0.5, "theta2": 0.0}
    for missing, surplus, columns in (
        (point, None, 1), (point, nearby, 2), (None, None, 0), ({}, None, 0), ({"x": 1}, {}, 0),
    ):  # fmt: skip
        table = make_counterexample_table(problem, problem["singular-angles"], SetDifference(missing, surplus))
        assert (len(table.columns) - 1 if table else 0) == columns
        assert table is None or [len(row.cells) for row in table.symbol_rows] == [columns] * 2
        assert columns != 2 or (table and table.symbol_rows[1].cells[1].startswith("0 rad"))


@pytest.mark.parametrize(
    ("level", "expected"),
    [("outcome", (0, 0, 0)), ("mistake", (0, 1, 0)), ("counterexample", (1, 1, 0)), ("values", (1, 1, 1))],
)
def test_the_feedback_level_decides_what_is_shown(
    assignment: Assignment, mixed_result: Result, level: str, expected: tuple[int, int, int]
) -> None:
    text, page = make_page(replace(assignment, feedback=level), mixed_result)
    tables = [table_text for attrs, table_text in page.all("table") if attrs.get("class") == "differs"]
    shown = bool(tables), "Likely mistake" in text, any("Correct" in table for table in tables)
    assert tuple(map(int, shown)) == expected
    assert ("Singular, but not in your answer" in text) == (level == "values")


def test_the_page_reveals_no_answer_and_no_problem_id(assignment: Assignment, mixed_result: Result) -> None:
    text, _ = make_page(assignment, make_result(assignment, lambda slot, part, code: "blank"))
    for (slot, problem), entry in zip(assignment.generate_problems("s1"), mixed_result.problems, strict=True):
        assert str(problem.id) not in text and str(problem.id.seed) not in text
        assert entry.id not in text and assignment.secret not in text
        for part in problem.parts:
            if not isinstance(part.answer, Choice) and len(write_right_answer(problem, part.name)) > 8:
                assert write_right_answer(problem, part.name) not in text, (slot, part.name)


@pytest.mark.parametrize(
    ("obstacle", "is_submitted", "advice"),
    [
        ("nothing was submitted", False, "If you did submit your notebook, tell"),
        ("hw.ipynb is not a Jupyter notebook & <more>", True, "save it, and submit that file"),
    ],
)
def test_the_page_without_a_notebook_shows_why_and_what_to_do(
    assignment: Assignment, obstacle: str, is_submitted: bool, advice: str
) -> None:
    result = replace(make_result(assignment, lambda *_: None), obstacle=obstacle, notes=())
    result = result if is_submitted else replace(result, submission=None)
    text, page = make_page(assignment, result)
    assert 'class="part' not in text and "<nav" not in text and "<footer" not in text
    assert any(obstacle in paragraph and advice in paragraph for _, paragraph in page.all("p"))
    assert not re.search(r"\d of \d|No mark yet", page.text)
    text, _ = make_page(assignment, replace(result, override=Override(3.0, "", None)))
    assert re.search(r"</strong> of \d+ points", text)


def test_a_repeated_mistake_is_described_once(tmp_path: Path) -> None:
    """Each transposed matrix used to be explained again."""
    names = ["jacobian", "geometric-jacobian"]
    problems = "".join(f'[[problem]]\nfamily = "{family}"\nquestions = {names}\n' for family in FAMILY_PAIR)
    assignment = make_class(tmp_path / "hw", [Student("s1")], f'title = "T"\nkey = "hw"\n{problems}')
    result = make_result(assignment, lambda slot, part, code: str(sp.Matrix(sp.sympify(code)).T.tolist()))
    _, page = make_page(assignment, result)
    advice = [text for _, text in page.all("p") if text.startswith("Likely mistake")]
    assert "your matrix is transposed" in advice[0] and len(advice) == 2
    repetitions = [text for _, text in page.all("p") if "seem to have made the same mistake as in" in text]
    assert len(repetitions) == 3 and all("same mistake as in 1.1. " in text for text in repetitions)


def test_blank_answers_are_listed_once(assignment: Assignment) -> None:
    """Each blank part used to repeat the sentence that its answer is blank."""
    _, page = make_page(assignment, make_result(assignment, lambda slot, _, code: code if slot == "p1" else "blank"))
    sentences = [text for _, text in page.all("li") if text.startswith("You left")]
    assert len(sentences) == 1 and re.fullmatch(r"You left \d+ answers blank: (2\.\d|, )+[^:]*", sentences[0])
    assert "left the answer blank" not in page.text and "not answered" in page.text


def test_a_page_says_whether_all_answers_are_right(assignment: Assignment, mixed_result: Result) -> None:
    for result, is_right in ((make_result(assignment), True), (mixed_result, False)):
        _, page = make_page(assignment, result)
        assert ("All of your answers are right." in page.text) is is_right


def test_the_page_is_accessible_html(assignment: Assignment, mixed_result: Result) -> None:
    for result in (mixed_result, make_result(assignment), make_result(assignment, lambda *_: None)):
        text, page = make_page(assignment, result)
        tags = [tag for tag, _, _ in page.elements]
        levels = [int(tag[1]) for tag in tags if re.fullmatch(r"h\d", tag)]
        assert levels[0] == 1 and levels.count(1) == 1
        assert all(after <= before + 1 for before, after in pairwise(levels))
        assert [tags.count(tag) for tag in ("header", "nav", "main", "footer")] == [1] * 4
        ids = [attrs["id"] for _, attrs, _ in page.elements if "id" in attrs]
        assert len(set(ids)) == len(ids)
        for tag, attrs, _ in page.elements:
            for name in ("aria-labelledby", "href"):
                assert all(target.lstrip("#") in ids for target in attrs.get(name, "").split()), (tag, attrs)
            assert tag != "svg" or "aria-hidden" in attrs or "aria-labelledby" in attrs
            assert attrs.get("role") != "region" or (attrs["tabindex"] == "0" and attrs["aria-label"])
            assert not [name for name in attrs if name.startswith("on")]
        assert not {"script", "link", "iframe", "object", "embed", "img", "base", "form"} & set(tags)
        tables = tags.count("table")
        assert tables == tags.count("caption")
        assert all(attrs.get("scope") in ("row", "col") for attrs, _ in page.all("th"))
        assert not re.search(r"url\(|@import|https?://(?!www\.w3\.org/)", text)
        for formula in re.findall(r"<math.*?</math>|<svg xmlns.*?</svg>", text, re.DOTALL):
            ET.fromstring(formula)


def compute_luminance(colour: str) -> float:
    digits = colour.lstrip("#")
    digits = "".join(2 * digit for digit in digits) if len(digits) == 3 else digits
    parts = [int(digits[k : k + 2], 16) / 255 for k in (0, 2, 4)]
    linear = [part / 12.92 if part <= 0.03928 else ((part + 0.055) / 1.055) ** 2.4 for part in parts]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def test_every_colour_has_enough_contrast() -> None:
    css = (find_template_folder() / "reports/feedback.css.j2").read_text(encoding="utf-8")
    schemes = [dict(re.findall(r"--(\w+): (#\w+)", block)) for block in re.findall(r":root \{(.*?)\}", css)]
    assert len(schemes) == 3  # light, dark, print
    for scheme in schemes:
        for background in ("paper", "card", "field"):
            for foreground in ("ink", "soft", "link", "good", "half", "bad", "none"):
                darker, lighter = sorted((compute_luminance(scheme[background]), compute_luminance(scheme[foreground])))
                assert (lighter + 0.05) / (darker + 0.05) >= 4.5, (background, foreground, scheme)


HOSTILE = [
    "<script>alert(1)</script>", "]]></math><img src=x onerror=alert(1)>", "a1 & a2 < a1 > 'x' \"y\"", "9**9**9",
    "(" * 200 + "1" + ")" * 200, "[" * 55 + "1" + "]" * 55, "2^" * 55 + "2", "x\ud800y", "\x00\x01\x1b[31m",
    "\u202eabc", "a1+" * 66_000 + "a1", "a1/" * 1300 + "a1", "sin(" * 28 + "a1" + ")" * 28, "9" * 4000, "1e400",
    "0." + "0" * 900 + "1", "\\frac{1}{2}" * 300, "\\text{<b>}", "ﷺ*x⑴", "{{{}}}", "[[], []]",
    "{theta1: {theta2: 0}}", "lambda x: x", "\n" * 3000 + "a1", "A", "", " ", FUNCTION_TEXT,
    TABLE_PREFIX + '{"shape": [], "values": []}', "blank", "theta1 = theta2 = 0",
    "[[a1, a2], [a1]]", "x__y.__class__.__bases__", "Or(And(theta1, theta2), 0)", "а1*θ₁", "1 2 3", "k" * 59 + "*a1",
]  # fmt: skip


@pytest.mark.parametrize("text", HOSTILE, ids=range(len(HOSTILE)))
def test_any_answer_is_shown_safely_and_quickly(assignment: Assignment, text: str) -> None:
    start = time.process_time()
    for _, problem in assignment.generate_problems("s1"):
        for part in problem.parts:
            answer = show_answer(problem, part, text)
            answer.text.encode("utf-8")
            assert not set(answer.text) & set(map(chr, (*range(9), *range(11, 32))))
            if answer.html:
                element = ET.fromstring(answer.html)
                assert {"script", "img", "b"}.isdisjoint(child.tag for child in element.iter()) or part.type == "choice"
    assert time.process_time() - start < 5


def test_numbers_in_other_units_are_shown_in_si_units() -> None:
    problem = generate("planar-2r/3", ["joint-rates"])
    html = show_answer(problem, problem.parts[0], "17 deg/s, -200 mrad/s").html
    assert re.findall(r"<mn>([^<]*)</mn>", html) == ["0.296706", "0.2"]
    assert show_answer(problem, problem.parts[0], "[17 deg/s, blank]").html


def test_hostile_answers_and_reasons_are_escaped(assignment: Assignment, mixed_result: Result) -> None:
    for text in sample_for_suite(HOSTILE, 8):
        result = replace(mixed_result, notes=(text[:100],))
        for name, part in mixed_result.parts.items():
            result = change_part(result, name, answer=text, reason=f"{part.reason} near '{text[:40]}'")
        page, _ = make_page(assignment, result)
        assert "<script" not in page and "onerror=alert(1)>" not in page.replace("&gt;", "")
        page.encode("utf-8")


def test_references_of_every_type_are_typeset(problem: Problem) -> None:
    for part in problem.parts:
        text = write_right_answer(problem, part.name)
        answer = show_answer(problem, part, text)
        if len(text) <= 3000:
            assert answer.html, (part.name, text)
            ET.fromstring(answer.html.strip() if part.type != "choice" else f"<div>{answer.html}</div>")
        if isinstance(part.answer, Matrix):
            assert answer.text.startswith(text[:1000])


def test_formulas_are_typeset_and_unparsable_text_is_verbatim(assignment: Assignment) -> None:
    problem = assignment.generate_problems("s1")[0][1]
    part = problem.parts[2]
    formula = show_answer(problem, part, "a1*sin(theta2)").html
    assert "xmlns" not in formula and "&#x" not in formula  # short, because a page has many
    tree = ET.fromstring(formula)
    assert not [row for row in tree.iter("mrow") if len(row) == 1 and row[0].tag in ("mi", "mn", "mo")]
    assert "".join(tree.itertext()).replace("\u2061", "").replace(" ", "") == "a1s2"
    for text in ("sin(", "a1+" * 1400 + "a1", "(-" * 40 + "1" + ")" * 40):
        answer = show_answer(problem, part, text)
        assert not answer.html and answer.is_verbatim and answer.text.startswith(text[:1000])
    assert not show_answer(problem, part, FUNCTION_TEXT).is_verbatim
    assert "0.5" in show_answer(problem, part, "0,5").html


def test_a_page_is_rewritten_only_if_it_changes(assignment: Assignment, mixed_result: Result) -> None:
    other_result = replace(mixed_result, student="s2", obstacle="nothing was submitted")
    written: list[None] = []

    def write(results: list[Result]) -> dict[str, int]:
        written.clear()
        write_reports(assignment, results, 1, lambda: written.append(None))
        assert len(written) == 2
        pages = sorted((assignment.folder / "graded" / "feedback").glob("*.html"))
        return {page.stem: page.stat().st_mtime_ns for page in pages}

    first = write([mixed_result, other_result])
    assert set(first) == {"s1", "s2"}
    assert write([mixed_result, other_result]) == first
    changed = write([replace(mixed_result, notes=("another",)), other_result])
    assert changed["s1"] > first["s1"] and changed["s2"] == first["s2"]
    fingerprints = {compute_page_fingerprint(assignment, assignment.roster[0], r) for r in (mixed_result, other_result)}
    assert len(fingerprints) == 2
