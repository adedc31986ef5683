"""The site's bank: which problems it has, and keys: right values, by a second route, and each mistake's are wrong."""

import json
import re
from collections import Counter
from itertools import product
from typing import Any

import numpy as np
import pytest
import sympy as sp

from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.variation import VARIATION_STEPS
from qdot.exercises.derivation.derivation import derive
from qdot.exercises.derivation.graph import compute_numeric_stages
from qdot.exercises.families import FAMILIES
from qdot.exercises.generation import find_listing, generate, sample_chain, select_quiz_questions
from qdot.exercises.problem.problem import Part, Problem, ProblemId
from qdot.exercises.questions.results import comes_from_stages, compute_answer
from qdot.exercises.reference_answers import Choice, Matching, Number, Selection
from qdot.exercises.site.bank_problem import (
    ARMS_PER_QUESTION,
    ARMS_PER_STEP,
    QUIZ,
    BankProblem,
    deal_questions,
    find_questions_with_sampled_numbers,
    list_problems_of_families,
)
from qdot.exercises.site.keys import _evaluate_derivation, _find_derived_question, compute_weight, make_key
from qdot.exercises.site.record import (
    _find_given_pose,
    _list_labels,
    find_mentioned_names,
    list_determinant_factors,
    make_arm_record,
    make_asked_record,
    make_site_record,
    make_solutions_record,
    translate_record,
)
from qdot.exercises.writing.latex import tex
from qdot.exercises.writing.problem_texts import write_prompt
from tests.support import ROOT
from tests.support.problems import get_problem, select_parts
from tests.support.suites import WHOLE, few_families, sample_for_suite, select_for_suite


@few_families
def test_keys_hold_what_the_derivation_in_numbers_gives(family: str) -> None:
    problem = get_problem(family, 0)
    for part in select_parts(problem):
        if isinstance(part.answer, Number) and problem.chain.n >= 6 and not WHOLE:
            continue  # what mistakes give in numbers takes seconds, and nothing but their form is looked at here
        key = make_key(problem, part)
        json.dumps(key, allow_nan=False)
        if key["type"] == "values" and comes_from_stages(part):
            _values_are_right(problem, part, key)
        if key["type"] == "configurations":
            _poses_are_singular(problem, key)
        if key["type"] in ("choice", "selection", "matching"):
            assert len(key["option_mistakes"]) == key["options"] > max(key["right"])


def test_a_prompt_says_in_which_rates_an_answer_is_and_what_rows_and_columns_belong_to(family: str) -> None:
    """A page offers signs of those alone."""
    problem = get_problem(family, 0)
    spoken = {name for name, info in problem.symbols.items() if info.role in ("rate", "velocity", "force", "moment")}
    for part in problem.parts:
        if not isinstance(part.answer, (Choice, Selection, Matching)):
            used = set(re.findall(r"\w+", json.dumps(part.answer.as_json()))) & spoken
            assert used <= set(find_mentioned_names(problem, write_prompt(problem, part))), part.name
    for part in problem.parts:
        plain, grid = re.sub(r"[{}]", "", write_prompt(problem, part)), _list_labels(problem.chain, part)
        for lines, count, order in zip(grid, part.shape or (1, 1), ("rows", "columns"), strict=True):
            assert len(lines) in (0, count), (part.name, order)
            named = re.search(rf"{order} in the order \$([^$]*)\$", plain)
            if named:
                assert named[1].split(", ") == [re.sub(r"[{}]", "", line) for line in lines], (part.name, order)
        if part.shape and part.shape[1] > 1 and "column $i$ belongs to joint $i$" in plain:
            assert grid[1] == [tex(rate, problem.chain) for rate in problem.chain.rates[: part.shape[1]]]


def _values_are_right(problem: Problem, part: Part, key: dict[str, Any]) -> None:
    values = {name: np.array(column) for name, column in zip(key["symbols"], np.array(key["points"]).T, strict=True)}
    found = compute_answer(compute_numeric_stages(problem.chain, values), part).reshape(len(key["right"]), -1)
    right = np.array(key["right"], dtype=float)
    scale = np.abs(right).max(axis=0)
    assert (np.abs(found - right) <= 1e-9 * (np.abs(right) + scale)).all(), part.name
    total = sum(compute_weight(i) * entry for i, entry in enumerate(right))
    for mistake in key["mistakes"]:
        apart = [abs(a - b) > 3e-5 * abs(b) for a, b in zip(mistake["print"], total, strict=False)]
        assert any(apart), (part.name, mistake)


