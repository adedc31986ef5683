"""Generate problems: the same id gives the same problem, byte for byte, as long as the engine is the same."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import cache, partial
from itertools import count, islice

from qdot.exercises.arm.chain import CONVENTIONS, Chain
from qdot.exercises.arm.difficulty import HARDEST, describe_band, difficulty, step
from qdot.exercises.arm.library import robots
from qdot.exercises.common.errors import QdotError, unknown
from qdot.exercises.common.stream import Stream, derive_seed
from qdot.exercises.common.variation import DEFAULT, STEPS, axes_of
from qdot.exercises.families import FAMILIES, Family
from qdot.exercises.families.listing import FamilyListing, listing
from qdot.exercises.problem.problem import ENGINE, Part, Problem, ProblemId
from qdot.exercises.questions import QUESTIONS, Question
from qdot.exercises.quizzes import ASKED, QUIZZES

ATTEMPTS = 8
"""Arms of a varied family, and for short questions, that are tried before what finds nothing to ask is given up."""

DRAWS = 200
"""Arms that are sampled before qdot reports that a family has none in a band of difficulty."""

SHORT_QUIZ = (
    "singular-angles-choice", "column-choice", "determinant-choice", "vector-choice", "singular-configurations",
    "dependence", "match-columns", "speed", "determinant-value", "true-or-false",
)  # fmt: skip
"""Of these, the first of each form makes a quiz."""

QUIZ_DRAWS, QUIZ_LOOKED_AT = 12, 2
"""Arms that are sampled before a short question is given up, and examined before one is put into a quiz."""

LOOKED_AT, LOOKED_AT_VARIED = 8, 120
"""Arms from which the difficulty of a family is found out, more if structures are sampled: hard ones are rarer."""


def look_up_family(name: str) -> Family:
    """Return a registered family. Raises QdotError."""
    if name in FAMILIES:
        return FAMILIES[name]
    if name in robots():
        raise QdotError(
            f'{name} is no family but a real robot: robot = "{name}" in assignment.toml asks about it, and '
            f"`qdot families {name}` lists what"
        )
    raise unknown("family", name, list(FAMILIES))


def sample_chain(identity: ProblemId, family: Family | None = None, attempt: int = 0) -> Chain:
    """Return the arm of a problem; `family` is given if it is not registered (an instructor's own robot).

    Attempts after the first sample another arm, if a question found nothing to ask of the first one.
    Raises QdotError for a family or engine that this version does not know, and if no arm is in the identity's band.
    """
    family = family or look_up_family(identity.family)
    if identity.engine != ENGINE:
        raise QdotError(f"{identity} was made by engine {identity.engine}; this version of qdot has engine {ENGINE}")
    in_convention = partial(_in_convention, convention=identity.convention, twist_order=identity.twist_order)
    stream = Stream(f"qdot/{identity.engine}/{identity.family_and_seed}/arm" + (f"/{attempt}" if attempt else ""))
    axes = axes_of(identity.variation)
    if family.structures is not None:
        accepts = lambda chain: not _object_to_questions(in_convention(chain), identity.questions)  # noqa: E731
        return in_convention(family.structures(stream, axes, identity.band, accepts))
    quizzes = [name for name in identity.questions if name in QUIZZES]
    arms = map(in_convention, _sample_arms(family, stream, axes))
    low, high = identity.band or (0, HARDEST)
    seen: dict[Chain, int] = {}
    for number, chain in enumerate(islice(arms, DRAWS)):
        if identity.band is not None:
            if chain in seen:
                break
            seen[chain] = step(chain)
            if not low <= seen[chain] <= high:
                continue
        if number >= QUIZ_DRAWS or _object_to_questions(chain, quizzes) is None:
            return chain
    steps = describe_band(min(seen.values()), max(seen.values()))
    raise QdotError(
        f"{family.name} has no arm of difficulty {describe_band(low, high)}; its arms are of difficulty {steps}"
    )


def _in_convention(chain: Chain, convention: str, twist_order: str = "") -> Chain:
    """Return an arm as it is presented in a convention, with its twists in an order; its own, if none is named."""
    presented = replace(chain, convention=convention) if convention else chain
    return replace(presented, twist_order=twist_order) if twist_order else presented


def _sample_arms(family: Family, stream: Stream, axes: tuple[str, ...]) -> Iterator[Chain]:
    """Yield arm after arm; the first is the identity's own, unless something speaks against it."""
    yield family.sample(stream, axes)
    for again in count(1):
        yield family.sample(stream.part(f"draw {again}"), axes)


def _object_to_questions(chain: Chain, questions: Sequence[str]) -> str | None:
    """Return why one of the questions can't be asked of an arm, or None; unknown ones are reported elsewhere."""
    for name in questions:
        if name in ASKED and (refused := ASKED[name].refusal(chain)) is not None:
            return f"question {name!r} can't be asked of {chain.name}: {refused}"
    return None


def applicable_questions(chain: Chain, among: Mapping[str, Question] = QUESTIONS) -> tuple[str, ...]:
    """Return the names of the questions that can be asked of an arm, in the chapter's order; or of `among`."""
    return tuple(name for name, question in among.items() if question.refusal(chain) is None)


def _find_family(family: str | Family) -> Family:
    return look_up_family(family) if isinstance(family, str) else family


def _look_up_listing(family: Family) -> FamilyListing | None:
    """Return what is listed of a registered family, as finding it out takes seconds; None of any other family."""
    return listing().get(family.name) if FAMILIES.get(family.name) is family else None


def questions_of(family: str | Family, convention: str = "") -> tuple[str, ...]:
    """Return the names of the questions that can be asked of every arm of a family, or of some of a varied one."""
    known = _find_family(family)
    entry = _look_up_listing(known)
    return find_questions(known, convention) if entry is None or convention else entry.questions


def short_quiz(family: str | Family, convention: str = "") -> tuple[str, ...]:
    """Return a quiz for a family's arms: a short question of each form, as far as one can be asked."""
    known = _find_family(family)
    identities = (ProblemId(known.name, seed, convention=convention) for seed in range(QUIZ_LOOKED_AT))
    arms = [sample_chain(identity, known) for identity in identities]
    chosen: dict[str, str] = {}
    for name in SHORT_QUIZ:
        question = QUIZZES[name]
        if question.form not in chosen and all(question.refusal(arm) is None for arm in arms):
            chosen[question.form] = name
    return tuple(chosen.values())


def find_questions(family: Family, convention: str = "") -> tuple[str, ...]:
    """Find out what can be asked of a family's arms."""
    if not family.varied:
        return applicable_questions(sample_chain(ProblemId(family.name, 0, convention=convention), family))
    missing = dict(QUESTIONS)
    for arm in (_in_convention(chain, convention) for chain in _sampled_arms(family)):
        for name in applicable_questions(arm, missing):
            del missing[name]
    return tuple(name for name in QUESTIONS if name not in missing)


@cache
def _sampled_arms(family: Family) -> tuple[Chain, ...]:
    """Return the arms from which the questions and the difficulty of a family are found out.

    If structures are sampled, it is one arm of each of so many structures, all classes before a second of any: what
    can't be asked of these can't be asked of the others, as all of a class lose rank alike.
    """
    if family.structures is None:
        return tuple(sample_chain(ProblemId(family.name, seed), family) for seed in range(LOOKED_AT))
    arms: list[Chain] = []

    def is_last(chain: Chain) -> bool:
        arms.append(chain)
        return len(arms) == LOOKED_AT_VARIED

    with suppress(QdotError):  # it has fewer
        family.structures(Stream(f"qdot/{ENGINE}/{family.name}/looked at"), STEPS["full"], None, is_last)
    return tuple(arms)


def listing_of(family: str | Family, convention: str = "") -> FamilyListing:
    """Return what is listed of a registered family; of a robot, or of a new one, it is found out here."""
    known = _find_family(family)
    entry = _look_up_listing(known) or find_out(known)
    return replace(entry, questions=find_questions(known, convention)) if convention else entry


@cache
def find_out(family: Family) -> FamilyListing:
    """Find out from a family's arms what is to be listed of it: kinds of joints, difficulty, questions."""
    arms = _sampled_arms(family)
    steps = [step(arm) for arm in arms]
    kinds = "" if family.varied else "".join(joint.kind for joint in arms[0].joints)
    return FamilyListing(kinds, (min(steps), max(steps)), find_questions(family), _measure_steps(family))


def _measure_steps(family: Family) -> tuple[int, ...]:
    """Return the difficulty of an arm at each step of variation; all arms of a family have that of a step's.

    A robot of a file has no such steps.
    """
    if family.varied or family.robot:
        return ()
    return tuple(difficulty(sample_chain(ProblemId(family.name, 0, variation=name), family)) for name in STEPS)


def check_questions(
    family: str | Family,
    questions: Sequence[str],
    band: tuple[int, int] | None = None,
    variation: str = DEFAULT,
    convention: str = "",
) -> None:
    """Raise QdotError where a question is unknown, asked twice, or can't be asked of the family's arms."""
    known = _find_family(family)
    _check_names(questions)
    if FAMILIES.get(known.name) is known:
        for name in questions:
            if (reason := ASKED[name].objection_to_convention(convention or CONVENTIONS[0])) is not None:
                raise QdotError(f"question {name!r} can't be asked of {known.name}: {reason}")
    entry = None if convention else _look_up_listing(known)
    if entry is not None:
        missing = [name for name in questions if name not in entry.questions]
        if not known.varied and band is None and variation in STEPS and not missing:
            return  # what is listed, for arms of every step, need not be derived
        for name in missing:
            if known.varied and name in QUESTIONS:
                raise QdotError(
                    f"question {name!r} can be asked of no arm of {known.name}; "
                    f"`qdot families {known.name}` lists what can"
                )
    identity = ProblemId(known.name, 0, tuple(questions), band=band, variation=variation, convention=convention)
    _check_can_be_asked(sample_chain(identity, known), questions, known, convention)


def _check_names(questions: Sequence[str]) -> None:
    for name in questions:
        if name not in ASKED:
            raise unknown("question", name, list(ASKED))
        if list(questions).count(name) > 1:
            raise QdotError(f"question {name!r} is asked twice")
        shown = next((asked for asked in ASKED[name].shows if asked in questions), None)
        if shown is not None:
            raise QdotError(
                f"question {name!r} shows the answer to {shown!r} among its options; ask them of different arms, each "
                "in a [[problem]] of its own"
            )


def _check_can_be_asked(chain: Chain, questions: Sequence[str], family: Family, convention: str) -> None:
    objection = _object_to_questions(chain, questions)
    if objection is not None:
        option = f" --convention {convention}" if convention else ""
        raise QdotError(f"{objection}; `qdot families {family.robot or family.name}{option}` lists what can")


def generate(
    identity: ProblemId | str,
    questions: Sequence[str] = (),
    *,
    points: Sequence[float] | None = None,
    family: Family | None = None,
) -> Problem:
    """Return the problem of an identity or a text FAMILY/SEED, with these `questions`; without any, all that apply.

    `points` gives the points of each part, else those of the question; `family` as in `sample_chain`. Each part has
    its own stream, so that it does not depend on what else is asked of the arm. Lengths are in metres,
    angles in radians, everything in the base frame. Raises QdotError for a family or question that is none, and for
    a question that can't be asked of the arm.

    >>> generate("planar-2r/7", ["position", "jacobian"])
    Problem(planar-2r/7: position, jacobian)
    """
    identity = ProblemId.parse(identity) if isinstance(identity, str) else identity
    identity = replace(identity, questions=tuple(questions)) if questions else identity
    _check_names(identity.questions)
    known = family or look_up_family(identity.family)
    again = known.varied or any(name in QUIZZES for name in identity.questions)
    for attempt in range(ATTEMPTS if again else 1):
        chain = sample_chain(identity, family, attempt)
        _check_can_be_asked(chain, identity.questions, known, identity.convention)
        try:
            return Problem(identity, chain, _ask_parts(identity, chain, points))
        except RuntimeError:
            if not again or attempt == ATTEMPTS - 1:
                raise
    raise AssertionError("a loop of at least one attempt ended without a result")


def _ask_parts(identity: ProblemId, chain: Chain, points: Sequence[float] | None) -> tuple[Part, ...]:
    """Return the parts of a problem. Raises RuntimeError where a question finds nothing to ask of the arm."""
    names = identity.questions or applicable_questions(chain)
    parts = []
    for index, name in enumerate(names):
        question = ASKED[name]
        answer, details = question.ask(chain, Stream(f"qdot/{identity.engine}/{identity.family_and_seed}/{name}"))
        part_points = question.points if points is None else points[index]
        needs = tuple(need for need in question.needs if need in names)
        parts.append(Part(name, name, answer, part_points, needs, details))
    return tuple(parts)


def student_problem_id(secret: str, student: str, slot: str, problem: ProblemId) -> ProblemId:
    """Return the problem of one student in one slot of an assignment: `problem` with a seed of the student's own.

    Without the secret it can't be guessed. It depends on nobody else, so that a student who joins later changes no
    other problem.
    """
    return replace(problem, seed=derive_seed(secret, student, slot, problem.family))
