"""The pages of docs/ that are generated from the code, such as the families, the questions, and the chapter's examples.

`python -m qdot.exercises.docs` writes them all; a test fails if they are out of date.

    errata.toml         errors in the printed chapter
    sharing             how many students would share an answer, as was measured
    robots              the table of real robots, and their singular configurations
"""

import json
import re
import tomllib
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from functools import cache
from pathlib import Path
from types import MappingProxyType

from qdot.exercises.arm.chain import CONVENTIONS, Chain
from qdot.exercises.common.files import write_atomically
from qdot.exercises.common.stream import Stream
from qdot.exercises.common.variation import DEFAULT, STEPS
from qdot.exercises.docs.robots import robots_page
from qdot.exercises.docs.sharing import GROUPS, load_measured
from qdot.exercises.families import FAMILIES
from qdot.exercises.families.listing import LISTING, FamilyListing
from qdot.exercises.figure import figure_svg, singular_svg, thumbnail_svg
from qdot.exercises.generation import find_out, sample_chain
from qdot.exercises.mistakes.catalogue import SECTIONS
from qdot.exercises.problem.problem import Part, Problem, ProblemId
from qdot.exercises.questions import QUESTIONS
from qdot.exercises.quizzes import QUIZZES
from qdot.exercises.writing.languages import ENGLISH, catalogue
from qdot.exercises.writing.render import render
from qdot.exercises.writing.statement import worked_solution
from qdot.exercises.writing.wording import Wording

ERRATA = Path(__file__).with_name("errata.toml")


@cache
def documents() -> Mapping[str, str]:
    """Return every generated file of docs/: path inside the folder -> text."""
    plain, scorbot = planar_2r(), scorbot_arm()
    drawings = {
        "examples/planar-2r.svg": figure_svg(plain, "planar-2r"),
        "examples/planar-2r-singular.svg": singular_svg(plain, "planar-2r-singular"),
        "examples/scorbot.svg": figure_svg(scorbot, "scorbot"),
        "examples/scorbot-singular.svg": singular_svg(scorbot, "scorbot-singular"),
    }
    shown = [(name, DEFAULT) for name in FAMILIES] + [(SHOWN, step) for step in STEPS]
    for name, step in shown:
        arm = sample_chain(ProblemId(name, 0, variation=step))
        drawings[thumbnail_path(name, step)] = thumbnail_svg(arm, name)
    made = {
        "families.md": families_page(),
        "questions.md": questions_page(),
        "examples.md": examples_page(),
        "mistakes.md": mistakes_page(),
        "variation.md": variation_page(),
        "robots.md": robots_page(),
        **drawings,
    }
    return MappingProxyType(made)


def write(folder: Path) -> list[Path]:
    """Write the generated files into a docs folder, and return their paths. Raises QdotError."""
    texts = documents()
    write_atomically(LISTING, listing_text())
    for name, text in texts.items():
        write_atomically(folder / name, text)
    return [folder / name for name in texts]


# --- families ---


def families_page() -> str:
    """Return docs/families.md."""
    return render(
        "docs/families.md.j2",
        families=FAMILIES,
        listed=list_families(),
        tasks={name: Wording(_first_arm(name)).task for name in FAMILIES},
        questions=list(QUESTIONS),
    )


def questions_page() -> str:
    """Return docs/questions.md."""
    asked: dict[str, int | str] = {
        name: sum(name in listed.questions for listed in list_families().values()) for name in QUESTIONS
    }
    for question in QUESTIONS.values():
        if CONVENTIONS[0] not in question.conventions:
            asked[question.name] = ", ".join(f"`{convention}`" for convention in question.conventions)
    return render(
        "docs/questions.md.j2",
        questions=QUESTIONS.values(),
        quizzes=QUIZZES.values(),
        asked=asked,
        families=len(FAMILIES),
    )


SHOWN = "planar-2r"
"""The family whose arm docs/variation.md shows at each step."""

AXES_IN_WORDS = {
    "lengths": "numbers for some lengths of the table, each in steps of 5 cm",
    "zeros": "joints that are zero elsewhere: angles that one knows the sine of, slides by centimetres",
    "senses": "axes that turn the other way: twists of 90° or −90°, 0 or 180°",
    "base": "where the base stands, and how it is turned: on the floor, on a wall, under the ceiling",
    "tool": "where the point of interest is: in the last frame's origin, or beside or beyond it",
    "task": "which rows are asked: the plane in which an arm stands",
}
"""What each axis of variation changes."""


def variation_page() -> str:
    """Return docs/variation.md, of what was measured (`sharing.json`) and listed."""
    measured = load_measured()
    asked = {name for steps in measured["asked"]["families"].values() for counts in steps.values() for name in counts}
    return render(
        "docs/variation.md.j2",
        axes=AXES_IN_WORDS,
        steps=STEPS,
        default=DEFAULT,
        shown=SHOWN,
        tables=[(step, Wording(sample_chain(ProblemId(SHOWN, 0, variation=step)))) for step in STEPS],
        thumbnails={step: thumbnail_path(SHOWN, step) for step in STEPS},
        groups=GROUPS,
        sharing=measured["formulas"],
        varied=[name for name, family in FAMILIES.items() if family.varied],
        asked=measured["asked"] | {"questions": [name for name in QUESTIONS if name in asked]},
        difficulty={name: listed.by_variation for name, listed in list_families().items() if listed.by_variation},
        has={name: FAMILIES[name].has_axes for name in FAMILIES},
    )


