"""Generate the random numbers behind every problem from the SHAKE-256 hash of a text.

They are the same on every machine, forever: a hash is a standard, but `random` and `numpy.random` guarantee the same
numbers only for some methods and releases. A stream is always passed as an argument and never stored globally.
"""

import hashlib
import hmac
from collections.abc import Sequence
from typing import TypeVar

T = TypeVar("T")

_BLOCK_SIZE = 1024
"""Number of bytes that are computed at once."""


class Stream:
    """A random number generator whose numbers depend only on the text `seed`.

    >>> Stream("planar-2r/7").integer_below(1000)
    424
    """

    def __init__(self, seed: str) -> None:
        self._seed = seed.encode()
        self._block_number = 0
        self._buffer = b""

    def take_bytes(self, byte_count: int) -> bytes:
        """Return the next `byte_count` bytes."""
        while len(self._buffer) < byte_count:
            block = self._seed + b"\x00" + self._block_number.to_bytes(8, "big")
            self._buffer += hashlib.shake_256(block).digest(_BLOCK_SIZE)
            self._block_number += 1
        chunk, self._buffer = self._buffer[:byte_count], self._buffer[byte_count:]
        return chunk

    def substream(self, name: str) -> "Stream":
        """Return an independent stream with this name; numbers taken from this stream don't change it."""
        return Stream(f"{self._seed.decode()}/{name}")

    def integer_below(self, n: int) -> int:
        """Return an integer from 0 to n - 1, all equally likely (rejection sampling, no modulo bias)."""
        if n < 1:
            raise ValueError(f"integer_below() takes a positive number, not {n}")
        limit = (1 << 64) - (1 << 64) % n
        while True:
            value = int.from_bytes(self.take_bytes(8), "big")
            if value < limit:
                return value % n

    def choice(self, items: Sequence[T]) -> T:
        """Return one of the items, all equally likely."""
        return items[self.integer_below(len(items))]

    def integer(self, low: int, high: int) -> int:
        """Return an integer from `low` to `high`, both included."""
        return low + self.integer_below(high - low + 1)

    def nonzero_integer(self, maximum: int) -> int:
        """Return a nonzero integer from -maximum to maximum, all equally likely."""
        return self.choice([k for k in range(-maximum, maximum + 1) if k])

    def permutation(self, items: Sequence[T]) -> list[T]:
        """Return the items in random order (Fisher-Yates)."""
        shuffled = list(items)
        for i in range(len(shuffled) - 1, 0, -1):
            j = self.integer_below(i + 1)
            shuffled[i], shuffled[j] = shuffled[j], shuffled[i]
        return shuffled

    def uniform(self, low: float, high: float) -> float:
        """Return a number in [low, high), with 53 random bits."""
        unit: float = (int.from_bytes(self.take_bytes(8), "big") >> 11) / (1 << 53)
        return low + (high - low) * unit


def derive_seed(secret: str, *names: str) -> int:
    """Return a 63-bit seed from some names; without the secret, it can't be computed (HMAC-SHA-256).

    The names are joined by a null byte, which no name may contain, so that ("a", "bc") and ("ab", "c") differ.
    """
    digest = hmac.new(secret.encode(), "\x00".join(names).encode(), hashlib.sha256).digest()
    return int.from_bytes(digest[:8], "big") >> 1
