"""The feedback page: every outcome on it, readable by people and by screen readers, safe whatever was typed."""

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

from qdot.exercises.arm.chain import CONVENTIONS
from qdot.exercises.assignment.assignment import Assignment, Student, load_assignment
from qdot.exercises.assignment.release import init_assignment
from qdot.exercises.formula.equality import EntryDifference, SetDifference
from qdot.exercises.problem.problem import Problem
from qdot.exercises.reference_answers import Choice, Matrix
from qdot.exercises.writing.markup import to_html
from qdot.exercises.writing.problem_texts import write_prompt
from qdot.exercises.writing.render import find_template_folder
from qdot.grader.grading.attempt import make_part_result
from qdot.grader.grading.result import CountingSubmission, ProblemResult, Result
from qdot.grader.judging.functions import FUNCTION_TEXT
from qdot.grader.judging.verdict import Outcome
from qdot.grader.marking.marking import WRONG_OR_PARTIAL, mark, sum_points
from qdot.grader.reports.answers import show_answer
from qdot.grader.reports.counterexample_table import format_decimal, make_counterexample_table
from qdot.grader.reports.feedback import compute_page_fingerprint, make_feedback_page
from qdot.grader.reports.tables import find_work_status
from qdot.grader.reports.write import write_reports
from qdot.grader.sandbox.contained.callables import TABLE_PREFIX
from tests.support.results import change_part
from tests.support.suites import sample_for_suite

TOML = """title = "Arms & <angles>"
key = "hw"
[[problem]]
family = "planar-2r"
questions = ["position", "jacobian", "determinant", "singular-angles", "joint-rates"]
[[problem]]
family = "polar-rp"
questions = ["twist", "joint-effect", "lost-direction", "rank"]
"""
VOID = {"meta", "link", "br", "hr", "img", "path", "circle", "use", "rect", "polyline", "polygon", "mspace"}
Answers = Callable[[str, str, str], str | None]
"""Slot, part and right answer to what is handed in, None for nothing."""


