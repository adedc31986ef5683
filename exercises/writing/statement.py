"""A problem in words: its statement, the prompt of each part, and worked solutions, as Markdown with LaTeX."""

import re
from functools import lru_cache
from typing import Any

from exercises.arm.chain import Chain
from exercises.arm.derivation import derive
from exercises.problem import (
    LETTERS,
    Choice,
    ConditionSet,
    Expression,
    Matching,
    Matrix,
    Part,
    Problem,
    Selection,
)
from exercises.quizzes import ASKED
from exercises.render import environment, render
from exercises.writing.latex import tex
from exercises.writing.wording import Wording
from exercises.writing.worked import Worked


def statement(problem: Problem, title: str, figure: str = "", typed: bool = True) -> str:
    """Return what is given: arm, DH table, base, point P, task, symbols. `figure` is Markdown that shows the arm.

    Where answers are no formulas, it need not say how symbols are `typed`.
    """
    chain = problem.chain
    arm = chain.title or "arm"
    article = "an" if re.match(r"[aeiou]|R[RP]+ ", arm) else "a"
    text = render(
        "statement.md.j2",
        chain=chain,
        title=title,
        figure=figure,
        w=Wording(chain),
        arm=arm,
        article=article,
        typed=typed,
    )
    return _tidy(text)


def prompt(problem: Problem, part: Part) -> str:
    """Return what is asked, in which frame and units, and the form of the answer; nothing of the answer itself."""
    text = str(_macros(part).prompt(part, problem.chain, Wording(problem.chain)))
    if part.rounding is not None and isinstance(part.answer, (Expression, Matrix, ConditionSet)):
        text += f"\n\nDecimals are accepted {part.rounding.words}."
    return _tidy(text)


def option_text(problem: Problem, part: Part, index: int) -> str:
    """Return what an option shows, in Markdown on one line: a formula, a set, a configuration, or its words."""
    answer, details, chain = part.answer, part.details, problem.chain
    assert isinstance(answer, (Choice, Selection, Matching))
    macros: Any = environment()
    if "offered" in details:
        offered: Any = details["offered"]
        return str(macros.get_template("questions/options.md.j2").module.formula(offered[index], chain))
    if "places" in details:
        places: Any = details["places"]
        return str(macros.get_template("questions/rank.md.j2").module.at(places[index], chain, Wording(chain)))
    line = re.search(rf"^- \*\*{LETTERS[index]}\.\*\* (.*)$", prompt(problem, part), re.MULTILINE)
    return line[1] if line is not None else answer.options[index]


def hints(problem: Problem, part: Part) -> tuple[str, str, str]:
    """Return three hints for this very arm, from gentle to nearly there; none of them holds the answer."""
    chain, steps = problem.chain, worked_steps(problem.chain)
    text = _macros(part).hints(part, chain, derive(chain), Wording(chain), steps)
    gentle, plan, nearly = (with_meanings(steps, hint) for hint in re.split(r"^---$", text, flags=re.MULTILINE))
    return gentle, plan, nearly


def worked_solution(problem: Problem, part: Part) -> str:
    """Return the way to the answer as the chapter would print it: formula, steps, result, what it means."""
    chain, steps = problem.chain, worked_steps(problem.chain)
    return with_meanings(steps, _macros(part).solution(part, chain, derive(chain), Wording(chain), steps))


def with_meanings(steps: Worked, text: str) -> str:
    """Return text on an arm after what the names of angles in it stand for."""
    used = [(name, tex(angle)) for name, angle in steps.angles.meanings.items() if str(name) in text]
    return _tidy(render("solution.md.j2", angles=used, solution=text))


@lru_cache(maxsize=256)
def worked_steps(chain: Chain) -> Worked:
    """Return the steps of an arm, kept because several parts show the same ones."""
    return Worked(chain)


def _macros(part: Part) -> Any:
    return environment().get_template(f"questions/{ASKED[part.kind].template or part.kind}.md.j2").module


def _tidy(text: str) -> str:
    """Return text without spaces at line ends and without runs of empty lines, which macros leave behind."""
    lines = "\n".join(line.rstrip() for line in text.strip().splitlines())
    return re.sub(r"\n{3,}", "\n\n", lines) + "\n"
