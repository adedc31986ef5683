"""Build the site in a folder: scripts and styles, pages, the problem bank, and the service worker for offline use."""

import hashlib
import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from qdot.exercises.assignment.assignment import FEEDBACK_LEVELS
from qdot.exercises.assignment.certified_problems import FailedSlot, FailureFinder
from qdot.exercises.common.files import make_folder, write_atomically
from qdot.exercises.problem.record import Json
from qdot.exercises.site import bank, pages
from qdot.exercises.site.bank_problem import BankProblem, find_custom_questions
from qdot.exercises.site.page import INDEX_FILE, ROBOTS_FILE
from qdot.exercises.site.robots import make_tables_json
from qdot.exercises.writing.languages import LANGUAGES
from qdot.exercises.writing.render import render

SIZES_FILE = f"{bank.BANK_FOLDER}/sizes.json"
"""The sizes of the files of each problem: {"files": {"FAMILY/KEY": {ending: bytes}}}."""
GALLERY_FOLDER = "docs/families/"
"""The folder with the pictures of the gallery, which are available offline, unlike the documentation's other files."""


@dataclass(frozen=True)
class SiteSpec:
    """The specification of a site.

    - `folder`: the folder into which the site is written
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
    find_failures: FailureFinder
    jobs: int
    command_reference: str
    docs: Path | None = None
    course: str = ""
    feedback: str = FEEDBACK_LEVELS[-1]

    @property
    def has_solutions(self) -> bool:
        """Whether the bank has solutions."""
        return self.feedback == FEEDBACK_LEVELS[-1]


def write_site(spec: SiteSpec, on_problem: Callable[[], None], on_failed: Callable[[FailedSlot], None]) -> Json:
    """Build the site, and return the numbers of problems, questions and files for offline use. Raises QdotError.

    `on_problem` is called after every problem, and `on_failed` for each problem that fails with every seed.
    """
    assets = pages.find_assets()
    make_folder(spec.folder)
    entries = bank.write_bank(
        spec.folder, spec.problems, spec.find_failures, spec.jobs, on_problem, on_failed, spec.has_solutions
    )
    custom_questions = find_custom_questions(spec.problems)
    folder = spec.folder / bank.BANK_FOLDER
    bank_paths: dict[str, dict[str, Path]] = {}
    for entry in entries:
        name = f"{entry['family']}/{entry['key']}"
        bank_paths[name] = {ending: folder / f"{name}{ending}" for ending in bank.list_endings(entry)}
    sizes = {name: {ending: p.stat().st_size for ending, p in paths.items()} for name, paths in bank_paths.items()}
    files: dict[str, str | bytes] = {
        **{path.relative_to(assets.folder).as_posix(): path.read_bytes() for path in assets.files},
        ROBOTS_FILE: make_tables_json(),
        SIZES_FILE: json.dumps({"format": 1, "files": sizes}, separators=(",", ":")),
        INDEX_FILE: bank.make_index_json(entries, spec.titles, spec.feedback, custom_questions),
        **{
            f"{bank.BANK_FOLDER}/index.{code}.json": bank.make_titles_json(code, spec.titles, custom_questions)
            for code in LANGUAGES
        },
        "icon.svg": pages.read_favicon(),
        "manifest.webmanifest": render(  # for adding the site to a phone's home screen
            "site/manifest.json.j2", name=spec.course or "qdot: velocity kinematics", short=spec.course or "qdot"
        ),
        **_write_pages(spec, assets),
    }
    linked_files = {} if spec.docs is None else _read_linked_files(spec.docs)
    offline_files = files | {path: data for path, data in linked_files.items() if path.startswith(GALLERY_FOLDER)}
    bank_data = (path.read_bytes() for paths in bank_paths.values() for path in paths.values())
    version = hashlib.sha256()  # if it changes, browsers discard their whole cache
    for data in (*offline_files.values(), *bank_data):
        version.update(data.encode() if isinstance(data, str) else data)
    for path, data in (offline_files | linked_files).items():
        write_atomically(spec.folder / path, data, is_synced=False)
    service_worker = render("site/sw.js.j2", files=[*offline_files], version=version.hexdigest()[:16])
    write_atomically(spec.folder / "sw.js", service_worker)
    questions = sum(len(entry["questions"]) for entry in entries)
    return {"problems": len(entries), "questions": questions, "files": len(offline_files)}


def _write_pages(spec: SiteSpec, assets: pages.Assets) -> dict[str, str]:
    """Map the path in the site of each page to its HTML, and the path of each translation to its JSON."""
    files = {}
    families, licences = [name for name, _, _ in spec.titles], pages.render_licences(assets.folder)
    for page in pages.make_pages(spec.docs, spec.command_reference, spec.course, families, licences):
        files[page.path] = pages.render_page(page, assets, spec.course, spec.docs is not None)
        for language, (title, body) in page.translations.items():
            translation = json.dumps({"title": title, "body": body}, ensure_ascii=False)
            files[page.make_translated_path(language)] = translation
    return files


def _read_linked_files(docs: Path) -> dict[str, bytes]:
    """Map the path in the site of each file that the documentation links, such as a picture, to the file's content."""
    paths = sorted(path for path in docs.rglob("*") if path.suffix in (".png", ".svg", ".json", ".toml"))
    return {f"docs/{path.relative_to(docs).as_posix()}": path.read_bytes() for path in paths}
