"""Questions that instructors define in TOML.

The modules, from what an instructor writes to the question (its formulas are in `questions.language`):

    definition      what an instructor writes
    texts           splits texts at their placeholders, and checks their LaTeX
    reader          reads it from a file
    units           checks the unit of a number
    question        the question of a definition: computes, samples and checks its answer
"""

from qdot.exercises.questions.custom.definition import Definition
from qdot.exercises.questions.custom.question import CustomDetails, CustomQuestion, make_question

__all__ = ["CustomDetails", "CustomQuestion", "Definition", "make_question"]