class Page(HTMLParser):
    """A page taken apart: its elements with the text in each; raises AssertionError where they do not nest."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[tuple[str, dict[str, str]]] = []
        self.found: list[tuple[str, dict[str, str], list[str]]] = []
        self.inside: list[list[str]] = []
        self.feed(text)
        self.close()
        assert not self.open

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        about = {name: value or "" for name, value in attrs}
        assert len(about) == len(attrs), (tag, attrs)
        self.found.append((tag, about, []))
        if tag not in VOID:
            self.open.append((tag, about))
            self.inside.append(self.found[-1][2])

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.found.append((tag, {name: value or "" for name, value in attrs}, []))

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
        """All that a reader sees."""
        return " ".join(text for _, text in self.all("body"))

    def all(self, *tags: str) -> list[tuple[dict[str, str], str]]:
        return [(about, " ".join("".join(texts).split())) for tag, about, texts in self.found if tag in tags]


@pytest.fixture(scope="module")
def assignment(tmp_path_factory: pytest.TempPathFactory) -> Assignment:
    folder = tmp_path_factory.mktemp("class") / "hw"
    init_assignment(folder, "T", "hw", [Student("s1", "A. <b>"), Student("s2")], "0123456789abcdef")
    (folder / "assignment.toml").write_text('feedback = "values"\n' + TOML)
    return load_assignment(folder)


def right(problem: Problem, name: str) -> str:
    part = next(part for part in problem.parts if part.name == name)
    found = part.answer.as_json()
    return str(found).replace("'", "") if part.type != "singular" else f"[{', '.join(found)}]"


def result_of(assignment: Assignment, answers: Answers = lambda slot, part, code: code) -> Result:
    """Return what grading a student makes of answers, without a notebook."""
    marked = list[ProblemResult]()
    for slot, problem in assignment.generate_problems("s1"):
        own = {part.name: answers(slot, part.name, right(problem, part.name)) for part in problem.parts}
        handed_in = {name: text for name, text in own.items() if text is not None}
        verdicts = mark(problem, handed_in, secret=assignment.secret, points_seed="points")
        parts = tuple(make_part_result(slot, verdict) for verdict in verdicts)
        marked.append(ProblemResult(str(problem.id), slot, parts))
    every = [part for problem in marked for part in problem.parts]
    return Result(
        student="s1", assignment="hw", submission=CountingSubmission("hw.ipynb", "0", None), late=None,
        score=sum_points(part.points for part in every), max_score=sum_points(part.max_points for part in every),
        notes=("<i>told</i>",), problems=tuple(marked),
    )  # fmt: skip


def mixed(slot: str, part: str, code: str) -> str | None:
    changed: dict[tuple[str, str], str | None] = {
        ("p1", "position"): f"-({code.strip('[]')}, 1)", ("p1", "jacobian"): code.replace("sin", "cos", 1),
        ("p1", "determinant"): f"2*({code})", ("p1", "singular-angles"): "{theta2: [0, 1]}",
        ("p1", "joint-rates"): "[1/0, 2]", ("p2", "twist"): None, ("p2", "joint-effect"): "A" if code != "A" else "B",
        ("p2", "lost-direction"): "[1, 2]",
    }  # fmt: skip
    return changed.get((slot, part), code)


@pytest.fixture(scope="module")
def mix(assignment: Assignment) -> Result:
    """A result with every outcome in it, and a part that follows from a wrong one."""
    result = result_of(assignment, mixed)
    reason = "qdot failed on this answer (E: <x>)"
    result = change_part(result, "p2.rank", outcome=Outcome.UNGRADED, points=None, reason=reason)
    assert {part.outcome for part in result.parts.values()} == set(Outcome) - {Outcome.CORRECT}
    right = result_of(assignment).parts["p1.position"]
    return change_part(result, "p1.position", **{field.name: getattr(right, field.name) for field in fields(right)})


def page_of(assignment: Assignment, result: Result) -> tuple[str, Page]:
    text = make_feedback_page(assignment, assignment.roster[0], result)
    return text, Page(text)


def test_every_outcome_is_said_in_words_and_by_a_sign(assignment: Assignment, mix: Result) -> None:
    text, page = page_of(assignment, mix)
    for part in mix.parts.values():
        assert f'class="part {part.outcome}"' in text
    words = [said for about, said in page.all("span") if about.get("class") == "word"]
    assert len(set(words)) == 5
    assert Counter(words) == Counter({word: 2 * words[9:].count(word) for word in words})  # contents and parts
    assert "points so far" in text and "No mark yet" not in text
    assert "<i>" not in text and "&lt;i&gt;told" in text and "A. &lt;b&gt;" in text
    assert "Worked solution" not in text
    for slot, problem in assignment.generate_problems("s1"):
        for asked in problem.parts:
            assert to_html(write_prompt(problem, asked)) in text, (slot, asked.name)
    assert len([about for about, _ in page.all("details") if about.get("class") == "asked"]) == 9


def test_entries_that_follow_are_marked_as_such_and_parts_called_by_their_numbers(tmp_path: Path) -> None:
    """Relative for absolute angles in the position, and in the Jacobian that follows from it."""
    init_assignment(tmp_path / "hw", "T", "hw", [Student("s1")], "0123456789abcdef")
    (tmp_path / "hw" / "assignment.toml").write_text(f'variation = "chapter"\n{TOML}')
    made = load_assignment(tmp_path / "hw")
    wrong = {
        "position": "[a1*cos(theta1) + a2*cos(theta2), a1*sin(theta1) + a2*sin(theta2)]",
        "jacobian": "[[-a1*sin(theta1), -a2*sin(theta2)], [a1*cos(theta1), a2*cos(theta2)]]",
    }
    result = result_of(made, lambda slot, part, code: wrong.get(part, code))
    text, page = page_of(made, result)
    jacobian = result.parts["p1.jacobian"]
    assert (jacobian.followed_from, jacobian.follows) == ("position", ((True, True), (True, True)))
    assert [said for about, said in page.all("td") if about.get("class") == "follows"] == ["↪follows"] * 4
    assert "or follow from 1.1" in text and "'position'" not in text


def test_the_page_links_the_first_part_to_correct_of_each_problem(assignment: Assignment, mix: Result) -> None:
    """A wrong part comes before an unanswered one, and a problem without either has no link."""
    _, page = page_of(assignment, mix)
    [links] = [text for about, text in page.all("p") if about.get("class") == "review"]
    assert links == "Start with: 1.2 Jacobian by differentiation, 2.2 Velocity caused by one joint"
    assert page_of(assignment, result_of(assignment))[0].count('class="review"') == 0


def test_a_table_is_called_what_it_is(tmp_path: Path) -> None:
    """And a short sheet has no contents."""
    asked = '[[problem]]\nfamily = "planar-2r"\nquestions = ["position"]\nconvention = "{}"\n'
    init_assignment(tmp_path / "hw", "T", "hw", [Student("s1")], "0123456789abcdef")
    problems = "".join(map(asked.format, CONVENTIONS))
    (tmp_path / "hw" / "assignment.toml").write_text(f'title = "T"\nkey = "hw"\n{problems}')
    made = load_assignment(tmp_path / "hw")
    text, page = page_of(made, result_of(made))
    called = [caption for about, caption in page.all("caption") if about.get("class") == "unseen"]
    assert called == ["Denavit–Hartenberg parameters"] * 2 + ["Joint axes at home"]
    assert "<nav" not in text and "<figure" in text


def test_the_table_holds_what_the_certificate_does_and_the_reason_does_not_repeat_it(
    assignment: Assignment, mix: Result
) -> None:
    text, page = page_of(assignment, mix)
    assert (
        "in your answer, but not singular" in text and "singular, but not in your answer" in text
    )  # the two drawn arms
    tables = [said for about, said in page.all("table") if about.get("class") == "differs"]
    examples = [
        part.certificate.counterexample
        for part in mix.parts.values()
        if part.outcome in WRONG_OR_PARTIAL and part.certificate and part.certificate.counterexample
    ]
    assert len(tables) == len(examples) >= 4
    for table, example in zip(tables, examples, strict=True):
        for at in (example.missing, example.surplus) if isinstance(example, SetDifference) else (example.at,):
            for name, value in (at or {}).items():
                unit = {"t": " rad", "q": ""}.get(name[0], " m")
                assert f"{format_decimal(value if abs(value) > 1e-12 else 0.0)}{unit}" in table, (table, name)
        for number in () if isinstance(example, SetDifference) else (example.yours, example.expected):
            assert number is None or isinstance(number, str) or format_decimal(number) in table
    reasons = re.findall(r'<article class="part (?:wrong|partial)".*?<p class="reason">(.*?)</p>', text, re.DOTALL)
    assert len(reasons) >= 5
    assert not [reason for reason in reasons if re.search(r"yours|expected|= -?\d", reason)]
    of_direction = next(table for table in tables if "Correct for your entry 1" in table)
    assert "Your answer2 " in of_direction


def test_two_values_are_shown_with_the_digits_that_tell_them_apart(assignment: Assignment) -> None:
    problem = assignment.generate_problems("s1")[0][1]
    part = problem.parts[2]

    def shown(yours: float | str, expected: float | str) -> tuple[str, ...]:
        example = EntryDifference(0, {"theta1": 0.5}, yours, expected)
        table = make_counterexample_table(problem, part, example)
        assert table is not None
        assert table.symbols[0].cells == ("0.5 rad (28.65°)",)
        return tuple(row.cells[0] for row in table.results)

    assert shown(0.25, -0.5) == ("0.25", "−0.5")
    assert shown(0.500001, 0.500002) == ("0.500001", "0.500002")
    assert shown("0.3 + -0.2i", 1e-7) == ("0.3 − 0.2 i", "1·10⁻⁷")
    assert shown("0.3 + 0.2i", "(0.3 - 0.25j)") == ("0.3 + 0.2 i", "0.3 − 0.25 i")
    assert shown("not a finite number", 1.0) == ("not a finite number", "1")
    assert shown("3.14159265358979", "3.14159265358980") == ("3.14159265358979", "3.14159265358980")
    assert shown("blank", 0.0) == ("left blank", "0")
    assert make_counterexample_table(problem, part, EntryDifference(0, {"k": 1.0}, 1.0, None)) is None


def test_sets_have_a_column_for_each_way_in_which_they_differ(assignment: Assignment) -> None:
    problem = assignment.generate_problems("s1")[0][1]
    at, nearby = {"theta1": 0.5, "theta2": 1.25}, {"theta1": 0.5, "theta2": 0.0}
    for missing, surplus, columns in (
        (at, None, 1),
        (at, nearby, 2),
        (None, None, 0),
        ({}, None, 0),
        ({"x": 1}, {}, 0),
    ):
        table = make_counterexample_table(problem, problem["singular-angles"], SetDifference(missing, surplus))
        assert (len(table.columns) - 1 if table else 0) == columns
        assert table is None or [len(row.cells) for row in table.symbols] == [columns] * 2
        assert columns != 2 or (table and table.symbols[1].cells[1].startswith("0 rad"))


@pytest.mark.parametrize(
    ("level", "has"),
    [("outcome", (0, 0, 0)), ("mistake", (0, 1, 0)), ("counterexample", (1, 1, 0)), ("values", (1, 1, 1))],
)
def test_levels_of_feedback(assignment: Assignment, mix: Result, level: str, has: tuple[int, int, int]) -> None:
    text, page = page_of(replace(assignment, feedback=level), mix)
    tables = [said for about, said in page.all("table") if about.get("class") == "differs"]
    shown = bool(tables), "What seems to have happened" in text, any("Correct" in table for table in tables)
    assert tuple(map(int, shown)) == has
    assert ("Singular, but not in your answer" in text) == (level == "values")


def test_nothing_on_it_tells_the_answer_or_regenerates_the_problem(assignment: Assignment, mix: Result) -> None:
    text, _ = page_of(assignment, result_of(assignment, lambda slot, part, code: "blank"))
    for (slot, problem), entry in zip(assignment.generate_problems("s1"), mix.problems, strict=True):
        assert str(problem.id) not in text and str(problem.id.seed) not in text
        assert entry.id not in text and assignment.secret not in text
        for part in problem.parts:
            if not isinstance(part.answer, Choice) and len(right(problem, part.name)) > 8:
                assert right(problem, part.name) not in text, (slot, part.name)


@pytest.mark.parametrize("obstacle", ["nothing was handed in", "hw.ipynb is not a Jupyter notebook & <more>"])
def test_a_page_of_one_who_handed_in_nothing(assignment: Assignment, obstacle: str) -> None:
    result = replace(result_of(assignment, lambda *_: None), obstacle=obstacle, submission=None, notes=())
    assert find_work_status(result) == "missing"
    text, page = page_of(assignment, result)
    assert 'class="part' not in text and "<nav" not in text
    assert any(obstacle in paragraph for _, paragraph in page.all("p"))


def test_it_is_well_built(assignment: Assignment, mix: Result) -> None:
    for result in (mix, result_of(assignment), result_of(assignment, lambda *_: None)):
        text, page = page_of(assignment, result)
        tags = [tag for tag, _, _ in page.found]
        levels = [int(tag[1]) for tag in tags if re.fullmatch(r"h\d", tag)]
        assert levels[0] == 1 and levels.count(1) == 1
        assert all(after <= before + 1 for before, after in pairwise(levels))
        assert [tags.count(tag) for tag in ("header", "nav", "main", "footer")] == [1] * 4
        ids = [about["id"] for _, about, _ in page.found if "id" in about]
        assert len(set(ids)) == len(ids)
        for tag, about, _ in page.found:
            for name in ("aria-labelledby", "href"):
                assert all(target.lstrip("#") in ids for target in about.get(name, "").split()), (tag, about)
            assert tag != "svg" or "aria-hidden" in about or "aria-labelledby" in about
            assert about.get("role") != "region" or (about["tabindex"], bool(about["aria-label"])) == ("0", True)
            assert not [name for name in about if name.startswith("on")]
        assert not {"script", "link", "iframe", "object", "embed", "img", "base", "form"} & set(tags)
        tables = tags.count("table")
        assert tables == tags.count("caption")
        assert all(about.get("scope") in ("row", "col") for about, _ in page.all("th"))
        assert not re.search(r"url\(|@import|https?://(?!www\.w3\.org/)", text)
        for formula in re.findall(r"<math.*?</math>|<svg xmlns.*?</svg>", text, re.DOTALL):
            ET.fromstring(formula)


def _luminance(colour: str) -> float:
    digits = colour.lstrip("#")
    digits = "".join(2 * digit for digit in digits) if len(digits) == 3 else digits
    parts = [int(digits[k : k + 2], 16) / 255 for k in (0, 2, 4)]
    linear = [part / 12.92 if part <= 0.03928 else ((part + 0.055) / 1.055) ** 2.4 for part in parts]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def test_every_colour_can_be_read_on_every_ground() -> None:
    css = (find_template_folder() / "reports/feedback.css.j2").read_text(encoding="utf-8")
    schemes = [dict(re.findall(r"--(\w+): (#\w+)", found)) for found in re.findall(r":root \{(.*?)\}", css)]
    assert len(schemes) == 3  # light, dark, print
    for scheme in schemes:
        for ground in ("paper", "card", "field"):
            for ink in ("ink", "soft", "link", "good", "half", "bad", "none"):
                one, other = sorted((_luminance(scheme[ground]), _luminance(scheme[ink])))
                assert (other + 0.05) / (one + 0.05) >= 4.5, (ground, ink, scheme)


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
def test_whatever_was_typed_is_shown_safely_and_soon(assignment: Assignment, text: str) -> None:
    start = time.process_time()
    for _, problem in assignment.generate_problems("s1"):
        for part in problem.parts:
            answer = show_answer(problem, part, text)
            answer.text.encode("utf-8")
            assert not set(answer.text) & set(map(chr, (*range(9), *range(11, 32))))
            if answer.html:
                element = ET.fromstring(answer.html)
                assert {"script", "img", "b"}.isdisjoint(one.tag for one in element.iter()) or part.type == "choice"
    assert time.process_time() - start < 5


def test_a_page_of_hostile_answers_and_reasons(assignment: Assignment, mix: Result) -> None:
    for text in sample_for_suite(HOSTILE, 8):
        result = replace(mix, notes=(text[:100],))
        for name, part in mix.parts.items():
            result = change_part(result, name, answer=text, reason=f"{part.reason} near '{text[:40]}'")
        page, _ = page_of(assignment, result)
        assert "<script" not in page and "onerror=alert(1)>" not in page.replace("&gt;", "")
        page.encode("utf-8")


def test_a_reference_of_every_type_is_set(problem: Problem) -> None:
    for part in problem.parts:
        text = right(problem, part.name)
        answer = show_answer(problem, part, text)
        if len(text) <= 3000:
            assert answer.html, (part.name, text)
            ET.fromstring(answer.html.strip() if part.type != "choice" else f"<div>{answer.html}</div>")
        if isinstance(part.answer, Matrix):
            assert answer.text.startswith(text[:1000])


def test_what_is_set_and_what_stands_there_as_text(assignment: Assignment) -> None:
    problem = assignment.generate_problems("s1")[0][1]
    part = problem.parts[2]
    formula = show_answer(problem, part, "a1*sin(theta2)").html
    assert "xmlns" not in formula and "&#x" not in formula  # a page holds many: each is set in few characters
    tree = ET.fromstring(formula)
    assert not [row for row in tree.iter("mrow") if len(row) == 1 and row[0].tag in ("mi", "mn", "mo")]
    assert "".join(tree.itertext()).replace("\u2061", "").replace(" ", "") == "a1s2"
    for text in ("sin(", "a1+" * 1400 + "a1", "(-" * 40 + "1" + ")" * 40):
        answer = show_answer(problem, part, text)
        assert not answer.html and answer.is_verbatim and answer.text.startswith(text[:1000])
    assert not show_answer(problem, part, FUNCTION_TEXT).is_verbatim
    assert "0.5" in show_answer(problem, part, "0,5").html


def test_a_page_is_written_again_only_if_it_says_something_else(assignment: Assignment, mix: Result) -> None:
    other = replace(mix, student="s2", obstacle="nothing was handed in")
    counted: list[None] = []

    def write(results: list[Result]) -> dict[str, int]:
        counted.clear()
        write_reports(assignment, results, 1, lambda: counted.append(None))
        assert len(counted) == 2
        pages = sorted((assignment.folder / "graded" / "feedback").glob("*.html"))
        return {page.stem: page.stat().st_mtime_ns for page in pages}

    first = write([mix, other])
    assert set(first) == {"s1", "s2"}
    assert write([mix, other]) == first
    changed = write([replace(mix, notes=("another",)), other])
    assert changed["s1"] > first["s1"] and changed["s2"] == first["s2"]
    assert compute_page_fingerprint(assignment, assignment.roster[0], mix) != compute_page_fingerprint(
        assignment, assignment.roster[0], other
    )
