"""Exact comparison: what it decides, and that its error bound holds in sample spaces small enough to show errors."""

from collections.abc import Mapping
from fractions import Fraction
from itertools import count
from math import gcd, inf, log2

import pytest
import sympy as sp

from qdot.exercises.common.stream import Stream
from qdot.exercises.formula import exact, field
from qdot.exercises.formula.angles import MAX_BITS, find_angles
from qdot.exercises.formula.exact import ExactComparison, bound_chance_of_agreement, make_modular_program
from qdot.exercises.formula.field import (
    PRIME_BITS,
    PRIME_COUNT,
    ROOT_ORDER,
    USES_PER_FIELD,
    Field,
    SharedField,
    choose_field,
    choose_integer_below,
    is_prime,
)
from qdot.exercises.formula.parser import parse_formula
from qdot.exercises.formula.program import Program, compile_program
from tests.support import read_cases


def compute_size(program: exact.ModularProgram) -> exact.Size:
    size = program.find_size(0)
    assert size is not None
    return size


def compare(student: str, reference: str, seed: str = "seed", **lengths: Fraction) -> ExactComparison:
    theirs, ours = (compile_program([parse_formula(text)]) for text in (student, reference))
    return exact.compare(theirs, ours, lengths, seed)[0]


@pytest.mark.parametrize("seed", ["one", "two", "three"])
def test_equal_functions_are_equal_in_any_form_and_near_ones_differ(seed: str) -> None:
    for student, reference in read_cases("equal")["same"]:
        judged = compare(student, reference, seed)
        assert judged.is_equal is True and judged.bound < 1e-15, student
    for student, reference in read_cases("equal")["different"]:
        assert compare(student, reference, seed).is_equal is False, student


def test_non_rational_functions_are_undecided() -> None:
    for text in read_cases("equal")["undecided"]:
        assert compare(text, "a1").is_equal is compare("a1", text).is_equal is None, text


