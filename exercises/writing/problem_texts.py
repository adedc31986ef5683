"""Write the texts of a problem: its statement, prompts, hints and worked solutions, as Markdown with LaTeX.

Every text is available in each of the `languages`.
"""

import re
from dataclasses import replace
from functools import lru_cache
from typing import Any

from qdot.exercises.answer_types import LETTERS
from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.derivation import derive
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.short_questions import ALL_QUESTIONS
from qdot.exercises.short_questions.options import ConfigurationOptions, Options
from qdot.exercises.writing.languages import ENGLISH, catalogue
from qdot.exercises.writing.latex import tex_angle
from qdot.exercises.writing.render import environment
from qdot.exercises.writing.solution_steps import SolutionSteps
from qdot.exercises.writing.wording import Wording


def statement(
    problem: Problem, title: str, figure: str = "", explains_typing: bool = True, language: str = ENGLISH
) -> str:
    """Return the given data: arm, DH table, base, point P, task, symbols. `figure` is Markdown that shows the arm.

    If no answer is a formula, `explains_typing` can be false: then the text doesn't explain how to type symbols.
    """
    chain, messages = problem.chain, catalogue(language)
    names = {"chain": chain, "title": title, "figure": figure, "typed": explains_typing}
    template = environment(language).get_template("writing/statement.md.j2")
    text = template.render(names, w=Wording(chain, messages), arm=messages.arm_in_sentence(chain.title))
    return messages.localize_formulas(_clean_whitespace(text))


def prompt(problem: Problem, part: Part, language: str = ENGLISH) -> str:
    """Return the question with its frame, its units and the form of the answer, without revealing the answer."""
    messages = catalogue(language)
    text = str(_question_macros(part, language).prompt(part, problem.chain, Wording(problem.chain, messages)))
    if part.rounding is not None and part.answer.is_exact:
        how = messages.translate_phrase(part.rounding.words)
        text += "\n\n" + messages.gettext("Decimals are accepted %(how)s.", how=how)
    return messages.localize_formulas(_clean_whitespace(text))


def option_text(problem: Problem, part: Part, index: int, language: str = ENGLISH) -> str:
    """Return the text of an option in Markdown on one line: a formula, a set, a configuration, or words."""
    details, chain, messages = part.details, problem.chain, catalogue(language)
    macros: Any = environment(language)
    if isinstance(details, Options):
        text = str(macros.get_template("questions/options.md.j2").module.formula(details.offered[index], chain))
        return messages.localize_formulas(text)
    if isinstance(details, ConfigurationOptions):
        option = macros.get_template("questions/rank.md.j2").module.option
        return messages.localize_formulas(str(option(details, details.offered_configurations[index], chain)))
    option_line = re.search(rf"^- \*\*{LETTERS[index]}\.\*\* (.*)$", prompt(problem, part, language), re.MULTILINE)
    return option_line[1] if option_line is not None else messages.translate_phrase(part.answer.offered_options[index])


def hints(problem: Problem, part: Part, language: str = ENGLISH) -> tuple[str, str, str]:
    """Return three hints for this particular arm, from vague to detailed; none of them contains the answer."""
    chain, steps, messages = problem.chain, solution_steps(problem.chain), catalogue(language)
    text = _question_macros(part, language).hints(part, chain, derive(chain), Wording(chain, messages), steps)
    with_legends = (add_angle_legend(steps, hint, language) for hint in re.split(r"^---$", text, flags=re.MULTILINE))
    vague, plan, detailed = map(messages.localize_formulas, with_legends)
    return vague, plan, detailed


def worked_solution(problem: Problem, part: Part, language: str = ENGLISH) -> str:
    """Return the derivation of the answer as the chapter would print it: formula, steps, result, meaning.

    The text is self-contained: it begins with a legend of the names of angles, sines and cosines in it.
    """
    text = _derivation(problem, part, language)
    legend = _make_legend(solution_steps(problem.chain), text)
    return catalogue(language).localize_formulas(_add_legend(legend, text, language))


