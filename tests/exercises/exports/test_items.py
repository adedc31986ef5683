"""Exports: the items of quizzes, and what holds for every format."""

import random
import re
import stat
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from qdot.exercises.arm.conventions.base import VELOCITY_NAMES
from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.assignment.assignment import Student, load_assignment
from qdot.exercises.common.console import ProgressCounter
from qdot.exercises.common.errors import QdotError
from qdot.exercises.exports import scorm
from qdot.exercises.exports.assignment_files import read_assignment_files
from qdot.exercises.exports.bank import convert_bank, iterate_bank
from qdot.exercises.exports.export_format import ExportRequest
from qdot.exercises.exports.items import (
    ChoiceForm,
    NumberField,
    NumberForm,
    QuizItem,
    WrongValue,
    _make_field,
    make_items,
)
from qdot.exercises.exports.numeric_part import NumericPart, ask_in_numbers
from qdot.exercises.exports.platform_markup import Picture, format_decimal, format_tolerance
from qdot.exercises.exports.registry import EXPORT_FORMATS
from qdot.exercises.exports.typed_numbers import list_accepted_texts, make_number_pattern
from qdot.exercises.families import FAMILIES
from qdot.exercises.generation import generate, list_questions_of_family
from qdot.exercises.problem.problem import Problem, ProblemId
from qdot.exercises.problem.record import compute_digests
from qdot.exercises.questions.results import is_derived_step_by_step
from qdot.exercises.reference_answers import Number
from qdot.exercises.robots.library import ROBOT_FOLDER
from qdot.exercises.verify.certificate import certify
from qdot.exercises.verify.numeric_model import compute_exponential_jacobian
from qdot.grader.cli import export_commands
from qdot.grader.cli.main import app
from qdot.grader.grading.certify import find_failures
from qdot.grader.marking.marking import compute_earned_share
from tests.support import read_data
from tests.support.command import run, run_and_fail, runner
from tests.support.problems import get_problem
from tests.support.site_scripts import write_stand_in_assets
from tests.support.submitting import make_class
from tests.support.suites import sample_for_suite, select_for_suite

TOML = read_data("assignments/items.toml")


def make_request(folder: Path, toml: str = TOML, variants: int = 2) -> ExportRequest:
    assignment = make_class(folder / "hw", [Student("ada")])
    (assignment.folder / "assignment.toml").write_text(toml)
    return ExportRequest(load_assignment(assignment.folder), lambda _: [], variant_count=variants)


@pytest.fixture(scope="module")
def items(tmp_path_factory: pytest.TempPathFactory) -> list[QuizItem]:
    return list(make_items(make_request(tmp_path_factory.mktemp("items"))))


def find_item(items: Sequence[QuizItem], kind: str) -> QuizItem:
    return next(item for item in items if item.key.endswith(f"-{kind}"))


def test_every_part_of_every_variant_is_a_self_contained_item(items: list[QuizItem]) -> None:
    assert len(items) == 2 * (6 + 3 + 1) == len({item.key for item in items})
    for item in items:
        assert isinstance(item.body[0], Picture)
        for text in (*item.body, *(item.single_number_item.body if item.single_number_item else ())):
            if isinstance(text, Picture):
                assert text.alt and text.svg.startswith("<svg")
            else:  # no remarks on typing formulas or letters
                assert not [word for word in ("`", "typed", "**A.**", r"\text{A.}") if word in text]
        assert item.solution[0] and len(item.hints) == 3


def test_formulas_become_numbers_directions_are_scaled_and_sets_become_choices(items: list[QuizItem]) -> None:
    item = find_item(items, "jacobian")
    assert isinstance(item.form, NumberForm)
    assert [len(row) for row in item.form.rows] == [2, 2]
    asked = str(item.body[-1])
    assert "$v_{x}, v_{y}$" in asked and "three significant digits" in asked and r"\theta_{1} = " in asked
    assert item.single_number_item is not None
    assert len(item.single_number_item.form.fields) == 1  # type: ignore[union-attr]
    counts = find_item(items, "jacobian-size").form
    assert isinstance(counts, NumberForm) and [field.tolerance for field in counts.fields] == [0, 0]  # they are exact
    item = find_item(items, "lost-direction")
    assert isinstance(item.form, NumberForm)
    assert [entry for row in item.form.rows for entry in row if isinstance(entry, str)] == ["1"]
    assert abs(item.form.fields[0].value) <= 1
    assert "entry $u_{" in str(item.body[-1])
    assert isinstance(find_item(items, "singular-angles-choice").form, ChoiceForm)


