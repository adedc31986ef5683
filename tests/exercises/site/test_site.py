"""The site: its pages and bank, the problems that it has, and their keys."""

import functools
import html
import json
import re
import shutil
import threading
import urllib.error
import urllib.request
from collections import Counter
from collections.abc import Iterator
from http.server import ThreadingHTTPServer
from itertools import islice, product
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sympy as sp

from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.assignment.assignment import Student
from qdot.exercises.chapter import read_errata
from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.variation import VARIATION_STEPS
from qdot.exercises.derivation.derivation import derive
from qdot.exercises.derivation.graph import compute_numeric_stages
from qdot.exercises.families import FAMILIES
from qdot.exercises.generation import find_listing, generate, sample_chain, select_quiz_questions
from qdot.exercises.problem.problem import Part, Problem, ProblemId
from qdot.exercises.questions.results import compute_answer, is_derived_step_by_step
from qdot.exercises.reference_answers import Choice, Matching, Number, Selection
from qdot.exercises.site import bank_problem
from qdot.exercises.site import pages as site_pages
from qdot.exercises.site.bank_problem import (
    ARMS_PER_QUESTION,
    ARMS_PER_STEP,
    QUIZ,
    BankProblem,
    deal_questions,
    find_questions_with_sampled_numbers,
    list_problems_of_families,
)
from qdot.exercises.site.chapter import ERRATA_PATH, make_chapter_pages
from qdot.exercises.site.guide import COMMANDS, OTHER_PAGES, REPLACED_PAGES, arrange_pages
from qdot.exercises.site.keys import _evaluate_derivation, _find_derived_question, compute_weight, make_key
from qdot.exercises.site.pages import find_assets, link_pages, make_pages, read_assets
from qdot.exercises.site.record import (
    _find_given_pose,
    _list_labels,
    find_mentioned_names,
    list_determinant_factors,
    make_arm_record,
    make_asked_record,
    make_site_record,
    make_solutions_record,
    translate_record,
)
from qdot.exercises.site.robots import make_tables_json
from qdot.exercises.writing.latex import tex
from qdot.exercises.writing.problem_texts import write_prompt
from qdot.grader.cli import site_commands as command
from qdot.grader.cli.main import app
from qdot.grader.cli.site_commands import _QuietHandler
from tests.support import ROOT
from tests.support.command import run, run_and_fail, runner
from tests.support.problems import get_problem, select_parts
from tests.support.site_scripts import write_stand_in_assets
from tests.support.submitting import TOML, make_class
from tests.support.suites import WHOLE, few_families, sample_for_suite, select_for_suite

DOCS = ROOT / "docs"


