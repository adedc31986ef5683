"""Generate problems; the same id and the same version of the generator always give the same problem."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import cache, partial
from itertools import count, islice

from qdot.exercises.arm.chain import CONVENTIONS, Chain
from qdot.exercises.arm.difficulty import HARDEST_BAND, describe_band, difficulty, difficulty_band
from qdot.exercises.arm.library import robots
from qdot.exercises.common.errors import QdotError, unknown_name
from qdot.exercises.common.stream import Stream, derive_seed
from qdot.exercises.common.variation import DEFAULT_VARIATION, VARIATION_STEPS, variation_axes
from qdot.exercises.families import FAMILIES, Family
from qdot.exercises.families.listing import FamilyListing, listing
from qdot.exercises.problem.problem import ENGINE, Part, Problem, ProblemId
from qdot.exercises.questions import QUESTIONS, Question
from qdot.exercises.quizzes import ASKED, QUIZZES

MAX_ATTEMPTS = 8
"""Maximum number of arms that are tried until every question finds something to ask about.

Only families with varied structures and quizzes try more than one."""

MAX_SAMPLED_ARMS = 200
"""Maximum number of arms that are sampled to find one in a band of difficulty."""

QUIZ_CANDIDATES = (
    "singular-angles-choice", "column-choice", "determinant-choice", "vector-choice", "singular-configurations",
    "dependence", "match-columns", "speed", "determinant-value", "true-or-false",
)  # fmt: skip
"""Candidates for a quiz: it takes the first question of each form that applies."""

MAX_QUIZ_ARMS, QUIZ_CHECKED_ARMS = 12, 2
"""Maximum number of arms that are sampled until all short questions apply, and the number that decides on a quiz.

A short question is put into a family's quiz only if it applies to all of the latter."""

LISTING_ARMS, VARIED_LISTING_ARMS = 8, 120
"""Number of arms from which a family's difficulty is determined; more if structures vary, as hard ones are rare."""


def look_up_family(name: str) -> Family:
    """Return the registered family of a name. Raises QdotError if there is none."""
    if name in FAMILIES:
        return FAMILIES[name]
    if name in robots():
        raise QdotError(
            f'{name} is no family but a real robot: robot = "{name}" in assignment.toml asks about it, and '
            f"`qdot families {name}` lists what"
        )
    raise unknown_name("family", name, list(FAMILIES))


def sample_chain(identity: ProblemId, family: Family | None = None, attempt: int = 0) -> Chain:
    """Return the arm of a problem. Give `family` if it is not registered (an instructor's own robot).

    If a question found nothing to ask of the first arm, a higher `attempt` samples another one.
    Raises QdotError if this version doesn't know the family or engine, or if no arm is in the identity's band.
    """
    family = family or look_up_family(identity.family)
    if identity.engine != ENGINE:
        raise QdotError(f"{identity} was made by engine {identity.engine}; this version of qdot has engine {ENGINE}")
    in_convention = partial(_in_convention, convention=identity.convention, twist_order=identity.twist_order)
    stream = Stream(f"qdot/{identity.engine}/{identity.family_and_seed}/arm" + (f"/{attempt}" if attempt else ""))
    axes = variation_axes(identity.variation)
    if family.sample_structure is not None:
        accepts = lambda chain: not _find_objection(in_convention(chain), identity.questions)  # noqa: E731
        return in_convention(family.sample_structure(stream, axes, identity.band, accepts))
    quizzes = [name for name in identity.questions if name in QUIZZES]
    arms = map(in_convention, _sample_arms(family, stream, axes))
    low, high = identity.band or (0, HARDEST_BAND)
    steps_by_arm: dict[Chain, int] = {}
    for sample_index, chain in enumerate(islice(arms, MAX_SAMPLED_ARMS)):
        if identity.band is not None:
            if chain in steps_by_arm:
                break
            steps_by_arm[chain] = difficulty_band(chain)
            if not low <= steps_by_arm[chain] <= high:
                continue
        if sample_index >= MAX_QUIZ_ARMS or _find_objection(chain, quizzes) is None:
            return chain
    steps = describe_band(min(steps_by_arm.values()), max(steps_by_arm.values()))
    raise QdotError(
        f"{family.name} has no arm of difficulty {describe_band(low, high)}; its arms are of difficulty {steps}"
    )


def _in_convention(chain: Chain, convention: str, twist_order: str = "") -> Chain:
    """Return the arm presented in a convention and twist order; an empty string keeps the arm's own."""
    presented = replace(chain, convention=convention) if convention else chain
    return replace(presented, twist_order=twist_order) if twist_order else presented