def test_three_digits_are_accepted_and_mistakes_are_not(items: list[QuizItem]) -> None:
    fields = [field for item in items if isinstance(item.form, NumberForm) for field in item.form.fields]
    assert sum(len(field.wrong_values) for field in fields) > 2 * len(fields)
    for field in fields:
        rounded = float(f"{field.value:.2e}")
        assert abs(rounded - field.value) <= float(format_tolerance(field.tolerance))
        near: list[NumberField | WrongValue] = [field, *field.wrong_values]
        for number, item in enumerate(near):
            for later in near[number + 1 :]:
                assert abs(item.value - later.value) > item.tolerance + later.tolerance
        assert all(wrong.feedback and "{" not in wrong.feedback for wrong in field.wrong_values)


def test_ranges_of_wrong_numbers_never_contain_zero_or_the_right_number() -> None:
    """A length in millimetres makes a number a thousand times too small, but a zero is no such number."""
    problem = generate(ProblemId("planar-2r", 3, ("determinant",)))
    part = problem.parts[0]
    numeric_part = ask_in_numbers(problem, part)
    assert numeric_part is not None
    ratios = (1e-6, 1e-3, 0.01, 1.0005, 2.0, 1e15)  # the last is a division by a zero that was rounded
    wrong_answers = tuple((f"times {ratio}", ratio * numeric_part.values) for ratio in ratios)
    field = _make_field(part, replace(numeric_part, wrong_answers=wrong_answers), 0, "d", explains_mistakes=True)
    assert [wrong.feedback for wrong in field.wrong_values] == [f"times {ratio}" for ratio in (1e-6, 1e-3, 0.01, 2.0)]
    for wrong in field.wrong_values:
        assert wrong.tolerance < abs(wrong.value) and abs(wrong.value - field.value) > wrong.tolerance


DETERMINANT = 'title = "T"\nkey = "hw"\n[[problem]]\nfamily = "planar-2r"\nquestions = ["determinant"]\n'


def test_decimals_set_the_tolerance_and_unsupported_parts_are_noted_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (item,) = make_items(make_request(tmp_path, f"{DETERMINANT}decimals = 2\n", 1))
    assert isinstance(item.form, NumberForm)
    (field,) = item.form.fields
    assert field.tolerance == pytest.approx(0.05 * abs(field.value))
    assert "two significant digits" in str(item.body[-1])
    monkeypatch.setattr("qdot.exercises.exports.items.ask_in_numbers", lambda problem, part: None)
    notes: list[str] = []
    assert not list(make_items(replace(make_request(tmp_path / "other", DETERMINANT), report=notes.append)))
    assert len(notes) == 1 and notes[0].startswith("p1: determinant ")


def test_inconsistent_numbers_are_not_exported() -> None:
    problem, other_problem = (generate(ProblemId("planar-2r", seed, ("jacobian",))) for seed in (7, 8))
    with pytest.raises(QdotError, match="do not agree"):
        ask_in_numbers(problem, other_problem.parts[0])


def _compute_expected(problem: Problem, numeric: NumericPart) -> np.ndarray:
    assert numeric.given_values is not None
    values, chain = numeric.given_values.values, problem.chain
    arm = NumericChain(chain, {symbol.name: values[symbol.name] for symbol in chain.parameters})
    q = np.array([values[symbol.name] for symbol in chain.q])
    whole = compute_exponential_jacobian(arm, q)
    jacobian = whole[[VELOCITY_NAMES.index(row) for row in chain.task]]
    rates = np.array([values[rate.name] for rate in chain.rates])
    velocity = np.array([values[row] for row in chain.task])
    kinds: dict[str, Callable[[], Any]] = {
        "jacobian": lambda: jacobian,
        "geometric-jacobian": lambda: whole,
        "determinant": lambda: np.linalg.det(jacobian),
        "gram-determinant": lambda: np.linalg.det(jacobian @ jacobian.T),
        "inverse-velocity": lambda: np.linalg.solve(jacobian, velocity),
        "twist": lambda: whole @ rates,
        "joint-torques": lambda: jacobian.T @ np.array([values[name] for name in numeric.part.symbols]),
        "position": lambda: arm.compute_point(q)[["xyz".index(axis) for axis in chain.linear_axes]],
    }
    expected: np.ndarray = np.asarray(kinds[numeric.part.kind]())
    return expected.reshape(numeric.values.shape)


