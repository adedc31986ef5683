"""The bank of the site: problems written as JSON, each certified, a rerun keeping what is up to date.

bank/index.json                 what there is to choose from
bank/FAMILY/KEY.json            a problem (`record.site_record`)
bank/FAMILY/KEY.solutions.json  its worked solutions, loaded when they are asked for, where they are told at all
bank/FAMILY/KEY.de.json         its texts in German, loaded where that is the page's language (`languages`)
bank/FAMILY/KEY.solutions.de.json  the same of its solutions
bank/index.de.json              the titles in index.json in German
"""

import hashlib
import json
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing
from functools import cache
from pathlib import Path

from qdot.exercises.arm.difficulty import step
from qdot.exercises.assignment.draws import Failures, GivenUp
from qdot.exercises.assignment.store import code
from qdot.exercises.common.files import write_atomically
from qdot.exercises.common.parallel import ordered_map
from qdot.exercises.families import FAMILIES
from qdot.exercises.figure.plane import is_flat
from qdot.exercises.problem.problem import Problem
from qdot.exercises.problem.record import Json
from qdot.exercises.quizzes import ASKED
from qdot.exercises.site.record import site_record, solutions_record, translated_record, translated_solutions
from qdot.exercises.site.supply import Wanted
from qdot.exercises.writing.languages import LANGUAGES, LOCALE, catalogue
from qdot.exercises.writing.render import template_folder

FOLDER = "bank"

TOLD = (".json", *(f".{code}.json" for code in LANGUAGES))
SOLVED = tuple(f".solutions{ending}" for ending in TOLD)
"""How the names of a problem's files end, and of its solutions'."""


def write_bank(
    folder: Path, wanted: Sequence[Wanted], failures: Failures, jobs: int, each: Callable[[], None],
    left_out: Callable[[GivenUp], None], solved: bool = True,
) -> list[Json]:  # fmt: skip
    """Write the problems and return what index.json lists of each: family, key, difficulty, title, questions, flat.

    `left_out` is told of one of which no draw passes its certificate. Without `solved`, there are no solutions.
    """
    listed = []
    with closing(ordered_map(_write, wanted, jobs, _state, (folder, failures, solved))) as every:
        for record in every:
            if isinstance(record, GivenUp):
                left_out(record)
            else:
                listed.append(record)
            each()
    return listed


_State = tuple[Path, Failures, bool]


def _state(folder: Path, failures: Failures, solved: bool) -> _State:
    return folder, failures, solved


def _write(state: _State, wanted: Wanted) -> Json | GivenUp:
    folder, failures, solved = state
    path = folder / FOLDER / wanted.family / f"{wanted.key}.json"
    problem_id = wanted.problem and wanted.problem.id
    drawn_as = f"{wanted.seed}/{wanted.asked}/{wanted.share}/{wanted.variation}/{wanted.told}/{problem_id}"
    about = f"{code()}/{_texts()}/{drawn_as}"
    made_from = hashlib.sha256(about.encode()).hexdigest()  # a seed is not to be read from the bank
    if not solved:
        for ending in SOLVED:
            path.with_suffix(ending).unlink(missing_ok=True)
    kept = _kept(path, made_from, TOLD + SOLVED * solved)
    if kept is not None:
        return kept
    problem = wanted.certified(failures)
    if isinstance(problem, GivenUp):
        return problem
    record = site_record(problem)
    listed = {
        "family": wanted.family, "key": wanted.key, "difficulty": step(problem.chain), "title": record["title"],
        "questions": [part.kind for part in problem.parts], "variation": problem.id.variation,
        **({"flat": True} if is_flat(problem.chain) else {}),
    }  # fmt: skip
    if wanted.problem is not None:
        record["id"] = wanted.key  # its own would tell the seed
    if solved:
        _write_solutions(path, problem, record["id"])
    for language in LANGUAGES:
        _write_text(path.with_suffix(f".{language}.json"), translated_record(problem, record, language))
    _write_text(path, {**record, "made_from": made_from, "listed": listed})
    return listed


def _write_solutions(path: Path, problem: Problem, key: str) -> None:
    _write_text(path.with_suffix(".solutions.json"), solutions_record(problem) | {"id": key})
    for language in LANGUAGES:
        _write_text(path.with_suffix(f".solutions.{language}.json"), translated_solutions(problem, language))


def _write_text(path: Path, content: Json) -> None:
    """Write a file of the bank; waiting for the disk would take as long as the problem, and it can be made again."""
    write_atomically(path, _text(content), lasting=False)


def _kept(path: Path, made_from: str, endings: Sequence[str]) -> Json | None:
    """Return what is listed of a problem that is there already, made by this very code."""
    try:
        record = json.loads(path.read_text(encoding="utf-8"))
        listed: Json | None = record["listed"] if record["made_from"] == made_from else None
    except (OSError, ValueError, KeyError, TypeError):
        return None
    return listed if all(_is_written(path.with_suffix(ending)) for ending in endings) else None


def _is_written(path: Path) -> bool:
    """Return whether a file is there, and not empty, as where the power failed before the disk had it."""
    try:
        return path.stat().st_size > 0
    except OSError:
        return False


@cache
def _texts() -> str:
    """Return a digest of what the texts are made from; `code` has none of it, as wording decides no problem."""
    digest = hashlib.sha256()
    folder = template_folder()
    for path in sorted(folder.rglob("*.md.j2")):
        digest.update(path.relative_to(folder).as_posix().encode() + b"\0" + path.read_bytes())
    for language in LANGUAGES:
        digest.update((LOCALE / f"{language}.po").read_bytes())
    return digest.hexdigest()


def index_text(listed: Sequence[Json], titles: Sequence[tuple[str, str, str]], feedback: str) -> str:
    """Return index.json; `titles` are (name, title, source) of the families or places, in order.

    `feedback` is how much is told of a wrong answer, of the levels of an assignment.
    """
    asked = {question for entry in listed for question in entry["questions"]}
    return _text(
        {
            "format": 1,
            "feedback": feedback,
            "families": [
                {"name": name, "title": title, "source": source, "problems": list(_of(listed, name))}
                for name, title, source in titles
            ],
            "questions": [
                {"name": q.name, "title": q.title, "source": q.source, "form": q.form}
                for q in ASKED.values()
                if q.name in asked
            ],
        }
    )


def titles_text(language: str, titles: Sequence[tuple[str, str, str]]) -> str:
    """Return the titles in index.json in another language: {"families": {name: title}, "questions": {name: title}}.

    A place of an instructor's own has none, whatever its name, and keeps the title that it was given.
    """
    words = catalogue(language)
    ours = {name for name, title, _ in titles if name in FAMILIES and FAMILIES[name].title == title}
    families = {name: words.family(FAMILIES[name].title) for name in sorted(ours)}
    return _text({"families": families, "questions": {q.name: words.question(q.title) for q in ASKED.values()}})


def _of(listed: Sequence[Json], family: str) -> Iterator[Json]:
    for entry in listed:
        if entry["family"] == family:
            yield {name: value for name, value in entry.items() if name != "family"}


def _text(content: Json) -> str:
    return json.dumps(content, ensure_ascii=False, separators=(",", ":"), allow_nan=False) + "\n"