def _poses_are_singular(problem: Problem, key: dict[str, Any]) -> None:
    for piece in key["pieces"]:
        assert piece
        for pose in piece:
            values = dict(zip(key["symbols"], pose, strict=True))
            lengths = {name: value for name, value in values.items() if name not in key["joints"]}
            chain = NumericChain(problem.chain, lengths)
            rows = [["vx", "vy", "vz", "wx", "wy", "wz"].index(row) for row in problem.chain.task]
            jacobian = chain.compute_jacobian(np.array([values[name] for name in key["joints"]]))[rows]
            singular = np.linalg.svd(jacobian)[1]
            assert singular[-1] < 1e-5 * max(1.0, singular[0])


def test_mistakes_are_told_and_none_of_them_is_right() -> None:
    """Also what people do most, though it comes late in the catalogue, and those that no derivation makes."""
    problem = generate(ProblemId("elbow-3r", 1, ("jacobian", "joint-rates"), variation="chapter"))
    jacobian, rates = ({mistake["name"] for mistake in make_key(problem, part)["mistakes"]} for part in problem.parts)
    assert {"transposed", "cross-order"} <= jacobian
    assert {"rates-in-degrees", "degrees-as-radians", "degrees", "transpose-for-inverse"} <= rates
    asked = ("jacobian-size", "joint-rates", "path-rates", "rank", "manipulability", "determinant-value", "speed")
    problem = generate(ProblemId("planar-2r", 1, asked, variation="chapter"))
    told: dict[str, set[str]] = {}
    for part in problem.parts:
        key = make_key(problem, part)
        told[part.kind] = {mistake["name"] for mistake in key["mistakes"]}
        for mistake in key["mistakes"]:
            assert len(mistake["values"]) == len(key["right"])
            assert not np.allclose(mistake["values"], key["right"], rtol=1e-4, atol=0.0), mistake
    assert told["jacobian-size"] >= {"size-six-rows"} and told["rank"] >= {"rank-full"}
    assert told["path-rates"] >= {"rates-at-start", "path-reversed", "degrees", "rates-in-degrees"}
    assert {"row-misread", "product-sign", "determinant-sign"} <= told["joint-rates"]
    assert {"determinant-sign", "degrees-as-radians", "degrees"} <= told["determinant-value"]
    assert {"components-added", "component-alone", "speed-squared"} <= told["speed"]
    assert "degrees-as-radians" in told["speed"] and "rates-in-degrees" not in told["speed"]


def test_of_a_factor_and_of_lengths_that_are_missing_it_is_told_which() -> None:
    problem = generate(ProblemId("elbow-3r", 1, ("determinant", "inverse-velocity"), variation="chapter"))
    record = make_site_record(problem)
    lost = {row[3] for row in record["said"] if row[0] == "factor-lost"}
    assert {"a2", "a3", "theta3", "theta2, theta3"} <= lost
    determinant, rates = (part["key"] for part in record["parts"])
    everywhere = [record["said"][index] for index, *_ in rates["throughout"]]
    assert [row[3] for row in everywhere if row[0] == "lengths-missing"] == ["a1, a2, a3", "a1", "a2", "a3"]
    assert len({tuple(values) for _, *values in rates["throughout"]}) == len(rates["throughout"])
    assert "linear" not in determinant
    german = translate_record(problem, record, "de")["said"]
    assert [row[3:] for row in german] == [row[3:] for row in record["said"]]
    assert any(row[2].startswith("In deiner Antwort: ") for row in german)


def test_what_mistakes_make_of_a_direction_is_told_up_to_a_factor() -> None:
    """At the configurations of the key, with the joints where the question has them."""
    problem = generate(ProblemId("planar-2r", 1, ("lost-direction",), variation="chapter"))
    (key,) = (make_key(problem, part) for part in problem.parts)
    prints = {mistake["name"]: mistake["print"] for mistake in key["mistakes"]}
    for k, (one, other) in enumerate(zip(*key["right"], strict=True)):
        if k < len(prints["direction-that-moves"]):
            moves = abs(-other + compute_weight(1) * one) / np.hypot(one, other)
            assert prints["direction-that-moves"][k] == pytest.approx(moves, rel=1e-4)
    assert all(len(set(values)) > 1 for values in prints.values())


def test_a_key_tells_what_velocities_are_multiplied_by() -> None:
    problem = generate(ProblemId("planar-2r", 1, ("inverse-velocity",), variation="chapter"))
    (key,) = (make_key(problem, part) for part in problem.parts)
    assert set(key["linear"]) == {"vx", "vy"}
    for k in range(len(key["linear"]["vx"][0])):
        at = dict(zip(key["symbols"], key["points"][k], strict=True))
        for i, due in enumerate(key["right"]):
            given = sum(factors[i][k] * at[name] for name, factors in key["linear"].items())
            assert given == pytest.approx(due[k], rel=1e-4)


