"""The site as Python builds it: pages that lead where they say, a bank that a rerun keeps, what is wrong told."""

import functools
import html
import json
import re
import shutil
import threading
import urllib.error
import urllib.request
from collections.abc import Iterator
from http.server import ThreadingHTTPServer
from itertools import islice
from pathlib import Path
from typing import Any

import pytest

from qdot.exercises.assignment.assignment import Student
from qdot.exercises.chapter import read_errata
from qdot.exercises.common.errors import QdotError
from qdot.exercises.problem.problem import Problem
from qdot.exercises.site import bank_problem
from qdot.exercises.site import pages as site_pages
from qdot.exercises.site.chapter import ERRATA_PATH, make_chapter_pages
from qdot.exercises.site.guide import COMMANDS, OTHER_PAGES, REPLACED_PAGES, arrange_pages
from qdot.exercises.site.pages import find_assets, link_pages, make_pages, read_assets
from qdot.exercises.site.robots import make_tables_json
from qdot.grader.cli import site_commands as command
from qdot.grader.cli.main import app
from qdot.grader.cli.site_commands import _QuietHandler
from tests.support import ROOT
from tests.support.command import run, run_and_fail, runner
from tests.support.site_scripts import write_stand_in_assets
from tests.support.submitting import TOML, make_class
from tests.support.suites import select_for_suite

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
