"""Certificates: every reference passes, every planted mistake fails, and statements about singularities are true."""

import re
from collections.abc import Callable, Iterator
from dataclasses import replace

import pytest
import sympy as sp

from qdot.exercises.arm.chain import Chain, Joint
from qdot.exercises.common.stream import Stream
from qdot.exercises.common.variation import VARIATION_STEPS
from qdot.exercises.families import FAMILIES
from qdot.exercises.generation import generate, list_questions_of_family, sample_chain
from qdot.exercises.problem.problem import Problem, ProblemId
from qdot.exercises.questions import QUESTIONS
from qdot.exercises.questions.singular import KindDetails
from qdot.exercises.reference_answers import Answer, Choice, ConditionSet, Direction, Expression, Matrix, Number
from qdot.exercises.short_questions import ALL_QUESTIONS as EVERY_QUESTION
from qdot.exercises.short_questions.single_configuration import ConfigurationStatement
from qdot.exercises.singularities import classification
from qdot.exercises.singularities.classification import Classification, classify, sample_condition, split_by_value
from qdot.exercises.singularities.normalized_arm import normalize_arm, normalize_conditions
from qdot.exercises.singularities.singular_set import Component, find_singular_set
from qdot.exercises.verify import singularity_statements
from qdot.exercises.verify.certificate import CHECKS, certify
from qdot.exercises.verify.singularity_statements import statement_holds
from qdot.exercises.writing.problem_texts import write_solution
from tests.support.problems import LONG_ARMS, get_problem, replace_answer, select_parts
from tests.support.suites import few_families, few_or_all_families, sample_for_suite, select_for_suite

CHAPTER = ("planar-2r", "elbow-3r", "polar-rp", "planar-3r")


def _asked() -> list[tuple[str, str]]:
    """Return every question with a family of the chapter, in turn, or another one if those can't be asked it.

    In `make whole`, with two families of the chapter, if they can be asked it, and another one.
    """
    found: list[tuple[str, str]] = []
    turns = dict.fromkeys(FAMILIES, 0)
    for name in QUESTIONS:
        can = [family for family in FAMILIES if name in list_questions_of_family(family)]
        chapter = sorted((family for family in can if family in CHAPTER), key=turns.__getitem__)
        others = sorted((family for family in can if family not in CHAPTER), key=turns.__getitem__)
        chosen = [*chapter[: select_for_suite(1, 2)], *others[: select_for_suite(not chapter, 1)]]
        turns |= {family: turns[family] + 1 for family in chosen}
        found += [(family, name) for family in chosen]
    return found


ASKED = _asked()


def test_every_reference_passes(problem: Problem) -> None:
    parts = select_parts(problem) if problem.id.family in LONG_ARMS else problem.parts
    certificate = certify(replace(problem, parts=tuple(parts)))
    assert certificate.passed, certificate.failures


PATH, KIND = ("path-rates",), ("singularity-type", "singularity-meaning")
KIND_AND_PLACE = ("singular-angles", "singularity-type")
ALL: tuple[str, ...] = ()
FOUND_WRONG = {
    "stanford-6r/29": ALL, "puma-560/8": ALL,  # a pivot of 1e-31 stood for one of 0
    "orthogonal-3r/19": PATH, "orthogonal-3r/107": PATH,  # links differ so much that no line is very regular
    "orthogonal-3r/166": PATH,  # and none is long
    "elbow/61": PATH,  # joints move by a third of a radian between two of the places that are looked at
    "random-2/198": ALL,  # J is zero where two components meet
    "scara-rrrp/104": ALL,  # the open length was drawn as long as the given one but for 0.01 mm
    "orthogonal-3r/155": KIND,  # P at a corner of the reach, which few of its configurations show
    # det J changes its sign with the lengths
    "industrial-6r/28": ALL, "industrial-6r/57": ALL, "industrial-6r/58": ALL,
}  # fmt: skip
"""Problems of which a sweep found parts wrong, and the questions of those, which `make test` asks of three of them.

They were drawn before there was variation; the nearest to them is what the same ids draw at `full`.
"""


