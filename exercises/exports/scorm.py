"""Export of SCORM 1.2 and SCORM 2004 packages for learning platforms: a web page that reports a score, and a bank.

Each student gets one variant of every slot. The browser chooses it by the identifier that the platform provides, and
it also grades the answers (`qdot.exercises.site`). Therefore the package contains the correct answers.
"""

import json
import tempfile
from collections.abc import Generator
from dataclasses import replace
from pathlib import Path

from qdot.exercises.assignment.assignment import FEEDBACK, Slot
from qdot.exercises.assignment.draws import FailedSlot
from qdot.exercises.common.errors import QdotError
from qdot.exercises.exports.bank import bank
from qdot.exercises.exports.export_format import File, Order, archive
from qdot.exercises.exports.qti import TRIES
from qdot.exercises.problem.record import Json
from qdot.exercises.site.bank import FOLDER, index_text, titles_text, write_bank
from qdot.exercises.site.build import NOT_BUILT
from qdot.exercises.site.pages import Assets, built_assets, favicon
from qdot.exercises.site.supply import wanted_of_variants
from qdot.exercises.writing.languages import LANGUAGES
from qdot.exercises.writing.render import render

VERSIONS = {"1.2": "scorm12", "2004": "scorm2004"}
"""The versions of SCORM, each with the name of its package."""
MOST_PARTS = 1000
"""The number of questions whose state fits into SCORM 1.2's 4,096 characters per student (site/src/course/round.ts)."""
LONGEST_TITLE = 200
"""Maximum length of a title in the schema of SCORM 1.2, in characters."""
_OURS = ("made_from", "listed")
"""Fields of a record in the bank that are only for a later build of the site, and not for students."""

_Files = dict[str, str | bytes]


def export_scorm(order: Order) -> Generator[File, None, None]:
    """Yield a package for each version of SCORM: page, scripts, bank, and the manifest that lists them."""
    assignment = order.assignment
    assets = built_assets()
    if assets is None:
        raise QdotError(NOT_BUILT)
    for slot in assignment.slots:
        _note_differences(order, slot)
    scripts = {path.relative_to(assets.folder).as_posix(): path.read_bytes() for path in assets.files}
    files = _bank_files(order) | scripts | {"icon.svg": favicon()}
    for version, name in VERSIONS.items():
        page = _page(order, version, assets)
        manifest = render(
            f"exports/scorm/manifest-{version}.xml.j2", ident=f"qdot-{assignment.key}",
            title=assignment.title[:LONGEST_TITLE], paths=sorted({*files, "index.html"}),
        )  # fmt: skip
        package = {"imsmanifest.xml": manifest, "index.html": page} | dict(sorted(files.items()))
        yield File(f"{assignment.key}-{name}.zip", archive(package), private=True)


def missing_scripts() -> str:
    """Return how to build the site's scripts if they are missing, else ""."""
    try:
        return NOT_BUILT if built_assets() is None else ""
    except QdotError as error:
        return str(error)


def check_size(order: Order) -> None:
    """Raise QdotError if SCORM 1.2 can't store the state of all questions, because there are too many."""
    count = sum(len(slot.questions) for slot in order.assignment.slots)
    if count > MOST_PARTS:
        raise QdotError(
            f"{order.assignment.folder / 'assignment.toml'}: it has {count} questions, and a package has room for what "
            f"a student did in {MOST_PARTS}; export it in parts, each an assignment of its own"
        )


def _note_differences(order: Order, slot: Slot) -> None:
    """Tell the staff which marking rules of assignment.toml the browser does not apply."""
    if slot.decimals:
        rounded_names = ", ".join(name for name, _ in slot.decimals)
        order.note(f"{slot.name}: in the package, rounded decimals are not taken for right ({rounded_names})")
    names = [name for name, credit in slot.credit if credit.by not in ("", "whole")]
    if names:
        order.note(f"{slot.name}: in the package, partial credit of {', '.join(names)} is by the rule of its answer")


def _page(order: Order, version: str, assets: Assets) -> str:
    title = order.assignment.title
    page_data = json.dumps({"scorm": version, **_describe_set(order)}, ensure_ascii=False)
    return render(
        "exports/scorm/index.html.j2", title=title, set=page_data, frames=False, script=assets.scripts["package"],
        modules=assets.modules["package"], styles=assets.styles["package"],
    )  # fmt: skip


def _describe_set(order: Order) -> Json:
    """Return the data of an assignment for its page: its slots, with points and partial credit."""
    assignment = order.assignment
    return {
        "key": assignment.key,
        "title": assignment.title,
        "tries": assignment.attempts.best_of or TRIES,
        "pass": None if order.passing is None else float(order.passing),
        "places": [{"name": slot.name, "questions": _questions(slot)} for slot in assignment.slots],
    }


def _questions(slot: Slot) -> list[list[str | float]]:
    """Return the questions of a slot: name, points, and the factor for partial credit."""
    credit = {name: 0.0 if rule.by == "whole" else float(rule.worth) for name, rule in slot.credit}
    return [[name, points, credit.get(name, 1.0)] for name, points in zip(slot.questions, slot.max_points, strict=True)]


def _bank_files(order: Order) -> _Files:
    """Return the files of the bank by path: problems, translations, and also solutions if students may see them."""
    assignment = order.assignment
    level = FEEDBACK[-1] if order.solutions else assignment.feedback
    bank_problems = wanted_of_variants(list(bank(replace(order, each=lambda: None))))
    titles = [(slot.name, slot.family.title, slot.family.source) for slot in assignment.slots]
    with tempfile.TemporaryDirectory() as folder:
        failures: list[FailedSlot] = []
        entries = write_bank(
            Path(folder), bank_problems, order.failures, order.jobs, order.each, failures.append, level == FEEDBACK[-1]
        )
        if failures:
            raise QdotError(f"{failures[0]}. Nothing is exported")  # each passed before, so this is a bug
        for _ in range(len(assignment.slots) * order.variants - len(bank_problems)):
            order.each()
        files = _read_bank(Path(folder), assignment.hints)
    files[f"{FOLDER}/index.json"] = index_text(entries, titles, level)
    return files | {f"{FOLDER}/index.{code}.json": titles_text(code, titles) for code in LANGUAGES}


def _read_bank(folder: Path, hints: bool) -> _Files:
    """Return the files of a bank for a package, with hints only if the assignment gives hints."""
    return {
        path.relative_to(folder).as_posix(): _compact_record(json.loads(path.read_text(encoding="utf-8")), hints)
        for path in sorted(folder.rglob("*.json"))
    }


def _compact_record(record: Json, hints: bool) -> str:
    fields = {name: value for name, value in record.items() if name not in _OURS}
    if not hints:
        fields["parts"] = [part | {"hints": []} if "hints" in part else part for part in fields["parts"]]
    return json.dumps(fields, ensure_ascii=False, separators=(",", ":"), allow_nan=False) + "\n"