def worked_solutions(problem: Problem, language: str = ENGLISH) -> dict[str, str]:
    """Return the solutions of all parts, by part name, for a single text.

    Names are explained before their first use, and the result of an earlier part is not derived again.
    """
    explained: set[str] = set()
    parts = problem.parts
    is_several, solutions = len(parts) > 1, {}
    for number, part in enumerate(parts, 1):
        earlier_parts = replace(problem, parts=parts[:number])
        solutions[part.name] = next_solution(earlier_parts, explained, language, is_several)
    return solutions


def next_solution(
    problem: Problem, explained_names: set[str], language: str = ENGLISH, first_of_several: bool = True
) -> str:
    """Return the solution of the last part, for a text that already has the solutions of the earlier parts.

    Names are explained before their first use. `explained_names` has the names explained so far; new ones are added.
    """
    *earlier_parts, part = problem.parts
    text = _derivation(problem, part, language, frozenset(earlier.kind for earlier in earlier_parts))
    legend = [pair for pair in _make_legend(solution_steps(problem.chain), text) if pair[0] not in explained_names]
    explained_names.update(name for name, _ in legend)
    return catalogue(language).localize_formulas(_add_legend(legend, text, language, first_of_several))


def _derivation(problem: Problem, part: Part, language: str, earlier: frozenset[str] = frozenset()) -> str:
    chain = problem.chain
    wording, steps = Wording(chain, catalogue(language), earlier), solution_steps(chain)
    return str(_question_macros(part, language).solution(part, chain, derive(chain), wording, steps))


def answer_code(problem: Problem, part: Part, used_columns: int = 0) -> str:
    """Return the answer as Python code with the angles of the worked solution, after `used_columns` columns."""
    return part.answer.write_code(used_columns, solution_steps(problem.chain).angles.python_code)


def add_angle_legend(steps: SolutionSteps, text: str, language: str = ENGLISH) -> str:
    """Return a text on an arm, preceded by a legend of the names of angles in it."""
    return _add_legend(_named_angles(steps, text), text, language)


def _named_angles(steps: SolutionSteps, text: str) -> list[tuple[str, str]]:
    """Return the names of angles in a text, each with its meaning."""
    return [(str(name), tex_angle(angle)) for name, angle in steps.angles.angle_by_name.items() if str(name) in text]


def _make_legend(steps: SolutionSteps, text: str) -> list[tuple[str, str]]:
    """Return the names of angles, and the abbreviated sines and cosines, in a text, each with its meaning."""
    joints = re.findall(r"(?<![A-Za-z\\])[cs]_\{?([1-9]{1,7})\}?", text)
    single_angles = [(r"c_i", r"\cos\theta_i"), (r"s_i", r"\sin\theta_i")]
    angle_sums = [(r"c_{ij \dots}", r"\cos(\theta_i + \theta_j + \dots)")]
    has_single, has_sums = (any((len(digits) > 1) is is_sum for digits in joints) for is_sum in (False, True))
    return [*_named_angles(steps, text), *single_angles * has_single, *angle_sums * has_sums]


def _add_legend(legend: list[tuple[str, str]], text: str, language: str, is_for_several: bool = False) -> str:
    """Return a text preceded by a legend; if `is_for_several`, the legend is for the following texts, too."""
    template = environment(language).get_template("writing/solution.md.j2")
    return _clean_whitespace(template.render(solution=text, names=legend, first_of_all=is_for_several))


@lru_cache(maxsize=64)
def solution_steps(chain: Chain) -> SolutionSteps:
    """Return the solution steps of an arm; cached, because several parts show the same ones."""
    return SolutionSteps(chain)


def _question_macros(part: Part, language: str) -> Any:
    return (
        environment(language).get_template(f"questions/{ALL_QUESTIONS[part.kind].template or part.kind}.md.j2").module
    )


def _clean_whitespace(text: str) -> str:
    """Remove the trailing spaces and repeated empty lines that macros produce."""
    lines = "\n".join(line.rstrip() for line in text.strip().splitlines())
    return re.sub(r"\n{3,}", "\n\n", lines) + "\n"