KINDS = (
    "jacobian", "determinant", "inverse-velocity", "joint-torques", "gram-determinant", "geometric-jacobian", "twist",
    "position",
)  # fmt: skip


def test_numbers_agree_with_the_product_of_exponentials(family: str) -> None:
    can = [kind for kind in KINDS if kind in list_questions_of_family(family)]
    first = list(FAMILIES).index(family)
    for kind in can[first % max(len(can), 1) :][:1]:
        problem = generate(ProblemId(family, 3, (kind,)))
        numeric = ask_in_numbers(problem, problem.parts[0])
        assert numeric is not None
        assert np.allclose(numeric.values, _compute_expected(problem, numeric), rtol=1e-8, atol=1e-9)
        assert np.abs(numeric.values).max() > 1e-3


def test_numbers_are_written_without_exponents() -> None:
    assert format_decimal(1e-7) == "0.0000001"
    assert format_decimal(123456.0) == "123456"
    assert "e" not in format_decimal(-2.5e-9)
    assert float(format_tolerance(0.0123451)) >= 0.0123451


@pytest.mark.parametrize("family", select_for_suite(["planar-3r"], ["planar-2r", "elbow-3r", "planar-3r"]))
def test_numeric_answers_are_unchanged_and_mistakes_differ(family: str) -> None:
    problem = get_problem(family, 0)
    parts = [part for part in problem.parts if isinstance(part.answer, Number)]
    assert len(parts) >= 3
    for part in parts:
        numeric = ask_in_numbers(problem, part)
        assert numeric is not None and isinstance(part.answer, Number), part.name
        right = np.array(part.answer.reference.tolist(), dtype=float)
        assert np.array_equal(numeric.values, right), part.name
        assert numeric.wrong_answers or not is_derived_step_by_step(part), part.name
        for sentence, values in numeric.wrong_answers:
            assert values.shape != right.shape or not np.array_equal(values, right), sentence


def test_single_number_distinguishes_most_mistakes(items: list[QuizItem]) -> None:
    alone = [(item.form, item.single_number_item.form) for item in items if item.single_number_item is not None]
    counts_per_item = []
    for whole, single in alone:
        assert isinstance(whole, NumberForm) and isinstance(single, NumberForm)
        (field,) = single.fields
        able = [field for field in whole.fields if round(abs(field.value), 9) not in (0, 1)] or whole.fields
        counts_per_item.append({len(field.wrong_values) for field in able})
        assert len(field.wrong_values) == max(counts_per_item[-1])
    assert any(len(counts) > 1 for counts in counts_per_item)


def sample_value_and_tolerance(rng: random.Random) -> tuple[float, float]:
    value = float(f"{rng.choice([-1, 1]) * rng.uniform(1, 10) * 10 ** rng.randint(-3, 3):.10g}")
    floor = rng.choice([1e-5, 0.001, 0.02, 2])
    return (0.0 if rng.random() < 0.1 else value), float(f"{max(0.005 * abs(value), floor):.4g}")


def is_within(text: str, value: float, tolerance: Fraction) -> bool:
    return abs(Fraction(text) - Fraction(str(value))) <= tolerance


@pytest.mark.parametrize("seed", range(5))
def test_only_numbers_within_the_tolerance_are_accepted(seed: int) -> None:
    rng = random.Random(seed)
    for _ in range(100):
        value, tolerance = sample_value_and_tolerance(rng)
        exact_tolerance = Fraction(str(tolerance))
        texts, pattern = list_accepted_texts(value, tolerance), re.compile(make_number_pattern(value, tolerance))
        assert [text for text in texts if not is_within(text, value, exact_tolerance)] == []
        assert pattern.search(texts[0]) and len(texts) <= 40
        for _ in range(40):
            text = f"{value + rng.uniform(-2, 2) * tolerance:.{rng.randint(0, 8)}f}"
            if pattern.search(text):
                assert is_within(text, value, exact_tolerance), (value, tolerance, text)
            else:  # the first and the last of 100 steps may be refused
                assert not is_within(text, value, exact_tolerance * Fraction(97, 100)), (value, tolerance, text)