@pytest.fixture(scope="module")
def assets(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    made = write_stand_in_assets(tmp_path_factory.mktemp("scripts") / "dist")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(site_pages, "find_assets", lambda: made)
        yield


@pytest.fixture(scope="module")
def uncertified(assets: None) -> Iterator[None]:
    """Certificates take longer than all that is looked at here."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(command, "find_failures", lambda _: [])
        yield


@pytest.fixture(scope="module")
def built(uncertified: None, tmp_path_factory: pytest.TempPathFactory) -> Path:
    site = tmp_path_factory.mktemp("first") / "site"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(site_pages, "make_pages", lambda *around: islice(make_pages(*around), 3))
        run(*ordered(site))
    return site


@pytest.fixture
def few_pages(uncertified: None, monkeypatch: pytest.MonkeyPatch) -> None:
    """Only the first three pages, where a test looks at the bank: to write all takes longer than that."""
    monkeypatch.setattr(site_pages, "make_pages", lambda *around: islice(make_pages(*around), 3))


def ordered(site: Path, *more: str | Path) -> tuple[str | Path, ...]:
    asked = () if "--assignment" in more else ("--families", "polar-rp")
    variants = () if "--variants" in more else ("--variants", "1")
    return ("site", "build", "--out", site, *asked, *variants, "--jobs", "1", *more)


def loaded(site: Path, name: str) -> Any:
    return json.loads((site / "bank" / f"{name}.json").read_text())


@pytest.mark.whole
def test_the_chapters_pages_tell_where_the_book_differs() -> None:
    found = {page.path: page.body for page in make_chapter_pages()}
    assert len(re.findall("<h2>", found["examples/errata.html"])) == len(read_errata())
    for number, count in {"6-1": 2, "6-2": 2, "6-3": 3, "6-4": 0}.items():
        page = found[f"examples/{number}.html"]
        assert page.count("<strong>Printed:</strong>") == count, number
        assert ('id="differs"' in page) == bool(count)
        assert json.loads(html.unescape(re.findall(r'data-arm="([^"]*)"', page)[0]))["robot"]["joints"]


def test_the_errata_are_told_in_german_with_the_same_numbers() -> None:
    for page in make_chapter_pages():
        title, body = page.translations["de"]
        assert body.count("<strong>Gedruckt:</strong>") == page.body.count("<strong>Printed:</strong>"), page.path
        assert "Printed" not in body
        assert page.path != ERRATA_PATH or title == "Errata des Kapitels"
    for english, german in zip(read_errata(), read_errata("de"), strict=True):
        assert german.reason != english.reason
        told = [value.replace(",", ".") for _, value in german.values]
        kinds = {"boundary": "am Rand", "internal": "im Inneren"}
        assert told == [kinds.get(value, value) for _, value in english.values], english.place
        texts = german.printed, german.correction, german.configuration, *sum(german.values, ())
        assert not re.search(r"\d\.\d", " ".join(texts))


@pytest.mark.parametrize("has_docs", select_for_suite([True], [False, True]))
def test_a_site_has_all_pages_which_lead_somewhere(
    has_docs: bool, built: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    site = Path(shutil.copytree(built, tmp_path / "site"))
    if not has_docs:
        monkeypatch.setattr(command, "find_docs_folder", lambda: None)
    run(*ordered(site))
    assert (site / "docs" / "index.html").exists() == has_docs
    if has_docs:
        assert "Deine erste Antwort" in (site / "docs" / "index.html").read_text()
        assert "Ebener 2R-Arm" in (site / "arms.html").read_text()
    _examples_are_told_in_german(site)
    _links_lead_somewhere(site)
    practice = (site / "practice.html").read_text()
    assert '<link rel="modulepreload" href="assets/shared.js">' in practice  # loaded at once, not one after another
    assert '<link rel="preload" href="bank/index.json" as="fetch" crossorigin="anonymous">' in practice
    assert "preload" not in (site / "accessibility.html").read_text()
    shell = json.loads(re.findall(r"const SHELL = (.*);", (site / "sw.js").read_text())[0])
    assert not [name for name in shell if not (site / name).is_file()]
    assert {"bank/index.de.json", "check.html"} <= set(shell)


def test_a_rerun_keeps_the_bank(built: Path, few_pages: None, tmp_path: Path) -> None:
    site = Path(shutil.copytree(built, tmp_path / "site"))
    arguments = ordered(site)
    assert "2 problems with" in run(*arguments)
    (family,) = loaded(site, "index")["families"]
    problems = family["problems"]
    assert family["name"] == "polar-rp"
    assert [(problem["key"], problem["variation"], problem["flat"]) for problem in problems] == [
        ("001", "chapter", True), ("001-quiz", "chapter", True),  # it never leaves a plane
    ]  # fmt: skip
    told = loaded(site, "sizes")["files"]
    sizes = {site / "bank" / f"{name}{ending}": size for name, each in told.items() for ending, size in each.items()}
    assert sizes == {path: path.stat().st_size for path in (site / "bank" / "polar-rp").rglob("*.json")}
    for problem in problems:
        assert "factors" in loaded(site, f"polar-rp/{problem['key']}")
        for kind in problem["questions"]:
            english, german = (loaded(site, f"polar-rp/{problem['key']}/{kind}{ending}") for ending in ("", ".de"))
            assert english["kind"] == kind
            assert english["name"] == german["name"] == german["solved"]["name"]
            used = {str(mistake[0]) for mistake in (*english["key"].get("mistakes", ()),)}
            assert used <= english["said"].keys() == german["said"].keys()
    assert loaded(site, "index.de")["families"]["polar-rp"].startswith("Ebener")
    before = {path: path.stat().st_mtime_ns for path in site.glob("bank/polar-rp/**/*.json")}
    first = {path.relative_to(site): path.read_bytes() for path in site.rglob("*") if path.is_file()}
    # A bank of before there were translations gets them; what lacks nothing is not made again.
    # What is empty, as the power failed before the disk had it, is made again.
    (site / "bank" / "polar-rp" / "001.de.json").unlink()
    (site / "bank" / "polar-rp" / "001" / "position.json").write_text("")
    run(*arguments)
    after = {path: path.stat().st_mtime_ns for path in site.glob("bank/polar-rp/**/*.json")}
    assert after.keys() == before.keys()
    assert {path.name for path in after if after[path] == before[path]} >= {"001-quiz.json", "001-quiz.de.json"}
    assert first == {path.relative_to(site): path.read_bytes() for path in site.rglob("*") if path.is_file()}


def test_what_cannot_be_certified_is_drawn_anew_and_at_last_left_out(
    few_pages: None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    site, wrong = tmp_path / "site", {1}

    def failures(problem: Problem) -> list[str]:
        seed, names = problem.id.seed, {part.name for part in problem.parts}
        is_wrong = seed in wrong or (seed % 1000 == 1 and 1 not in wrong)
        return ["put in"] if "determinant" in names and is_wrong else []

    monkeypatch.setattr(command, "find_failures", failures)
    monkeypatch.setattr(bank_problem, "MAX_SEEDS", 3)  # each of 10 would be made with all questions
    arguments = ordered(site)
    run(*arguments)
    assert loaded(site, "polar-rp/001")["id"] == "polar-rp/1001@chapter"
    wrong.clear()
    shutil.rmtree(site / "bank" / "polar-rp")
    result = runner.invoke(app, [str(word) for word in arguments])
    assert result.exit_code == 2
    assert all(text in result.stderr for text in ("001 (polar-rp)", "put in\n", "1 problem of polar-rp"))
    assert [problem["key"] for problem in loaded(site, "index")["families"][0]["problems"]] == ["001-quiz"]


def _examples_are_told_in_german(site: Path) -> None:
    for number in ("6-1", "6-2", "6-3", "6-4"):
        told = json.loads((site / "examples" / f"{number}.de.json").read_text())
        page = (site / "examples" / f"{number}.html").read_text()
        assert told["title"] == f"Beispiel {number.replace('-', '.')}"
        assert 'data-languages="de"' in page
        for mark in ("<section", "<table", "<figure", 'data-arm="', 'href="'):  # all that the English page has
            main = page[page.index("<main") : page.index("</main>")]
            assert told["body"].count(mark) == main.count(mark), (number, mark)
        assert not re.search(r"\b(The|the|Example|and|where)\b", _without_english(told["body"])), number


def _without_english(body: str) -> str:
    """Return the words of a page that are not marked as English, nor replaced by the page's script."""
    body = re.sub(r'<div lang="en">.*?</div>|<noscript>.*?</noscript>|<svg.*?</svg>', "", body, flags=re.DOTALL)
    body = re.sub(r"<(\w+)[^>]* data-text=.*?</\1>", "", body, flags=re.DOTALL)
    return re.sub(r"<[^>]*>", " ", body)


def _links_lead_somewhere(site: Path) -> None:
    for page in site.rglob("*.html"):
        text = page.read_text(encoding="utf-8")
        assert "<script" not in text.replace('<script type="module" src=', "")  # none but files of the site
        for address in re.findall(r'(?:href|src)="([^"#][^"]*)"', text):
            is_tried = page.name == "404.html" and address.startswith("../")  # wherever it is shown
            if not re.match(r"[a-z]+:", address) and not is_tried:
                target = (page.parent / address.partition("#")[0]).resolve()
                assert target.is_file() or "/docs/" not in str(target) or target.suffix != ".html", (page, address)
                assert target.suffix not in (".css", ".js", ".png") or target.is_file(), (page, address)


def test_a_built_site_is_served_and_what_is_not_there_is_answered_by_its_own_page(tmp_path: Path) -> None:
    (tmp_path / "404.html").write_text("no such page")
    (tmp_path / "index.html").write_text("hello")
    with ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(_QuietHandler, directory=str(tmp_path))) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        try:
            with urllib.request.urlopen(f"http://127.0.0.1:{server.server_port}/index.html") as answer:
                assert answer.read() == b"hello"
            with pytest.raises(urllib.error.HTTPError) as error:
                urllib.request.urlopen(f"http://127.0.0.1:{server.server_port}/deep/er/page.html")
            assert (error.value.code, error.value.read()) == (404, b"no such page")
            assert error.value.headers["Content-Type"] == "text/html; charset=utf-8"
        finally:
            server.shutdown()


