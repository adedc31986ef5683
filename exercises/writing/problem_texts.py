"""Write the texts of a problem as Markdown with LaTeX: its statement, prompts, hints and worked solutions.

Every text is available in each language of `languages`. A legend explains the abbreviations in a text, such as s_1.
"""

import re
from dataclasses import replace
from functools import lru_cache
from typing import Any

import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.derivation.derivation import derive
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.questions.custom.question import CustomDetails
from qdot.exercises.reference_answers import LETTERS
from qdot.exercises.short_questions import question_of
from qdot.exercises.short_questions.options import ConfigurationOptions, Options
from qdot.exercises.writing.custom_texts import write_custom_options
from qdot.exercises.writing.languages import ENGLISH, load_catalogue
from qdot.exercises.writing.latex import tex, tex_angle
from qdot.exercises.writing.render import make_environment
from qdot.exercises.writing.solution_steps import SolutionSteps
from qdot.exercises.writing.wording import Wording


def write_statement(
    problem: Problem, title: str, figure: str = "", explains_typing: bool = True, language: str = ENGLISH,
    is_movable: bool = False,
) -> str:  # fmt: skip
    """Return the statement of a problem: arm, table, base, point P, task, symbols. `figure` is Markdown for the figure.

    If `explains_typing`, the statement also says how to type symbols. A movable figure is drawn to scale.
    """
    chain, messages = problem.chain, load_catalogue(language)
    names = {"chain": chain, "title": title, "figure": figure}
    names |= {"explains_typing": explains_typing, "is_movable": is_movable}
    template = make_environment(language).get_template("writing/statement.md.j2")
    text = template.render(names, w=Wording(chain, messages), arm=messages.translate_arm_in_sentence(chain.title))
    return messages.localize_formulas(_clean_whitespace(text))


def write_prompt(problem: Problem, part: Part, language: str = ENGLISH) -> str:
    """Return the question of a part: the quantity to find, the frame, the units, and the form of the answer."""
    messages = load_catalogue(language)
    text = str(_get_question_macros(part, language).prompt(part, problem.chain, Wording(problem.chain, messages)))
    if part.rounding is not None and part.answer.is_exact:
        precision = messages.translate_phrase(part.rounding.words)
        text += "\n\n" + messages.gettext("Decimals are accepted if they are correct %(how)s.", how=precision)
    return messages.localize_formulas(_clean_whitespace(text))


def write_option(problem: Problem, part: Part, index: int, language: str = ENGLISH) -> str:
    """Return the text of an option in Markdown on one line: a formula, a set, a configuration, or words."""
    details, chain, messages = part.details, problem.chain, load_catalogue(language)
    templates: Any = make_environment(language)
    if isinstance(details, Options):
        template = templates.get_template("questions/options.md.j2")
        return messages.localize_formulas(str(template.module.formula(details.offered_options[index], chain)))
    if isinstance(details, ConfigurationOptions):
        option = templates.get_template("questions/rank.md.j2").module.option
        return messages.localize_formulas(str(option(details, details.offered_configurations[index], chain)))
    if isinstance(details, CustomDetails):
        return messages.localize_formulas(write_custom_options(part, Wording(chain, messages))[index])
    text = write_prompt(problem, part, language)
    option_line = re.search(rf"^- \*\*{LETTERS[index]}\.\*\* (.*)$", text, re.MULTILINE)
    return option_line[1] if option_line is not None else messages.translate_phrase(part.answer.offered_options[index])


def name_entries(problem: Problem, part: Part) -> tuple[str, ...]:
    """Return the names of the entries of an answer, row by row, as LaTeX; () if the entries have no names."""
    chain, question = problem.chain, question_of(part)
    typed_names = (tex(sp.Symbol(name), chain) for name in question.list_labels(chain))
    return tuple(question.name_entries(chain, part.details) or typed_names)


def write_hints(problem: Problem, part: Part, language: str = ENGLISH) -> tuple[str, ...]:
    """Return three hints for this arm, from vague to detailed; no hint contains the answer.

    A question that an instructor has defined may have none.
    """
    chain, messages = problem.chain, load_catalogue(language)
    steps = get_solution_steps(chain)
    text = _get_question_macros(part, language).hints(part, chain, derive(chain), Wording(chain, messages), steps)
    hints = re.split(r"^---$", text, flags=re.MULTILINE)
    hints_with_legends = (add_angle_legend(steps, hint, language) for hint in hints)
    return tuple(filter(str.strip, map(messages.localize_formulas, hints_with_legends)))


