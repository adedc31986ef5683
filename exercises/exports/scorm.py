"""Packages for learning platforms, SCORM 1.2 and SCORM 2004: a page of the site that reports a score, with its bank.

Each student has one variant of every place, drawn in the browser by the identifier that the platform gives; answers are
judged there, too (`qdot.exercises.site`), so that what is right is in the package.
"""

import json
import tempfile
from collections.abc import Generator
from dataclasses import replace
from pathlib import Path

from qdot.exercises.assignment.assignment import FEEDBACK, Slot
from qdot.exercises.assignment.draws import GivenUp
from qdot.exercises.common.errors import QdotError
from qdot.exercises.exports.bank import bank
from qdot.exercises.exports.markup import archive
from qdot.exercises.exports.outlet import File, Order
from qdot.exercises.exports.qti import TRIES
from qdot.exercises.problem.record import Json
from qdot.exercises.site.bank import FOLDER, index_text, titles_text, write_bank
from qdot.exercises.site.build import NOT_BUILT
from qdot.exercises.site.pages import Assets, built_assets, favicon
from qdot.exercises.site.supply import of_variants
from qdot.exercises.writing.languages import LANGUAGES
from qdot.exercises.writing.render import render

VERSIONS = {"1.2": "scorm12", "2004": "scorm2004"}
"""The versions of SCORM, each with what its package is called."""
MOST_PARTS = 1000
"""So many questions are kept in the 4,096 characters that SCORM 1.2 keeps for a student (site/src/course/round.ts)."""
LONGEST_TITLE = 200
"""Characters of a title, by the schema of SCORM 1.2."""
_OURS = ("made_from", "listed")
"""What a record of the bank has for the next build only."""

_Files = dict[str, str | bytes]


def packages(order: Order) -> Generator[File, None, None]:
    """Yield a package for each version of SCORM: the page, its scripts, the bank, the manifest that lists them."""
    assignment = order.assignment
    assets = built_assets()
    if assets is None:
        raise QdotError(NOT_BUILT)
    for slot in assignment.slots:
        _note_what_is_judged_otherwise(order, slot)
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
    """Return that the site's scripts are not built, and how they are; "" where they are."""
    try:
        return NOT_BUILT if built_assets() is None else ""
    except QdotError as error:
        return str(error)


def check_size(order: Order) -> None:
    """Raise QdotError for more questions than SCORM 1.2 keeps the standing of."""
    count = sum(len(slot.questions) for slot in order.assignment.slots)
    if count > MOST_PARTS:
        raise QdotError(
            f"{order.assignment.folder / 'assignment.toml'}: it has {count} questions, and a package has room for what "
            f"a student did in {MOST_PARTS}; export it in parts, each an assignment of its own"
        )


def _note_what_is_judged_otherwise(order: Order, slot: Slot) -> None:
    """Tell the staff of what assignment.toml says of marking that a browser does not do."""
    if slot.decimals:
        named = ", ".join(name for name, _ in slot.decimals)
        order.note(f"{slot.name}: in the package, rounded decimals are not taken for right ({named})")
    own = [name for name, credit in slot.credit if credit.by not in ("", "whole")]
    if own:
        order.note(f"{slot.name}: in the package, partial credit of {', '.join(own)} is by the rule of its answer")


def _page(order: Order, version: str, assets: Assets) -> str:
    title = order.assignment.title
    about = json.dumps({"scorm": version, **_set(order)}, ensure_ascii=False)
    return render(
        "exports/scorm/index.html.j2", title=title, set=about, frames=False, script=assets.scripts["package"],
        modules=assets.modules["package"], styles=assets.styles["package"],
    )  # fmt: skip


def _set(order: Order) -> Json:
    """Return what the page is told of the set: its places, with points and credit for what is right in part."""
    assignment = order.assignment
    return {
        "key": assignment.key,
        "title": assignment.title,
        "tries": assignment.attempts.best_of or TRIES,
        "pass": None if order.passing is None else float(order.passing),
        "places": [{"name": slot.name, "questions": _questions(slot)} for slot in assignment.slots],
    }


def _questions(slot: Slot) -> list[list[str | float]]:
    """Return the questions of a place: name, points, and what a share of the points is multiplied by."""
    credit = {name: 0.0 if one.by == "whole" else float(one.worth) for name, one in slot.credit}
    return [[name, points, credit.get(name, 1.0)] for name, points in zip(slot.questions, slot.max_points, strict=True)]


def _bank_files(order: Order) -> _Files:
    """Return the files of the bank by path: problems, their texts in other languages, solutions where they are told."""
    assignment = order.assignment
    level = FEEDBACK[-1] if order.solutions else assignment.feedback
    wanted = of_variants(list(bank(replace(order, each=lambda: None))))
    titles = [(slot.name, slot.family.title, slot.family.source) for slot in assignment.slots]
    with tempfile.TemporaryDirectory() as folder:
        left_out: list[GivenUp] = []
        listed = write_bank(
            Path(folder), wanted, order.failures, order.jobs, order.each, left_out.append, level == FEEDBACK[-1]
        )
        if left_out:
            raise QdotError(f"{left_out[0]}. Nothing is exported")  # it passed a moment ago: our own fault
        for _ in range(len(assignment.slots) * order.variants - len(wanted)):
            order.each()
        files = _read(Path(folder), assignment.hints)
    files[f"{FOLDER}/index.json"] = index_text(listed, titles, level)
    return files | {f"{FOLDER}/index.{code}.json": titles_text(code, titles) for code in LANGUAGES}


def _read(folder: Path, hints: bool) -> _Files:
    """Return the files of a bank as packages hold them, without hints where the assignment gives none."""
    return {
        path.relative_to(folder).as_posix(): _packed(json.loads(path.read_text(encoding="utf-8")), hints)
        for path in sorted(folder.rglob("*.json"))
    }


def _packed(record: Json, hints: bool) -> str:
    kept = {name: value for name, value in record.items() if name not in _OURS}
    if not hints:
        kept["parts"] = [_without_hints(part) for part in kept["parts"]]
    return json.dumps(kept, ensure_ascii=False, separators=(",", ":"), allow_nan=False) + "\n"


def _without_hints(part: Json) -> Json:
    return part | {"hints": []} if "hints" in part else part
