"""Export SCORM 1.2 and SCORM 2004 packages for learning platforms: a web page that reports a score, and a bank.

Each student gets one variant of every slot. The browser chooses the variant by the identifier that the platform gives
the student, and it also grades the answers (`qdot.exercises.site`). So the package contains the correct answers.
"""

import json
import tempfile
from collections.abc import Generator
from dataclasses import replace
from pathlib import Path

from qdot.exercises.assignment.assignment import FEEDBACK_LEVELS, Slot
from qdot.exercises.assignment.certified_problems import FailedSlot
from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.files import make_zip
from qdot.exercises.exports.bank import iterate_bank
from qdot.exercises.exports.export_format import ExportedFile, ExportRequest
from qdot.exercises.problem.record import Json
from qdot.exercises.site import bank
from qdot.exercises.site.bank_problem import find_custom_questions, list_problems_of_variants
from qdot.exercises.site.pages import Assets, find_assets, read_favicon
from qdot.exercises.writing.languages import LANGUAGES
from qdot.exercises.writing.render import render

PACKAGE_NAMES = {"1.2": "scorm12", "2004": "scorm2004"}
"""The versions of SCORM, each with the name of its package."""
MAX_QUESTIONS = 1000
"""The number of questions whose state fits into SCORM 1.2's 4,096 characters per student (site/src/course/round.ts)."""
MAX_TITLE_LENGTH = 200
"""Maximum length of a title in the schema of SCORM 1.2, in characters."""
_BUILD_ONLY_FIELDS = ("made_from", "listed")
"""Fields of a record in the bank that are only for a later build of the site, and not for students."""

_Files = dict[str, str | bytes]


def export_scorm(request: ExportRequest) -> Generator[ExportedFile, None, None]:
    """Yield a package for each version of SCORM: page, scripts, bank, and the manifest that lists them."""
    assets = find_assets()
    supported_request = request.without_text_questions("SCORM")
    assignment = supported_request.assignment
    for slot in assignment.slots:
        _report_differences(supported_request, slot)
    scripts = {path.relative_to(assets.folder).as_posix(): path.read_bytes() for path in assets.files}
    files = _make_bank_files(supported_request) | scripts | {"icon.svg": read_favicon()}
    for version, name in PACKAGE_NAMES.items():
        page = _render_page(supported_request, version, assets)
        manifest = render(
            f"exports/scorm/manifest-{version}.xml.j2", ident=f"qdot-{assignment.key}",
            title=assignment.title[:MAX_TITLE_LENGTH], paths=sorted({*files, "index.html"}),
        )  # fmt: skip
        package = {"imsmanifest.xml": manifest, "index.html": page} | dict(sorted(files.items()))
        yield ExportedFile(f"{assignment.key}-{name}.zip", make_zip(package), is_private=True)


def explain_missing_scripts() -> str:
    """Return how to get the site's scripts if they are missing, else ""."""
    try:
        find_assets()
    except QdotError as error:
        return str(error)
    return ""


def check_size(request: ExportRequest) -> None:
    """Raise QdotError if SCORM 1.2 can't store the state of all questions, because there are too many."""
    count = sum(len(slot.questions) for slot in request.assignment.slots)
    if count > MAX_QUESTIONS:
        raise QdotError(
            f"{request.assignment.folder / 'assignment.toml'}: the assignment has {count} questions, but a package can "
            f"store the answers to at most {MAX_QUESTIONS}; split it into several assignments"
        )


def _report_differences(request: ExportRequest, slot: Slot) -> None:
    """Tell the staff which marking rules of assignment.toml the browser does not apply."""
    if slot.decimals:
        rounded_questions = ", ".join(name for name, _ in slot.decimals)
        request.report(f"{slot.name}: the package does not accept rounded decimals ({rounded_questions})")
    questions = [name for name, credit in slot.credit if credit.rule not in ("", "whole")]
    if questions:
        request.report(f"{slot.name}: the package uses the default partial credit for {', '.join(questions)}")


def _render_page(request: ExportRequest, version: str, assets: Assets) -> str:
    title = request.assignment.title
    page_data = json.dumps({"scorm": version, **_describe_assignment(request)}, ensure_ascii=False)
    return render(
        "exports/scorm/index.html.j2", title=title, set=page_data, frames=False, script=assets.scripts["package"],
        modules=assets.modules["package"], styles=assets.styles["package"],
    )  # fmt: skip


def _describe_assignment(request: ExportRequest) -> Json:
    """Return the data of an assignment for its page: its slots, with points and partial credit."""
    assignment = request.assignment
    return {
        "key": assignment.key, "title": assignment.title, "tries": request.attempt_count,
        "pass": None if request.passing_share is None else float(request.passing_share),
        "places": [{"name": slot.name, "questions": _list_questions(slot)} for slot in assignment.slots],
    }  # fmt: skip


def _list_questions(slot: Slot) -> list[list[str | float]]:
    """Return the questions of a slot: name, points, and the factor for partial credit."""
    credit = {name: 0.0 if rule.rule == "whole" else float(rule.factor) for name, rule in slot.credit}
    return [[name, points, credit.get(name, 1.0)] for name, points in slot.points_by_question.items()]


def _make_bank_files(request: ExportRequest) -> _Files:
    """Map the path of each file of the bank to its content, with solutions if students may see them."""
    assignment = request.assignment
    level = FEEDBACK_LEVELS[-1] if request.has_solutions else assignment.feedback
    bank_problems = list_problems_of_variants(list(iterate_bank(replace(request, on_step=lambda: None))))
    titles = [(slot.name, slot.family.title, slot.family.source) for slot in assignment.slots]
    with tempfile.TemporaryDirectory() as folder:
        failures: list[FailedSlot] = []
        entries = bank.write_bank(
            Path(folder), bank_problems, request.find_failures, request.jobs, request.on_step, failures.append,
            level == FEEDBACK_LEVELS[-1],
        )  # fmt: skip
        if failures:
            raise QdotError(f"{failures[0]}. Nothing is exported")  # each problem passed before, so this is a bug
        # the steps of variants that could not be generated, so that the progress is complete
        for _ in range(len(assignment.slots) * request.variant_count - len(bank_problems)):
            request.on_step()
        paths = sorted(Path(folder).rglob("*.json"))
        files: _Files = {
            path.relative_to(folder).as_posix(): _compact_record(json.loads(path.read_bytes()), assignment.hints)
            for path in paths
        }
    questions = find_custom_questions(bank_problems)
    files[f"{bank.BANK_FOLDER}/index.json"] = bank.make_index_json(entries, titles, level, questions)
    return files | {
        f"{bank.BANK_FOLDER}/index.{code}.json": bank.make_titles_json(code, titles, questions) for code in LANGUAGES
    }


def _compact_record(record: Json, has_hints: bool) -> str:
    """Return the JSON text of a record of the bank for students, with hints only if `has_hints`."""
    fields = {name: value for name, value in record.items() if name not in _BUILD_ONLY_FIELDS}
    if not has_hints and "hints" in fields:
        fields["hints"] = []
    return bank.write_compact_json(fields)