def _sample_arms(family: Family, stream: Stream, axes: tuple[str, ...]) -> Iterator[Chain]:
    """Yield random arms of a family without end; a problem takes the first one that is suitable."""
    yield family.sample(stream, axes)
    for sample_number in count(1):
        yield family.sample(stream.substream(f"draw {sample_number}"), axes)


def _find_objection(chain: Chain, questions: Sequence[str]) -> str | None:
    """Return why one of the questions doesn't apply to an arm, or None; unknown questions are skipped."""
    for name in questions:
        if name in ASKED and (objection := ASKED[name].find_obstacle(chain)) is not None:
            return f"question {name!r} can't be asked of {chain.name}: {objection}"
    return None


def applicable_questions(chain: Chain, candidates: Mapping[str, Question] = QUESTIONS) -> tuple[str, ...]:
    """Return the names of the questions in `candidates` that apply to an arm, in order."""
    return tuple(name for name, question in candidates.items() if question.find_obstacle(chain) is None)


def _find_family(family: str | Family) -> Family:
    return look_up_family(family) if isinstance(family, str) else family


def _look_up_listing(family: Family) -> FamilyListing | None:
    """Return the stored listing of a registered family, or None for other families; computing one takes seconds."""
    return listing().get(family.name) if FAMILIES.get(family.name) is family else None


def questions_of_family(family: str | Family, convention: str = "") -> tuple[str, ...]:
    """Return the names of the questions that apply to a family's arms; in a varied family, to at least one arm."""
    known_family = _find_family(family)
    entry = _look_up_listing(known_family)
    return find_questions(known_family, convention) if entry is None or convention else entry.questions


def select_quiz_questions(family: str | Family, convention: str = "") -> tuple[str, ...]:
    """Return the names of the short questions in a family's quiz: one of each form, if one applies."""
    known_family = _find_family(family)
    identities = (ProblemId(known_family.name, seed, convention=convention) for seed in range(QUIZ_CHECKED_ARMS))
    arms = [sample_chain(identity, known_family) for identity in identities]
    chosen_by_form: dict[str, str] = {}
    for name in QUIZ_CANDIDATES:
        question = QUIZZES[name]
        if question.form not in chosen_by_form and all(question.find_obstacle(arm) is None for arm in arms):
            chosen_by_form[question.form] = name
    return tuple(chosen_by_form.values())


def find_questions(family: Family, convention: str = "") -> tuple[str, ...]:
    """Determine from sampled arms which questions apply to a family."""
    if not family.has_varied_structure:
        return applicable_questions(sample_chain(ProblemId(family.name, 0, convention=convention), family))
    missing = dict(QUESTIONS)
    for arm in (_in_convention(chain, convention) for chain in _listing_arms(family)):
        for name in applicable_questions(arm, missing):
            del missing[name]
    return tuple(name for name in QUESTIONS if name not in missing)


@cache
def _listing_arms(family: Family) -> tuple[Chain, ...]:
    """Return the arms from which a family's questions and difficulty are determined.

    If structures are sampled, these are one arm of each structure, and every class occurs once before any occurs twice.
    The arms of a class lose rank in the same way, so a question that applies to none of these arms applies to no other.
    """
    if family.sample_structure is None:
        return tuple(sample_chain(ProblemId(family.name, seed), family) for seed in range(LISTING_ARMS))
    arms: list[Chain] = []

    def is_last(chain: Chain) -> bool:
        arms.append(chain)
        return len(arms) == VARIED_LISTING_ARMS

    with suppress(QdotError):  # the family has fewer structures
        family.sample_structure(
            Stream(f"qdot/{ENGINE}/{family.name}/looked at"), VARIATION_STEPS["full"], None, is_last
        )
    return tuple(arms)


def find_listing(family: str | Family, convention: str = "") -> FamilyListing:
    """Return a family's listing: the stored one of a registered family, else one computed from sampled arms."""
    known_family = _find_family(family)
    entry = _look_up_listing(known_family) or compute_listing(known_family)
    return replace(entry, questions=find_questions(known_family, convention)) if convention else entry


@cache
def compute_listing(family: Family) -> FamilyListing:
    """Compute a family's listing from sampled arms: kinds of joints, difficulty, questions."""
    arms = _listing_arms(family)
    steps = [difficulty_band(arm) for arm in arms]
    kinds = "" if family.has_varied_structure else "".join(joint.kind for joint in arms[0].joints)
    return FamilyListing(kinds, (min(steps), max(steps)), find_questions(family), _measure_steps(family))


