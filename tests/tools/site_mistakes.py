"""What the site says of mistakes that are known: `python -m tests.tools.site_mistakes` counts them by question.

Each mistake of the catalogue is made in the answers to everything that is asked of a family, short questions too, as
`tests.tools.diagnoses` writes them down, and every wrong option is chosen; the site judges them. A slip that is told in
its place counts as named. Of slips that no catalogue has, `site_slips` tells.
"""

import argparse
import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from typing import Any

from exercises.families import FAMILIES
from exercises.generation import generate
from exercises.problem import Part, Problem, ProblemId
from exercises.quizzes import ASKED, QUIZZES
from exercises.site.keys import key_of
from exercises.site.record import Said, arm_record
from tests.support.problems import drawn
from tests.tools.diagnoses import answers_with, random_answers
from tests.tools.readers import part_json
from tests.tools.site_slips import called, told_of

LETTERS = "ABCDEFGH"
AT_RANDOM = "(at random)"
NOTHING, RIGHT = "nothing", "right"


def asked_of(family: str, seed: int, variation: str, questions: Sequence[str] = ()) -> list[Problem]:
    """Return what is asked of an arm: a problem with the chapter's questions, and one with the short ones."""
    whole = drawn(family, seed, variation)
    short = tuple(name for name, quiz in QUIZZES.items() if quiz.refusal(whole.chain) is None)
    wanted = [name for name in short if not questions or name in questions]
    quiz = [generate(ProblemId(family, seed, tuple(wanted), variation=variation))] if wanted else []
    return [whole, *quiz]


def wrong_letters(part: Part) -> Iterator[tuple[str, str]]:
    """Yield each wrong option of a part, alone or with the right ones, or each item with another's letter."""
    answer, options = part.answer, len(part.answer.offered)
    right = answer.right
    if part.type == "matching":
        for k in range(len(right)):
            for other in range(options):
                if other != right[k]:
                    chosen = [other if i == k else letter for i, letter in enumerate(right)]
                    yield "another's letter", "".join(LETTERS[i] for i in chosen)
        return
    for index in range(options):
        if index not in right:
            alone = part.type == "choice"
            yield "wrong option", "".join(LETTERS[i] for i in sorted({index, *(() if alone else right)}))


def problem_json(problem: Problem, questions: Sequence[str], few: int | None, at_random: int) -> dict[str, Any]:
    """Return a problem as the site's tests have it, with what is typed: {"id", "robot", "parts", "said", "slips"}."""
    said, parts, typed = Said(), [], []
    for part in problem.parts:
        if questions and part.kind not in questions:
            continue
        key = said.in_key(key_of(problem, part))
        parts.append(part_json(problem, part) | {"key": key})
        if part.answer.offered:
            typed += [[part.name, name, text] for name, text in wrong_letters(part)]
        else:
            typed += [[part.name, one.mistake, one.text] for one in answers_with(problem, part, few)]
            typed += [[part.name, AT_RANDOM, text] for text in random_answers(problem, part, at_random)]
    robot = arm_record(problem)["robot"]
    return {"id": str(problem.id), "robot": robot, "parts": parts, "said": said.rows, "slips": typed}


def main() -> int:
    """Have the mistakes judged, and print how many are named, by question."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--family", action="append", choices=FAMILIES)
    parser.add_argument("--question", action="append", choices=ASKED)
    parser.add_argument("--variation", default="chapter", help="a step or axes; chapter by default")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--few", type=int, help="so many answers to each question, drawn; all by default")
    parser.add_argument("--random", type=int, default=0, help="so many answers to each question that are no mistake's")
    parser.add_argument("--missed", action="store_true", help="print the answers of which nothing is said")
    options = parser.parse_args()
    questions = options.question or ()
    counts: dict[str, Counter[str]] = {}
    for family in options.family or [name for name, family in FAMILIES.items() if not family.varied]:
        arms = asked_of(family, options.seed, options.variation, questions)
        problems = [problem_json(arm, questions, options.few, options.random) for arm in arms]
        typed = [(each, *one) for each in problems for one in each["slips"]]
        for (problem, name, mistake, text), told in zip(typed, told_of(problems), strict=True):
            kind = next(part["kind"] for part in problem["parts"] if part["name"] == name)
            says = called(*told)
            named = NOTHING if says.endswith("nothing") else RIGHT if says == RIGHT else "named"
            counts.setdefault(f"{kind} {mistake}" if mistake == AT_RANDOM else kind, Counter())[named] += 1
            if options.missed and (named == NOTHING) != (mistake == AT_RANDOM):
                sys.stdout.write(f"{problem['id']} {name}, {mistake}: {text[:200]} ({says})\n")
        sys.stderr.write(f"{family}\n")
    for kind, told_as in counts.items():
        wrong = told_as["named"] + told_as[NOTHING]
        sys.stdout.write(f"{kind}: {told_as['named']} of {wrong} named\n")
    every = sum((told for kind, told in counts.items() if not kind.endswith(AT_RANDOM)), Counter[str]())
    sys.stdout.write(f"{every['named'] + every[NOTHING]} mistakes, {every['named']} named\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
