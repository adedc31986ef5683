"""A problem in words: its statement, the prompt of each part, and worked solutions, as Markdown with LaTeX.

All of it can be had in each of `languages`.
"""

import re
from functools import lru_cache
from typing import Any

from exercises.answers import LETTERS
from exercises.arm.chain import Chain
from exercises.arm.derivation import derive
from exercises.languages import ENGLISH
from exercises.problem import Part, Problem
from exercises.quizzes import ASKED
from exercises.quizzes.options import Options, Places
from exercises.render import catalogue, environment
from exercises.writing.latex import tex
from exercises.writing.wording import Wording
from exercises.writing.worked import Worked


def statement(problem: Problem, title: str, figure: str = "", typed: bool = True, language: str = ENGLISH) -> str:
    """Return what is given: arm, DH table, base, point P, task, symbols. `figure` is Markdown that shows the arm.

    Where answers are no formulas, it need not say how symbols are `typed`.
    """
    chain = problem.chain
    arm = chain.title or "arm"
    article = "an" if re.match(r"[aeiou]|R[RP]+ ", arm) else "a"
    text = (
        environment(language)
        .get_template("statement.md.j2")
        .render(
            chain=chain,
            title=title,
            figure=figure,
            w=Wording(chain),
            arm=arm if language == ENGLISH else catalogue(language).arm_shown(chain.title),
            article=article,
            typed=typed,
        )
    )
    return _put(_tidy(text), language)


def prompt(problem: Problem, part: Part, language: str = ENGLISH) -> str:
    """Return what is asked, in which frame and units, and the form of the answer; nothing of the answer itself."""
    text = str(_macros(part, language).prompt(part, problem.chain, Wording(problem.chain)))
    if part.rounding is not None and part.answer.is_exact:
        text += f"\n\n{_phrase(f'Decimals are accepted {part.rounding.words}.', language)}"
    return _put(_tidy(text), language)


def option_text(problem: Problem, part: Part, index: int, language: str = ENGLISH) -> str:
    """Return what an option shows, in Markdown on one line: a formula, a set, a configuration, or its words."""
    details, chain = part.details, problem.chain
    macros: Any = environment(language)
    if isinstance(details, Options):
        text = str(macros.get_template("questions/options.md.j2").module.formula(details.offered[index], chain))
        return _put(text, language)
    if isinstance(details, Places):
        text = str(macros.get_template("questions/rank.md.j2").module.at(details.places[index], chain, Wording(chain)))
        return _put(text, language)
    line = re.search(rf"^- \*\*{LETTERS[index]}\.\*\* (.*)$", prompt(problem, part, language), re.MULTILINE)
    return line[1] if line is not None else _phrase(part.answer.offered[index], language)


def hints(problem: Problem, part: Part, language: str = ENGLISH) -> tuple[str, str, str]:
    """Return three hints for this very arm, from gentle to nearly there; none of them holds the answer."""
    chain, steps = problem.chain, worked_steps(problem.chain)
    text = _macros(part, language).hints(part, chain, derive(chain), Wording(chain), steps)
    told = (with_meanings(steps, hint, language) for hint in re.split(r"^---$", text, flags=re.MULTILINE))
    gentle, plan, nearly = (_put(hint, language) for hint in told)
    return gentle, plan, nearly


def worked_solution(problem: Problem, part: Part, language: str = ENGLISH) -> str:
    """Return the way to the answer as the chapter would print it: formula, steps, result, what it means."""
    chain, steps = problem.chain, worked_steps(problem.chain)
    text = _macros(part, language).solution(part, chain, derive(chain), Wording(chain), steps)
    return _put(with_meanings(steps, text, language), language)


def with_meanings(steps: Worked, text: str, language: str = ENGLISH) -> str:
    """Return text on an arm after what the names of angles in it stand for."""
    used = [(name, tex(angle)) for name, angle in steps.angles.meanings.items() if str(name) in text]
    return _tidy(environment(language).get_template("solution.md.j2").render(angles=used, solution=text))


@lru_cache(maxsize=256)
def worked_steps(chain: Chain) -> Worked:
    """Return the steps of an arm, kept because several parts show the same ones."""
    return Worked(chain)


def _phrase(english: str, language: str) -> str:
    return english if language == ENGLISH else catalogue(language).phrase(english)


def _put(text: str, language: str) -> str:
    """Return text with the numbers of its formulas as the language writes them."""
    return text if language == ENGLISH else catalogue(language).with_decimals(text)


def _macros(part: Part, language: str) -> Any:
    return environment(language).get_template(f"questions/{ASKED[part.kind].template or part.kind}.md.j2").module


def _tidy(text: str) -> str:
    """Return text without spaces at line ends and without runs of empty lines, which macros leave behind."""
    lines = "\n".join(line.rstrip() for line in text.strip().splitlines())
    return re.sub(r"\n{3,}", "\n\n", lines) + "\n"
