"""From an identity to a problem: the same id gives the same problem, byte for byte, for as long as its engine lives."""

from collections.abc import Sequence

from exercises import ENGINE
from exercises.arm.chain import Chain
from exercises.errors import QdotError, unknown
from exercises.families import FAMILIES
from exercises.problem import Part, Problem, ProblemId
from exercises.questions import QUESTIONS
from exercises.stream import Stream, derived_seed


def sample_chain(identity: ProblemId) -> Chain:
    """Return the arm of a problem. Raises QdotError for a family or engine that this version does not know."""
    if identity.family not in FAMILIES:
        raise unknown("family", identity.family, list(FAMILIES))
    if identity.engine != ENGINE:
        raise QdotError(f"{identity} was made by engine {identity.engine}; this version of qdot has engine {ENGINE}")
    return FAMILIES[identity.family].sample(Stream(f"qdot/{identity.engine}/{identity}/arm"))


def applicable(chain: Chain) -> tuple[str, ...]:
    """Return the names of the questions that can be asked of an arm, in the chapter's order."""
    return tuple(name for name, question in QUESTIONS.items() if question.objection(chain) is None)


def questions_of(family: str) -> tuple[str, ...]:
    """Return the names of the questions that can be asked of every arm of a family."""
    return applicable(sample_chain(ProblemId(family, 0)))


def check_questions(family: str, questions: Sequence[str]) -> None:
    """Raise QdotError where a question is unknown, asked twice, or can't be asked of the family's arms."""
    chain = sample_chain(ProblemId(family, 0))
    for name in questions:
        if name not in QUESTIONS:
            raise unknown("question", name, list(QUESTIONS))
        objection = QUESTIONS[name].objection(chain)
        if objection is not None:
            raise QdotError(f"question {name!r} can't be asked of {family}: {objection}")
        if list(questions).count(name) > 1:
            raise QdotError(f"question {name!r} is asked twice")


def generate(identity: ProblemId, points: Sequence[float] | None = None) -> Problem:
    """Return the problem with that identity; without questions in it, every question that applies is asked.

    `points` gives the points of each part, else those of the question. Each part draws from a stream of its own, so
    that a part is the same whatever else is asked.
    """
    chain = sample_chain(identity)
    names = identity.questions or applicable(chain)
    check_questions(identity.family, names)
    parts = []
    for index, name in enumerate(names):
        question = QUESTIONS[name]
        answer, details = question.ask(chain, Stream(f"qdot/{identity.engine}/{identity}/{name}"))
        given = question.points if points is None else points[index]
        needs = tuple(need for need in question.needs if need in names)
        parts.append(Part(name, name, answer, given, needs, details))
    return Problem(identity, chain, tuple(parts))


def student_problem_id(secret: str, student: str, slot: str, family: str, questions: Sequence[str]) -> ProblemId:
    """Return the problem of one student in one slot of an assignment; without the secret it can't be guessed.

    It depends on nobody else, so that a student who joins later changes no other problem.
    """
    return ProblemId(family, derived_seed(secret, student, slot, family), tuple(questions))
