"""Instructors' own questions: certified, marked or refused with a reason; the gallery; random formulas."""

import ast
import json
import math
import re
from collections.abc import Callable, Sequence
from dataclasses import replace
from fractions import Fraction
from itertools import combinations
from pathlib import Path
from typing import Any

import nbformat
import pytest
import sympy as sp

from qdot import generate
from qdot.exercises.assignment.assignment import Assignment, Student, load_assignment
from qdot.exercises.assignment.release import init_assignment
from qdot.exercises.common.errors import QdotError, Reason
from qdot.exercises.common.stream import Stream
from qdot.exercises.exports.boxes import arrange_options
from qdot.exercises.exports.export_format import ExportRequest, ShareOfTypedAnswer
from qdot.exercises.exports.items import ChoiceForm, make_items
from qdot.exercises.exports.known_wrong_answers import find_known_wrong_answers
from qdot.exercises.exports.numeric_part import _sample_configurations
from qdot.exercises.exports.paper import make_pdf_preview
from qdot.exercises.exports.registry import EXPORT_FORMATS
from qdot.exercises.exports.stack_parts import StackPart, convert_part
from qdot.exercises.formula.parser import parse_formula
from qdot.exercises.formula.trees import find_names
from qdot.exercises.notebook.notebook import NotebookContent, draw_singular_configurations, make_student_notebook
from qdot.exercises.notebook.problem_formats import show_assignment
from qdot.exercises.problem.problem import Part, Problem, list_table_numbers
from qdot.exercises.questions import QUESTIONS
from qdot.exercises.questions.custom import Definition, make_question
from qdot.exercises.questions.custom.definition import GivenValue, Texts
from qdot.exercises.questions.custom.question import CustomDetails
from qdot.exercises.questions.language import FormulaError, UnknownName, parse
from qdot.exercises.reference_answers import ConditionSet, Expression, Matrix, Number, Words
from qdot.exercises.site.bank import make_index_json, make_titles_json
from qdot.exercises.site.bank_problem import BankProblem, find_custom_questions
from qdot.exercises.site.record import make_site_record, translate_record
from qdot.exercises.verify.certificate import certify
from qdot.exercises.verify.custom import GeometryQuantities
from qdot.exercises.writing.paper_texts import remove_typing_remarks
from qdot.exercises.writing.problem_texts import write_hints, write_prompt, write_solution
from qdot.exercises.writing.short_answer import write_short_answer
from qdot.grader.cli.main import app
from qdot.grader.diagnosis.advice import advise
from qdot.grader.grading.attempt import grade_notebook
from qdot.grader.grading.certify import find_failures
from qdot.grader.grading.check import check_notebook
from qdot.grader.integrations.nbgrader_cells import restore_cells
from qdot.grader.judging.expected_form import read_answer
from qdot.grader.judging.judge import judge
from qdot.grader.judging.verdict import AWAITS_PERSON, Outcome
from qdot.grader.marking.marking import mark
from tests.support import read_cases, read_data
from tests.support.command import run, run_and_fail, runner
from tests.support.gallery import CHAPTER_ARMS, GALLERY, GALLERY_FOLDER
from tests.support.suites import sample_for_suite, select_for_suite


def make_assignment(folder: Path, text: str) -> Assignment:
    init_assignment(folder / "hw", "T", "hw", [Student("s1", "Ada")], "0123456789abcdef")
    (folder / "hw" / "assignment.toml").write_text(f'title = "T"\nkey = "hw"\n{text}', encoding="utf-8")
    return load_assignment(folder / "hw")


def ask_mine(folder: Path, question: str, family: str = "planar-2r", more: str = "") -> Assignment:
    """Return an assignment of a problem that asks one question, of which `question` has the keys."""
    text = f'{more}[question.mine]\n{question}\n[[problem]]\nfamily = "{family}"\nquestions = ["mine"]\n'
    return make_assignment(folder, text)


def make_problem(folder: Path, question: str, family: str = "planar-2r", more: str = "") -> Problem:
    return ask_mine(folder, question, family, more).generate_problems("s1")[0][1]


def judge_answer(problem: Problem, answer: str) -> Outcome:
    return judge(problem, problem.parts[0], answer, "seed").outcome


# --- the gallery ---


def test_every_gallery_question_is_tested() -> None:
    assert sorted(path.stem for path in GALLERY_FOLDER.glob("*.toml")) == sorted(GALLERY)


@pytest.mark.parametrize("name", GALLERY)
def test_gallery_question_is_certified_and_marked(name: str, tmp_path: Path) -> None:
    variation = 'variation = "chapter"\n' if name in CHAPTER_ARMS else ""
    path = GALLERY_FOLDER / f"{name}.toml"
    tables = f'[[problem]]\nfamily = "{GALLERY[name]}"\nquestions = ["position", "{path}"]\n'
    assignment = make_assignment(tmp_path, variation + tables)
    ((_, problem),) = assignment.generate_problems("s1")
    part = problem.parts[1]
    assert find_failures(problem) == []
    texts = [write_prompt(problem, part), write_solution(problem, part), *write_hints(problem, part)]
    assert all("{" not in text.replace("{{", "") or "$" in text for text in texts)
    assert write_prompt(problem, part, "de").strip()
    if not isinstance(part.answer, Words):
        assert mark(problem, {part.name: part.answer.as_typed()}, secret="s")[1].points == part.points


# --- each kind of answer ---


@pytest.mark.parametrize("answer", read_cases("own_questions")["roots_and_quotients"])
def test_roots_quotients_and_other_functions_stay_in_the_answer(answer: str) -> None:
    """With the usual step of differences, the last three could not be certified for one of these arms."""
    definition = Definition("mine", answer, (Texts("Mine", "x"),))
    for seed in (1, 3):
        problem = generate(f"planar-2r/{seed}", ["mine"], definitions=[definition])
        assert find_failures(problem) == []
        part = problem.parts[0]
        assert judge_answer(problem, part.answer.as_typed()) == "correct"
        wrong_matrix = part.answer.as_matrix() * sp.Rational(1000001, 1000000)
        wrong_answer = Expression(wrong_matrix[0]) if part.shape is None else Matrix(wrong_matrix)
        wrong = replace(part, answer=wrong_answer)
        assert "geometry and differences" in find_failures(replace(problem, parts=(wrong,)))[0]


@pytest.mark.whole
@pytest.mark.parametrize("position", ["[a1*cos(theta1), 1]", "[atan2(a1, theta1), 1]"])
def test_derivative_is_marked_after_any_wrong_position(position: str) -> None:
    definition = Definition("mine", "ddt(abs(p.x))", (Texts("Mine", "x"),))
    problem = generate("planar-2r/1", ["position", "mine"], definitions=[definition])
    _, marked = mark(problem, {"position": position, "mine": "qd1"}, secret="s")
    assert (marked.judgement.outcome, marked.points) == (Outcome.WRONG, 0)