@pytest.mark.whole
def test_a_site_is_told_in_the_convention_of_a_course(built: Path, few_pages: None, tmp_path: Path) -> None:
    site = Path(shutil.copytree(built, tmp_path / "site"))
    assert "convention" not in loaded(site, "polar-rp/001")["robot"]
    run(*ordered(site, "--twist-order", "v-omega"))
    record = loaded(site, "polar-rp/001")
    assert (record["robot"]["convention"], record["robot"]["twist_order"]) == ("screws", "v-omega")
    assert re.search(r"<mi>v</mi>.{,40}&#x003C9;", loaded(site, "polar-rp/001/space-twist")["prompt"])  # (v, ω)
    assert "Denavit" not in record["statement"]
    questions = loaded(site, "index")["families"][0]["problems"][0]["questions"]
    assert {"space-jacobian", "body-twist"} <= set(questions) and "position-vectors" not in questions
    assert "described by screw axes" in run_and_fail(*ordered(site, "--convention", "dh", "--twist-order", "v-omega"))
    assignment = make_class(tmp_path / "hw", [Student("ada")])
    said = run_and_fail(*ordered(site, "--assignment", assignment.folder, "--convention", "screws"))
    assert 'set them in assignment.toml, as in convention = "screws"' in said


def test_a_course_has_variants_of_its_own_problems_and_tells_no_seed(few_pages: None, tmp_path: Path) -> None:
    assignment = make_class(tmp_path / "hw", [Student("ada")])
    site = tmp_path / "site"
    run(*ordered(site, "--assignment", assignment.folder, "--variants", "2", "--variation", "frames"))
    families = loaded(site, "index")["families"]
    assert {problem["variation"] for family in families for problem in family["problems"]} == {"frames"}
    assert loaded(site, "p1/p1-001")["id"] == "p1-001"
    seeds = [str(assignment.slots[0].make_problem_id(assignment.secret, f"bank/{n}").seed) for n in range(20)]
    content = "".join(path.read_text() for path in site.glob("bank/**/*.json"))
    assert not [hidden for hidden in (assignment.secret, *seeds) if hidden in content]
    assert "<title>T</title>" in (site / "index.html").read_text()