@pytest.mark.parametrize("text", ["-0.707", "-.707", "-0.71", "-0.7071", "-0.70711", "-0.707107", "-0.70710"])
def test_rounded_and_truncated_values_are_listed(text: str) -> None:
    assert text in list_accepted_texts(-0.70710678118, 0.0036)


@pytest.mark.parametrize("text", [" -0.707 ", "-,7071", "−0.70710678118", "-0.7100", "-0.71"])
def test_patterns_accept_commas_spaces_and_typeset_minus_signs(text: str) -> None:
    assert re.search(make_number_pattern(-0.70710678118, 0.0036), text)


@pytest.mark.parametrize("text", ["0.707", "-0.7", "-0.707 m", "-0.7.07", "", "-", "1-0.707", "-0.707\n1"])
def test_patterns_refuse_other_texts(text: str) -> None:
    assert not re.search(make_number_pattern(-0.70710678118, 0.0036), text)


def test_counts_are_exact() -> None:
    assert list_accepted_texts(3, 0) == ("3", "3.0", "3.00", "3.000", "3.0000", "3.00000")
    pattern = make_number_pattern(3, 0)
    assert all(re.search(pattern, text) for text in ("3", "+3", "3.00"))
    assert not any(re.search(pattern, text) for text in ("3.01", "33", "-3"))


@pytest.mark.parametrize(("value", "tolerance"), [(173.123456789, 5e-7), (-0.123456789, 1e-9), (2.5e-7, 1e-9)])
def test_numbers_that_need_many_digits_are_listed(value: float, tolerance: float) -> None:
    texts = list_accepted_texts(value, tolerance)
    assert texts and all(is_within(text, value, Fraction(str(tolerance))) for text in texts)


@pytest.fixture(scope="module")
def export_request(tmp_path_factory: pytest.TempPathFactory) -> ExportRequest:
    assignment = make_class(tmp_path_factory.mktemp("bank") / "hw", [Student("ada")])
    return ExportRequest(assignment, find_failures, variant_count=4, compute_earned_share=compute_earned_share)


def test_bank_has_distinct_certified_problems_and_extends_a_shorter_one(export_request: ExportRequest) -> None:
    steps: list[None] = []
    short = list(iterate_bank(replace(export_request, on_step=lambda: steps.append(None))))
    assert [variant.key for variant in short] == ["p1-001", "p1-002", "p1-003", "p1-004"]
    assert len(steps) == 4 == EXPORT_FORMATS["html"].count_steps(export_request) * 4
    assert len({compute_digests(variant.problem).sha256 for variant in short}) == 4
    assert not [failed for variant in short for failed in certify(variant.problem).failures]
    longer = list(iterate_bank(replace(export_request, variant_count=6, jobs=2)))
    assert [str(variant.problem.id) for variant in longer[:4]] == [str(variant.problem.id) for variant in short]
    student_ids = {str(problem.id) for _, problem in export_request.assignment.generate_problems("ada")}
    assert not student_ids & {str(variant.problem.id) for variant in longer}


def test_small_family_gives_all_its_problems_with_a_note(
    export_request: ExportRequest, monkeypatch: pytest.MonkeyPatch
) -> None:
    same = export_request.assignment.slots[0].generate_problem("secret", "ada")
    monkeypatch.setattr("qdot.exercises.exports.bank.generate_and_certify", lambda make, vouch: (same, None))
    notes: list[str] = []
    steps: list[None] = []
    worked: list[Problem] = []  # duplicates are not processed
    request = replace(export_request, report=notes.append, on_step=lambda: steps.append(None))
    assert len(list(convert_bank(request, lambda _order, _slot, problem: worked.append(problem)))) == 1
    assert worked == [same]
    assert len(steps) == 4
    assert len(notes) == 1 and notes[0].startswith("p1: planar-2r") and "variation zeros" in notes[0]