def test_textbook_form_that_numbers_contradict_is_not_used(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("qdot.exercises.questions.custom.question.write_in_textbook_form", lambda entry: entry + 1)
    definition = Definition("mine", "norm(p)", (Texts("Unconfirmed", "x"),))
    assert find_failures(generate("planar-2r/1", ["mine"], definitions=[definition])) == []


def test_formula_that_is_too_long_to_simplify_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("qdot.exercises.questions.custom.question.MAX_OPERATIONS", 9)
    definition = Definition("mine", "norm(p)", (Texts("Too long", "x"),))
    with pytest.raises(QdotError, match="more than 9 operations"):
        generate("planar-2r/1", ["mine"], definitions=[definition])


@pytest.mark.parametrize(
    ("answer", "joint"), [("zeros(sin(theta1)/cos(theta2))", 1), ("zeros(diff(norm(p), theta2)*exp(theta1))", 2)]
)
def test_zeros_of_quotients_are_those_of_the_numerator(answer: str, joint: int, tmp_path: Path) -> None:
    problem = make_problem(tmp_path, f'prompt = "x"\nanswer = "{answer}"', more='variation = "chapter"\n')
    assert problem.parts[0].answer.as_typed() == f"[theta{joint} = 0, theta{joint} = pi]"
    assert find_failures(problem) == []


@pytest.mark.parametrize(("family", "number"), [("planar-2r", "a1"), ("elbow", "a3")])
def test_length_that_is_a_number_in_the_table_is_given_this_value(family: str, number: str, tmp_path: Path) -> None:
    question = f'prompt = "At {{given}}."\nanswer = "{number}*J[1, 1]"\ngiven = {{theta1 = "angle", theta2 = "angle", '
    question += 'a2 = "length", ' + ('theta3 = "angle", a3 = "length"}' if number == "a3" else 'a1 = "length"}')
    problem = make_problem(tmp_path, question, family)
    details, value = problem.parts[0].details_as(CustomDetails), list_table_numbers(problem.chain)[number]
    assert details.values[sp.Symbol(number)] == value and find_failures(problem) == []
    assert rf"{number[0]}_{{{number[1]}}} = {float(value):g}\,\text{{m}}" in write_prompt(problem, problem.parts[0])
    assert details.configuration is not None and sp.Symbol("a2") in details.configuration.lengths
    assert sp.Symbol("a2") not in details.values  # a second value


def test_options_are_shuffled_and_several_may_be_correct(tmp_path: Path) -> None:
    question = 'prompt = "x"\noptions = ["x2", "y2", "x1", "y1"]\nshown = "formula"'
    assignment = ask_mine(tmp_path, question, "elbow-3r")
    problems = [assignment.generate_problems(student)[0][1] for student in "abcdef"]
    assert len({problem.parts[0].answer.as_typed() for problem in problems}) > 1
    several_right = (
        'prompt = "x"\noptions = [{text = "no"}, {formula = "x1", right = true}, {formula = "x2", right = true}]'
    )
    problem = make_problem(tmp_path / "2", several_right, "elbow-3r")
    assert problem.parts[0].type == "selection" and find_failures(problem) == []
    right = "".join(problem.parts[0].answer.as_json())
    assert judge_answer(problem, right) == "correct" and judge_answer(problem, right[0]) == "partial"


@pytest.mark.parametrize(("question", "family", "answer", "advice"), read_cases("own_questions")["advice"])
def test_advice_names_missing_symbols_and_only_equations_that_exist(
    question: str, family: str, answer: str, advice: str, tmp_path: Path
) -> None:
    prompt = "Find it at {given}." if "given" in question else "Find it."
    problem = make_problem(tmp_path, f'prompt = "{prompt}"\n{question}', family)
    parsed = read_answer(problem, problem["mine"], answer)
    remark = advise(problem, problem["mine"], parsed, "seed")
    assert remark is not None and advice in remark.feedback


def test_masses_are_positive_in_counterexamples_and_on_platforms(tmp_path: Path) -> None:
    units = 'units = {m = "kg", b = "kg/s", F = "N", g = "m/s^2"}'
    problem = make_problem(tmp_path, f'prompt = "M?"\nanswer = "[sqrt(m^2)*g*p.x + b, F]"\n{units}')
    assert {name: problem.domain.roles[name] for name in "mbFg"} == {
        "m": "positive", "b": "positive", "F": "signed", "g": "signed"
    }  # fmt: skip
    part = problem["mine"]
    right = part.answer.as_typed().replace("sqrt(m**2)", "m")
    assert judge(problem, part, right, "seed").outcome is Outcome.CORRECT
    configurations = _sample_configurations(problem.chain, part, Stream("s"))
    assert all(configuration[sp.Symbol("m")] > 0 for configuration in configurations)


def test_text_answer_is_left_for_manual_grading(tmp_path: Path) -> None:
    problem = make_problem(tmp_path, 'prompt = "Why?"\nanswer = "text"')
    assert find_failures(problem) == []
    (answered,) = mark(problem, {"mine": "Because det J is zero."}, secret="s")
    assert (answered.judgement.outcome, answered.points) == (Outcome.UNGRADED, None)
    (blank,) = mark(problem, {"mine": "\nblank\n"}, secret="s")
    assert (blank.judgement.outcome, blank.points) == (Outcome.MISSING, 0)


def test_text_without_quotes_is_shown_to_the_person_who_marks_it(tmp_path: Path) -> None:
    problem = make_problem(tmp_path, 'prompt = "Why?"\nanswer = "text"')
    typed_texts = read_cases("own_questions")["typed_texts"]
    problems = {f"p{number}": problem for number in range(1, len(typed_texts) + 1)}
    notebook = make_student_notebook(NotebookContent("T", "hw", "s1", list(problems.items())))
    cells = [cell for cell in notebook.cells if cell.metadata.get("qdot", {}).get("part")]
    for cell, (source, cell_type, _) in zip(cells, typed_texts, strict=True):
        cell.source, cell.cell_type = source, cell_type
        if cell_type == "markdown":
            del cell["outputs"], cell["execution_count"]
    path = tmp_path / "mine.ipynb"
    path.write_text(nbformat.writes(notebook), encoding="utf-8")
    marked, rows = grade_notebook(path, problems), check_notebook(path).rows
    for (verdict,), row, (source, _, answer) in zip(marked.values(), rows, typed_texts, strict=True):
        if not answer:
            assert (verdict.judgement.outcome, row.is_readable) == (Outcome.MISSING, False), source
        else:
            assert (verdict.judgement.reason, verdict.points, verdict.answer) == (AWAITS_PERSON, None, answer), source
            assert row.is_readable and row.message.startswith("a text, which a person marks: "), source


@pytest.mark.parametrize(
    ("offsets", "ending", "answer"),
    sample_for_suite([
        ([1], ".ipynb", "Because det J = 0."), ([0], ".ipynb", "Because det J = 0."),
        ([1, 1], ".ipynb", "Because det J = 0.\n\nBecause det J = 0."), ([1], ".md", "Because det J = 0."),
        ([], ".ipynb", None), ([], ".md", None),
    ], 3),
)  # fmt: skip
def test_a_text_cell_beside_a_blank_answer_cell_is_the_answer_in_words(
    offsets: list[int], ending: str, answer: str | None, tmp_path: Path
) -> None:
    problem = make_problem(tmp_path, 'prompt = "Why?"\nanswer = "text"')
    problems = {"p1": problem, "p2": problem}
    notebook = make_student_notebook(NotebookContent("T", "hw", "s1", list(problems.items())))
    for offset in offsets:
        position = next(k for k, cell in enumerate(notebook.cells) if cell.id == "p1-mine")
        notebook.cells.insert(position + offset, nbformat.v4.new_markdown_cell("Because det J = 0."))
    path = tmp_path / f"mine{ending}"
    fenced_cells = [f"```python\n{c.source}\n```" if c.cell_type == "code" else c.source for c in notebook.cells]
    text = "\n".join(fenced_cells) if ending == ".md" else nbformat.writes(notebook)
    path.write_text(text, encoding="utf-8")
    first_verdict, second_verdict = (verdict for (verdict,) in grade_notebook(path, problems).values())
    assert second_verdict.judgement.outcome is Outcome.MISSING and (first_verdict.answer == answer or answer is None)
    assert first_verdict.judgement.outcome is (Outcome.UNGRADED if answer else Outcome.MISSING)
    if ending == ".ipynb":  # the metadata say that the answers are in words
        assert [row.is_readable for row in check_notebook(path).rows] == [answer is not None, False]


def test_accelerations_and_own_symbols_may_be_typed(tmp_path: Path) -> None:
    problem = make_problem(tmp_path, 'prompt = "x"\nanswer = "ddt(v)"\nrows = ["a_x", "a_y"]')
    prompt = write_prompt(problem, problem.parts[0]).strip()
    accelerations = r"$\ddot{\theta}_{1}$, $\ddot{\theta}_{2}$"
    assert prompt.endswith(rf"The answer may contain `qd1`, `qd2`, {accelerations} (typed `qdd1`, `qdd2`).")
    assert {"qdd1", "qdd2"} <= set(problem.symbols) and remove_typing_remarks(prompt, problem).endswith("}$.")
    assert r"\ddot{\theta}_{1}" in write_solution(problem, problem.parts[0])
    load = 'prompt = "x"\nanswer = "transpose(Jv)*[0, m*g, 0]"\nunits = {m = "kg", g = "m/s^2"}'
    problem = make_problem(tmp_path / "2", load)
    assert judge_answer(problem, problem.parts[0].answer.as_typed().replace("m*", "1.0*m*")) == "correct"


def test_halves_are_fractions_unless_lengths_are_numbers(tmp_path: Path) -> None:
    question = 'prompt = "x"\nanswer = "m/2*dot(o1, o1)"\nunits = {m = "kg"}'
    problem = make_problem(tmp_path, question, more='variation = "chapter"\n')
    assert r"\tfrac{1}{2} a_{1}^{2} m" in write_solution(problem, problem.parts[0])
    definition = Definition("mine", "a2*p.x/2", (Texts("Mine", "x"),))
    problem = generate("planar-2r/3", ["mine"], definitions=[definition])  # a2 is 0.35 m
    assert "0.175 a_{1}" in write_solution(problem, problem.parts[0])


@pytest.mark.parametrize(
    ("answer", "is_right"),
    [("M = m*a1^2", True), ("M := m*a1^2", True), ("M = 2*m*a1^2", False), ("m = m*a1^2", False), ("M = M*a1^2", True)],
)
def test_an_answer_may_have_a_capital_name_although_the_small_letter_is_a_symbol(
    answer: str, is_right: bool, tmp_path: Path
) -> None:
    question = 'prompt = "x"\nanswer = "m*a1^2"\nunits = {m = "kg"}'
    problem = make_problem(tmp_path, question, more='variation = "chapter"\n')
    assert (judge_answer(problem, answer) is Outcome.CORRECT) == is_right


def test_message_on_a_symbol_lists_no_symbols_of_other_questions(tmp_path: Path) -> None:
    text = '[question.mine]\nprompt = "x"\nanswer = "p.x"\n[question.other]\nprompt = "x"\nanswer = "m*p.x"\n'
    text += 'units = {m = "kg"}\n[[problem]]\nfamily = "planar-2r"\nquestions = ["mine", "other"]\n'
    ((_, problem),) = make_assignment(tmp_path, text).generate_problems("s1")
    reasons = [judge(problem, part, "k*a1", "seed").reason for part in problem.parts]
    assert [", m, " in reason for reason in reasons] == [False, True]


def test_german_texts_replace_english_ones_where_they_exist(tmp_path: Path) -> None:
    german = """[question.mine.de]
title = "Mitte"
prompt = 'In {base} und im {base} ist die Verschiebung von {base} nach {p} am {base} bekannt.'
"""
    question = f'title = "Middle"\nprompt = "x"\nanswer = "p"\nhints = ["In {{base}}", "b", "c"]\n{german}'
    problem = make_problem(tmp_path, question)
    part, frame = problem.parts[0], "Basiskoordinatensystem $O_0$"
    prompt = write_prompt(problem, part, "de").partition(" bekannt")[0]
    assert prompt.startswith(f"Im {frame} und im {frame} ist die Verschiebung vom {frame} nach $")
    assert prompt.endswith(f"am {frame}")
    assert [hint.strip() for hint in write_hints(problem, part, "de")] == ["In the base frame $O_0$", "b", "c"]
    record = make_site_record(problem)
    assert (record["parts"][0]["title"], translate_record(problem, record, "de")["parts"][0]["title"]) == (
        "Middle", "Mitte",
    )  # fmt: skip
    questions = find_custom_questions([BankProblem("p1", "p1-001", problem=problem)])
    assert json.loads(make_titles_json("de", [], questions))["questions"]["mine"] == "Mitte"


def test_digest_of_problems_ignores_wording(tmp_path: Path) -> None:
    questions = ['prompt = "x"\nanswer = "p"', 'prompt = "y"\nanswer = "p"', 'prompt = "x"\nanswer = "2*p"']
    made = [ask_mine(tmp_path / str(k), question) for k, question in enumerate(questions)]
    assert made[0].problems_digest == made[1].problems_digest != made[2].problems_digest
    assert made[0].notebook_digest != made[1].notebook_digest


# --- commands and exports ---

EVERY_KIND = read_data("assignments/every_kind_of_own_question.toml")


# "scorm" needs the site's scripts
@pytest.mark.parametrize("name", sample_for_suite([name for name in EXPORT_FORMATS if name != "scorm"], 2))
def test_every_export_accepts_every_kind_of_custom_question(name: str, tmp_path: Path) -> None:
    folder = make_assignment(tmp_path, EVERY_KIND).folder
    output = run("export", folder, "--to", name, "--variants", "1", "--jobs", "1")
    assert f"{name}: " in output and any((folder / "exports" / name).iterdir())


@pytest.mark.whole
def test_stack_export_leaves_out_only_what_fails_and_names_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """For the square of a distance, one of the likely mistakes is to take degrees for radians."""
    square = EVERY_KIND.replace("ddt((o1 + o2)/2)", "ddt(dot(p, p))").replace('rows = ["v_x", "v_y"]\n', "")
    folder = make_assignment(tmp_path, 'variation = "lengths"\n' + square).folder
    run("export", folder, "--to", "stack", "--variants", "1", "--jobs", "1")
    text = (folder / "exports" / "stack" / "hw-stack.xml").read_text()
    assert "p1-001, midpoint: T" in text and "p1-001, tip: T" in text

    def fail_for_tip(problem: Problem, part: Part, compute_earned_share: ShareOfTypedAnswer) -> StackPart | Reason:
        if part.name == "tip":
            raise ValueError("the sum diverges")
        return convert_part(problem, part, compute_earned_share)

    monkeypatch.setattr("qdot.exercises.exports.stack.convert_part", fail_for_tip)
    result = runner.invoke(app, ["export", str(folder), "--to", "stack", "--variants", "1", "--jobs", "1"])
    reason = "qdot itself failed: ValueError: the sum diverges; please report it"
    assert f"p1: STACK leaves out 'tip': {reason}" in result.stderr and result.exit_code == 0
    text = (folder / "exports" / "stack" / "hw-stack.xml").read_text()
    assert "p1-001, midpoint: T" in text and "p1-001, tip: T" not in text


def test_wrong_units_are_expected_only_where_they_change_the_number(tmp_path: Path) -> None:
    """Millimetres leave angles unchanged, and make torques a thousand times too large; metres, rates as much.

    A number that is nearly zero is no expected answer.
    """
    definitions = {
        "slope": ('"atan(p.y/p.x)"\ngiven = ["pose"]', "rad", {"result-in-degrees": 180 / sp.pi}),
        "torque": ('"p.x*F"\ngiven = {theta1 = "angle", theta2 = "angle", F = [1, 9]}\nunits = {F = "N"}', "N m",
                   {"millimetres": 1000, "centimetres": 100}),
        "rate": ('"dot(inv(J)*xd, [1, 0])"\ngiven = ["pose", "velocity"]', "rad/s",
                 {"result-in-degrees": 180 / sp.pi, "thousandth": 1000}),
    }  # fmt: skip
    definitions["lever"] = ('"a1*cos(theta1)"\ngiven = ["pose"]', "m", definitions["torque"][2])
    definitions["area"] = ('"a2*p.x"\ngiven = ["pose"]', "m^2", {"millimetres": 1e6, "centimetres": 1e4})
    definitions["speed"] = ('"v.x"\ngiven = ["pose", "rates"]', "m/s", definitions["torque"][2])
    for name, (answer, unit, expected_factors) in definitions.items():
        question = f'prompt = "{{given}}"\nunit = "{unit}"\nanswer = {answer}'
        problem = make_problem(tmp_path / name, question, "polar-rp" if name == "speed" else "planar-2r")
        (part,) = problem.parts
        units = {"result-in-degrees", "millimetres", "thousandth", "centimetres"}
        wrong_answers = {known.mistake: known for known in find_known_wrong_answers(problem, part, 20)}
        factors = {
            name: wrong_answers[name].matrix[0] / part.answer.as_matrix()[0] for name in units & set(wrong_answers)
        }
        assert factors == pytest.approx({name: float(factor) for name, factor in expected_factors.items()}, rel=1e-4)


def test_questions_of_the_same_name_have_their_own_wrong_answers() -> None:
    wrong_answers = []
    for answer in ("dot(p, p)", "p.x"):
        definition = Definition("same-name", answer, (Texts("Mine", "x"),))
        problem = generate("planar-2r/3", ["same-name"], definitions=[definition])
        wrong_answers.append({str(wrong.matrix) for wrong in find_known_wrong_answers(problem, problem.parts[0], 3)})
    assert all(wrong_answers) and wrong_answers[0].isdisjoint(wrong_answers[1])


@pytest.mark.parametrize("sheet", ["exam", "key", "marking"])
def test_text_question_is_laid_out_on_paper(sheet: str, tmp_path: Path) -> None:
    folder = make_assignment(tmp_path, EVERY_KIND).folder
    run("export", folder, "--to", "html", "--sheet", sheet, "--jobs", "1")
    pages = "".join(path.read_text() for path in (folder / "exports" / "html").rglob("*.html"))
    assert ("Because the rates grow" in pages) == (sheet != "exam")
    assert ("decision, from 0 to 1 points" in pages) == (sheet == "marking")
    assert "A person marks it" not in pages


@pytest.mark.whole
def test_text_question_becomes_an_essay_in_moodle(tmp_path: Path) -> None:
    folder = make_assignment(tmp_path, EVERY_KIND).folder
    run("export", folder, "--to", "moodle", "--variants", "1", "--jobs", "1")
    bank = (folder / "exports" / "moodle" / "hw.xml").read_text()
    essay = bank[bank.index('<question type="essay">') :]
    assert "Explain why." in essay and "Because the rates grow" in essay[essay.index("<graderinfo") :]


def test_a_person_marks_a_text_in_nbgrader(tmp_path: Path) -> None:
    folder = make_assignment(tmp_path, EVERY_KIND).folder
    run("export", folder, "--to", "nbgrader", "--jobs", "1")
    points = {f"p1.{name}": 1.0 for name in ("midpoint", "tip", "where", "which", "why")}
    for path in ("source/hw/hw.ipynb", "handout/s1/hw/hw.ipynb"):
        cells = json.loads((folder / "exports/nbgrader" / path).read_text())["cells"]
        restored = restore_cells(json.loads(json.dumps(cells)), points, {"p1.why"})
        for each in (cells, restored):
            kinds = {
                data["grade_id"]: (data["grade"], data["solution"])
                for cell in each
                if (data := cell["metadata"].get("nbgrader"))
            }
            assert kinds["p1-why"] == (True, True) and "p1-why-answer" not in kinds
            assert kinds["p1-tip"] == (True, False) and kinds["p1-tip-answer"] == (False, True)


def test_a_browser_can_mark_all_but_texts(tmp_path: Path) -> None:
    kept, left_out = make_assignment(tmp_path, EVERY_KIND).without_text_questions()
    assert left_out == ("why",)
    problem = kept.slots[0].generate_from_seed(1)
    record = make_site_record(problem)
    assert [part["name"] for part in record["parts"]] == ["midpoint", "tip", "where", "which"]
    assert record["parts"][0]["names"] == ["qd1", "qd2"] and all(part["key"] for part in record["parts"])
    questions = find_custom_questions([BankProblem("p1", "p1-001", problem=problem)])
    index = json.loads(
        make_index_json([{"family": "p1", "questions": ["midpoint", "tip"]}], [("p1", "", "")], "", questions)
    )
    assert [question["title"] for question in index["questions"]] == ["Midpoint", "Tip"]
    only_text = make_assignment(tmp_path / "2", re.sub(r'\["midpoint.*"why"\]', '["why"]', EVERY_KIND))
    with pytest.raises(QdotError, match="mark every question"):
        only_text.without_text_questions()


BUILT_IN = [name for name, question in QUESTIONS.items() if question.formula and not question.sample]


@pytest.mark.parametrize(("setting", "words", "error"), read_cases("own_questions")["precisions"])
def test_a_number_is_marked_to_the_precision_that_its_prompt_states(
    setting: str, words: str, error: float, tmp_path: Path
) -> None:  # fmt: skip
    given, answer = 'given = ["pose", "rates"]', 'answer = "12.3456*norm(v)/norm(v) + v.x/1000"'
    question = f'prompt = "{{given}}"\n{given}\n{answer}\n{setting}'
    problem = make_problem(tmp_path, question)
    (number,) = map(float, problem.parts[0].answer.as_json())
    assert words in write_prompt(problem, problem.parts[0])
    allowed = error * (1 if "tolerance" in setting else number)
    assert judge_answer(problem, f"{number + allowed:.12g}") == "correct"
    assert judge_answer(problem, f"{number + 1.5 * allowed:.12g}") == "wrong"
    (wrong,) = mark(problem, {"mine": "-7.2"}, secret="s")
    solution, key = write_solution(problem, problem.parts[0]), write_short_answer(problem, problem.parts[0])
    for text in (solution, key, wrong.judgement.reason.replace("-7.2", "")):
        (shown_number,) = re.findall(r"\d+\.\d+", text)
        assert judge_answer(problem, shown_number) == "correct"


@pytest.mark.parametrize("name", BUILT_IN)
def test_custom_question_with_the_formula_of_a_built_in_question_has_its_answer(name: str) -> None:
    family = "planar-3r" if name == "gram-determinant" else "planar-2r"
    chain, part = (problem := generate(f"{family}/3", [name])).chain, problem.parts[0]
    rows = () if "determinant" in name else tuple(QUESTIONS[name].name_entries(chain, part.details))
    definition = Definition("mine", QUESTIONS[name].formula, (Texts("Mine", "x"),), rows=rows)
    problem = generate(f"{family}/3", [name, "mine"], definitions=[definition])
    built_in, own = (part.answer.as_matrix() for part in problem.parts)
    assert (built_in - own).applyfunc(lambda entry: sp.simplify(sp.expand_trig(entry))).is_zero_matrix
    assert find_failures(problem) == []


@pytest.mark.parametrize(
    ("answer", "unit", "warning"),
    [
        ("norm(p) + theta1", "m", "adds quantities of different units"),
        ("sin(p.x)", "m", "a function of a quantity with a unit"),
        ("det(J)*d2", "m^2", None), ("norm(v)", "m/s", None), ("qd1*theta1", "rad/s", None), ("p.x*a1", "m^2", None),
        ("norm(v)", "", "it has no unit, but the answer is in m/s"),
        ("qd1*p.x*10", "kg m/s", "its unit kg m/s doesn't fit, because the answer is in m/s; if a number in the"),
        ("qd", "rad/s, m/s", None), ("qd", "", "different units"),
        ("a1 + theta1*qd1", None, "line 6: question: mine: answer = \"a1 + theta1*qd1\": for polar-rp, it has no unit"),
        ("p.x + 0.3", None, "if a number in the formula has a unit"), ("[p.x, theta1*qd2^2/2]", None, None),
        ("transpose(J)*f", None, None), ("ddt(v)", None, None),
    ],
)  # fmt: skip
def test_a_unit_that_does_not_fit_is_said(answer: str, unit: str | None, warning: str | None, tmp_path: Path) -> None:
    given = 'prompt = "{given}"\ngiven = ["pose", "rates"]' if unit is not None else 'prompt = "x"\n'
    rows = 'rows = ["v_x", "v_y"]\n' if "v)" in answer and unit is None else ""
    unit_line = f'unit = "{unit}"\n' if unit is not None else rows
    assignment = ask_mine(tmp_path, f'{given}\nanswer = "{answer}"\n{unit_line}', "polar-rp")
    notes = [note for note in assignment.notes if "mine" in note]
    assert bool(notes) == (warning is not None) and (warning is None or warning in notes[0])
    errors = runner.invoke(app, ["show", str(assignment.folder)]).stderr
    assert (warning or "") in errors and bool(errors) == (warning is not None)


@pytest.mark.parametrize(("text", "is_right"), read_cases("own_questions")["units_of_rates"])
def test_numbers_may_have_different_units(text: str, is_right: bool, tmp_path: Path) -> None:
    given = 'prompt = "{given}"\ngiven = ["pose", "rates"]\nanswer = "qd"\nunit = "rad/s, m/s"'
    problem = make_problem(tmp_path, given, "polar-rp")
    part = problem["mine"]
    angle_rate, speed = map(float, part.answer_as(Number).reference)
    typed = text.format(angle_rate, speed, math.degrees(angle_rate), 1000 * speed)
    assert (judge_answer(problem, typed) is Outcome.CORRECT) == is_right
    assert "two numbers in rad/s and m/s, in this order, each" in write_prompt(problem, part)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("{0} rad/s, {1} m/s", Outcome.CORRECT), ("{2} rad/s, {1} m/s", Outcome.CORRECT),
        ("{0} rad/s, {3} m/s", Outcome.PARTIAL), ("{2} rad/s, {4} m/s", Outcome.PARTIAL),
    ],
)  # fmt: skip
def test_numbers_may_have_different_tolerances(text: str, expected: Outcome, tmp_path: Path) -> None:
    """The rate may be off by 0.02 rad/s, the speed by 1 mm/s."""
    given = 'prompt = "{given}"\ngiven = ["pose", "rates"]\nanswer = "qd"\nunit = "rad/s, m/s"'
    problem = make_problem(tmp_path, f'{given}\ntolerance = "0.02 rad/s, 1 mm/s"', "polar-rp")
    part = problem["mine"]
    angle_rate, speed = map(float, part.answer_as(Number).reference)
    typed = text.format(angle_rate, speed, angle_rate + 0.019, speed + 0.002, speed - 0.002)
    assert judge_answer(problem, typed) is expected
    order = "two numbers in rad/s and m/s, in this order: within 0.02 rad/s, within 1 mm/s."
    assert order in write_prompt(problem, part)
    german_order = "in rad/s und m/s, in dieser Reihenfolge: auf 0,02 rad/s genau, auf 1 mm/s genau."
    assert german_order in write_prompt(problem, part, "de")
    key = make_site_record(problem)["parts"][0]["key"]
    assert (key["tolerance"], key["floor"], key["floors"]) == (0, 0.001, [0.02, 0.001])


