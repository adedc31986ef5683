"""The pages of docs/ that are generated from the code, such as the families, the questions, and the chapter's errata.

`python -m tests.tools.docs_pages` writes them all (`make docs`); a test fails if they are out of date.
"""

import ast
import inspect
import json
import re
from collections.abc import Mapping
from dataclasses import asdict
from functools import cache
from itertools import pairwise
from pathlib import Path
from types import MappingProxyType

import pydantic
from pydantic.fields import FieldInfo

from qdot.exercises.arm.chain import DEFAULT_CONVENTION, Chain
from qdot.exercises.assignment.assignment import AssignmentFile, ProblemEntry
from qdot.exercises.assignment.expected_forms import ATTEMPT_FORMS, EXPECTED_FORMS, LATE_FORMS, PAPER_FORMS
from qdot.exercises.chapter import read_errata
from qdot.exercises.common.console import print_result
from qdot.exercises.common.files import write_atomically
from qdot.exercises.common.variation import DEFAULT_VARIATION, VARIATION_STEPS
from qdot.exercises.families import FAMILIES
from qdot.exercises.families.listing import LISTING_FILE, FamilyListing
from qdot.exercises.families.structures import group_clean_structures, read_clean_structures
from qdot.exercises.figure.arm_figure import draw_thumbnail_svg
from qdot.exercises.generation import compute_listing, sample_chain
from qdot.exercises.mistakes.catalogue import SECTIONS
from qdot.exercises.problem.problem import ProblemId
from qdot.exercises.questions import QUESTIONS
from qdot.exercises.questions.custom.reader import FORMS as QUESTION_FORMS
from qdot.exercises.questions.custom.reader import OptionEntry, QuestionEntry, TextsEntry
from qdot.exercises.robots.library import list_robots
from qdot.exercises.short_questions import SHORT_QUESTIONS
from qdot.exercises.writing.render import render
from qdot.exercises.writing.wording import Wording
from tests.support import ROOT


def describe_fields(model: type[pydantic.BaseModel]) -> None:
    """Make the docstring below each field its description, because pydantic does so only at the cost of speed."""
    (definition,) = ast.parse(inspect.getsource(model)).body
    assert isinstance(definition, ast.ClassDef)
    for field, text in pairwise(definition.body):
        if isinstance(field, ast.AnnAssign) and isinstance(text, ast.Expr) and isinstance(text.value, ast.Constant):
            assert isinstance(field.target, ast.Name) and isinstance(text.value.value, str)
            model.model_fields[field.target.id].description = inspect.cleandoc(text.value.value)
    model.model_rebuild(force=True)


for described in (OptionEntry, TextsEntry, QuestionEntry, ProblemEntry, AssignmentFile):
    describe_fields(described)


@cache
def make_documents() -> Mapping[str, str]:
    """Return every generated file of docs/: path inside the folder -> text."""
    drawn_arms = [(name, DEFAULT_VARIATION) for name in FAMILIES] + [(SAMPLE_FAMILY, step) for step in VARIATION_STEPS]
    drawings = {
        find_thumbnail_path(name, step): draw_thumbnail_svg(sample_chain(ProblemId(name, 0, variation=step)), name)
        for name, step in drawn_arms
    }
    pages = {
        "families.md": make_families_page(),
        "questions.md": make_questions_page(),
        "errata.md": render("docs/errata.md.j2", errata=read_errata()),
        "assignment.md": make_assignment_page(),
        "schemas/assignment.json": make_assignment_schema(),
        "mistakes.md": make_mistakes_page(),
        "variation.md": make_variation_page(),
        "robots.md": make_robots_page(),
        **drawings,
    }
    return MappingProxyType(pages)


def write_documents(folder: Path) -> list[Path]:
    texts = make_documents()
    write_atomically(LISTING_FILE, make_listing_text())
    for name, text in texts.items():
        write_atomically(folder / name, text)
    return [folder / name for name in texts]


# --- families ---


def make_families_page() -> str:
    return render(
        "docs/families.md.j2",
        families=FAMILIES,
        listed=list_families(),
        tasks={name: Wording(_generate_first_arm(name)).task for name in FAMILIES},
        classes={n: len(group_clean_structures(n)) for n in read_clean_structures()},
    )


def make_questions_page() -> str:
    families: dict[str, int | str] = {
        name: sum(name in family.questions for family in list_families().values()) for name in QUESTIONS
    }
    for question in QUESTIONS.values():
        if DEFAULT_CONVENTION not in question.conventions:
            families[question.name] = ", ".join(f"`{convention}`" for convention in question.conventions)
    return render(
        "docs/questions.md.j2",
        questions=QUESTIONS.values(),
        quizzes=SHORT_QUESTIONS.values(),
        asked=families,
        families=len(FAMILIES),
    )


SAMPLE_FAMILY = "planar-2r"
"""The family whose arm docs/variation.md shows at each step."""