@pytest.mark.parametrize("identity", sample_for_suite(FOUND_WRONG, 1))
def test_problems_that_a_sweep_found_wrong_pass(identity: str) -> None:
    family, seed = identity.split("/")
    asked = select_for_suite(FOUND_WRONG[identity], ALL)
    certificate = certify(generate(ProblemId(family, int(seed), asked, variation="full")))
    assert certificate.passed, certificate.failures


@pytest.mark.parametrize(
    ("identity", "asked"),
    sample_for_suite(
        [
            # theta3 = acos(-(a1 + a2)/a3) is there for one arm in sixteen
            ("random-3/10091@chapter", ("singular-angles",)),
            # folded so, the arm is at the boundary only where a link is long; the others are not always stretched out
            *((f"planar-3r/{arm}", KIND_AND_PLACE) for arm in ("10001@full", "10157@lengths", "10007@lengths")),
        ],
        2,
    ),
)
def test_what_is_so_for_some_lengths_only_is_met(identity: str, asked: tuple[str, ...]) -> None:
    certificate = certify(generate(replace(ProblemId.parse(identity), questions=asked)))
    assert certificate.passed, certificate.failures


def test_every_kind_of_question_is_tested() -> None:
    assert set(EVERY_QUESTION) == set(CHECKS)


def test_a_kind_that_nothing_tests_fails() -> None:
    problem = generate(ProblemId("planar-2r", 1, ("position",)))
    strange = replace(problem, parts=(replace(problem.parts[0], kind="colour"),))
    assert not certify(strange).passed


def with_entry(m: sp.Matrix, index: int, change: Callable[[sp.Expr], sp.Expr]) -> sp.Matrix:
    return sp.Matrix(m.rows, m.cols, [change(entry) if i == index else entry for i, entry in enumerate(m)])


def dropped_term(m: sp.Matrix) -> sp.Matrix:
    longest = max(range(len(m)), key=lambda i: len(sp.Add.make_args(sp.expand(m[i]))))
    return with_entry(m, longest, lambda entry: sp.Add(*sp.Add.make_args(sp.expand(entry))[1:]))


STRANGER, T1 = sp.symbols("stranger theta1")
BUGS: dict[str, Callable[[sp.Matrix], sp.Matrix]] = {
    "negated": lambda m: -m,
    "one sign": lambda m: with_entry(m, max(i for i, entry in enumerate(m) if entry != 0), lambda entry: -entry),
    "dropped term": dropped_term, "swapped trigs": lambda m: m.replace(sp.sin, sp.cos),
    "shifted": lambda m: m + sp.Rational(1, 10**6) * sp.ones(*m.shape),
    "scaled": lambda m: m * (1 + sp.Rational(1, 10**5)),
    "columns turned": lambda m: sp.Matrix.hstack(m[:, 1:], m[:, :1]),
    "rows turned": lambda m: sp.Matrix.vstack(m[1:, :], m[:1, :]), "transposed": lambda m: m.T,
    "other angle": lambda m: m.xreplace({T1: T1 + sp.pi / 2}),
    "a row short": lambda m: m[:-1, :] if m.rows > 1 else sp.zeros(2, m.cols),
    "stranger": lambda m: m + sp.ones(*m.shape) * (STRANGER - STRANGER**2), "undefined": lambda m: m * sp.nan,
}  # fmt: skip


