"""Answers as a browser submits them to PrairieLearn's elements for options, matching and numbers."""

from typing import Any

from qdot.exercises.exports.prairielearn import list_input_names
from qdot.exercises.problem.problem import Part
from qdot.exercises.reference_answers import (
    LETTERS,
    TRUE_FALSE,
    Answer,
    AnswerVisitor,
    Letters,
    Matching,
    Number,
    Selection,
)

Data = dict[str, Any]


def fill_form(part: Part, text: str, params: Data) -> Data:
    """Return the form data for an answer that is typed as `text` on other platforms; letters stand for options."""
    return _FormFiller(part, text, params).visit(part.answer)


def leave_blank(part: Part) -> Data:
    """Return the form data for an unanswered part; boxes that are not ticked send nothing."""
    if part.answer.offered_options and not part.answer.matched_items:
        return {}
    return dict.fromkeys(list_input_names(part), "-1" if part.answer.matched_items else "")


class _FormFiller(AnswerVisitor[Data]):
    def __init__(self, part: Part, text: str, params: Data) -> None:
        self.part, self.text, self.params = part, text, params

    def visit_choice(self, answer: Letters) -> Data:
        if self.text in TRUE_FALSE:
            self.text = LETTERS[TRUE_FALSE.index(self.text)]
        return {self.part.name: self._keys()[0]}

    def visit_selection(self, answer: Selection) -> Data:
        keys = self._keys()
        return {self.part.name: keys if len(keys) > 1 else keys[0]}

    def visit_matching(self, answer: Matching) -> Data:
        return dict(zip(list_input_names(self.part), (str(LETTERS.index(letter)) for letter in self.text), strict=True))

    def visit_number(self, answer: Number) -> Data:
        numbers = self.text.replace("[", "").replace("]", "").split(", ")
        return dict(zip(list_input_names(self.part), numbers, strict=True))

    def visit_any(self, answer: Answer) -> Data:
        return {self.part.name: self.text}

    def _keys(self) -> list[str]:
        offered = self.params[self.part.name]
        return [offered[LETTERS.index(letter)]["key"] for letter in self.text]