def test_a_course_tells_of_wrong_answers_what_its_assignment_says(few_pages: None, tmp_path: Path) -> None:
    assignment, site = make_class(tmp_path / "hw", [Student("ada")]), tmp_path / "site"
    arguments = ordered(site, "--assignment", assignment.folder)

    def built(*more: str) -> tuple[str, set[str]]:
        run(*arguments, *more)
        revealing = [
            path for path in site.glob("bank/p1/**/*.json") if re.search('"(solved|factors)"', path.read_text())
        ]
        return loaded(site, "index")["feedback"], {path.name for path in revealing}

    level, solved = built("--feedback", "solutions")
    questions = loaded(site, "index")["families"][0]["problems"][0]["questions"]
    assert level == "solutions"
    assert solved == {"p1-001.json", *(f"{name}{ending}" for name in questions for ending in (".json", ".de.json"))}
    assert built() == ("counterexample", set())
    made = (site / "bank" / "p1" / "p1-001.json").stat().st_mtime_ns
    (assignment.folder / "assignment.toml").write_text(f'feedback = "outcome"\n{TOML}')
    assert built() == ("outcome", set())
    assert (site / "bank" / "p1" / "p1-001.json").stat().st_mtime_ns == made
    assert built("--feedback", "solutions") == ("solutions", solved)
    assert "unknown level of feedback 'all'" in run_and_fail(*arguments, "--feedback", "all")