def write_solution(problem: Problem, part: Part, language: str = ENGLISH) -> str:
    """Return the worked solution of a part: formula, steps, result, meaning. The text begins with a legend."""
    text = _write_derivation(problem, part, language)
    legend = _make_legend(get_solution_steps(problem.chain), text)
    return load_catalogue(language).localize_formulas(_add_legend(legend, text, language))


def write_solutions(problem: Problem) -> dict[str, str]:
    """Return the solutions of all parts, by part name, for a single text in English.

    Each abbreviation is explained before its first use. The result of an earlier part is not derived again.
    """
    explained_names: set[str] = set()
    parts, solutions = problem.parts, {}
    for number, part in enumerate(parts, 1):
        problem_so_far = replace(problem, parts=parts[:number])
        solutions[part.name] = write_next_solution(problem_so_far, explained_names, ENGLISH, len(parts) > 1)
    return solutions


def write_next_solution(
    problem: Problem, explained_names: set[str], language: str = ENGLISH, may_be_followed: bool = True
) -> str:
    """Return the solution of a problem's last part, for a text that already has the solutions of the earlier parts.

    `explained_names` has the abbreviations that the text explains already; abbreviations of this solution are added.
    `may_be_followed` says whether other solutions may follow; if so, the legend also applies to them.
    """
    *earlier_parts, part = problem.parts
    text = _write_derivation(problem, part, language, frozenset(earlier_part.kind for earlier_part in earlier_parts))
    legend = [pair for pair in _make_legend(get_solution_steps(problem.chain), text) if pair[0] not in explained_names]
    explained_names.update(name for name, _ in legend)
    return load_catalogue(language).localize_formulas(_add_legend(legend, text, language, may_be_followed))


def _write_derivation(problem: Problem, part: Part, language: str, solved_kinds: frozenset[str] = frozenset()) -> str:
    chain = problem.chain
    wording, steps = Wording(chain, load_catalogue(language), solved_kinds), get_solution_steps(chain)
    return str(_get_question_macros(part, language).solution(part, chain, derive(chain), wording, steps))


def write_answer_code(problem: Problem, part: Part, prefix_width: int = 0) -> str:
    """Return the answer as Python code with the angles of the worked solution.

    The code is broken into lines as if `prefix_width` columns before its first line were taken.
    """
    return part.answer.write_code(prefix_width, get_solution_steps(problem.chain).angles.write_python_code)


def add_angle_legend(steps: SolutionSteps, text: str, language: str = ENGLISH) -> str:
    """Return a text on an arm, preceded by a legend of the angles' names in the text."""
    return _add_legend(_list_named_angles(steps, text), text, language)


def _list_named_angles(steps: SolutionSteps, text: str) -> list[tuple[str, str]]:
    """Return the names of angles in a text, each with the angle that it stands for."""
    return [(str(name), tex_angle(angle)) for name, angle in steps.angles.angle_by_name.items() if str(name) in text]


def _make_legend(steps: SolutionSteps, text: str) -> list[tuple[str, str]]:
    """Return the names of angles and the abbreviations of sines and cosines in a text, each with its meaning."""
    joint_digits = re.findall(r"(?<![A-Za-z\\])[cs]_\{?([1-9]{1,7})\}?", text)
    legend = _list_named_angles(steps, text)
    if any(len(digits) == 1 for digits in joint_digits):
        legend += [(r"c_i", r"\cos\theta_i"), (r"s_i", r"\sin\theta_i")]
    if any(len(digits) > 1 for digits in joint_digits):
        legend.append((r"c_{ij \dots}", r"\cos(\theta_i + \theta_j + \dots)"))
    return legend


def _add_legend(legend: list[tuple[str, str]], text: str, language: str, is_for_several: bool = False) -> str:
    """Return a text preceded by a legend; if `is_for_several`, the legend also applies to the following texts."""
    template = make_environment(language).get_template("writing/solution.md.j2")
    return _clean_whitespace(template.render(solution=text, legend=legend, is_for_several=is_for_several))


@lru_cache(maxsize=64)
def get_solution_steps(chain: Chain) -> SolutionSteps:
    """Return the solution steps of an arm; cached, because several parts show the same ones."""
    return SolutionSteps(chain)


def _get_question_macros(part: Part, language: str) -> Any:
    return make_environment(language).get_template(f"questions/{question_of(part).template or part.kind}.md.j2").module


def _clean_whitespace(text: str) -> str:
    """Remove the trailing spaces and repeated empty lines that macros produce."""
    lines = "\n".join(line.rstrip() for line in text.strip().splitlines())
    return re.sub(r"\n{3,}", "\n\n", lines) + "\n"