def test_behind_a_single_number_of_many_digits_more_mistakes_are_told() -> None:
    problem = generate(ProblemId("elbow-3r", 1, ("joint-rates", "manipulability", "speed"), variation="chapter"))
    rates, measure, speed = (make_key(problem, part) for part in problem.parts)
    assert "precise" not in rates
    for key in (measure, speed):
        assert len(key["precise"]) > 20
        assert not {tuple(one["values"]) for one in key["precise"]} & {tuple(one["values"]) for one in key["mistakes"]}
    assert {"sine-for-cosine", "link-left-out"} <= {one["name"] for one in speed["precise"]}
    kept = make_site_record(problem)["parts"][1]["key"]["precise"]
    assert all(isinstance(index, int) for index, _ in kept)


@pytest.mark.parametrize("name", ["determinant-value", "speed"])
def test_a_short_question_in_numbers_is_worked_out_as_the_chapters(name: str) -> None:
    """With no mistake in it, the derivation gives its answer."""
    problem = generate(ProblemId("elbow-3r", 1, (name,)))
    (part,) = problem.parts
    derived, of_answer = _find_derived_question(part)
    assert derived is not None
    right = of_answer(compute_answer(_evaluate_derivation(problem, part), derived)).tolist()
    assert right == pytest.approx([float(value) for value in part.answer.as_matrix()])


def test_the_page_knows_the_steps_in_their_order() -> None:
    text = (ROOT / "site" / "src" / "practice" / "choice.ts").read_text(encoding="utf-8")
    assert f"export const VARIATION_STEPS = {json.dumps(list(VARIATION_STEPS))} as const;" in text


@few_families
def test_a_record_for_a_server_has_the_form_of_each_answer_but_no_value(family: str) -> None:
    problem = get_problem(family, 0)
    english, german = make_asked_record(problem, has_hints=True), make_asked_record(problem, False, "de")
    assert "said" not in english and "lang" not in english and german["lang"] == "de"
    assert german["title"] == german["robot"]["title"] != english["title"]
    shown = {part["name"]: part for part in english["parts"]}
    for part in {part.type: part for part in select_parts(problem)}.values():
        key = make_key(problem, part, with_mistakes=False)
        form = {"type": key["type"], "units": key.get("units", []), "items": key.get("items", 0)}
        assert shown[part.name]["key"] == form
    assert any(part["hints"] for part in english["parts"])
    assert not any(part["hints"] for part in german["parts"])
    for part, translated in zip(english["parts"], german["parts"], strict=True):
        assert translated["prompt"] != part["prompt"] and translated["key"] == part["key"]


def test_a_record_says_what_a_page_needs() -> None:
    problem = generate(ProblemId("planar-2r", 7, ("position", "jacobian", "singular-angles")))
    record = make_site_record(problem)
    assert record == make_site_record(problem)
    assert "<math" in record["statement"] and 'class="tex"' not in record["statement"]
    assert 'class="tex"' in record["parts"][0]["hints"][0]
    assert [part["names"] for part in record["parts"]] == [[], [], []]
    assert "$" not in record["statement"]
    assert record["robot"]["joints"][0]["kind"] == "R"
    named = [mistake for part in record["parts"][:2] for mistake in part["key"]["mistakes"]]
    assert named and all(len(record["said"][mistake[0]]) in (3, 4) for mistake in named)
    position = record["parts"][0]["key"]
    assert len(position["points"]) == 16 and (position["rows"], position["columns"]) == (2, 1)
    text = json.dumps(record["parts"][1]["key"])
    assert "sin" not in text and "theta1*" not in text  # numbers, no formula
    solved = make_solutions_record(problem)
    assert "factors" in solved and "factors" not in record
    assert [part["name"] for part in solved["parts"]] == ["position", "jacobian", "singular-angles"]
    assert solved["parts"][2]["figure"].startswith("<svg")
    assert 'class="tex"' in solved["parts"][0]["solution"]


LENGTH = re.compile(r"([ad])_\{(\d)\} = (-?[\d.]+)\\,\\text\{m\}")
ANGLE = re.compile(r"\\theta_\{(\d)\} = (-?[\d.]+)\^\\circ")


