"""Write the problem bank of the site: certified problems as JSON.

A rerun does not rewrite files that are up to date.

bank/index.json                    the list of problems
bank/FAMILY/KEY.json               the arm of a problem (`record.split_record`)
bank/FAMILY/KEY/QUESTION.json      a question about it, with its worked solution if students may see it
bank/FAMILY/KEY.de.json            texts in German, loaded if the page is in German (`languages`)
bank/FAMILY/KEY/QUESTION.de.json   likewise
bank/index.de.json                 the titles of index.json in German

A page loads only the arm and the question that it shows. All questions about an arm would be ten times as much.
"""

import hashlib
import json
import shutil
from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import closing
from dataclasses import replace
from functools import cache
from pathlib import Path

from qdot.exercises.assignment.certified_problems import FailedSlot, FailureFinder
from qdot.exercises.assignment.store import compute_package_digest
from qdot.exercises.common.files import write_atomically
from qdot.exercises.common.parallel import map_in_order, return_state
from qdot.exercises.families import FAMILIES
from qdot.exercises.figure.plane import is_drawn_flat
from qdot.exercises.problem.record import Json
from qdot.exercises.questions.base import Question
from qdot.exercises.short_questions import ALL_QUESTIONS
from qdot.exercises.singularities.difficulty import rate_difficulty_level
from qdot.exercises.site.bank_problem import BankProblem
from qdot.exercises.site.record import (
    make_site_record,
    make_solutions_record,
    split_record,
    translate_record,
    translate_solutions,
)
from qdot.exercises.writing.custom_texts import translate_title
from qdot.exercises.writing.languages import LANGUAGES, LOCALE, load_catalogue
from qdot.exercises.writing.render import find_template_folder

BANK_FOLDER = "bank"

LANGUAGE_ENDINGS = (".json", *(f".{code}.json" for code in LANGUAGES))
"""The endings of the names of the bank's files: for English, and for each other language."""


def write_bank(
    folder: Path, problems: Sequence[BankProblem], find_failures: FailureFinder, jobs: int,
    on_problem: Callable[[], None], on_failed: Callable[[FailedSlot], None], with_solutions: bool = True,
) -> list[Json]:  # fmt: skip
    """Write the problems and return their entries in index.json.

    An entry has the keys family, key, difficulty, title, questions and variation, and flat if the arm's figure is
    planar. `on_problem` is called after every problem, and `on_failed` for each problem that fails with every seed.
    Solutions are written only if `with_solutions`.
    """
    entries, state = [], (folder, find_failures, with_solutions)
    with closing(map_in_order(_write_problem, problems, jobs, setup=return_state, arguments=(state,))) as results:
        for result in results:
            if isinstance(result, FailedSlot):
                on_failed(result)
            else:
                entries.append(result)
            on_problem()
    return entries


_BankState = tuple[Path, FailureFinder, bool]
"""The parameters `folder`, `find_failures` and `with_solutions` of `write_bank`."""


def _write_problem(state: _BankState, bank_problem: BankProblem) -> Json | FailedSlot:
    """Write the files of a problem that are not up to date; return the problem's entry in index.json."""
    folder, find_failures, with_solutions = state
    stem = folder / BANK_FOLDER / bank_problem.family / bank_problem.key
    problem_id = bank_problem.problem and bank_problem.problem.id
    source = (
        f"{compute_package_digest()}/{_compute_texts_digest()}/{with_solutions}/{replace(bank_problem, problem=None)}/"
        f"{problem_id}"
    )
    source_digest = hashlib.sha256(source.encode()).hexdigest()  # the bank must not reveal seeds
    current_entry = _find_current_entry(stem, source_digest)
    if current_entry is not None:
        return current_entry
    problem = bank_problem.find_certified(find_failures)
    if isinstance(problem, FailedSlot):
        return problem
    record = make_site_record(problem)
    entry = {
        "family": bank_problem.family, "key": bank_problem.key, "difficulty": rate_difficulty_level(problem.chain),
        "title": record["title"], "questions": [part.kind for part in problem.parts],
        "variation": problem.id.variation, **({"flat": True} if is_drawn_flat(problem.chain) else {}),
    }  # fmt: skip
    if bank_problem.problem is not None:
        record["id"] = bank_problem.key  # the problem's own id would reveal the seed
    solutions = make_solutions_record(problem) if with_solutions else None
    files = _name_files(split_record(record, record, solutions), ".json")
    for language in LANGUAGES:
        texts = translate_record(problem, record, language)
        solutions = translate_solutions(problem, language) if with_solutions else None
        files |= _name_files(split_record(record, texts, solutions), f".{language}.json")
    files[".json"] |= {"made_from": source_digest, "listed": entry}
    shutil.rmtree(stem, ignore_errors=True)  # it may have questions that are no longer asked
    stem.mkdir(parents=True)
    for ending, content in files.items():
        # A file that a power failure destroys is written again by the next run.
        write_atomically(Path(f"{stem}{ending}"), write_compact_json(content), is_synced=False)
    return entry


