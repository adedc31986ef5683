"""A problem in words: its statement, the prompt of each part, and worked solutions, as Markdown with LaTeX.

All of it can be had in each of the `languages`.
"""

import re
from functools import lru_cache
from typing import Any

from qdot.exercises.answers import LETTERS
from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.derivation import derive
from qdot.exercises.families import FAMILIES
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.quizzes import ASKED
from qdot.exercises.quizzes.options import Options, Places
from qdot.exercises.writing.languages import ENGLISH, catalogue
from qdot.exercises.writing.latex import tex_angle
from qdot.exercises.writing.render import environment
from qdot.exercises.writing.wording import Wording
from qdot.exercises.writing.worked import Worked


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
    chain, steps, words = problem.chain, worked_steps(problem.chain), catalogue(language)
    text = _macros(part, language).hints(part, chain, derive(chain), Wording(chain, words), steps)
    told = (with_meanings(steps, hint, language) for hint in re.split(r"^---$", text, flags=re.MULTILINE))
    gentle, plan, nearly = (words.with_decimals(hint) for hint in told)
    return gentle, plan, nearly


def worked_solution(problem: Problem, part: Part, language: str = ENGLISH) -> str:
    """Return the way to the answer as the chapter would print it: formula, steps, result, what it means.

    It is for a part by itself, and begins with what names of angles, sines and cosines in it stand for.
    """
    steps, text = worked_steps(problem.chain), _derivation(problem, part, language)
    names = [*_used(steps, text), *_short(text)]
    return catalogue(language).with_decimals(_after(names, text, language, and_so_on=_has_other_sums(text)))


def worked_solutions(problem: Problem, language: str = ENGLISH) -> dict[str, str]:
    """Return the solutions of all parts by their names, for one text.

    What names stand for is said once, before all, and what an earlier part has found is not derived again.
    """
    steps, words = worked_steps(problem.chain), catalogue(language)
    texts: dict[str, str] = {}
    for number, part in enumerate(problem.parts):
        before = frozenset(each.kind for each in problem.parts[:number])
        texts[part.name] = _derivation(problem, part, language, before)
    every = "".join(texts.values())
    names = [*_used(steps, every), *_short(every)]
    first = next((name for name, text in texts.items() if _used(steps, text) or _short(text)), "")
    told = {name: _tidy(text) for name, text in texts.items()}
    if first:
        whole, others = len(texts) > 1, _has_other_sums(every)
        told[first] = _after(names, texts[first], language, first_of_all=whole, and_so_on=others)
    return {name: words.with_decimals(text) for name, text in told.items()}


def next_solution(problem: Problem, explained: set[str], language: str = ENGLISH) -> str:
    """Return the solution of the last part, for a text that has those of the parts before it.

    What names stand for is said where they are used first; `explained` are those of which it was said, and grows.
    """
    *before, part = problem.parts
    text = _derivation(problem, part, language, frozenset(each.kind for each in before))
    new = [one for one in (*_used(worked_steps(problem.chain), text), *_short(text)) if one[0] not in explained]
    if any(_SHORT.search(name) for name in explained):  # one sum has been an example of how they are written
        new = [(name, angle) for name, angle in new if not _SHORT.fullmatch(name)]
    explained.update(name for name, _ in new)
    example = any(_SHORT.fullmatch(name) for name, _ in new)  # the parts that follow may have others
    whole = _after(new, text, language, first_of_all=True, and_so_on=example) if new else _tidy(text)
    return catalogue(language).with_decimals(whole)


def _derivation(problem: Problem, part: Part, language: str, earlier: frozenset[str] = frozenset()) -> str:
    chain = problem.chain
    words, steps = Wording(chain, catalogue(language), earlier, _is_of_chapter(problem)), worked_steps(chain)
    return str(_macros(part, language).solution(part, chain, derive(chain), words, steps))


def _is_of_chapter(problem: Problem) -> bool:
    """Whether a family drew the arm: a file of somebody's own may have the name of one, but not its title."""
    family = FAMILIES.get(problem.id.family)
    return family is not None and family.plain is not None and problem.chain.title == family.plain.title


def answer_code(problem: Problem, part: Part, taken: int = 0) -> str:
    """Return the answer as Python code with the angles of the worked solution; `taken` columns are used already."""
    return part.answer.code(taken, worked_steps(problem.chain).angles.typed)


def with_meanings(steps: Worked, text: str, language: str = ENGLISH) -> str:
    """Return text on an arm after what the names of angles in it stand for."""
    return _after(_used(steps, text), text, language)


def _used(steps: Worked, text: str) -> list[tuple[str, str]]:
    """Return the names of angles in a text, each with what it stands for."""
    return [(str(name), tex_angle(angle)) for name, angle in steps.angles.meanings.items() if str(name) in text]


def _short(text: str) -> list[tuple[str, str]]:
    """Return what sines and cosines in short stand for: all of one angle, and the first of a sum as an example."""
    found = [(wave, digits) for wave, digits in _SHORT.findall(text)]
    single = [(r"c_i", r"\cos\theta_i"), (r"s_i", r"\sin\theta_i")] if any(len(i) == 1 for _, i in found) else []
    wave, digits = next(((wave, digits) for wave, digits in found if len(digits) > 1), ("", ""))
    angle = " + ".join(rf"\theta_{{{digit}}}" for digit in digits)
    return [*single, *([(f"{wave}_{{{digits}}}", rf"\{_WAVES[wave]}({angle})")] if digits else [])]


def _has_other_sums(text: str) -> bool:
    """Whether more sines and cosines of sums are in short than the one that is an example of them."""
    return len({found for found in _SHORT.findall(text) if len(found[1]) > 1}) > 1


_SHORT = re.compile(r"(?<![A-Za-z\\])([cs])_\{?([1-9]{1,7})\}?")
_WAVES = {"c": "cos", "s": "sin"}


def _after(
    names: list[tuple[str, str]], text: str, language: str, *, first_of_all: bool = False, and_so_on: bool = False
) -> str:
    """Return text after what names in it stand for, or in all that follows, of which it is then the `first_of_all`."""
    template = environment(language).get_template("writing/solution.md.j2")
    told = {"names": names, "and_so_on": and_so_on, "first_of_all": first_of_all}
    return _tidy(template.render(solution=text, **told))


@lru_cache(maxsize=64)
def worked_steps(chain: Chain) -> Worked:
    """Return the steps of an arm, kept because several parts show the same ones."""
    return Worked(chain)


def _macros(part: Part, language: str) -> Any:
    return environment(language).get_template(f"questions/{ASKED[part.kind].template or part.kind}.md.j2").module


def _tidy(text: str) -> str:
    """Return text without spaces at line ends and without runs of empty lines, which macros leave behind."""
    lines = "\n".join(line.rstrip() for line in text.strip().splitlines())
    return re.sub(r"\n{3,}", "\n\n", lines) + "\n"