@pytest.mark.parametrize(("question", "family", "warning"), read_cases("own_questions")["warnings"])
def test_what_is_probably_not_meant_is_a_warning_with_its_line(
    question: str, family: str, warning: str, tmp_path: Path
) -> None:
    prompt = "" if "prompt" in question else 'prompt = "x"\n'
    notes = [note for note in ask_mine(tmp_path, f"{prompt}{question}", family).notes if "mine" in note]
    assert [warning] == [warning for note in notes if warning in note] if warning else not notes
    assert all("assignment.toml: line " in note and f": for {family}, " in note for note in notes)


@pytest.mark.parametrize("family", ["planar-2r", "planar-3r", "scara", "polar-rp"])
def test_no_number_and_no_sum_of_rates_is_0_by_chance(family: str) -> None:
    definition = Definition(
        "mine", "v", (Texts("Mine", "{given}"),), rows=("v_x", "v_y"), unit="m/s",
        given=(GivenValue("pose"), GivenValue("rates")),
    )  # fmt: skip
    for seed in range(40):
        problem = generate(f"{family}/{seed}@chapter", ["mine"], definitions=[definition])
        values = problem["mine"].details_as(CustomDetails).list_given_values(problem.chain)
        revolute_joints = problem.chain.revolute_joints
        assert all(map(float, problem["mine"].answer.as_matrix()))
        assert all(values[problem.chain.q[i].name] for i in revolute_joints)
        rates = [Fraction(f"{values[problem.chain.rates[i].name]:.6f}") for i in revolute_joints if i < 3]
        assert all(sum(rates[i:j]) for i, j in combinations(range(len(rates) + 1), 2))