def _name_files(contents: Mapping[str, Json], language_ending: str) -> dict[str, Json]:
    """Return the same contents, with the ending for a language added to the ending of each file's name."""
    return {f"{ending}{language_ending}": content for ending, content in contents.items()}


def list_endings(entry: Json) -> list[str]:
    """Return what follows the key in the names of a problem's files, given the problem's entry in index.json."""
    stems = ["", *(f"/{name}" for name in entry["questions"])]
    return [f"{stem}{ending}" for stem in stems for ending in LANGUAGE_ENDINGS]


def _find_current_entry(stem: Path, source_digest: str) -> Json | None:
    """Return a problem's entry in index.json if its files exist and were made from the same source; else None."""
    try:
        record = json.loads(Path(f"{stem}.json").read_text(encoding="utf-8"))
        entry: Json = record["listed"]
        is_current = record["made_from"] == source_digest
        files = [Path(f"{stem}{ending}") for ending in list_endings(entry)]
    except (OSError, ValueError, KeyError, TypeError):
        return None  # a power failure may leave an empty file
    return entry if is_current and all(file.is_file() and file.stat().st_size for file in files) else None


@cache
def _compute_texts_digest() -> str:
    """Return a digest of the templates and translations, which `compute_package_digest` does not cover."""
    digest = hashlib.sha256()
    folder = find_template_folder()
    for path in sorted(folder.rglob("*.md.j2")):
        digest.update(path.relative_to(folder).as_posix().encode() + b"\0" + path.read_bytes())
    for language in LANGUAGES:
        digest.update((LOCALE / f"{language}.po").read_bytes())
    return digest.hexdigest()


def make_index_json(
    entries: Sequence[Json], titles: Sequence[tuple[str, str, str]], feedback: str, custom_questions: Iterable[Question]
) -> str:  # fmt: skip
    """Return index.json; `titles` are (name, title, source) of the families or slots, in order.

    `feedback` is the level of feedback on wrong answers, as in an assignment.
    """
    asked_names = {name for entry in entries for name in entry["questions"]}
    problems: dict[str, list[Json]] = defaultdict(list)
    for entry in entries:
        problems[entry["family"]].append({name: value for name, value in entry.items() if name != "family"})
    families = [
        {"name": name, "title": title, "source": source, "problems": problems[name]} for name, title, source in titles
    ]
    questions = [
        {"name": question.name, "title": question.title, "source": question.source, "form": question.form}
        for question in (*ALL_QUESTIONS.values(), *custom_questions)
        if question.name in asked_names
    ]
    return write_compact_json({"format": 1, "feedback": feedback, "families": families, "questions": questions})


def make_titles_json(
    language: str, titles: Sequence[tuple[str, str, str]], custom_questions: Sequence[Question] = ()
) -> str:  # fmt: skip
    """Return the titles in index.json in another language: {"families": {name: title}, "questions": {name: title}}.

    A slot of an instructor's assignment keeps its own title, whatever its name.
    """
    messages = load_catalogue(language)
    library_names = {name for name, title, _ in titles if name in FAMILIES and FAMILIES[name].title == title}
    families = {name: messages.translate_family(FAMILIES[name].title) for name in sorted(library_names)}
    all_questions = (*ALL_QUESTIONS.values(), *custom_questions)
    questions = {question.name: translate_title(question, messages) for question in all_questions}
    return write_compact_json({"families": families, "questions": questions})


def write_compact_json(content: Json) -> str:
    """Return a file of the bank as JSON on one line."""
    return json.dumps(content, ensure_ascii=False, separators=(",", ":"), allow_nan=False) + "\n"
