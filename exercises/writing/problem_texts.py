"""A problem in words: its statement, the prompt of each part, and worked solutions, as Markdown with LaTeX.

All of it can be had in each of the `languages`.
"""

import re
from dataclasses import replace
from functools import lru_cache
from typing import Any

from qdot.exercises.answers import LETTERS
from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.derivation import derive
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.quizzes import ASKED
from qdot.exercises.quizzes.options import Options, Places
from qdot.exercises.writing.languages import ENGLISH, catalogue
from qdot.exercises.writing.latex import tex_angle
from qdot.exercises.writing.render import environment
from qdot.exercises.writing.solution_steps import SolutionSteps
from qdot.exercises.writing.wording import Wording


def statement(problem: Problem, title: str, figure: str = "", typed: bool = True, language: str = ENGLISH) -> str:
    """Return what is given: arm, DH table, base, point P, task, symbols. `figure` is Markdown that shows the arm.

    Where answers are no formulas, it need not say how symbols are `typed`.
    """
    chain, words = problem.chain, catalogue(language)
    text = (
        environment(language)
        .get_template("writing/statement.md.j2")
        .render(
            chain=chain,
            title=title,
            figure=figure,
            w=Wording(chain, words),
            arm=words.arm_shown(chain.title),
            typed=typed,
        )
    )
    return words.with_decimals(_tidy(text))


def prompt(problem: Problem, part: Part, language: str = ENGLISH) -> str:
    """Return what is asked, in which frame and units, and the form of the answer; nothing of the answer itself."""
    words = catalogue(language)
    text = str(_macros(part, language).prompt(part, problem.chain, Wording(problem.chain, words)))
    if part.rounding is not None and part.answer.is_exact:
        accepted = words.gettext("Decimals are accepted %(how)s.", how=words.phrase(part.rounding.words))
        text += f"\n\n{accepted}"
    return words.with_decimals(_tidy(text))


def option_text(problem: Problem, part: Part, index: int, language: str = ENGLISH) -> str:
    """Return what an option shows, in Markdown on one line: a formula, a set, a configuration, or its words."""
    details, chain, words = part.details, problem.chain, catalogue(language)
    macros: Any = environment(language)
    if isinstance(details, Options):
        text = str(macros.get_template("questions/options.md.j2").module.formula(details.offered[index], chain))
        return words.with_decimals(text)
    if isinstance(details, Places):
        option = macros.get_template("questions/rank.md.j2").module.option
        return words.with_decimals(str(option(details, details.places[index], chain)))
    line = re.search(rf"^- \*\*{LETTERS[index]}\.\*\* (.*)$", prompt(problem, part, language), re.MULTILINE)
    return line[1] if line is not None else words.phrase(part.answer.offered[index])


def hints(problem: Problem, part: Part, language: str = ENGLISH) -> tuple[str, str, str]:
    """Return three hints for this very arm, from gentle to nearly there; none of them holds the answer."""
    chain, steps, words = problem.chain, solution_steps(problem.chain), catalogue(language)
    text = _macros(part, language).hints(part, chain, derive(chain), Wording(chain, words), steps)
    gentle, plan, nearly = (
        words.with_decimals(with_meanings(steps, hint, language))
        for hint in re.split(r"^---$", text, flags=re.MULTILINE)
    )
    return gentle, plan, nearly


def worked_solution(problem: Problem, part: Part, language: str = ENGLISH) -> str:
    """Return the way to the answer as the chapter would print it: formula, steps, result, what it means.

    It is for a part by itself, and begins with what names of angles, sines and cosines in it stand for.
    """
    text = _derivation(problem, part, language)
    return catalogue(language).with_decimals(_with_legend(_legend(solution_steps(problem.chain), text), text, language))


def worked_solutions(problem: Problem, language: str = ENGLISH) -> dict[str, str]:
    """Return the solutions of all parts by their names, for one text.

    Names are explained before their first use, and the result of an earlier part is not derived again.
    """
    explained: set[str] = set()
    parts = problem.parts
    return {
        part.name: next_solution(replace(problem, parts=parts[: number + 1]), explained, language, len(parts) > 1)
        for number, part in enumerate(parts)
    }


def next_solution(problem: Problem, explained: set[str], language: str = ENGLISH, first_of_several: bool = True) -> str:
    """Return the solution of the last part, for a text that has those of the parts before it.

    Names are explained before their first use; `explained`, which grows, has those that were explained already.
    """
    *before, part = problem.parts
    text = _derivation(problem, part, language, frozenset(earlier.kind for earlier in before))
    legend = [(name, angle) for name, angle in _legend(solution_steps(problem.chain), text) if name not in explained]
    explained.update(name for name, _ in legend)
    return catalogue(language).with_decimals(_with_legend(legend, text, language, first_of_several))


def _derivation(problem: Problem, part: Part, language: str, earlier: frozenset[str] = frozenset()) -> str:
    chain = problem.chain
    words, steps = Wording(chain, catalogue(language), earlier), solution_steps(chain)
    return str(_macros(part, language).solution(part, chain, derive(chain), words, steps))


def answer_code(problem: Problem, part: Part, taken: int = 0) -> str:
    """Return the answer as Python code with the angles of the worked solution; `taken` columns are used already."""
    return part.answer.code(taken, solution_steps(problem.chain).angles.to_python)


def with_meanings(steps: SolutionSteps, text: str, language: str = ENGLISH) -> str:
    """Return text on an arm after what the names of angles in it stand for."""
    return _with_legend(_named_angles(steps, text), text, language)


def _named_angles(steps: SolutionSteps, text: str) -> list[tuple[str, str]]:
    """Return the names of angles in a text, each with what it stands for."""
    return [(str(name), tex_angle(angle)) for name, angle in steps.angles.meanings.items() if str(name) in text]


def _legend(steps: SolutionSteps, text: str) -> list[tuple[str, str]]:
    """Return what the names of angles in a text stand for, and its short sines and cosines."""
    joints = re.findall(r"(?<![A-Za-z\\])[cs]_\{?([1-9]{1,7})\}?", text)
    single = [(r"c_i", r"\cos\theta_i"), (r"s_i", r"\sin\theta_i")]
    sums = [(r"c_{ij \dots}", r"\cos(\theta_i + \theta_j + \dots)")]
    has_single, has_sums = (any((len(digits) > 1) is is_sum for digits in joints) for is_sum in (False, True))
    return [*_named_angles(steps, text), *single * has_single, *sums * has_sums]


def _with_legend(names: list[tuple[str, str]], text: str, language: str, first_of_several: bool = False) -> str:
    """Return text after what names in it stand for, or in all that follows if it is the `first_of_several`."""
    template = environment(language).get_template("writing/solution.md.j2")
    return _tidy(template.render(solution=text, names=names, first_of_all=first_of_several))


@lru_cache(maxsize=64)
def solution_steps(chain: Chain) -> SolutionSteps:
    """Return the steps of an arm, kept because several parts show the same ones."""
    return SolutionSteps(chain)


def _macros(part: Part, language: str) -> Any:
    return environment(language).get_template(f"questions/{ASKED[part.kind].template or part.kind}.md.j2").module


def _tidy(text: str) -> str:
    """Return text without spaces at line ends and without runs of empty lines, which macros leave behind."""
    lines = "\n".join(line.rstrip() for line in text.strip().splitlines())
    return re.sub(r"\n{3,}", "\n\n", lines) + "\n"