def test_a_fixed_value_may_be_0() -> None:
    given = (GivenValue("theta1", "angle"), GivenValue("theta2"), GivenValue("qd1"), GivenValue("qd2", "rate"))
    definition = Definition("mine", "v.x", (Texts("Mine", "{given}"),), unit="m/s", given=given)
    problem = generate("planar-2r/3@chapter", ["mine"], definitions=[definition])
    values = problem["mine"].details_as(CustomDetails).list_given_values(problem.chain)
    assert (values["theta2"], values["qd1"]) == (0, 0) and values["qd2"]


def test_a_mass_is_no_unit_when_the_solution_is_simplified() -> None:
    definition = Definition("mine", "m*transpose(Jv)*Jv", (Texts("Mine", "x"),), units=(("m", "kg"),))
    problem = generate("cylindrical/1@chapter", ["mine"], definitions=[definition])
    assert problem["mine"].answer.as_json()[0] == ["m*(a2**2 + d3**2)", "0", "a2*m"]


@pytest.mark.parametrize(("answer", "given", "unit"), read_cases("own_questions")["given_symbols"])
def test_given_symbols_have_their_units(answer: str, given: str, unit: str, tmp_path: Path) -> None:
    keys = f'prompt = "{{given}}"\nanswer = "{answer}"\nunit = "{unit}"\ngiven = {{theta1 = "angle", {given}}}'
    assert ask_mine(tmp_path, keys, "polar-rp", 'variation = "chapter"\n').notes == ()