def mistakes_page() -> str:
    """Return docs/mistakes.md."""
    sections = [
        {
            "title": title,
            "mistakes": [
                {"name": m.name, "title": m.title, "said": re.sub(r"{\w+}", "\\*", m.says), "source": m.source}
                for m in module.MISTAKES
            ],
        }
        for title, module in SECTIONS.items()
    ]
    return render("docs/mistakes.md.j2", sections=sections)


def _first_arm(family: str) -> Chain:
    return sample_chain(ProblemId(family, 0))


def thumbnail_path(family: str, step: str = DEFAULT) -> str:
    """Return the path of the drawing of a family's first arm at a step of variation."""
    return f"families/{family}.svg" if step == DEFAULT else f"families/{family}-{step}.svg"


@cache
def list_families() -> dict[str, FamilyListing]:
    """Return what is to be listed of each family, found out from its arms."""
    return {name: find_out(family) for name, family in FAMILIES.items()}


def listing_text() -> str:
    """Return the file that `families.listing` reads."""
    return json.dumps({name: asdict(listed) for name, listed in list_families().items()}, indent=1) + "\n"


# --- the chapter's examples ---


def planar_2r() -> Chain:
    """Return the arm of Examples 6.1, 6.2 and 6.4."""
    return sample_chain(ProblemId("planar-2r", 0, variation="chapter"))


def scorbot_arm() -> Chain:
    """Return the arm of Example 6.3: a Scorbot down to the wrist point P."""
    return replace(sample_chain(ProblemId("elbow-3r", 0, variation="chapter")), title="Scorbot, wrist point P")


@dataclass(frozen=True)
class Example:
    """One example of the chapter: its arm, its drawings (docs/examples/KEY.svg) and its steps with titles.

    `drawn` says whether the arm is shown, `singular` whether its singular configurations are.
    """

    number: str
    title: str
    key: str
    arm: Chain
    steps: tuple[tuple[str, str], ...]
    drawn: bool
    singular: bool

    @property
    def rows(self) -> list[list[str]]:
        """The DH table as LaTeX."""
        return Wording(self.arm).rows

    @property
    def task(self) -> list[str]:
        """The rows that count as LaTeX."""
        return Wording(self.arm).task


def gettext(message: str) -> str:
    """Mark a text as a message; it is translated where it is shown."""
    return message


EXAMPLES = (
    ("6.1", gettext("the planar 2R arm by direct differentiation"), "planar-2r", ("position", "velocity", "jacobian")),
    (
        "6.2",
        gettext("inverse velocity and singularities of the same arm"),
        "planar-2r",
        ("determinant", "inverse-jacobian", "inverse-velocity", "singular-angles"),
    ),
    (
        "6.3",
        gettext("the arm of a Scorbot, down to its wrist point"),
        "scorbot",
        ("position", "jacobian", "determinant", "singular-angles"),
    ),
    (
        "6.4",
        gettext("the planar 2R arm by velocity propagation"),
        "planar-2r",
        ("joint-axes", "position-vectors", "geometric-jacobian", "twist"),
    ),
)
"""Number, title, arm, and the questions that make up each example."""


@cache
def examples(language: str = ENGLISH) -> tuple[Example, ...]:
    """Return the chapter's examples, solved."""
    words = catalogue(language)
    arms = {"planar-2r": planar_2r(), "scorbot": scorbot_arm()}
    worked_out: list[Example] = []
    for number, title, key, questions in EXAMPLES:
        steps = tuple((words.question(QUESTIONS[name].title), _solve(arms[key], name, language)) for name in questions)
        drawn = all(before.key != key for before in worked_out)
        worked_out.append(
            Example(number, words.gettext(title), key, arms[key], steps, drawn, "singular-angles" in questions)
        )
    return tuple(worked_out)


@dataclass(frozen=True)
class Erratum:
    """A correction of the chapter: its place, what is printed, what is right, why it matters, and numbers that show it.

    `kind` is "wrong", "incomplete" or "lost in the layout". `at` is the configuration that `values` are for; `values`
    are pairs of words and a number.
    """

    where: str
    kind: str
    printed: str
    right: str
    why: str
    at: str
    values: tuple[tuple[str, str], ...]


@cache
def corrections(language: str = ENGLISH) -> tuple[Erratum, ...]:
    """Return what is wrong in the chapter as printed, from errata.toml."""
    words = catalogue(language)

    def translate(text: str) -> str:
        return words.with_decimals(words.pgettext("erratum", text))

    return tuple(
        Erratum(
            **{name: translate(text) for name, text in entry.items() if name != "values"},
            values=tuple((translate(what), words.with_decimal(translate(value))) for what, value in entry["values"]),
        )
        for entry in tomllib.loads(ERRATA.read_text(encoding="utf-8"))["erratum"]
    )


def examples_page() -> str:
    """Return docs/examples.md."""
    return render("docs/examples.md.j2", examples=examples(), errata=corrections())


@cache
def _solve(chain: Chain, name: str, language: str) -> str:
    answer, details = QUESTIONS[name].ask(chain, Stream("docs"))
    part = Part(name, name, answer, details=details)
    return worked_solution(Problem(ProblemId(chain.name, 0), _with_family_title(chain), (part,)), part, language)


def _with_family_title(chain: Chain) -> Chain:
    """Return an arm with the title that its family gives to it."""
    plain = FAMILIES[chain.name].plain
    return chain if plain is None else replace(chain, title=plain.title)