def broken(answer: Expression | Matrix | Number | Direction, bug: str) -> Answer | None:
    """Return the answer with a bug in it, or nothing where the bug changes nothing."""
    right = sp.Matrix([answer.reference]) if isinstance(answer, Expression) else sp.Matrix(answer.reference)
    wrong = BUGS[bug](right)
    if isinstance(answer, Direction) and bug in ("negated", "scaled"):
        return None
    values = {s: sp.Float(0.3 + 0.37 * i) for i, s in enumerate(sorted(right.free_symbols, key=str))}
    if wrong.shape == right.shape:
        change = [complex(sp.N(entry)) for entry in (wrong - right).xreplace({**values, STRANGER: sp.Float(0.7)})]
        if all(abs(entry) < 1e-12 for entry in change):
            return None
    if not isinstance(answer, Expression):
        return replace(answer, reference=wrong)
    return replace(answer, reference=wrong[0]) if wrong.shape == (1, 1) else None


@pytest.mark.parametrize(
    ("family", "name"),
    [pytest.param(*which, marks=pytest.mark.xdist_group(which[0])) for which in sample_for_suite(ASKED, 17)],
)
def test_planted_bugs_are_found(family: str, name: str) -> None:
    problem = _with_one_question(family, name)
    answer = problem.parts[0].answer
    assert certify(problem).passed
    mutants: list[Answer]
    if isinstance(answer, ConditionSet):
        mutants = list(conditions_broken(answer))
    elif isinstance(answer, Choice):
        mutants = [Choice(answer.options, n) for n in range(len(answer.options)) if n != answer.correct]
    else:
        assert isinstance(answer, (Expression, Matrix, Number, Direction))
        mutants = [found for bug in BUGS if (found := broken(answer, bug)) is not None]
    assert len(mutants) >= 2
    for mutant in mutants:
        assert not certify(replace_answer(problem, mutant)).passed, mutant


def _with_one_question(family: str, name: str) -> Problem:
    """Return a problem with this question alone, from the cached one unless another structure may be needed."""
    if FAMILIES[family].has_varied_structure:
        return generate(ProblemId(family, 4, (name,)))
    problem = get_problem(family, 0)
    return replace(problem, parts=tuple(part for part in problem.parts if part.name == name))


def conditions_broken(answer: ConditionSet) -> Iterator[ConditionSet]:
    components = answer.components
    for i, component in enumerate(components):
        if len(components) > 1:
            yield ConditionSet(components[:i] + components[i + 1 :])
        moved = tuple(condition + sp.Rational(1, 50) for condition in component.conditions)
        if component.solutions is None:
            yield ConditionSet((*components[:i], Component(moved, None), *components[i + 1 :]))
            continue
        for k, (joint, values) in enumerate(component.solutions):
            others = [(joint, tuple(value + sp.Rational(1, 50) for value in values))]
            if len(values) > 1:
                others += [(joint, values[:1]), (joint, values[1:]), (joint, (*values, sp.Rational(1, 3)))]
            for other in others:
                solutions = (*component.solutions[:k], other, *component.solutions[k + 1 :])
                yield ConditionSet((*components[:i], Component(component.conditions, solutions), *components[i + 1 :]))
    yield ConditionSet(())
    extra = Component((sp.Symbol("qd1"),), None)
    yield ConditionSet((*components, extra))


def test_a_wrong_kind_is_found() -> None:
    """The option and the stated kind agree, but the arm does not."""
    for seed in range(8):
        problem = generate(ProblemId("elbow-3r", seed, ("singularity-type",)))
        (part,) = problem.parts
        assert isinstance(part.answer, Choice)
        for number in range(3):
            other = part.answer.options[number]
            kind = "regular" if other.startswith("no ") else other.split()[1]
            details = part.details_as(KindDetails)
            if kind != details.singularity_kind:
                wrong = replace(
                    part, answer=Choice(part.answer.options, number), details=replace(details, singularity_kind=kind)
                )
                assert not certify(replace(problem, parts=(wrong,))).passed


def test_a_badly_conditioned_pose_is_found() -> None:
    problem = generate(ProblemId("planar-2r", 3, ("joint-rates",)))
    (part,) = problem.parts
    assert isinstance(part.answer, Number)
    strict = replace(part.answer, tolerance=1e-9, floor=1e-12)
    assert not certify(replace_answer(problem, strict)).passed