def test_other_sets_than_the_singular_one_are_not_called_singular(tmp_path: Path) -> None:
    problem = make_problem(tmp_path, 'prompt = "When is $x$ fixed?"\nanswer = "zeros(Jv[1, 2])"')
    verdict = mark(problem, {"mine": "[Eq(theta2, 0)]"}, secret="s")[0]
    text = verdict.judgement.reason + (verdict.diagnosis.feedback if verdict.diagnosis else "")
    assert verdict.points == 0 and "a configuration is missing" in text
    assert not any(word in text for word in ("singular", "determinant", "det J", "(6.8)"))
    assert draw_singular_configurations(problem, problem.parts[0], "x") == ""
    request = ExportRequest(load_assignment(tmp_path / "hw"), find_failures, variant_count=1)
    (item,) = make_items(request)
    assert item.title.startswith("Mine") and "When is $x$ fixed?" in str(item.body[-1])
    assert isinstance(item.form, ChoiceForm) and len(item.form.options) == 4


def test_a_slide_is_solved_before_the_angle(tmp_path: Path) -> None:
    problem = make_problem(tmp_path, 'prompt = "x"\nanswer = "zeros(det(J), p.x)"', "polar-rp")
    answer = problem.parts[0].answer_as(ConditionSet)
    assert all(component.solutions for component in answer.components) and find_failures(problem) == []


