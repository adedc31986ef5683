"""Choose random prime fields that contain a root of unity, to evaluate formulas without rounding."""

import secrets
from dataclasses import dataclass

from sympy.ntheory.primetest import mr

from qdot.exercises.common.stream import Stream

ROOT_ORDER = 1440
"""Order of the root of unity, which stands for a rotation by a quarter of a degree. Sums of its powers are the square
roots of 2, 3, 5 and -1."""
PRIME_BITS = 80
"""Primes are chosen between 2^80 and 2^81."""
PRIME_COUNT = 4.5e19
"""A lower bound on the number of primes = 1 (mod 1440) between X = 2^80 and 2X. It is rounded down from 4.8e19.

Let theta(x) be the sum of the logarithms of such primes up to x. Then |theta(x) - x / 384| < x / (160 log x) (Bennett,
Martin, O'Bryant, Rechnitzer, Explicit bounds for primes in arithmetic progressions, Illinois J. Math. 62, 2018). The
number of primes is at least (theta(2X) - theta(X)) / log(2X).
"""

_SMALL_PRIMES = (7, 11, 13, 17, 19, 23, 29, 31, 37, 41)
"""Primes that most composite numbers have as a factor, which is quicker to find than the full test is to run. 2, 3 and
5 are factors of ROOT_ORDER."""
_WITNESSES = (2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41)
"""Bases that prove a number below 3.3e24 prime (Sorenson and Webster, Math. Comp. 86, 2017)."""


@dataclass(frozen=True)
class Field:
    """The integers modulo `prime`, with a `root` of unity of order ROOT_ORDER.

    The prime was chosen at random among `prime_count` primes of `bits` bits.
    """

    prime: int
    root: int
    bits: int = PRIME_BITS
    prime_count: float = PRIME_COUNT

    def raise_root(self, exponent: int) -> int:
        """Return the power of the root of unity, modulo the prime."""
        return pow(self.root, exponent % ROOT_ORDER, self.prime)


def is_prime(number: int) -> bool:
    """Return whether a number below 3.3e24 is prime; the test is exact.

    >>> is_prime(2**61 - 1), is_prime(2**67 - 1)
    (True, False)
    """
    return number in _WITNESSES or mr(number, _WITNESSES)


def choose_field(stream: Stream) -> Field:
    """Return a field with a random prime and root; all primes and all roots are equally likely."""
    low = (1 << PRIME_BITS) // ROOT_ORDER
    while True:
        prime = ROOT_ORDER * (low + 1 + choose_integer_below(stream, low - 1)) + 1
        if all(prime % q for q in _SMALL_PRIMES) and is_prime(prime):
            return Field(prime, _choose_root(prime, stream))


USES_PER_FIELD = 64
"""Number of comparisons that share a field, because finding a prime takes longer than most comparisons."""


class SharedField:
    """A field chosen by the system's random generator, and replaced after USES_PER_FIELD comparisons.

    The bound on the chance of a wrong verdict includes the chance that this choice is unlucky.
    """

    def __init__(self) -> None:
        self._remaining_uses, self._field = 0, Field(0, 0)

    def get(self) -> Field:
        """Return the current field, or a new one if it has been used USES_PER_FIELD times."""
        if self._remaining_uses == 0:
            self._remaining_uses, self._field = USES_PER_FIELD, choose_field(Stream(secrets.token_hex(32)))
        self._remaining_uses -= 1
        return self._field


def _choose_root(prime: int, stream: Stream) -> int:
    """Return a random root of unity of order ROOT_ORDER."""
    while True:
        root = pow(1 + choose_integer_below(stream, prime - 1), (prime - 1) // ROOT_ORDER, prime)
        if all(pow(root, ROOT_ORDER // q, prime) != 1 for q in (2, 3, 5)):
            return root


def choose_integer_below(stream: Stream, limit: int) -> int:
    """Return a random integer from 0 to limit - 1; the numbers are almost equally likely (by a factor of 1 + 2^-40)."""
    return ((stream.integer_below(1 << 63) << 63) | stream.integer_below(1 << 63)) % limit
