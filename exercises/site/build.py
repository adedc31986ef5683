"""Build the site in a folder: scripts and styles, pages, the problem bank, and the service worker for offline use."""

import hashlib
import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from qdot.exercises.assignment.assignment import FEEDBACK
from qdot.exercises.assignment.certified_problems import FailedSlot, FindFailures
from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.files import make_folder, write_atomically
from qdot.exercises.problem.record import Json
from qdot.exercises.site import pages
from qdot.exercises.site.bank import BANK_FOLDER, PROBLEM_ENDINGS, SOLUTION_ENDINGS, index_text, titles_text, write_bank
from qdot.exercises.site.page import INDEX_FILE, ROBOTS_FILE
from qdot.exercises.site.robots import robots_text
from qdot.exercises.site.supply import BankProblem
from qdot.exercises.writing.languages import LANGUAGES

NOT_BUILT_MESSAGE = (
    "the site's scripts are not built: run `make site`, which needs Node and npm; an installed qdot has them already"
)
SIZES_FILE = f"{BANK_FOLDER}/sizes.json"
GALLERY_FOLDER = "docs/families/"
"""The folder with the pictures of the gallery, which is available offline like the other pages."""


@dataclass(frozen=True)
class SiteSpec:
    """The specification of a site.

    - `problems`: the problems of its bank
    - `titles`: the name, the title and the source of each family or slot
    - `find_failures`: a function that returns what is wrong with a problem
    - `jobs`: the number of processes
    - `command_reference`: the reference of the command line, as HTML
    - `docs`: the folder of the documentation, None for a site without it
    - `course`: the title of an instructor's own site
    - `feedback`: the level of feedback on wrong answers; at the last level, the bank has solutions
    """

    folder: Path
    problems: Sequence[BankProblem]
    titles: Sequence[tuple[str, str, str]]
    find_failures: FindFailures
    jobs: int
    command_reference: str
    docs: Path | None = None
    course: str = ""
    feedback: str = FEEDBACK[-1]

    @property
    def has_solutions(self) -> bool:
        """Whether the bank has solutions."""
        return self.feedback == FEEDBACK[-1]


def write_site(spec: SiteSpec, on_problem: Callable[[], None], on_failed: Callable[[FailedSlot], None]) -> Json:
    """Build the site, and return the numbers of problems, questions and files for offline use. Raises QdotError.

    `on_problem` is called after every problem, and `on_failed` for each problem of which every draw fails its
    certificate.
    """
    assets = pages.find_assets()
    if assets is None:
        raise QdotError(NOT_BUILT_MESSAGE)
    make_folder(spec.folder)
    entries = write_bank(
        spec.folder, spec.problems, spec.find_failures, spec.jobs, on_problem, on_failed, spec.has_solutions
    )
    endings = PROBLEM_ENDINGS + SOLUTION_ENDINGS * spec.has_solutions
    problems = {
        name: {ending: spec.folder / BANK_FOLDER / f"{name}{ending}" for ending in endings}
        for name in (f"{entry['family']}/{entry['key']}" for entry in entries)
    }
    files: dict[str, str | bytes] = {
        **{path.relative_to(assets.folder).as_posix(): path.read_bytes() for path in assets.files},
        ROBOTS_FILE: robots_text(),
        SIZES_FILE: _sizes_text(problems),
        INDEX_FILE: index_text(entries, spec.titles, spec.feedback),
        **{f"{BANK_FOLDER}/index.{language}.json": titles_text(language, spec.titles) for language in LANGUAGES},
        "icon.svg": pages.favicon_text(),
        "manifest.webmanifest": pages.manifest_text(spec.course),
    }
    families = [name for name, _, _ in spec.titles]
    for page in pages.make_pages(
        pages.PageContext(spec.docs, spec.command_reference, spec.course, families, pages.licences_text(assets.folder))
    ):
        files[page.path] = pages.page_text(page, assets, spec.course, spec.docs is not None)
        for language, (title, body) in page.translations.items():
            translated = json.dumps({"title": title, "body": body}, ensure_ascii=False)
            files[page.translated_path(language)] = translated
    drawings = {} if spec.docs is None else _drawings(spec.docs)
    offline = files | {path: data for path, data in drawings.items() if path.startswith(GALLERY_FOLDER)}
    version = hashlib.sha256()  # browsers discard their whole cache if a file of the bank changes
    for data in (*offline.values(), *(path.read_bytes() for paths in problems.values() for path in paths.values())):
        version.update(data.encode() if isinstance(data, str) else data)
    for path, data in (offline | drawings).items():
        write_atomically(spec.folder / path, data, is_synced=False)
    write_atomically(spec.folder / "sw.js", pages.service_worker_text([*offline], version.hexdigest()[:16]))
    questions = sum(len(entry["questions"]) for entry in entries)
    return {"problems": len(entries), "questions": questions, "files": len(offline)}


def _sizes_text(problems: Mapping[str, Mapping[str, Path]]) -> str:
    """Return the sizes of the files of each problem: {"files": {"FAMILY/KEY": {ending: bytes}}}."""
    files = {name: {ending: path.stat().st_size for ending, path in paths.items()} for name, paths in problems.items()}
    return json.dumps({"format": 1, "files": files}, separators=(",", ":"))


def _drawings(docs: Path) -> dict[str, bytes]:
    """Return the drawings and pictures of the documentation, by their paths in the site."""
    paths = sorted(path for path in docs.rglob("*") if path.suffix in (".png", ".svg"))
    return {f"docs/{path.relative_to(docs).as_posix()}": path.read_bytes() for path in paths}
