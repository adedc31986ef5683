"""The forms in which answers are asked for: whoever treats them differently has a way for each.

A type of answer tells which form it is of (`Answer.told_to`); the ways that are alike are written once, in `formulas`,
`letters` or `other`.
"""

from typing import Any, Generic, NoReturn, TypeVar

T = TypeVar("T")


class Forms(Generic[T]):
    """A way for each form of answer, each given the answer; where one is not written, it is that of a wider form."""

    def formula(self, answer: Any) -> T:
        """Take one formula."""
        return self.formulas(answer)

    def matrix(self, answer: Any) -> T:
        """Take a matrix of formulas, or a vector."""
        return self.formulas(answer)

    def formulas(self, answer: Any) -> T:
        """Take formulas, one or in rows and columns."""
        return self.other(answer)

    def direction(self, answer: Any) -> T:
        """Take a vector up to a factor."""
        return self.other(answer)

    def numbers(self, answer: Any) -> T:
        """Take numbers with units."""
        return self.other(answer)

    def conditions(self, answer: Any) -> T:
        """Take conditions on the joints."""
        return self.other(answer)

    def one_of(self, answer: Any) -> T:
        """Take one of several options."""
        return self.letters(answer)

    def some_of(self, answer: Any) -> T:
        """Take several options."""
        return self.letters(answer)

    def matching(self, answer: Any) -> T:
        """Take an option for each item."""
        return self.letters(answer)

    def letters(self, answer: Any) -> T:
        """Take letters of options, whatever they stand for."""
        return self.other(answer)

    def other(self, answer: Any) -> T:
        """Take whatever has no way of its own."""
        return self._none(answer)

    def _none(self, answer: Any) -> NoReturn:
        raise TypeError(f"{type(self).__name__} has no way for answers of type {answer.type}")