def test_a_symbol_for_two_things_is_found() -> None:
    for own, other, passes in (("a1", 0.5, True), ("a1", "a1", True), ("a2", 0.5, False), ("qd1", 0.5, False),
                               ("vx", 0.5, False)):  # fmt: skip
        joints = (Joint("R", "theta1", 0, own, 0), Joint("R", "theta2", 0, sp.nsimplify(other), 0))
        chain = Chain("two things", joints, ("vx", "vy"))
        assert certify(Problem(ProblemId("two-things", 0), chain, ())).passed is passes, own


@pytest.mark.parametrize(
    ("task", "said"),
    [
        (("vx", "vy"), None), (("vx", "vy", "wz"), None), (("vx", "vy", "vz"), "vx, vy, vz has rank 2 of 3"),
        (("vz",), "vz has rank 0 of 1"), (("wx", "wy", "wz"), "wx, wy, wz has rank 1 of 3"),
    ],
)  # fmt: skip
def test_a_task_that_no_configuration_can_do_is_found(
    task: tuple[str, ...], said: str | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The turned base leaves rounding errors in vz, which are no rank."""
    family = FAMILIES["planar-3r"]

    def changed(chain: Chain, rng: Stream) -> Chain:
        return replace(chain, task=task, base=replace(chain.base, yaw=sp.pi / 12, tilt=sp.pi), tool=None)

    variations = {**family.variations, "lengths": changed}
    monkeypatch.setitem(FAMILIES, "my-rpr", replace(family, name="my-rpr", variations=variations))
    certificate = certify(generate(ProblemId("my-rpr", 0, ("jacobian",))))
    assert [check.name for check in certificate.failures] == ([] if said is None else ["full rank"])
    assert said is None or said in certificate.failures[0].detail


FARTHEST = "as far from the axis of joint 2 as joint 3 can bring it"


def parts(chain: Chain) -> Iterator[tuple[list[str], str]]:
    """Yield conditions of the bare arm, and what is said of them."""
    for component in find_singular_set(chain) or ():
        values = split_by_value(component, classify(chain, component))
        for part in (component, *(part for _, part in values)):
            yield normalize_conditions(chain, part), classify(chain, part).meaning


def are_so(chain: Chain, pieces: list[str], words: str) -> set[bool]:
    arm = normalize_arm(chain)
    samples = [sample for piece in pieces for sample in sample_condition(arm, piece, "test", samples_per_arm=6)]
    return {statement_holds(arm, words, sample) for sample in samples}


@few_or_all_families
def test_what_is_said_is_so(family: str) -> None:
    for step in select_for_suite(("chapter", "full"), tuple(VARIATION_STEPS)):
        for pieces, words in parts(sample_chain(ProblemId(family, 3).with_variation(step))):
            assert are_so(sample_chain(ProblemId(family, 3).with_variation(step)), pieces, words) == {True}, words


@few_families
def test_the_same_of_other_joints_is_not(family: str) -> None:
    """Every number in a sentence counts: with another joint in its place it is false, or says the same."""
    chain = sample_chain(ProblemId(family, 3).with_variation("chapter"))
    for pieces, words in parts(chain):
        for match in re.finditer(r"(?<=joint )\d", words):
            told = int(match[0])
            others = [
                words[: match.start()] + str(n) + words[match.end() :] for n in range(1, chain.n + 1) if n != told
            ]
            assert any(are_so(chain, pieces, other) != {True} for other in others), words


@pytest.mark.parametrize(
    ("identity", "piece", "words", "is_so"),
    sample_for_suite(
        [
            # what was once said, and is not so in all of the configurations: stretched out in a quarter of them;
            # joint 3 is bent; the far end of two, of which the other one is farther
            ("orthogonal-3r/1@chapter", "theta3 = pi", f"the point is {FARTHEST}", False),
            ("random-3/10085@full", "theta2 = pi", "arm folded back", False),
            ("random-3/10002@full", "theta2 = pi", "arm stretched out or folded back", False),
            ("planar-3r/1@chapter", "theta2 = pi and theta3 = pi", "arm folded back", True),
            # each joint alone has the point farthest, both together do not: the links run there, back and there again
            ("planar-3r/1@chapter", "theta2 = pi and theta3 = pi", "arm stretched out", False),
            ("planar-2r/1@chapter", "theta2 = 0", "arm stretched out", True),
            ("planar-2r/1@chapter", "theta2 = 0", "arm folded back", False),
            ("planar-2r/1@chapter", "theta2 = 0", "arm stretched", False),  # words that are not known
            ("planar-2r/1@chapter", "theta2 = 0", "arm stretched out, and joint 1 has no effect on the task", False),
        ],
        3,
    ),
)
def test_what_is_said_of_an_arm_is_true_or_false(identity: str, piece: str, words: str, is_so: bool) -> None:
    chain = sample_chain(ProblemId.parse(identity))
    assert (are_so(chain, [piece], words) == {True}) is is_so
    assert is_so or ([piece], words) not in list(parts(chain))


@pytest.mark.parametrize(
    ("identity", "question", "said"),
    [
        ("planar-2r/1@chapter", "singular-angles", Classification("boundary", True, "arm folded back")),
        ("planar-2r/1@chapter", "singular-angles", Classification("internal", True, "arm stretched out")),
        (
            "elbow/2@chapter",
            "singularity-type",
            Classification("boundary", False, "the point lies on the axis of joint 3"),
        ),
    ],
)
def test_a_false_sentence_or_kind_fails_the_certificate(
    identity: str, question: str, said: Classification, monkeypatch: pytest.MonkeyPatch
) -> None:
    problem = generate(replace(ProblemId.parse(identity), questions=(question,)))
    assert question == "singular-angles" or problem.parts[0].details_as(KindDetails).singularity_kind != "regular"
    assert certify(problem).passed

    def falsely(chain: Chain, component: Component) -> Classification:
        is_place = question == "singular-angles" and component.solutions and component.solutions[0][1] != (0,)
        return classification.classify(chain, component) if is_place else said

    monkeypatch.setattr(singularity_statements, "classify", falsely)
    (failure,) = certify(problem).failures
    assert failure.name.startswith(f"{question}: said of") and said.meaning in failure.detail


@pytest.mark.parametrize("family", ["planar-3r", "elbow-3r"])
def test_that_a_pose_is_singular_is_true_or_false_as_its_rank_says(family: str) -> None:
    answers = set()
    for seed in range(40):
        problem = generate(ProblemId(family, seed, ("true-or-false",)))
        (part,) = problem.parts
        if part.details_as(ConfigurationStatement).statement_kind == "singular":
            assert isinstance(part.answer, Choice)
            assert certify(problem).passed
            answers.add(part.answer.options[part.answer.correct])
        if answers == {"true", "false"}:
            return
    pytest.fail(f"of 40 statements, {answers} only")


@pytest.mark.parametrize(
    ("problem", "conditions", "one_side"),
    sample_for_suite(
        [("orthogonal-3r/219@lengths", 2, False), ("orthogonal-3r/4@full", 1, False), ("planar-2r/3@lengths", 1, True)],
        2,
    ),
)
def test_one_side_of_a_boundary_is_named_only_if_the_lost_direction_has_one(
    problem: str, conditions: int, one_side: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """P on the axis of joint 2 is on the boundary, but reaches both sides of the lost direction there."""
    asked = generate(problem, ["singularity-type"])
    (part,) = asked.parts
    solution = write_solution(asked, part)
    assert part.details_as(KindDetails).singularity_kind == "boundary"
    assert ("to only one side of this point" in solution) == one_side and certify(asked).passed
    assert solution.partition("the Jacobian loses rank")[0].count("= 0") == conditions
    monkeypatch.setattr("qdot.exercises.verify.singularity_statements.is_one_sided", lambda *_: True)
    assert certify(asked).passed == one_side
