"""Whole numbers modulo a random prime, with a root of unity: formulas are evaluated exactly there."""

import secrets
from dataclasses import dataclass

from sympy.ntheory.primetest import mr

from qdot.exercises.common.stream import Stream

ORDER = 1440
"""Order of the root of unity, which stands for a quarter of a degree; it also makes the roots of 2, 3, 5 and -1."""
BITS = 80
"""Primes are chosen between 2^80 and 2^81."""
PRIMES = 4.5e19
"""There are more primes = 1 (mod 1440) than that between X = 2^80 and 2X, namely 4.8e19 or more.

With theta the sum of their logarithms, |theta(x) - x / 384| < x / (160 log x) (Bennett, Martin, O'Bryant, Rechnitzer,
Explicit bounds for primes in arithmetic progressions, Illinois J. Math. 62, 2018), and there are at least
(theta(2X) - theta(X)) / log(2X) of them.
"""

_SMALL = (7, 11, 13, 17, 19, 23, 29, 31, 37, 41)
_WITNESSES = (2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41)
"""Bases that prove a number below 3.3e24 prime (Sorenson and Webster, Math. Comp. 86, 2017)."""


@dataclass(frozen=True)
class Field:
    """The integers modulo `prime`, with a `root` of unity of order ORDER; it is one of `choices` primes."""

    prime: int
    root: int
    bits: int = BITS
    choices: float = PRIMES

    def power(self, exponent: int) -> int:
        """Return that power of the root of unity."""
        return pow(self.root, exponent % ORDER, self.prime)


def is_prime(number: int) -> bool:
    """Tell whether a number below 3.3e24 is prime, for certain.

    >>> [n for n in range(1400, 3000, 1440) if is_prime(n + 41)], is_prime(2**61 - 1), is_prime(2**67 - 1)
    ([], True, False)
    """
    return number in _WITNESSES or mr(number, _WITNESSES)


def draw_field(stream: Stream) -> Field:
    """Return a field with a random prime and root; all primes and all roots have the same chance."""
    low = (1 << BITS) // ORDER
    while True:
        prime = ORDER * (low + 1 + below(stream, low - 1)) + 1
        if all(prime % q for q in _SMALL) and is_prime(prime):
            return Field(prime, _root(prime, stream))


ANSWERS = 64
"""The number of comparisons that share a field, because finding a prime takes longer than most of them."""


class SharedField:
    """A field from the system's randomness, another one after ANSWERS comparisons.

    A verdict depends on it only by the chance that the verdict's bound states.
    """

    def __init__(self) -> None:
        self._left, self._field = 0, Field(0, 0)

    def get(self) -> Field:
        """Return the field."""
        if self._left == 0:
            self._left, self._field = ANSWERS, draw_field(Stream(secrets.token_hex(32)))
        self._left -= 1
        return self._field


def _root(prime: int, stream: Stream) -> int:
    while True:
        root = pow(1 + below(stream, prime - 1), (prime - 1) // ORDER, prime)
        if all(pow(root, ORDER // q, prime) != 1 for q in (2, 3, 5)):
            return root


def below(stream: Stream, limit: int) -> int:
    """Return a whole number from 0 to limit - 1; the chances differ by less than 2^-40 of themselves."""
    return ((stream.below(1 << 63) << 63) | stream.below(1 << 63)) % limit