def test_show_and_verify_accept_custom_questions(tmp_path: Path) -> None:
    folder = make_assignment(tmp_path, EVERY_KIND).folder
    samples, of_ada = run("show", folder), run("show", folder, "--student", "s1", "--solution")
    assert "Which of these is" in samples and "Because the rates grow" not in samples
    assert "Because the rates grow" in of_ada and samples.splitlines()[:4] == of_ada.splitlines()[:4]
    assert "'s2'" in run_and_fail("show", folder, "--student", "s2")
    assert "--student needs" in run_and_fail("show", "planar-2r/7", "--student", "s1")
    pdf = make_pdf_preview(load_assignment(folder), "preview", [generate("planar-2r/7")], has_solutions=False)
    assert pdf.startswith(b"%PDF")
    path = GALLERY_FOLDER / "tip-speed.toml"
    output = run("verify", path, "--family", "planar-2r", "--count", "4", "--jobs", "1").splitlines()
    assert [line.split(":")[0] for line in output[:-1]] == [f"tip-speed for planar-2r/{seed}" for seed in range(3)]
    assert output[-1] == "4 problems verified, 0 failed"
    assert "name the families" in run_and_fail("verify", path)
    printed = run("verify", folder / "assignment.toml", "--family", "planar-2r", "--count", "1", "--jobs", "1")
    assert "5 problems verified, 0 failed" in printed
    result = runner.invoke(app, ["verify", str(folder / "assignment.toml"), "--family", "planar-3r", "--count", "1"])
    assert "4 problems verified, 0 failed" in result.stdout and "where: answer" in result.stderr
    assert "--family planar-2r" in run_and_fail("verify", path, "planar-2r/7", "--family", "planar-2r")


def test_verify_fails_for_a_family_whose_problem_asks_the_question(tmp_path: Path) -> None:
    more = '[[problem]]\nfamily = "polar-rp"\nquestions = ["position"]\n'
    question = 'prompt = "{pose}, {force}"\ngiven = ["pose", "force"]\nanswer = "transpose(J)*f"\nunit = "N m"'
    path = ask_mine(tmp_path, question, more='variation = "chapter"\n').folder / "assignment.toml"
    path.write_text(path.read_text("utf-8") + more, "utf-8")
    printed = run("verify", path, "--count", "4", "--jobs", "1")
    assert "2 problems verified, 0 failed" in printed and "polar-rp" not in printed
    path.write_text(path.read_text("utf-8").replace('["position"]', '["mine"]'), "utf-8")
    assert "its unit N m doesn't fit" in run_and_fail("verify", path, "--count", "4", "--jobs", "1")


def test_options_that_are_matrices_are_displayed_over_several_lines(tmp_path: Path) -> None:
    problem = make_problem(tmp_path, 'prompt = "x"\nshown = "formula"\noptions = ["x1", {text = "none of these"}, "p"]')
    (part,) = problem.parts
    rows = [line for line in show_assignment("T", [("p1", problem)]).splitlines() if re.search("[⎡⎢⎣]", line)]
    assert len(rows) == 6 and all(re.fullmatch(r" +([AB]\. +)?[⎡⎢⎣][^⎡⎢⎣]*", row) for row in rows)
    options = arrange_options(problem, part)
    assert options is not None and [option.text[:2] for option in options.options] == ["$$", "$$", "no"]
    (item,) = make_items(ExportRequest(load_assignment(tmp_path / "hw"), find_failures, variant_count=1))
    assert isinstance(item.form, ChoiceForm) and "bmatrix" not in str(item.body[-1])


def test_option_about_the_others_stays_last(tmp_path: Path) -> None:
    options = 'prompt = "x"\nshown = "formula"\noptions = ["x1", {text = "None of these"}, "y2", "z0"]'
    slot = ask_mine(tmp_path, options).slots[0]
    answers = [slot.generate_from_seed(seed).parts[0].answer.offered_options for seed in range(8)]
    assert {options[-1] for options in answers} == {"None of these"} and len(set(answers)) > 1


@pytest.mark.parametrize("format", ["text", "html", "latex"])
def test_an_answer_in_words_has_no_typed_form(format: str, tmp_path: Path) -> None:
    problem = make_problem(tmp_path, 'prompt = "x"\nanswer = "text"\nsolution = "Because."')
    shown = show_assignment("T", [("p1", problem)], solution=True, format=format)
    assert "Because." in shown and "Typed answer" not in shown and "A person marks this answer" not in shown


def test_preview_needs_only_the_assignment_file(tmp_path: Path) -> None:
    folder = make_assignment(tmp_path, EVERY_KIND).folder
    secret = (folder / "secret.txt").read_bytes()
    (folder / "secret.txt").unlink()
    (folder / "roster.csv").unlink()
    assert "Which of these is" in run("show", folder)
    (folder / "secret.txt").write_bytes(secret)
    assert "roster.csv: file not found" in run_and_fail("show", folder, "--student", "s1")


def test_students_are_told_that_multiples_count(tmp_path: Path) -> None:
    problem = make_problem(tmp_path, 'prompt = "x"\nanswer = "v"\nrows = ["v_x", "v_y"]\nup_to_factor = true')
    answer_line = write_prompt(problem, problem.parts[0]).splitlines()[-1]
    assert answer_line == (
        "**Answer:** a 2 × 1 vector, in the order $v_x, v_y$. Any nonzero multiple is also correct. "
        "The answer may contain `qd1`, `qd2`."
    )
    first, second = problem.parts[0].answer.list_formulas()
    assert judge_answer(problem, f"[-2*({first}), -2*({second})]") == "correct"


# --- refused, with the reason ---

REFUSED = read_cases("refused_questions")["case"]


@pytest.mark.parametrize("case", REFUSED, ids=lambda case: case["question"])
def test_invalid_question_is_refused_with_file_line_and_reason(case: dict[str, str], tmp_path: Path) -> None:
    question = case["question"] if case["question"].startswith("prompt") else 'prompt = "x"\n' + case["question"]
    more = f'variation = "{case["variation"]}"\n' if "variation" in case else ""
    with pytest.raises(QdotError) as refused:
        make_problem(tmp_path, question, case.get("family", "planar-2r"), more)
    message = str(refused.value)
    assert re.search(".*".join(map(re.escape, case["reason"].split(" … "))), message) and "\n" not in message
    assert "assignment.toml: line " in message and re.search("question(: |[.])m|not valid TOML", message)


@pytest.mark.parametrize("depth", [100, 1000])
def test_deeply_nested_latex_is_refused(depth: int, tmp_path: Path) -> None:
    with pytest.raises(QdotError, match=r"line 4: .* is nested too deeply"):
        make_problem(tmp_path, "prompt = '$" + depth * r"\hat" + " a$'\nanswer = 'p'")


def test_a_misspelt_name_gets_a_suggestion_and_an_unknown_index_is_no_missing_unit(tmp_path: Path) -> None:
    tables = '[question.slope]\nprompt = "x"\nanswer = "p"\n[[problem]]\nfamily = "scara"\nquestions = ["slop"]\n'
    with pytest.raises(QdotError, match="did you mean 'slope'"):
        make_assignment(tmp_path, tables)

    assert "units" not in str(UnknownName("name", "o7", ["o1", "theta1"]))