@pytest.mark.parametrize("family", ["planar-2r", "polar-rp", "elbow", "scara"])
@pytest.mark.parametrize("quiz", [False, True])
def test_the_arm_beside_a_question_has_the_numbers_of_its_text(family: str, quiz: bool) -> None:
    asked = select_quiz_questions(family, "") if quiz else tuple(set(find_listing(family).questions) & set(GIVEN))
    problem = generate(ProblemId(family, 1, asked))
    found = 0
    for part in problem.parts:
        if part.kind in OF_ALL_POSES:
            continue
        pose = _find_given_pose(problem.chain, part)
        text = write_prompt(problem, part).split("- **A.**")[0]
        said = {f"{letter}{index}": float(value) for letter, index, value in LENGTH.findall(text)}
        said |= {f"theta{index}": np.radians(float(value)) for index, value in ANGLE.findall(text)}
        assert not said or pose == pytest.approx(said | (pose or {}), abs=1e-4), part.kind
        found += len(said)
    assert found > 3


GIVEN = ["joint-effect", "joint-rates", "path-rates", "rank", "singularity-type"]
OF_ALL_POSES = ["singularity-meaning"]
"""The questions about all configurations with a joint at a value, not about a single configuration."""


def test_a_letter_is_drawn_with_no_length_of_the_table() -> None:
    for variation, seed in product(VARIATION_STEPS, range(1, 9)):
        problem = generate(ProblemId("planar-2r", seed, ("position",), variation=variation))
        values = {round(value, 6) for value in make_arm_record(problem)["robot"]["values"].values()}
        lengths = {length for joint in problem.chain.joints for length in (joint.a, joint.d) if length.is_number}
        assert not values & {round(float(length), 6) for length in lengths}, (variation, seed)


@pytest.mark.parametrize("family", ["planar-2r", "elbow-3r", "polar-rp"])
def test_the_factors_of_a_record_make_up_its_determinant(family: str) -> None:
    chain = generate(ProblemId(family, 3, ("position",))).chain
    names = {str(symbol): symbol for symbol in (*chain.q, *chain.parameters)}
    factors = [sp.sympify(typed, names) for _, typed in list_determinant_factors(chain)]
    determinant = derive(chain).jacobian.det()
    quotient = determinant / sp.Mul(*factors)
    letters = {symbol: 0.3 + 0.1 * k for k, symbol in enumerate(sorted(chain.parameters, key=str))}
    values = {quotient.subs({**letters, **dict.fromkeys(chain.q, at)}).evalf(12) for at in (0.7, 1.9)}
    assert max(values) - min(values) < 1e-9
    assert factors


def test_an_arm_without_determinant_has_no_factors() -> None:
    assert list_determinant_factors(generate(ProblemId("planar-3r", 7, ("position",))).chain) == []


ALL = ARMS_PER_STEP * len(VARIATION_STEPS)


def arms(family: str, variants: int) -> list[BankProblem]:
    return [wanted for wanted in list_problems_of_families([family], variants) if wanted.questions != (QUIZ,)]


@pytest.mark.whole
def test_family_has_so_many_arms_at_every_step() -> None:
    wanted = list_problems_of_families(list(FAMILIES), ALL)
    assert len({(one.family, one.key) for one in wanted}) == len(wanted)
    counts = Counter((one.family, one.variation) for one in wanted if one.questions != (QUIZ,))
    assert counts == {(family, step): ARMS_PER_STEP for family in FAMILIES for step in VARIATION_STEPS}


@few_families
def test_arms_of_a_step_differ_and_every_question_comes_with_several_of_them(family: str) -> None:
    if FAMILIES[family].has_varied_structure:
        pytest.skip("its arms have structures of their own, which are drawn as they are made")
    wanted = arms(family, ALL)
    for step in VARIATION_STEPS:
        of_step = [one for one in wanted if one.variation == step]
        fresh = [one for one in of_step if one.question_share is None]
        chains = {sample_chain(ProblemId(family, one.seed, variation=step)) for one in fresh}
        assert len(chains) == len(fresh)
        assert fresh[0].questions == ()
        others = Counter(name for one in fresh[1:] for name in one.questions)
        assert others == dict.fromkeys(
            find_listing(family).questions if fresh[1:] else (), min(ARMS_PER_QUESTION, len(fresh) - 1)
        )
        again = [one for one in of_step if one.question_share is not None]
        assert {sample_chain(ProblemId(family, one.seed, variation=step)) for one in again} <= chains
    assert len([one for one in wanted if one.variation == "full" and one.question_share is None]) == ARMS_PER_STEP


