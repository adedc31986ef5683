"""What tests of questions share: problems of one question for any chain, and problems with another reference."""

from dataclasses import replace

from exercises.arm.chain import Chain
from exercises.problem import Answer, Part, Problem, ProblemId
from exercises.questions import QUESTIONS
from exercises.stream import Stream


def asked(name: str, chain: Chain, seed: int = 1) -> Problem:
    """Return a problem with this question alone, for a chain that need not be of a family."""
    question = QUESTIONS[name]
    answer, details = question.ask(chain, Stream(f"{chain.name}/{seed}/{name}"))
    part = Part(name, name, answer, question.points, (), details)
    return Problem(ProblemId("textbook", seed, (name,)), chain, (part,))


def with_answer(problem: Problem, answer: Answer) -> Problem:
    """Return the problem with another reference for its only part."""
    (part,) = problem.parts
    return replace(problem, parts=(replace(part, answer=answer),))