def test_question_that_does_not_apply_to_the_arm_of_one_student_is_reported_with_its_line(tmp_path: Path) -> None:
    """The zeros are found for the arm on which the file is checked, but not for that of ada."""
    text = (
        'variation = "zeros"\n[question.mine]\nprompt = "x"\nanswer = "zeros(p.x - p.y*d3)"\n'
        '[[problem]]\nfamily = "spherical"\nquestions = ["mine"]\n'
    )
    assignment = make_assignment(tmp_path, text)
    with pytest.raises(QdotError, match=r'line 6: question: mine: answer = "zeros.*find its zeros'):
        assignment.slots[0].generate_from_seed(1)


def test_values_that_the_answer_does_not_need_may_be_left_out(tmp_path: Path) -> None:
    """The norm of v does not depend on theta1, and the prompt states the fixed mass in its own words."""
    question = """prompt = "A mass of 2 kg: {theta2}, {qd1}, {qd2}, {a1}, {a2}."
given = {theta2 = "angle", qd1 = "rate", qd2 = "rate", m = 2}
units = {m = "kg"}
answer = "m*norm(v)"
"""
    assert find_failures(make_problem(tmp_path, question)) == []
    assignment = ask_mine(tmp_path / "2", question.replace(", {a2}", ""))
    problems = [assignment.generate_problems(student)[0][1] for student in "abcdefgh"]
    is_symbolic = ["a2" in {symbol.name for symbol in problem.chain.parameters} for problem in problems]
    assert any(is_symbolic) and [bool(find_failures(problem)) for problem in problems] == is_symbolic


def test_one_question_of_a_file_can_be_chosen(tmp_path: Path) -> None:
    question = 'prompt = "x"\nanswer = "{}"\n'
    (tmp_path / "mine.toml").write_text(
        f"[question.mine]\n{question.format('p')}[question.inverse]\n{question.format('inv(J)')}"
    )
    text = '[[problem]]\nfamily = "planar-3r"\nquestions = ["../../mine.toml{}"]\n'
    assert make_assignment(tmp_path / "1", text.format("#mine")).slots[0].questions == ("mine",)
    for chosen, message in (("", "needs a square"), ("#mind", "unknown question 'mind' .did you mean 'mine'")):
        with pytest.raises(QdotError, match=message):
            make_assignment(tmp_path / f"2{chosen}", text.format(chosen))


@pytest.mark.parametrize(
    ("question", "place"),
    [
        ('answer = "p*p"', 'line 3: question: mine: answer = "p*p": '),
        ('options = ["a", "b",\n"z9"]\nshown = "formula"', "line 3: question: mine: options"),
        ('answer = "p"\n[question.mine.de]\nprompt = "{posse}"', 'line 5: question: mine: de: prompt = "{posse}": '),
    ],
)  # fmt: skip
def test_error_names_the_file_the_line_and_the_key(question: str, place: str, tmp_path: Path) -> None:
    (tmp_path / "hw").mkdir()
    path = tmp_path / "hw" / "mine.toml"
    path.write_text(f'[question.mine]\nprompt = "x"\n{question}\n')
    with pytest.raises(QdotError) as refused:
        make_assignment(tmp_path, '[[problem]]\nfamily = "planar-2r"\nquestions = ["mine.toml"]\n')
    assert 'assignment.toml: line 5: problem 1: questions = ["mine.toml"]: ' in str(refused.value)
    assert f"hw/mine.toml: {place}" in str(refused.value)
    assert f"hw/mine.toml: {place}" in run_and_fail("verify", path, "--family", "planar-2r")


ROBOTICS_TEXT = read_data("robotics.md")


def test_latex_of_robotics_is_shown_in_every_format(tmp_path: Path) -> None:
    question = f"prompt = '''{ROBOTICS_TEXT}'''\nanswer = 'p'\nsolution = '''{ROBOTICS_TEXT}'''"
    assignment = ask_mine(tmp_path, question, more='variation = "chapter"\n')
    problems = assignment.generate_problems("s1")
    formats = ("text", "html", "latex", "ipynb")
    shown = {name: show_assignment("T", problems, format=name, solution=True) for name in formats}
    assert "v\u20d7 = 𝐉 (𝒒) 𝒒\u0307, 𝐳₁\u0302 ⊥ a\u0304 ∥ b\u0303, ‖v‖ ≠ ‖q\u0308‖, Jᵀ ∈ ℝ^(n×3)" in shown["text"]
    assert "$5:" in shown["text"]
    assert r"\frac{a_{1}}{b_{1}}" in shown["latex"]
    assert r"\\dot{\\hat{\\mathbf{x_{1}}}}" in shown["ipynb"]
    assert all(f"&#x{ord(char):05X};" in shown["html"] for char in "𝐉ℝ𝒩∞∀∠⊥∥‖∇")
    assert make_pdf_preview(assignment, "preview", [problems[0][1]], has_solutions=True)[:4] == b"%PDF"


def test_title_is_shown_literally(tmp_path: Path) -> None:
    question = "title = 'Speed of *P* & a_b <b> #1 50 %'\nprompt = 'x'\nanswer = 'p'"
    problems = ask_mine(tmp_path, question).generate_problems("s1")
    shown = {name: show_assignment("T", problems, format=name) for name in ("text", "latex", "html", "ipynb")}
    assert "Speed of *P* & a_b <b> #1 50 %" in shown["text"]
    assert r"Speed of *P* \& a\_b <b> \#1 50 \%" in shown["latex"]
    assert "Speed of *P* &amp; a_b &lt;b&gt; #1 50 %" in shown["html"]
    assert r"Speed of \\*P* & a_b \\<b> #1 50 %" in shown["ipynb"]


def test_power_in_a_unit_is_a_superscript_in_every_format(tmp_path: Path) -> None:
    question = (
        'prompt = "At {given}:"\nanswer = "m*g*p.y"\n'
        'given = {theta1 = "angle", theta2 = "angle", m = [1, 5], g = 9.81}\n'
        'units = {m = "kg", g = "m/s^2"}\nunit = "kg*m^2/s^2"'
    )
    assignment = ask_mine(tmp_path, question)
    problems = assignment.generate_problems("s1")
    shown = {name: show_assignment("T", problems, format=name, solution=True) for name in ("text", "latex", "html")}
    assert r"$g = 9.81\,\text{m/s}^{2}$" in shown["latex"]
    assert shown["latex"].count(r"\text{kg m}^{2}\text{/s}^{2}") == 2  # in the prompt and in the solution
    assert "g = 9.81 m/s²" in shown["text"] and shown["text"].count("kg m²/s²") == 2
    assert "^" not in re.sub("<pre.*?</pre>", "", shown["html"], flags=re.DOTALL)
    (item,) = make_items(ExportRequest(assignment, find_failures, variant_count=1))
    assert "kg m²/s²" in repr(item.form)


def test_latex_keeps_its_braces(tmp_path: Path) -> None:
    problem = make_problem(
        tmp_path,
        r"""prompt = 'Let $\frac{a}{b}^{2}_{i}$ and $M = {p.x}$ in {{braces}}.'
answer = "p" """,
    )
    text = write_prompt(problem, problem.parts[0])
    assert r"$\frac{a}{b}^{2}_{i}$" in text and "in {braces}." in text and r"\cos" in text