def test_few_arms_are_asked_everything() -> None:
    assert [one.variation for one in arms("scara", 6)] == [*VARIATION_STEPS, "chapter"]
    assert {one.variation for one in list_problems_of_families(["scara"], 3, "base+lengths")} == {"lengths+base"}
    everything = find_listing("scara").questions
    several = arms("scara", len(VARIATION_STEPS) * (1 + ARMS_PER_QUESTION))
    asked = {one.questions for one in several if one.question_share is None}
    assert asked <= {(), everything}
    assert len(arms("scara", 3)) == 3


@pytest.mark.families(select_for_suite(("polar-rp", "wrist-zyz"), tuple(FAMILIES)), every=True)
def test_an_arm_that_is_there_already_is_asked_what_comes_in_other_numbers(family: str) -> None:
    if FAMILIES[family].has_varied_structure:
        pytest.skip("its arms are never there already")
    names = find_questions_with_sampled_numbers(family)
    assert names and "position" not in names and "determinant" not in names
    assert set(names) < set(find_listing(family).questions)
    again = [one for one in arms(family, ALL) if one.variation == "chapter" and one.question_share is not None]
    assert len(again) == ARMS_PER_STEP - 1
    asked = Counter(name for one in again for name in deal_questions(names, *(one.question_share or (0, 1))))
    assert set(asked) == set(names) and min(asked.values()) >= ARMS_PER_QUESTION
    first = generate(ProblemId(family, 1, names, variation="chapter"))
    told: dict[str, set[str]] = {name: set() for name in names}
    for seed in (one.seed for one in again):
        left = tuple(name for name in names if len(told[name]) < 2)
        if left:
            other = generate(ProblemId(family, seed, left, variation="chapter"))
            assert other.chain == first.chain
            for part in other.parts:
                told[part.name].add(repr((part.answer.as_json(), part.details)))
    assert all(len(ways) > 1 for ways in told.values()), told


def test_questions_are_dealt_evenly() -> None:
    for count, places in product(range(1, 31), (1, 2, 3, 4, 24, 100)):
        names = [f"q{i}" for i in range(count)]
        hands = [deal_questions(names, place, places) for place in range(places)]
        assert all(hands) and all(list(hand) == sorted(hand, key=names.index) for hand in hands)
        counts = Counter(name for hand in hands for name in hand)
        assert set(counts) == set(names), (count, places)
        assert max(counts.values()) - min(counts.values()) <= 1, (count, places)
        assert min(counts.values()) >= min(ARMS_PER_QUESTION, places), (count, places)


TOLD = [
    ("screws", "", ("screws", "")), ("", "v-omega", ("screws", "v-omega")),
    ("modified-dh", "", ("modified-dh", "")), ("dh", "", ("", "")),
]  # fmt: skip


@pytest.mark.parametrize(("convention", "twist_order", "told"), sample_for_suite(TOLD, 2))
def test_a_site_is_told_in_a_convention_throughout(convention: str, twist_order: str, told: tuple[str, str]) -> None:
    wanted = list_problems_of_families(["planar-2r"], ALL, "", convention, twist_order)
    usual = list_problems_of_families(["planar-2r"], ALL)
    assert [(o.key, o.seed, o.variation) for o in wanted] == [(o.key, o.seed, o.variation) for o in usual]
    assert {one.frame_convention for one in wanted} == {told}
    first, quiz, shared = (
        next(one for one in wanted if one.questions == asked and bool(one.question_share) == is_shared)
        for asked, is_shared in (((), False), ((QUIZ,), False), ((), True))
    )
    for one in (first, quiz, shared):
        made = one.generate()
        assert (made.id.convention, made.id.twist_order) == told
        assert made.chain.convention == (told[0] or "dh")
        assert made.chain.twist_order == (told[1] or "omega-v")
        assert made.parts
    asked = {part.name for part in first.generate().parts}
    assert ("space-jacobian" in asked) == (told[0] == "screws")


def test_every_question_of_a_convention_comes_with_several_arms() -> None:
    of_step = [one for one in list_problems_of_families(["planar-3r"], ALL, "", "screws") if one.variation == "full"]
    others = Counter(name for one in of_step if one.question_share is None for name in one.questions if name != QUIZ)
    assert others == dict.fromkeys(find_listing("planar-3r", "screws").questions, ARMS_PER_QUESTION)
    assert "body-jacobian" in others


def test_an_order_of_twists_beside_a_table_is_refused() -> None:
    with pytest.raises(QdotError, match="order of twists"):
        list_problems_of_families(["planar-2r"], 1, "", "modified-dh", "v-omega")
    with pytest.raises(QdotError, match="'srews'"):
        list_problems_of_families(["planar-2r"], 1, "", "srews")