def _measure_steps(family: Family) -> tuple[int, ...]:
    """Return the difficulty at each step of variation; at one step, all arms of a family are equally difficult.

    Families with varied structures and robots from files have no such steps.
    """
    if family.has_varied_structure or family.robot_argument:
        return ()
    return tuple(
        difficulty(sample_chain(ProblemId(family.name, 0, variation=name), family)) for name in VARIATION_STEPS
    )


def check_questions(
    family: str | Family,
    questions: Sequence[str],
    band: tuple[int, int] | None = None,
    variation: str = DEFAULT_VARIATION,
    convention: str = "",
) -> None:
    """Raise QdotError if a question is unknown, is asked twice, or doesn't apply to the family's arms."""
    known_family = _find_family(family)
    _check_names(questions)
    if FAMILIES.get(known_family.name) is known_family:
        for name in questions:
            if (reason := ASKED[name].find_convention_objection(convention or CONVENTIONS[0])) is not None:
                raise QdotError(f"question {name!r} can't be asked of {known_family.name}: {reason}")
    entry = None if convention else _look_up_listing(known_family)
    if entry is not None:
        missing = [name for name in questions if name not in entry.questions]
        if not known_family.has_varied_structure and band is None and variation in VARIATION_STEPS and not missing:
            return  # the listing covers the arms of every step: no derivation needed
        for name in missing:
            if known_family.has_varied_structure and name in QUESTIONS:
                raise QdotError(
                    f"question {name!r} can be asked of no arm of {known_family.name}; "
                    f"`qdot families {known_family.name}` lists what can"
                )
    identity = ProblemId(known_family.name, 0, tuple(questions), band=band, variation=variation, convention=convention)
    _check_questions_apply(sample_chain(identity, known_family), questions, known_family, convention)


def _check_names(questions: Sequence[str]) -> None:
    for name in questions:
        if name not in ASKED:
            raise unknown_name("question", name, list(ASKED))
        if list(questions).count(name) > 1:
            raise QdotError(f"question {name!r} is asked twice")
        source = next((question for question in ASKED[name].shown_answers if question in questions), None)
        if source is not None:
            raise QdotError(
                f"question {name!r} shows the answer to {source!r} among its options; ask them of different arms, each "
                "in a [[problem]] of its own"
            )


def _check_questions_apply(chain: Chain, questions: Sequence[str], family: Family, convention: str) -> None:
    objection = _find_objection(chain, questions)
    if objection is not None:
        option = f" --convention {convention}" if convention else ""
        raise QdotError(f"{objection}; `qdot families {family.robot_argument or family.name}{option}` lists what can")


def generate(
    identity: ProblemId | str,
    questions: Sequence[str] = (),
    *,
    points: Sequence[float] | None = None,
    family: Family | None = None,
) -> Problem:
    """Return the problem of an identity, or of a text FAMILY/SEED, with the given `questions` or all that apply.

    `points` gives the points of each part; by default a part has those of its question. `family` is as in
    `sample_chain`. Each part has its own stream, so it does not depend on the other questions. Lengths are in metres,
    angles in radians, everything in the base frame. Raises QdotError if the family or a question is unknown, or if
    a question doesn't apply to the arm.

    >>> generate("planar-2r/7", ["position", "jacobian"])
    Problem(planar-2r/7: position, jacobian)
    """
    identity = ProblemId.parse(identity) if isinstance(identity, str) else identity
    identity = replace(identity, questions=tuple(questions)) if questions else identity
    _check_names(identity.questions)
    known_family = family or look_up_family(identity.family)
    may_retry = known_family.has_varied_structure or any(name in QUIZZES for name in identity.questions)
    for attempt in range(MAX_ATTEMPTS if may_retry else 1):
        chain = sample_chain(identity, family, attempt)
        _check_questions_apply(chain, identity.questions, known_family, identity.convention)
        try:
            return Problem(identity, chain, _make_parts(identity, chain, points))
        except RuntimeError:
            if not may_retry or attempt == MAX_ATTEMPTS - 1:
                raise
    raise AssertionError("a loop of at least one attempt ended without a result")


def _make_parts(identity: ProblemId, chain: Chain, points: Sequence[float] | None) -> tuple[Part, ...]:
    """Return the parts of a problem. Raises RuntimeError if a question finds nothing to ask of the arm."""
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
    """Return the id of a student's problem in one slot of an assignment: `problem` with the student's own seed.

    Without the secret, nobody can guess it. It doesn't depend on other students, so a student who joins later changes
    no one else's problem.
    """
    return replace(problem, seed=derive_seed(secret, student, slot, problem.family))