@pytest.mark.parametrize(
    ("questions", "message"),
    {
        '["a.toml", "b.toml"]': "a.toml: line 2: question: mine; ",
        '["https://example.org/a.toml"]': "is a web address; download the file, and write its path",
        '["a.tml"]': "'a.tml' is not a question; the name of a file of questions ends in .toml",
        '["empty.toml"]': "empty.toml: it defines no questions; write each in a table [question.NAME]",
    }.items(),
)
def test_files_of_questions_are_named_in_errors(questions: str, message: str, tmp_path: Path) -> None:
    (tmp_path / "hw").mkdir()
    for name, answer in (("a", "p"), ("b", "v")):
        (tmp_path / "hw" / f"{name}.toml").write_text(f'\n[question.mine]\nprompt = "x"\nanswer = "{answer}"\n')
    (tmp_path / "hw" / "empty.toml").write_text("")
    with pytest.raises(QdotError) as refused:
        make_assignment(tmp_path, f'[[problem]]\nfamily = "planar-2r"\nquestions = {questions}\n')
    assert f"assignment.toml: line 5: problem 1: questions = {questions}: " in str(refused.value)
    assert message in str(refused.value)


def test_a_file_without_a_valid_question_is_not_verified(tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text('[question.mine]\nprompt = "{posse}"\nanswer = "p"\n[[problem]]\n')
    assert "unknown name 'posse'" in run_and_fail("verify", tmp_path / "mine.toml", "--family", "planar-2r")


def test_invalid_question_name_is_refused(tmp_path: Path) -> None:
    for name in ("Mine", "position", "my_question", "x" * 41):
        with pytest.raises(QdotError, match="question: "):
            make_assignment(tmp_path / name, f'[question.{name}]\nprompt = "x"\nanswer = "p"\n')


def test_long_or_deep_formula_is_refused_quickly() -> None:
    for text in ("(" * 300 + "p" + ")" * 300, "+".join(["p"] * 100), "p" + ".x" * 300, "-" * 490 + "p"):
        with pytest.raises(FormulaError):
            parse(text)


# --- random formulas ---

SCALARS = (
    "p.x", "p.y", "v.x", "det(J)", "theta1", "J[1, 2]", "norm(o1)", "dot(z1, p)", "sin(theta2)", "x1.y", "2", "1/3",
)  # fmt: skip
VECTORS = ("p", "v", "o1", "z0", "x2", "qd1*p", "cross(z0, p)", "J*qd")
FUZZ_FAMILIES = ("planar-2r", "polar-rp", "elbow-3r")


def make_random_formula(stream: Stream, depth: int = 0) -> str:
    if depth > 2 or stream.integer(0, 3) == 0:
        return stream.choice(SCALARS + VECTORS)
    first, second = make_random_formula(stream, depth + 1), make_random_formula(stream, depth + 1)
    forms = (
        f"({first} + {second})", f"({first} - {second})", f"{first}*{second}", f"ddt({first})", f"{first}/a2",
        f"diff({first}, theta1)", f"at({first}, theta1 = 0)", f"dot({first}, {second})", f"norm({first})",
        f"({first})^2",         f"[{first}, {second}]", f"cross({first}, {second})", f"sin({first})",
    )  # fmt: skip
    return stream.choice(forms)


def change_entry(entry: str, kind: int) -> str:
    changes: Sequence[Callable[[str], str]] = (
        lambda e: f"-({e})", lambda e: f"2*({e})", lambda e: f"({e}) + 1/7", lambda e: f"({e}) + theta1/9",
        lambda e: e.replace("sin", "cos", 1), lambda e: e.replace("theta1", "theta2"), lambda e: f"({e})*cos(theta1)",
        lambda e: f"({e}) - qd1/5", lambda e: e.replace("+", "-", 1), lambda e: f"({e})^2",
    )  # fmt: skip
    return changes[kind](entry)


def check_random_question(number: int) -> bool:
    """Certify a random question, or return False if it is refused with a reason."""
    stream = Stream(f"custom/{number}")
    family, answer = FUZZ_FAMILIES[number % len(FUZZ_FAMILIES)], make_random_formula(stream)
    try:
        definition = Definition("mine", answer, (Texts("Mine", "x"),))
        problem = generate(f"{family}/{number}", ["mine"], definitions=[definition])
    except QdotError as error:
        assert str(error).strip() and "Traceback" not in str(error)
        return False
    part = problem.parts[0]
    assert find_failures(problem) == [], answer
    entries = part.answer.list_formulas()
    forms = ("({})*1", "sin(theta1)^2 + cos(theta1)^2 - 1 + {}", "-(-({}))")
    for form in forms:
        assert judge_answer(problem, write_answer(part, [form.format(entry) for entry in entries])) == "correct", answer
    for kind in range(10):
        changed = [change_entry(entry, kind) for entry in entries]
        if not any(formulas_differ(problem, a, b) for a, b in zip(entries, changed, strict=True)):
            continue
        assert judge_answer(problem, write_answer(part, changed)) != "correct", (answer, kind)
    return True


def write_answer(part: Part, entries: list[str]) -> str:
    rows, columns = part.shape or (1, 1)
    if part.shape is None:
        return entries[0]
    return "[" + ", ".join("[" + ", ".join(entries[r * columns : (r + 1) * columns]) + "]" for r in range(rows)) + "]"


def formulas_differ(problem: Problem, first: str, second: str) -> bool:
    names = sorted({*problem.symbols, *find_names(parse_formula(first)), *find_names(parse_formula(second))})
    values = {sp.Symbol(name): sp.Float(0.3 + 0.17 * k) for k, name in enumerate(names)}
    values |= {sp.Symbol(n): info.value for n, info in problem.symbols.items() if info.value is not None}
    a, b = (sp.sympify(text.replace("^", "**")).xreplace(values) for text in (first, second))
    return abs(complex(sp.N(a)) - complex(sp.N(b))) > 1e-6


@pytest.mark.parametrize("block", select_for_suite((0, 2, 8), range(12)))  # formulas of 1 and 3 take ten seconds
def test_random_formulas_are_certified_or_refused(block: int) -> None:
    certified = sum(check_random_question(number) for number in range(10 * block, 10 * block + 10))
    assert certified


def test_formula_language_excludes_python_code() -> None:
    for text in ("p if p else v", "[x for x in p]", "p and v", "p < v", "f'{p}'", "p := v", "lambda x: x", "p[0:1]"):
        with pytest.raises(FormulaError):
            parse(text)
    assert isinstance(parse("p.x^2"), ast.BinOp)


@pytest.mark.parametrize("answer", ["p - o0", "R03", "cross(z0, p)"])
def test_formulas_may_name_frame_0_of_a_modified_table(answer: str) -> None:
    """Frame 0 is upright at the base, although the first row of the table may tilt and shift the arm."""
    definition = Definition("mine", answer, (Texts("Mine", "x"),))
    for seed in range(3):
        problem = generate(f"elbow-3r/{seed}@modified-dh", ["mine"], definitions=[definition])
        assert find_failures(problem) == []


def test_equal_definitions_make_the_same_question() -> None:
    definition = Definition("mine", "norm(v)", (Texts("Mine", "x"),), given=(GivenValue("pose"), GivenValue("rates")))
    assert make_question(definition) is make_question(definition)
    first, second = (generate("planar-2r/3", ["mine"], definitions=[definition]).parts[0].answer for _ in range(2))
    assert first == second


@pytest.mark.parametrize(("answer", "max_count"), [("ddt((o1 + o2)/2)", 10), ("zeros(det(J))", 9)])
def test_certifying_takes_few_evaluations_of_the_arm(
    answer: str, max_count: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """All steps of differences are evaluated together, because instructors' questions cost as much as built-in ones."""
    counts: list[int] = []
    make = GeometryQuantities.__init__

    def make_and_count(quantities: GeometryQuantities, *arguments: Any) -> None:
        counts.append(1)
        make(quantities, *arguments)

    monkeypatch.setattr(GeometryQuantities, "__init__", make_and_count)
    definition = Definition("mine", answer, (Texts("Mine", "x"),))
    problem = generate("planar-2r/1", ["mine"], definitions=[definition])
    counts.clear()
    assert certify(problem).passed
    assert 0 < len(counts) <= max_count, len(counts)