def test_robot_with_fixed_lengths_is_noted_as_same_for_all(tmp_path: Path) -> None:
    """The note does not mention a variation, which a robot does not have."""
    make_class(tmp_path, [Student("ada")])
    request = '[[problem]]\nrobot = "scorbot"\nquestions = ["jacobian"]\n'
    (tmp_path / "assignment.toml").write_text(f'title = "T"\nkey = "hw"\n{request}')
    assignment = load_assignment(tmp_path)
    notes: list[str] = []
    assert len(list(iterate_bank(ExportRequest(assignment, find_failures, variant_count=3, report=notes.append)))) == 1
    assert len(notes) == 1 and notes[0].startswith("p1: scorbot") and "variation" not in notes[0]


def test_several_formats_share_the_progress_and_each_note(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    shown: list[tuple[str, int]] = []

    @contextmanager
    def record_progress(title: str, total: int) -> Iterator[ProgressCounter]:
        shown.append((title, total))
        yield ProgressCounter(title, total)

    monkeypatch.setattr(export_commands, "show_progress", record_progress)
    assignment = make_class(tmp_path / "hw", [Student("ada")])
    same = assignment.slots[0].generate_problem("secret", "ada")
    monkeypatch.setattr("qdot.exercises.exports.bank.generate_and_certify", lambda make, vouch: (same, None))
    command = (
        "export", str(assignment.folder), *("--to", "moodle"), *("--to", "qti"), "--variants", "2", "--jobs", "1",
    )  # fmt: skip
    result = runner.invoke(app, command)
    assert [line.partition(":")[0] for line in result.stdout.splitlines()] == ["moodle", "qti"]
    assert result.stderr.count("p1: planar-2r has only one different problem") == 1
    assert shown == [("exporting to moodle, qti", 4)]


def test_export_uses_the_requested_variation(export_request: ExportRequest, tmp_path: Path) -> None:
    """Formats that generate problems from assignment.toml refuse the option."""
    assignment = export_request.assignment.with_variation("base+lengths")
    request = replace(export_request, assignment=assignment, variant_count=2)
    assert {variant.problem.id.variation for variant in iterate_bank(request)} == {"lengths+base"}
    folder = export_request.assignment.folder
    command: list[str | Path] = ["export", folder, "--to", "moodle", "--variants", "1", "--out"]
    assert "moodle: 2 files in" in run(*command, tmp_path / "m", "--variation", "chapter")
    run(*command, tmp_path / "own")
    plain, unchanged = (sorted((tmp_path / name).iterdir()) for name in ("m", "own"))
    assert [path.name for path in plain] == [path.name for path in unchanged]
    assert [path.read_bytes() for path in plain] != [path.read_bytes() for path in unchanged]
    for export_format in ("prairielearn", "html"):
        refused = run_and_fail("export", folder, "--to", export_format, "--variation", "chapter")
        assert "(moodle, canvas, common-cartridge, qti, scorm, stack)" in refused and f"for {export_format}," in refused
    assert "'plain'" in run_and_fail(*command, tmp_path / "plain", "--variation", "plain")

    # A slot whose questions don't apply to other arms is named.
    tied = export_request.assignment.slots[0]
    tied = replace(tied, family=FAMILIES["scara"], questions=("determinant", "jacobian"), band=(0, 0))
    with pytest.raises(QdotError, match=r"^p1, with variation full: "):
        replace(export_request.assignment, slots=(tied,)).with_variation("full")


@pytest.fixture(scope="module")
def assets(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    stand_in = write_stand_in_assets(tmp_path_factory.mktemp("scripts") / "dist")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(scorm, "find_assets", lambda: stand_in)
        yield


@pytest.mark.parametrize("export_format", EXPORT_FORMATS)
def test_problem_that_fails_its_certificate_is_not_exported(
    export_request: ExportRequest, assets: None, export_format: str
) -> None:
    request = replace(export_request, find_failures=lambda _: ["wrong"], variant_count=1)
    with pytest.raises(QdotError, match=r"p1.* \(planar-2r\): none of 10 attempts .* The first one failed: wrong"):
        list(EXPORT_FORMATS[export_format].export(request))


def test_files_outside_the_folder_are_copied_into_the_export(tmp_path: Path) -> None:
    """Two robots with the same name, a file of questions and the logo lie outside; a robot in the folder stays."""
    folder, robot = make_class(tmp_path / "hw", [Student("ada")]).folder, (ROBOT_FOLDER / "cobra600.toml").read_bytes()
    for path in ("other/arm.toml", "arm.toml", "hw/shared/arm.toml"):
        (tmp_path / path).parent.mkdir(exist_ok=True)
        (tmp_path / path).write_bytes(robot)
    question = 'prompt = "x"\nanswer = "p"\n'
    (tmp_path / "mine.toml").write_text(f"[question.mine]\n{question}[question.other]\n{question}")
    (tmp_path / "logo.svg").write_text("<svg/>")
    robots = ("../arm.toml", "shared/arm.toml", f"{tmp_path.as_posix()}/other/arm.toml")
    problems = "".join(f"[[problem]]\nrobot = '{name}'\nquestions = [ '../mine.toml#mine' ] # '\n" for name in robots)
    text = f'title = "T"\nkey = "hw"\n[paper]\nlogo = "../logo.svg"\n{problems}'
    (folder / "assignment.toml").write_text(text)
    assignment = load_assignment(folder)
    files = read_assignment_files(assignment)
    assert [path for path in files if "/" in path] == [
        "shared/arm.toml", "shared-2/arm.toml", "shared-3/arm.toml", "shared/mine.toml", "shared/logo.svg",
    ]  # fmt: skip
    for path, content in {**files, "secret.txt": assignment.secret.encode()}.items():
        (tmp_path / "export" / path).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "export" / path).write_bytes(content)
    exported = load_assignment(tmp_path / "export")
    assert exported.slots[0].questions == ("mine",)
    assert exported.notebook_digest == assignment.notebook_digest and exported.front_page == assignment.front_page


@pytest.fixture(scope="module")
def certified(export_request: ExportRequest) -> ExportRequest:
    """A request with solutions, whose problems are certified once for all export formats."""
    known: dict[str, Sequence[str]] = {}

    def find_failures_once(problem: Problem) -> Sequence[str]:
        name = str(problem.id)
        if name not in known:
            known[name] = find_failures(problem)
        return known[name]

    return replace(
        export_request, variant_count=select_for_suite(1, 2), has_solutions=True, find_failures=find_failures_once
    )


@pytest.mark.parametrize("export_format", sample_for_suite(EXPORT_FORMATS, 8))
def test_every_export_format_writes_the_same_files_twice(
    certified: ExportRequest, assets: None, export_format: str
) -> None:
    files = list(EXPORT_FORMATS[export_format].export(certified))
    assert files and files == list(EXPORT_FORMATS[export_format].export(certified))
    paths = [file.path for file in files]
    assert len(set(paths)) == len(paths)
    assert not [path for path in paths if path.startswith("/") or ".." in path.split("/")]
    public = [file.content for file in files if not file.is_private]
    content = [file_content if isinstance(file_content, bytes) else file_content.encode() for file_content in public]
    assert not [data for data in content if certified.assignment.secret.encode() in data]
    # Anyone who knows the id of a problem can see its solution with `qdot show`.
    ids = [variant.problem.id for variant in iterate_bank(certified)]
    ids += [problem.id for _, problem in certified.assignment.generate_problems("ada")]
    assert not [identity for identity in ids for data in content if str(identity.seed).encode() in data]


def test_export_command_writes_files_with_safe_permissions(export_request: ExportRequest, tmp_path: Path) -> None:
    folder = export_request.assignment.folder
    assert "html: 1 file in" in run("export", folder, "--to", "html", "--solutions", "--jobs", "1")
    page = folder / "exports" / "html" / "handout-solutions" / "ada.html"
    assert stat.S_IMODE(page.stat().st_mode) == 0o600  # it has the answers
    run("export", folder, "--to", "latex", "--page", "letter", "--out", tmp_path / "here", "--jobs", "1")
    source = tmp_path / "here" / "handout" / "ada.tex"
    assert stat.S_IMODE(source.stat().st_mode) == 0o644 and "letterpaper" in source.read_text()
    assert "'htm' (did you mean 'html'?)" in run_and_fail("export", folder, "--to", "htm")
    assert "no-such" in run_and_fail("export", tmp_path / "no-such", "--to", "html")