AXES_IN_WORDS = {
    "lengths": "some lengths in the table become numbers, in steps of 5 cm",
    "zeros": "joint offsets: angles with well-known sines, such as 30°, and distances in centimetres",
    "senses": "directions of axes: a twist angle of 90° may become −90°, and 0° may become 180°",
    "base": "position and orientation of the base: on the floor, on a wall, under the ceiling",
    "tool": "point of interest: at, beside or beyond the origin of the last frame",
    "task": "the plane in which an arm stands, and so the rows of its task",
}
"""What each axis of variation changes, in words."""


def make_variation_page() -> str:
    return render(
        "docs/variation.md.j2",
        axes=AXES_IN_WORDS,
        steps=VARIATION_STEPS,
        default=DEFAULT_VARIATION,
        shown=SAMPLE_FAMILY,
        thumbnails={step: find_thumbnail_path(SAMPLE_FAMILY, step) for step in VARIATION_STEPS},
    )


def make_mistakes_page() -> str:
    return render("docs/mistakes.md.j2", sections=SECTIONS)


def _generate_first_arm(family: str) -> Chain:
    return sample_chain(ProblemId(family, 0))


def find_thumbnail_path(family: str, step: str = DEFAULT_VARIATION) -> str:
    return f"families/{family}.svg" if step == DEFAULT_VARIATION else f"families/{family}-{step}.svg"


@cache
def list_families() -> dict[str, FamilyListing]:
    """Return the listing of each family, as derived from its arms."""
    return {name: compute_listing(family) for name, family in FAMILIES.items()}


def make_listing_text() -> str:
    """Return the file that `families.listing` reads."""
    return json.dumps({name: asdict(listing) for name, listing in list_families().items()}, indent=1) + "\n"


# --- assignment.toml ---


def make_assignment_page() -> str:
    all_problems = "For the whole assignment"
    inner_forms = {"late": LATE_FORMS, "attempts": ATTEMPT_FORMS, "paper": PAPER_FORMS}
    inner_tables = {
        table: {name: _describe_value_form(message) for name, message in messages.items()}
        for table, messages in inner_forms.items()
    }
    sections = {
        all_problems: _describe_keys(AssignmentFile, EXPECTED_FORMS),
        "For each problem": _describe_keys(ProblemEntry, EXPECTED_FORMS),
        "For each question of your own": _describe_keys(QuestionEntry, QUESTION_FORMS),
    }
    return render("docs/assignment.md.j2", sections=sections, inner_tables={all_problems: inner_tables})


def make_assignment_schema() -> str:
    """Return docs/schemas/assignment.json, with which editors complete and check assignment.toml."""
    schema = AssignmentFile.model_json_schema()
    question = QuestionEntry.model_json_schema()
    schema["$defs"] |= question.pop("$defs", {}) | {"QuestionEntry": question}
    reference = {"$ref": "#/$defs/QuestionEntry"}
    schema["properties"]["question"] |= {"additionalProperties": reference}
    header = {"$schema": "https://json-schema.org/draft/2020-12/schema", "$id": "urn:qdot:schema:assignment:1"}
    title = "assignment.toml, for editors that complete and check it"
    return json.dumps({**header, "version": 1, **schema, "title": title}, indent=1, ensure_ascii=False) + "\n"


def _describe_keys(model: type[pydantic.BaseModel], forms: Mapping[str, str]) -> list[dict[str, str]]:
    return [
        {
            "name": name,
            "description": " ".join((field.description or "").split()),
            "form": _describe_value_form(forms[name]),
            "default": _describe_default(field),
        }
        for name, field in model.model_fields.items()
    ]


def _describe_default(field: FieldInfo) -> str:
    if field.is_required():
        return "required"
    return "" if field.default is None else f"`{json.dumps(field.default)}`"


def _describe_value_form(message: str) -> str:
    """Return the form of a value for a cell of a table, from the message about a wrong value; examples become code."""
    text = message.removeprefix("expected ").replace("|", "\\|")
    return re.sub(r"\w+ = (?:\{.*?\}|\[.*?\]|\"[^\"]*\"|[^;,) ]+)|\[\{.*?\}\]|\[\".*?\]", r"`\g<0>`", text)


# --- real robots ---

PAGE = ROOT / "docs" / "robots.md"
SECTION, NEXT = "## Real robots\n", "\n## "


def make_robots_page() -> str:
    """Return docs/robots.md with an up-to-date section on real robots."""
    text = PAGE.read_text(encoding="utf-8")
    text_before, heading, section_and_rest = text.partition(SECTION)
    assert heading, f"docs/robots.md has no section {SECTION.strip()!r}"
    _, next_heading, text_after = section_and_rest.partition(NEXT)
    section = render("docs/robots.md.j2", robots=list_robots().values())
    return f"{text_before}{SECTION}{section.rstrip()}\n{next_heading}{text_after}"


if __name__ == "__main__":
    for path in write_documents(ROOT / "docs"):
        print_result(f"wrote {path.name}")