def test_what_is_wrong_is_said(assets: None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert "'planer-2r'" in run_and_fail("site", "build", "--out", tmp_path / "s", "--families", "planer-2r")
    assert "nowhere" in run_and_fail("site", "serve", tmp_path / "nowhere")
    monkeypatch.setattr(site_pages, "find_folder", lambda *_: None)
    monkeypatch.setattr(site_pages, "find_assets", find_assets)
    assert "run `make site-scripts` in" in run_and_fail(*ordered(tmp_path / "s"))
    monkeypatch.setattr(site_pages, "__file__", str(tmp_path / "qdot" / "exercises" / "site" / "pages.py"))
    assert "without Node: install Node 20.19 or later" in run_and_fail(*ordered(tmp_path / "s"))
    assert not (tmp_path / "s").exists()


@pytest.mark.parametrize(
    "written", ["{}", '{"src/practice/main.tsx": {"file": "assets/practice.js"}}', "no list", None]
)
def test_scripts_of_another_version_are_told(tmp_path: Path, written: str | None) -> None:
    if written is not None:
        (tmp_path / ".vite").mkdir()
        (tmp_path / ".vite" / "manifest.json").write_text(written)
    with pytest.raises(QdotError, match=r"src/learn/main\.tsx.* run `make site-scripts` in"):
        read_assets(tmp_path)


def test_links_of_the_docs_stay_on_the_site() -> None:
    page = link_pages('<h2>Two words</h2><a href="judging.md#bounds">x</a>')
    assert page == '<h2 id="two-words">Two words</h2><a href="judging.html#bounds">x</a>'


def test_every_page_of_the_documentation_has_its_place() -> None:
    groups = arrange_pages(DOCS)
    assert OTHER_PAGES not in groups
    listed = [entry.name for entries in groups.values() for entry in entries]
    assert sorted(listed) == sorted({path.stem for path in DOCS.glob("*.md")} - set(REPLACED_PAGES) | {COMMANDS})


def test_the_list_of_arms_has_the_format_that_the_site_reads() -> None:
    declared = re.search(r"readonly format: (\d+);", (ROOT / "site/src/own/known-arms.ts").read_text(encoding="utf-8"))
    assert declared and json.loads(make_tables_json())["format"] == int(declared[1])


@few_families
def test_keys_hold_what_the_derivation_in_numbers_gives(family: str) -> None:
    problem = get_problem(family, 0)
    for part in select_parts(problem):
        if isinstance(part.answer, Number) and problem.chain.n >= 6 and not WHOLE:
            continue  # what mistakes give in numbers takes seconds, and nothing but their form is looked at here
        key = make_key(problem, part)
        json.dumps(key, allow_nan=False)
        if key["type"] == "values" and is_derived_step_by_step(part):
            _values_are_right(problem, part, key)
        if key["type"] == "configurations":
            _poses_are_singular(problem, key)
        if key["type"] in ("choice", "selection", "matching"):
            assert len(key["option_mistakes"]) == key["options"] > max(key["right"])


def test_a_prompt_says_in_which_rates_an_answer_is_and_what_rows_and_columns_belong_to(family: str) -> None:
    """A page offers signs of those alone."""
    problem = get_problem(family, 0)
    spoken = {name for name, info in problem.symbols.items() if info.role in ("rate", "velocity", "force", "moment")}
    for part in problem.parts:
        if not isinstance(part.answer, (Choice, Selection, Matching)):
            used = set(re.findall(r"\w+", json.dumps(part.answer.as_json()))) & spoken
            assert used <= set(find_mentioned_names(problem, write_prompt(problem, part))), part.name
    for part in problem.parts:
        plain, grid = re.sub(r"[{}]", "", write_prompt(problem, part)), _list_labels(problem.chain, part)
        for lines, count, order in zip(grid, part.shape or (1, 1), ("rows", "columns"), strict=True):
            assert len(lines) in (0, count), (part.name, order)
            named = re.search(rf"{order} in the order \$([^$]*)\$", plain)
            if named:
                assert named[1].split(", ") == [re.sub(r"[{}]", "", line) for line in lines], (part.name, order)
        if part.shape and part.shape[1] > 1 and "column $i$ belongs to joint $i$" in plain:
            assert grid[1] == [tex(rate, problem.chain) for rate in problem.chain.rates[: part.shape[1]]]


def _values_are_right(problem: Problem, part: Part, key: dict[str, Any]) -> None:
    values = {name: np.array(column) for name, column in zip(key["symbols"], np.array(key["points"]).T, strict=True)}
    found = compute_answer(compute_numeric_stages(problem.chain, values), part).reshape(len(key["right"]), -1)
    right = np.array(key["right"], dtype=float)
    scale = np.abs(right).max(axis=0)
    assert (np.abs(found - right) <= 1e-9 * (np.abs(right) + scale)).all(), part.name
    total = sum(compute_weight(i) * entry for i, entry in enumerate(right))
    for mistake in key["mistakes"]:
        apart = [abs(a - b) > 3e-5 * abs(b) for a, b in zip(mistake["print"], total, strict=False)]
        assert any(apart), (part.name, mistake)


def _poses_are_singular(problem: Problem, key: dict[str, Any]) -> None:
    for piece in key["pieces"]:
        assert piece
        for pose in piece:
            values = dict(zip(key["symbols"], pose, strict=True))
            lengths = {name: value for name, value in values.items() if name not in key["joints"]}
            chain = NumericChain(problem.chain, lengths)
            rows = [["vx", "vy", "vz", "wx", "wy", "wz"].index(row) for row in problem.chain.task]
            jacobian = chain.compute_jacobian(np.array([values[name] for name in key["joints"]]))[rows]
            singular = np.linalg.svd(jacobian)[1]
            assert singular[-1] < 1e-5 * max(1.0, singular[0])


def test_mistakes_are_told_and_none_of_them_is_right() -> None:
    """Also what people do most, though it comes late in the catalogue, and those that no derivation makes."""
    problem = generate(ProblemId("elbow-3r", 1, ("jacobian", "joint-rates"), variation="chapter"))
    jacobian, rates = ({mistake["name"] for mistake in make_key(problem, part)["mistakes"]} for part in problem.parts)
    assert {"transposed", "cross-order"} <= jacobian
    assert {"rates-in-degrees", "degrees-as-radians", "degrees", "transpose-for-inverse"} <= rates
    asked = ("jacobian-size", "joint-rates", "path-rates", "rank", "manipulability", "determinant-value", "speed")
    problem = generate(ProblemId("planar-2r", 1, asked, variation="chapter"))
    told: dict[str, set[str]] = {}
    for part in problem.parts:
        key = make_key(problem, part)
        told[part.kind] = {mistake["name"] for mistake in key["mistakes"]}
        for mistake in key["mistakes"]:
            assert len(mistake["values"]) == len(key["right"])
            assert not np.allclose(mistake["values"], key["right"], rtol=1e-4, atol=0.0), mistake
    assert told["jacobian-size"] >= {"size-six-rows"} and told["rank"] >= {"rank-full"}
    assert told["path-rates"] >= {"rates-at-start", "path-reversed", "degrees", "rates-in-degrees"}
    assert {"row-misread", "product-sign", "determinant-sign"} <= told["joint-rates"]
    assert {"determinant-sign", "degrees-as-radians", "degrees"} <= told["determinant-value"]
    assert {"components-added", "component-alone", "speed-squared"} <= told["speed"]
    assert "degrees-as-radians" in told["speed"] and "rates-in-degrees" not in told["speed"]


def test_of_a_factor_and_of_lengths_that_are_missing_it_is_told_which() -> None:
    problem = generate(ProblemId("elbow-3r", 1, ("determinant", "inverse-velocity"), variation="chapter"))
    record = make_site_record(problem)
    lost = {row[3] for row in record["said"] if row[0] == "factor-lost"}
    assert {"a2", "a3", "theta3", "theta2, theta3"} <= lost
    determinant, rates = (part["key"] for part in record["parts"])
    everywhere = [record["said"][index] for index, *_ in rates["throughout"]]
    assert [row[3] for row in everywhere if row[0] == "lengths-missing"] == ["a1, a2, a3", "a1", "a2", "a3"]
    assert len({tuple(values) for _, *values in rates["throughout"]}) == len(rates["throughout"])
    assert "linear" not in determinant
    german = translate_record(problem, record, "de")["said"]
    assert [row[3:] for row in german] == [row[3:] for row in record["said"]]
    assert any(row[2].startswith("In deiner Antwort: ") for row in german)


def test_what_mistakes_make_of_a_direction_is_told_up_to_a_factor() -> None:
    """At the configurations of the key, with the joints where the question has them."""
    problem = generate(ProblemId("planar-2r", 1, ("lost-direction",), variation="chapter"))
    (key,) = (make_key(problem, part) for part in problem.parts)
    prints = {mistake["name"]: mistake["print"] for mistake in key["mistakes"]}
    for k, (one, other) in enumerate(zip(*key["right"], strict=True)):
        if k < len(prints["direction-that-moves"]):
            moves = abs(-other + compute_weight(1) * one) / np.hypot(one, other)
            assert prints["direction-that-moves"][k] == pytest.approx(moves, rel=1e-4)
    assert all(len(set(values)) > 1 for values in prints.values())


def test_a_key_tells_what_velocities_are_multiplied_by() -> None:
    problem = generate(ProblemId("planar-2r", 1, ("inverse-velocity",), variation="chapter"))
    (key,) = (make_key(problem, part) for part in problem.parts)
    assert set(key["linear"]) == {"vx", "vy"}
    for k in range(len(key["linear"]["vx"][0])):
        at = dict(zip(key["symbols"], key["points"][k], strict=True))
        for i, due in enumerate(key["right"]):
            given = sum(factors[i][k] * at[name] for name, factors in key["linear"].items())
            assert given == pytest.approx(due[k], rel=1e-4)


def test_behind_a_single_number_of_many_digits_more_mistakes_are_told() -> None:
    problem = generate(ProblemId("elbow-3r", 1, ("joint-rates", "manipulability", "speed"), variation="chapter"))
    rates, measure, speed = (make_key(problem, part) for part in problem.parts)
    assert "precise" not in rates
    for key in (measure, speed):
        assert len(key["precise"]) > 20
        assert not {tuple(one["values"]) for one in key["precise"]} & {tuple(one["values"]) for one in key["mistakes"]}
    assert {"sine-for-cosine", "link-left-out"} <= {one["name"] for one in speed["precise"]}
    kept = make_site_record(problem)["parts"][1]["key"]["precise"]
    assert all(isinstance(index, int) for index, _ in kept)


@pytest.mark.parametrize("name", ["determinant-value", "speed"])
def test_a_short_question_in_numbers_is_worked_out_as_the_chapters(name: str) -> None:
    """With no mistake in it, the derivation gives its answer."""
    problem = generate(ProblemId("elbow-3r", 1, (name,)))
    (part,) = problem.parts
    derived, of_answer = _find_derived_question(part)
    assert derived is not None
    right = of_answer(compute_answer(_evaluate_derivation(problem, part), derived)).tolist()
    assert right == pytest.approx([float(value) for value in part.answer.as_matrix()])


def test_the_page_knows_the_steps_in_their_order() -> None:
    text = (ROOT / "site" / "src" / "practice" / "choice.ts").read_text(encoding="utf-8")
    assert f"export const VARIATION_STEPS = {json.dumps(list(VARIATION_STEPS))} as const;" in text


@few_families
def test_a_record_for_a_server_has_the_form_of_each_answer_but_no_value(family: str) -> None:
    problem = get_problem(family, 0)
    english, german = make_asked_record(problem, has_hints=True), make_asked_record(problem, False, "de")
    assert "said" not in english and "lang" not in english and german["lang"] == "de"
    assert german["title"] == german["robot"]["title"] != english["title"]
    shown = {part["name"]: part for part in english["parts"]}
    for part in {part.type: part for part in select_parts(problem)}.values():
        key = make_key(problem, part, with_mistakes=False)
        form = {"type": key["type"], "units": key.get("units", []), "items": key.get("items", 0)}
        assert shown[part.name]["key"] == form
    assert any(part["hints"] for part in english["parts"])
    assert not any(part["hints"] for part in german["parts"])
    for part, translated in zip(english["parts"], german["parts"], strict=True):
        assert translated["prompt"] != part["prompt"] and translated["key"] == part["key"]


def test_a_record_says_what_a_page_needs() -> None:
    problem = generate(ProblemId("planar-2r", 7, ("position", "jacobian", "singular-angles")))
    record = make_site_record(problem)
    assert record == make_site_record(problem)
    assert "<math" in record["statement"] and 'class="tex"' not in record["statement"]
    assert 'class="tex"' in record["parts"][0]["hints"][0]
    assert [part["names"] for part in record["parts"]] == [[], [], []]
    assert "$" not in record["statement"]
    assert record["robot"]["joints"][0]["kind"] == "R"
    named = [mistake for part in record["parts"][:2] for mistake in part["key"]["mistakes"]]
    assert named and all(len(record["said"][mistake[0]]) in (3, 4) for mistake in named)
    position = record["parts"][0]["key"]
    assert len(position["points"]) == 16 and (position["rows"], position["columns"]) == (2, 1)
    text = json.dumps(record["parts"][1]["key"])
    assert "sin" not in text and "theta1*" not in text  # numbers, no formula
    solved = make_solutions_record(problem)
    assert "factors" in solved and "factors" not in record
    assert [part["name"] for part in solved["parts"]] == ["position", "jacobian", "singular-angles"]
    assert solved["parts"][2]["figure"].startswith("<svg")
    assert 'class="tex"' in solved["parts"][0]["solution"]


LENGTH = re.compile(r"([ad])_\{(\d)\} = (-?[\d.]+)\\,\\text\{m\}")
ANGLE = re.compile(r"\\theta_\{(\d)\} = (-?[\d.]+)\^\\circ")


@pytest.mark.parametrize("family", sample_for_suite(["planar-2r", "polar-rp", "elbow", "scara"], 2))
@pytest.mark.parametrize("quiz", [False, True])
def test_the_arm_beside_a_question_has_the_numbers_of_its_text(family: str, quiz: bool) -> None:
    asked = select_quiz_questions(family, "") if quiz else tuple(set(find_listing(family).questions) & set(GIVEN))
    problem = generate(ProblemId(family, 1, asked))
    found = 0
    for part in problem.parts:
        if part.kind in OF_ALL_POSES:
            continue
        pose = _find_given_pose(problem.chain, part)
        text = write_prompt(problem, part).split("- **A.**")[0]
        said = {f"{letter}{index}": float(value) for letter, index, value in LENGTH.findall(text)}
        said |= {f"theta{index}": np.radians(float(value)) for index, value in ANGLE.findall(text)}
        assert not said or pose == pytest.approx(said | (pose or {}), abs=1e-4), part.kind
        found += len(said)
    assert found > 3


GIVEN = ["joint-effect", "joint-rates", "path-rates", "rank", "singularity-type"]
OF_ALL_POSES = ["singularity-meaning"]
"""The questions about all configurations with a joint at a value, not about a single configuration."""


def test_a_letter_is_drawn_with_no_length_of_the_table() -> None:
    for variation, seed in product(VARIATION_STEPS, range(1, 9)):
        problem = generate(ProblemId("planar-2r", seed, ("position",), variation=variation))
        values = {round(value, 6) for value in make_arm_record(problem)["robot"]["values"].values()}
        lengths = {length for joint in problem.chain.joints for length in (joint.a, joint.d) if length.is_number}
        assert not values & {round(float(length), 6) for length in lengths}, (variation, seed)


@pytest.mark.parametrize("family", ["planar-2r", "elbow-3r", "polar-rp"])
def test_the_factors_of_a_record_make_up_its_determinant(family: str) -> None:
    chain = generate(ProblemId(family, 3, ("position",))).chain
    names = {str(symbol): symbol for symbol in (*chain.q, *chain.parameters)}
    factors = [sp.sympify(typed, names) for _, typed in list_determinant_factors(chain)]
    determinant = derive(chain).jacobian.det()
    quotient = determinant / sp.Mul(*factors)
    letters = {symbol: 0.3 + 0.1 * k for k, symbol in enumerate(sorted(chain.parameters, key=str))}
    values = {quotient.subs({**letters, **dict.fromkeys(chain.q, at)}).evalf(12) for at in (0.7, 1.9)}
    assert max(values) - min(values) < 1e-9
    assert factors


def test_an_arm_without_determinant_has_no_factors() -> None:
    assert list_determinant_factors(generate(ProblemId("planar-3r", 7, ("position",))).chain) == []


ALL = ARMS_PER_STEP * len(VARIATION_STEPS)


def arms(family: str, variants: int) -> list[BankProblem]:
    return [wanted for wanted in list_problems_of_families([family], variants) if wanted.questions != (QUIZ,)]


@pytest.mark.whole
def test_family_has_so_many_arms_at_every_step() -> None:
    wanted = list_problems_of_families(list(FAMILIES), ALL)
    assert len({(one.family, one.key) for one in wanted}) == len(wanted)
    counts = Counter((one.family, one.variation) for one in wanted if one.questions != (QUIZ,))
    assert counts == {(family, step): ARMS_PER_STEP for family in FAMILIES for step in VARIATION_STEPS}


@few_families
def test_arms_of_a_step_differ_and_every_question_comes_with_several_of_them(family: str) -> None:
    if FAMILIES[family].has_varied_structure:
        pytest.skip("its arms have structures of their own, which are drawn as they are made")
    wanted = arms(family, ALL)
    for step in VARIATION_STEPS:
        of_step = [one for one in wanted if one.variation == step]
        fresh = [one for one in of_step if one.question_share is None]
        chains = {sample_chain(ProblemId(family, one.seed, variation=step)) for one in fresh}
        assert len(chains) == len(fresh)
        assert fresh[0].questions == ()
        others = Counter(name for one in fresh[1:] for name in one.questions)
        assert others == dict.fromkeys(
            find_listing(family).questions if fresh[1:] else (), min(ARMS_PER_QUESTION, len(fresh) - 1)
        )
        again = [one for one in of_step if one.question_share is not None]
        assert {sample_chain(ProblemId(family, one.seed, variation=step)) for one in again} <= chains
    assert len([one for one in wanted if one.variation == "full" and one.question_share is None]) == ARMS_PER_STEP


def test_few_arms_are_asked_everything() -> None:
    assert [one.variation for one in arms("scara", 6)] == [*VARIATION_STEPS, "chapter"]
    assert {one.variation for one in list_problems_of_families(["scara"], 3, "base+lengths")} == {"lengths+base"}
    everything = find_listing("scara").questions
    several = arms("scara", len(VARIATION_STEPS) * (1 + ARMS_PER_QUESTION))
    asked = {one.questions for one in several if one.question_share is None}
    assert asked <= {(), everything}
    assert len(arms("scara", 3)) == 3


@pytest.mark.families(select_for_suite(("polar-rp", "wrist-zyz"), tuple(FAMILIES)), every=True)
def test_an_arm_that_is_there_already_is_asked_what_comes_in_other_numbers(family: str) -> None:
    if FAMILIES[family].has_varied_structure:
        pytest.skip("its arms are never there already")
    names = find_questions_with_sampled_numbers(family)
    assert names and "position" not in names and "determinant" not in names
    assert set(names) < set(find_listing(family).questions)
    again = [one for one in arms(family, ALL) if one.variation == "chapter" and one.question_share is not None]
    assert len(again) == ARMS_PER_STEP - 1
    asked = Counter(name for one in again for name in deal_questions(names, *(one.question_share or (0, 1))))
    assert set(asked) == set(names) and min(asked.values()) >= ARMS_PER_QUESTION
    first = generate(ProblemId(family, 1, names, variation="chapter"))
    told: dict[str, set[str]] = {name: set() for name in names}
    for seed in (one.seed for one in again):
        left = tuple(name for name in names if len(told[name]) < 2)
        if left:
            other = generate(ProblemId(family, seed, left, variation="chapter"))
            assert other.chain == first.chain
            for part in other.parts:
                told[part.name].add(repr((part.answer.as_json(), part.details)))
    assert all(len(ways) > 1 for ways in told.values()), told


def test_questions_are_dealt_evenly() -> None:
    for count, places in product(range(1, 31), (1, 2, 3, 4, 24, 100)):
        names = [f"q{i}" for i in range(count)]
        hands = [deal_questions(names, place, places) for place in range(places)]
        assert all(hands) and all(list(hand) == sorted(hand, key=names.index) for hand in hands)
        counts = Counter(name for hand in hands for name in hand)
        assert set(counts) == set(names), (count, places)
        assert max(counts.values()) - min(counts.values()) <= 1, (count, places)
        assert min(counts.values()) >= min(ARMS_PER_QUESTION, places), (count, places)


TOLD = [
    ("screws", "", ("screws", "")), ("", "v-omega", ("screws", "v-omega")),
    ("modified-dh", "", ("modified-dh", "")), ("dh", "", ("", "")),
]  # fmt: skip


@pytest.mark.parametrize(("convention", "twist_order", "told"), sample_for_suite(TOLD, 2))
def test_a_site_is_told_in_a_convention_throughout(convention: str, twist_order: str, told: tuple[str, str]) -> None:
    wanted = list_problems_of_families(["planar-2r"], ALL, "", convention, twist_order)
    usual = list_problems_of_families(["planar-2r"], ALL)
    assert [(o.key, o.seed, o.variation) for o in wanted] == [(o.key, o.seed, o.variation) for o in usual]
    assert {one.frame_convention for one in wanted} == {told}
    first, quiz, shared = (
        next(one for one in wanted if one.questions == asked and bool(one.question_share) == is_shared)
        for asked, is_shared in (((), False), ((QUIZ,), False), ((), True))
    )
    for one in (first, quiz, shared):
        made = one.generate()
        assert (made.id.convention, made.id.twist_order) == told
        assert made.chain.convention == (told[0] or "dh")
        assert made.chain.twist_order == (told[1] or "omega-v")
        assert made.parts
    asked = {part.name for part in first.generate().parts}
    assert ("space-jacobian" in asked) == (told[0] == "screws")


def test_every_question_of_a_convention_comes_with_several_arms() -> None:
    of_step = [one for one in list_problems_of_families(["planar-3r"], ALL, "", "screws") if one.variation == "full"]
    others = Counter(name for one in of_step if one.question_share is None for name in one.questions if name != QUIZ)
    assert others == dict.fromkeys(find_listing("planar-3r", "screws").questions, ARMS_PER_QUESTION)
    assert "body-jacobian" in others


def test_an_order_of_twists_beside_a_table_is_refused() -> None:
    with pytest.raises(QdotError, match="order of twists"):
        list_problems_of_families(["planar-2r"], 1, "", "modified-dh", "v-omega")
    with pytest.raises(QdotError, match="'srews'"):
        list_problems_of_families(["planar-2r"], 1, "", "srews")
