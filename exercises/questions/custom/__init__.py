"""Questions that instructors define in TOML.

These modules make a question from a definition, in this order (`questions.language` handles the formulas):

    definition      what an instructor writes
    texts           splits texts at their placeholders, and checks their LaTeX
    reader          reads definitions from a file
    units           checks the unit of a number
    question        makes a question from a definition: computes, samples and checks its answer
"""

from qdot.exercises.questions.custom.definition import Definition
from qdot.exercises.questions.custom.question import CustomDetails, CustomQuestion, make_question

__all__ = ["CustomDetails", "CustomQuestion", "Definition", "make_question"]