@pytest.mark.parametrize(
    ("text", "most"),
    [
        ("x*theta1", 2**MAX_BITS - 1), ("theta1/x", 2**MAX_BITS - 1), ("theta1*x/2 + theta1*x/2", 2**MAX_BITS - 1),
        ("x*theta1 + theta1 - x*theta2", 2**MAX_BITS - 2), ("(x*theta1 + theta2)*x", 2 ** (MAX_BITS // 2) - 1),
    ],
)  # fmt: skip
def test_angle_with_too_long_factor_is_not_accepted(text: str, most: int) -> None:
    """Memory is limited: a factor may have 10,000 bits and no more."""
    program = compile_program([parse_formula(text)])
    for factor, is_angle in ((most, True), (most + 1, False)):
        steps = [("number", (), Fraction(factor)) if step[2] == "x" else step for step in program.steps]
        assert (find_angles(steps)[program.outputs[0]] is not None) is is_angle
    assert MAX_BITS == 10_000


def test_one_difference_decides_and_undefined_reference_decides_nothing() -> None:
    different = compare("a1", "a2")
    assert (different.is_equal, different.point_count) == (False, 1)
    for student in ("a1", "1/(a1 - a1)"):
        assert compare(student, "a1/(a2 - a2)").is_equal is None


def test_given_length_has_its_value() -> None:
    assert compare("a1*cos(theta1)", "7*cos(theta1)/20", a1=Fraction(7, 20)).is_equal is True
    assert compare("a1*cos(theta1)", "cos(theta1)/3", a1=Fraction(7, 20)).is_equal is False
    assert compare("d2*cos(theta1)", "-7*cos(theta1)/20", d2=Fraction(-7, 20)).is_equal is True
    assert compare("cos(a1)", "cos(a1)", a1=Fraction(7, 20)).is_equal is None


def test_field_contains_the_roots_of_unity() -> None:
    for seed in range(5):
        field = choose_field(Stream(f"field/{seed}"))
        assert 2**PRIME_BITS < field.prime < 2 ** (PRIME_BITS + 1)
        assert sp.isprime(field.prime)
        assert len({field.raise_root(k) for k in range(ROOT_ORDER)}) == ROOT_ORDER
        assert field.raise_root(720) == field.prime - 1


def test_primality_test_is_correct() -> None:
    assert [n for n in range(3000) if is_prime(n)] == list(sp.primerange(3000))
    strong = [3215031751, 3474749660383, 341550071728321, 3825123056546413051, 318665857834031151167461]
    assert not any(is_prime(n) for n in strong)  # composite numbers that pass the first witnesses


@pytest.mark.parametrize("highest", [False, True])
def test_prime_is_valid_at_both_ends_of_the_range(highest: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """Numbers counted up from the lowest, or down from the highest, replace random ones."""
    samples = count()
    monkeypatch.setattr(
        field, "choose_integer_below", lambda _, limit: limit - 1 - next(samples) if highest else next(samples)
    )
    chosen = choose_field(Stream("none"))
    first = 2**PRIME_BITS // ROOT_ORDER * ROOT_ORDER + ROOT_ORDER + 1
    last = 2 ** (PRIME_BITS + 1) // ROOT_ORDER * ROOT_ORDER + 1
    candidates = range(last, 0, -ROOT_ORDER) if highest else range(first, 2**82, ROOT_ORDER)
    assert chosen.prime == next(n for n in candidates if sp.isprime(n))
    assert len({chosen.raise_root(k) for k in range(ROOT_ORDER)}) == ROOT_ORDER


def test_root_of_unity_has_full_order(monkeypatch: pytest.MonkeyPatch) -> None:
    left, samples = [1440 * 7 - 1, 0, 1], count(2)
    monkeypatch.setattr(
        field, "choose_integer_below", lambda _, limit: min(left.pop(), limit - 1) if left else next(samples)
    )
    root = field._choose_root(SMALL[-1], Stream("none"))
    assert pow(root, ROOT_ORDER, SMALL[-1]) == 1
    assert all(pow(root, ROOT_ORDER // q, SMALL[-1]) != 1 for q in (2, 3, 5))


def test_long_random_number_combines_two_short_ones() -> None:
    class Two(Stream):
        def integer_below(self, limit: int) -> int:
            assert limit == 2**63
            return samples.pop(0)

    samples = [5, 7, 5, 7]
    assert choose_integer_below(Two("none"), 2**126) == 5 * 2**63 + 7
    assert choose_integer_below(Two("none"), 1000) == (5 * 2**63 + 7) % 1000


def test_shared_field_changes_after_a_number_of_uses() -> None:
    shared = SharedField()
    fields = [shared.get() for _ in range(2 * USES_PER_FIELD + 1)]
    changes = [k for k, shared_field in enumerate(fields) if shared_field is not fields[k - 1]]
    assert changes == [0, USES_PER_FIELD, 2 * USES_PER_FIELD]
    assert len({shared_field.prime for shared_field in fields}) == 3
    assert SharedField().get() != SharedField().get()


SMALL = [n for n in range(1, 2**16, ROOT_ORDER) if sp.isprime(n)]


def choose_small_field(stream: Stream) -> Field:
    prime = stream.choice(SMALL)
    root = next(
        r for k in range(2, 200)
        if len({pow(r := pow(k, (prime - 1) // ROOT_ORDER, prime), ROOT_ORDER // q, prime) for q in (2, 3, 5)}
               & {1}) == 0
    )  # fmt: skip
    turn = stream.choice([k for k in range(ROOT_ORDER) if gcd(k, ROOT_ORDER) == 1])
    return Field(prime, pow(root, turn, prime), int(log2(min(SMALL))), len(SMALL))


def compute_acceptance_rate(student: str, trials: int) -> float:
    theirs, ours = compile_program([parse_formula(student)]), compile_program([parse_formula("0")])
    seen = [exact.compare(theirs, ours, {}, f"trial/{k}", choose_small_field)[0].is_equal for k in range(trials)]
    return seen.count(True) / trials


def predict_acceptance_rate(student: str) -> float:
    program = make_modular_program(compile_program([parse_formula(student)]), {})
    return bound_chance_of_agreement(compute_size(program), exact.Size(0.0, 0.0), int(log2(min(SMALL))), len(SMALL))


@pytest.fixture
def one_point(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(exact, "MAX_ERROR_CHANCE", 1.0)


HALF = "*".join(map(str, SMALL[: len(SMALL) // 2]))
RATES = [
    # 720 zeros modulo each prime, as p - 1 is a multiple of 720: the maximum of the theorem
    ("a1^720 - 1", sum(720 / (prime - 1) for prime in SMALL) / len(SMALL)),
    (HALF, (len(SMALL) // 2) / len(SMALL)),  # half of the primes divide this number
    # in w = exp(i theta / 8): degree 48, minus the extracted powers of w
    ("cos(theta1) - cos(3*theta1)", None),
]


@pytest.mark.usefixtures("one_point")
@pytest.mark.parametrize(("student", "rate"), RATES, ids=["degree", "height", "sines"])
def test_error_rate_is_that_predicted_by_degree_and_height(student: str, rate: float | None) -> None:
    trials = 2000
    part = compute_acceptance_rate(student, trials)
    assert 0 < part <= predict_acceptance_rate(student) + 4 * ((rate or 0.01) / trials) ** 0.5
    assert rate is None or abs(part - rate) < 4 * (rate / trials) ** 0.5


def test_number_of_points_meets_the_error_bound() -> None:
    """A height of h bits excludes h / 80 of 4.5e19 primes: three million bits give 8e-16, five million 1.4e-15."""
    for power, points in ((3, 1), (5, 2)):
        comparison = compare(f"(((a1 + a2)^1000)^1000)^{power}", f"(((a2 + a1)^1000)^1000)^{power}")
        assert (comparison.is_equal, comparison.point_count) == (True, points)
        assert comparison.bound < 1e-15
        assert points == 2 or comparison.bound == pytest.approx(3e6 / 80 / PRIME_COUNT, rel=1e-4)


def test_every_further_point_uses_a_new_field(monkeypatch: pytest.MonkeyPatch) -> None:
    samples: list[Field] = []

    def record_field(stream: Stream) -> Field:
        samples.append(choose_field(stream))
        return samples[-1]

    monkeypatch.setattr(exact, "choose_field", record_field)
    assert compare("a1", "a1").is_equal is True
    assert not samples  # the first is shared with other comparisons
    high = "((((({})^1000)^1000)^1000)^1000)^200"
    comparison = compare(high.format("a1 + a2"), high.format("a2 + a1"))
    assert comparison.point_count == 3
    assert len({field.prime for field in samples}) == 2


@pytest.mark.usefixtures("one_point")
def test_undefined_point_does_not_make_an_answer_wrong() -> None:
    """Numerator and denominator share 720 zeros, which random points of a small field often hit."""
    theirs, ours = (compile_program([parse_formula(text)]) for text in ("a1*(a1^720 - 1)/(a1^720 - 1)", "a1"))
    comparisons = [exact.compare(theirs, ours, {}, f"trial/{k}", choose_small_field)[0] for k in range(300)]
    assert {result.is_equal for result in comparisons} == {True}


def test_degree_and_height_bound_those_of_the_polynomials() -> None:
    """Compare the bounds with numerator and denominator of the uncancelled fraction."""
    x, y = sp.symbols("a1 a2")
    for text in ("(a1 + 2*a2)^3/(a1 - a2) - 3/7*a1", "a1/(a2 + 1/a1) + 5*a2/3", "(a1 - 1/a2)^-2*(a1 + 10)"):
        program = make_modular_program(compile_program([parse_formula(text)]), {})
        above, below = sp.fraction(sp.cancel(sp.sympify(text.replace("^", "**"), locals={"a1": x, "a2": y})))
        size = compute_size(program)
        assert size[0] >= sp.Poly(above, x, y).total_degree()
        assert size[2] >= sp.Poly(below, x, y).total_degree()
        assert size[1] >= log2(sum(abs(c) for c in sp.Poly(above, x, y).coeffs())) - 1e-9
        assert size[3] >= log2(sum(abs(c) for c in sp.Poly(below, x, y).coeffs())) - 1e-9


def test_prime_count_is_a_lower_bound() -> None:
    """Check it with the theorem named in the module, from the sum of the primes' logarithms."""
    low, high = sp.Float(2**PRIME_BITS), sp.Float(2 ** (PRIME_BITS + 1))
    least = (high - low) / 384 - sum(x / (160 * sp.log(x)) for x in (low, high))
    assert least / sp.log(high) >= PRIME_COUNT
    assert sp.totient(ROOT_ORDER) == 384


SIZES = [
    ("a1", 1, 0, 0, 0), ("0", 0, -inf, 0, 0), ("I", 0, 0, 0, 0), ("a1^0", 0, 0, 0, 0), ("a1^-1", 0, 0, 1, 0),
    ("6*a1/5", 1, log2(6), 0, log2(5)), ("-a1/7", 1, 0, 0, log2(7)), ("a1*a2/(3*a3)", 2, 0, 1, log2(3)),
    ("a1 + a1 + a1", 1, log2(3), 0, 0), ("1/3 - a1/7 - a1/7", 1, log2(7) + 1, 0, log2(21)),
    ("1/a1 + 1/a2", 2, 1, 2, 0), ("a1/(a1 + 1) + a2^2/a3", 3, 2, 2, 1), ("a1^3 + a2/8", 3, 3 + 2**-2, 0, 3),
    ("(2/3*a1)^3", 3, 3, 0, 3 * log2(3)), ("(2/3*a1)^-3", 0, 3 * log2(3), 3, 3),
    ("sin(theta1)", 16, 1, 8, 1), ("cos(theta1 + 2*theta2)", 48, 1, 24, 1), ("tan(theta1/2)", 8, 1, 8, 1),
    ("cot(theta1)", 16, 1, 16, 1), ("sec(theta1)", 8, 1, 16, 1), ("csc(-theta1)", 8, 1, 16, 1),
    ("exp(I*theta1)", 8, 0, 8, 0), ("sqrt(8/9)", 0, 1 + 3, 0, log2(3)), ("sqrt(6)", 0, 6, 0, 0),
]  # fmt: skip


@pytest.mark.parametrize(("text", "degree", "height", "degree_below", "height_below"), SIZES)
def test_size_is_computed_from_the_formula(
    text: str, degree: float, height: float, degree_below: float, height_below: float
) -> None:
    """A sine is (w^16 - 1) / (2 i w^8); a root of 2, 3 or 5 counts 3 bits, for at most eight powers of the root."""
    program = make_modular_program(compile_program([parse_formula(text)]), {})
    assert compute_size(program) == pytest.approx((degree, height, degree_below, height_below), abs=1e-12)


def test_error_chance_follows_from_degree_and_height() -> None:
    """5 of 2^10 points, and 7.5 bits in primes of 10 bits, of which there are 100."""
    size, bound = exact.Size, bound_chance_of_agreement
    assert bound(size(3, 4, 0, 2), size(1, 5, 2, 1), 10, 100) == pytest.approx(5 / 2**10 + 7.5 / 10 / 100)
    assert bound(size(0, 4, 2, 1), size(3, 5, 0, 2), 10, 100) == pytest.approx(5 / 2**10 + 7 / 10 / 100)
    assert bound(size(0, -inf), size(0, -inf)) == 0 and bound(size(2.0**90, 0), size(0, 0)) == 1


def test_identical_programs_are_compiled_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """This happens for every part of a certified problem; two programs agree on the verdict."""
    text = "a1*sin(theta1)/(a2 + cos(theta2))"
    program, equal_program = (compile_program([parse_formula(text)]) for _ in range(2))
    made: list[object] = []
    original = make_modular_program

    def record_program(program: Program, fixed: Mapping[str, Fraction | None]) -> exact.ModularProgram:
        made.append(program)
        return original(program, fixed)

    monkeypatch.setattr(exact, "make_modular_program", record_program)
    (same,) = exact.compare(program, equal_program, {}, "seed")
    assert made == [program]
    (typed,) = exact.compare(compile_program([parse_formula(f"0 + {text}")]), program, {}, "seed")
    assert len(made) == 3
    assert (same.is_equal, same.point_count) == (typed.is_equal, typed.point_count) == (True, 1)
