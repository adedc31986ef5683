"""Questions that instructors define in TOML.

The modules, from what an instructor writes to the question:

    definition      what an instructor writes
    reader          reads it from a file
    language        the language of formulas: parsing, operations, functions
    quantities      the named quantities of an arm, in any arithmetic
    units           checks the unit of a number
    question        the question of a definition: computes, samples and checks its answer
"""

from qdot.exercises.questions.custom.definition import Definition
from qdot.exercises.questions.custom.question import CustomDetails, CustomQuestion, make_question

__all__ = ["CustomDetails", "CustomQuestion", "Definition", "make_question"]
