"""Builds the site in a folder: scripts and styles, pages, the bank, and the service worker for offline use."""

import hashlib
import json
import shutil
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from qdot.exercises.assignment.assignment import FEEDBACK
from qdot.exercises.assignment.draws import FailedSlot, Failures
from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.files import make_folder, write_atomically
from qdot.exercises.problem.record import Json
from qdot.exercises.site.bank import FOLDER, PROBLEM_ENDINGS, SOLUTION_ENDINGS, index_text, titles_text, write_bank
from qdot.exercises.site.page import INDEX, ROBOTS
from qdot.exercises.site.pages import (
    Around,
    Assets,
    built_assets,
    favicon,
    licences_text,
    manifest,
    page_text,
    pages,
    worker_text,
)
from qdot.exercises.site.robots import robots_text
from qdot.exercises.site.stale_files import remove_stale_files
from qdot.exercises.site.supply import BankProblem
from qdot.exercises.writing.languages import LANGUAGES

NOT_BUILT = (
    "the site's scripts are not built: run `make site`, which needs Node and npm; an installed qdot has them already"
)
SIZES = f"{FOLDER}/sizes.json"
GALLERY = "docs/families/"
"""The folder with the pictures of the gallery, which is available offline like the other pages."""


@dataclass(frozen=True)
class Order:
    """What site to build: the problems, their families or slots, and the texts around them.

    `feedback` is the level of feedback on wrong answers; at the last level, the bank has solutions.
    """

    folder: Path
    wanted: Sequence[BankProblem]
    titles: Sequence[tuple[str, str, str]]
    failures: Failures
    jobs: int
    commands: str
    docs: Path | None = None
    course: str = ""
    feedback: str = FEEDBACK[-1]

    @property
    def is_solved(self) -> bool:
        """Whether the bank has solutions."""
        return self.feedback == FEEDBACK[-1]


def build(order: Order, each: Callable[[], None], left_out: Callable[[FailedSlot], None]) -> Json:
    """Build the site; `each` is called after every problem, `left_out` for those of which no draw passes.

    Return counts: problems, questions, files for offline use. Raises QdotError.
    """
    assets = built_assets()
    if assets is None:
        raise QdotError(NOT_BUILT)
    make_folder(order.folder)
    listed = write_bank(order.folder, order.wanted, order.failures, order.jobs, each, left_out, order.is_solved)
    index = index_text(listed, order.titles, order.feedback)
    write_atomically(order.folder / INDEX, index)
    write_atomically(order.folder / ROBOTS, robots_text())
    titles = {f"{FOLDER}/index.{language}.json": titles_text(language, order.titles) for language in LANGUAGES}
    for name, text in titles.items():
        write_atomically(order.folder / name, text)
    write_atomically(order.folder / SIZES, _sizes_text(order, listed))
    shell = [*_copy_assets(assets, order.folder), ROBOTS, SIZES]
    families = [name for name, _, _ in order.titles]
    around = Around(order.docs, order.commands, order.course, families, licences_text(assets.folder))
    for page in pages(around):
        write_atomically(order.folder / page.path, page_text(page, assets, order.course, order.docs is not None))
        shell.append(page.path)
        for language, (title, body) in page.translations.items():
            path = page.translated_path(language)
            write_atomically(order.folder / path, json.dumps({"title": title, "body": body}, ensure_ascii=False))
            shell.append(path)
    drawings = [] if order.docs is None else _copy_drawings(order.docs, order.folder)
    shell += [name for name in drawings if name.startswith(GALLERY)]
    write_atomically(order.folder / "icon.svg", favicon())
    write_atomically(order.folder / "manifest.webmanifest", manifest(order.course))
    version = hashlib.sha256(
        b"".join((order.folder / name).read_bytes() for name in shell + _bank_paths(order, listed) + [*titles])
        + index.encode()
    ).hexdigest()
    shell += ["icon.svg", "manifest.webmanifest", INDEX, *titles]
    write_atomically(order.folder / "sw.js", worker_text(shell, version[:16]))
    remove_stale_files(order.folder, [*shell, *drawings, "sw.js"])
    questions = sum(len(entry["questions"]) for entry in listed)
    return {"problems": len(listed), "questions": questions, "files": len(shell)}


def _sizes_text(order: Order, listed: Sequence[Json]) -> str:
    """Return the sizes of the files of each problem: {"files": {"FAMILY/KEY": {ending: bytes}}}."""
    files: dict[str, dict[str, int]] = {}
    for entry in listed:
        name = f"{entry['family']}/{entry['key']}"
        paths = {
            ending: order.folder / FOLDER / f"{name}{ending}"
            for ending in PROBLEM_ENDINGS + SOLUTION_ENDINGS * order.is_solved
        }
        files[name] = {ending: path.stat().st_size for ending, path in paths.items()}
    return json.dumps({"format": 1, "files": files}, separators=(",", ":"))


def _bank_paths(order: Order, listed: Sequence[Json]) -> list[str]:
    """Return the paths of the bank's files; if one of them changes, browsers discard their cache of the site."""
    names = [f"{FOLDER}/{entry['family']}/{entry['key']}" for entry in listed]
    return [name + ending for name in names for ending in PROBLEM_ENDINGS + SOLUTION_ENDINGS * order.is_solved]


def _copy_drawings(docs: Path, folder: Path) -> list[str]:
    """Copy the documentation's drawings and pictures, and return their paths in the site."""
    names = []
    for drawing in sorted(path for path in docs.rglob("*") if path.suffix in (".png", ".svg")):
        names.append(f"docs/{drawing.relative_to(docs).as_posix()}")
        _copy(drawing, folder / names[-1])
    return names


def _copy_assets(assets: Assets, folder: Path) -> list[str]:
    """Copy scripts and styles, and return their paths in the site."""
    names = [path.relative_to(assets.folder).as_posix() for path in assets.files]
    for name, path in zip(names, assets.files, strict=True):
        _copy(path, folder / name)
    return names


def _copy(source: Path, target: Path) -> None:
    make_folder(target.parent)
    try:
        shutil.copyfile(source, target)
    except OSError as error:
        raise QdotError(f"{target} can't be written: {error.strerror or error}") from None
