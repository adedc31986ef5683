"""What is asked: robots, problems, their reference solutions, and every form they are handed out in.

The map, from the bottom up: nothing here imports what stands below it, nor anything of `grader`. A folder has a map of
its own in its `__init__`.

    errors                          the one exception that users are meant to read
    extras                          how qdot is installed; libraries that come only if wanted
    completion                      what the Tab key completes a value to
    variation                       how far arms lead away from the chapter's: axes, and steps of them
    files, input_file               files written whole or not at all; files that people wrote, and where they are wrong
    stream                          the random stream behind every problem (SHAKE-256)
    console, parallel, time_limit   results, notes and progress; one thing done to many items on several processes;
                                    work that ends when its time is over
    formula/                        text to a tree, a tree to numbers; are two expressions, or two sets, the same
    arm/                            a DH table, all that follows from it, and where it is singular
    credit, decimals, lateness      what half an answer earns, decimals may be off, and late work loses
    several                         which of several notebooks count
    difficulty                      how hard an arm is to work through by hand
    answers/                        the types of answers, a class each
    problem                         the nouns: identity, problem, part
    families/, questions/           which arms there are; what is asked of them
    mistakes/                       what goes wrong in a derivation, and what that makes of an answer
    quizzes/                        short questions, their wrong options made by mistakes; all that can be asked
    generation                      from an identity to a problem
    record                          a problem as plain data, and the digests by which it is known again
    verify/                         the certificate of a problem, by ways the reference was not derived by
    phrases, languages, render      words that problems carry; the messages of a language; the templates filled in
    writing/                        statements, hints, solutions; formulas as LaTeX, MathML, Typst, Maxima, text
    messages                        all messages collected, and merged into locale/CODE.po (`make messages`)
    figure/                         the drawing of an arm, as SVG and as TikZ, and its description in words
    self_check                      what a notebook checks of its own answers, without the right ones
    setup_cell                      the first cell of a notebook
    notebook, showing               notebooks; one problem in every format
    sound                           your own arm: what is said of it that passed a certificate's test
    redundant, locus                seven joints; a map of where it is singular
    special_lengths                 what differs for special lengths
    solving                         all that is derived for it (`qdot solve`)
    solving_in_time                 the same as it is ready, until the time is over
    docs/                           the pages of docs/ that are made from the code (`make docs`)
    gradebook                       Canvas's and Moodle's own exports as rosters
    redrawn, assignment             whose problems were drawn anew; an instructor's folder, read and checked
    drawing                         problems drawn until one passes; what to ask where none does
    store                           what was worked out, kept for grading
    sets, release                   ready-made sets of problems; an assignment made, its notebooks written
    exports/                        every other form in which an assignment is handed out (`qdot export`)
    site/                           the web site: pages, and problems that a browser can grade
    overview, options, commands     the families at a glance; what several commands take; those about what is asked

What a library or a notebook needs stands in this package itself (`__all__`), and is loaded when it is asked for:

>>> from qdot import generate, show
>>> problem = generate("planar-2r/7", ["jacobian"])
>>> problem
Problem(planar-2r/7: jacobian)
>>> problem["jacobian"].answer.as_matrix().shape
(2, 2)
"""

import os
from typing import TYPE_CHECKING, Any

# What SymPy remembers of each function: a class asks the same of the same formulas, and a thousand are soon forgotten.
os.environ.setdefault("SYMPY_CACHE_SIZE", "20000")

if TYPE_CHECKING:
    from qdot.exercises.answers import Answer as Answer
    from qdot.exercises.arm.chain import Base as Base
    from qdot.exercises.arm.chain import Chain as Chain
    from qdot.exercises.arm.chain import Joint as Joint
    from qdot.exercises.arm.chain import Point as Point
    from qdot.exercises.arm.robot_file import read_robot as read_robot
    from qdot.exercises.assignment import Assignment as Assignment
    from qdot.exercises.assignment import load_assignment as load_assignment
    from qdot.exercises.errors import QdotError as QdotError
    from qdot.exercises.families import FAMILIES as FAMILIES
    from qdot.exercises.generation import generate as generate
    from qdot.exercises.problem import ENGINE as ENGINE
    from qdot.exercises.problem import Part as Part
    from qdot.exercises.problem import Problem as Problem
    from qdot.exercises.problem import ProblemId as ProblemId
    from qdot.exercises.quizzes import ASKED as ASKED
    from qdot.exercises.showing import show as show
    from qdot.exercises.solving import Solution as Solution
    from qdot.exercises.solving import solve as solve
    from qdot.exercises.verify import ProblemCertificate as ProblemCertificate
    from qdot.exercises.verify import certify as certify

_HOMES = {
    "answers": ("Answer",), "arm.chain": ("Base", "Chain", "Joint", "Point"), "arm.robot_file": ("read_robot",),
    "assignment": ("Assignment", "load_assignment"), "errors": ("QdotError",), "families": ("FAMILIES",),
    "generation": ("generate",), "problem": ("ENGINE", "Part", "Problem", "ProblemId"), "quizzes": ("ASKED",),
    "showing": ("show",), "solving": ("Solution", "solve"), "verify": ("ProblemCertificate", "certify"),
}  # fmt: skip
"""Where what is offered here is made: SymPy is loaded for who asks for it, and not for who asks for the version."""

__all__ = [
    "ASKED", "ENGINE", "FAMILIES", "Answer", "Assignment", "Base", "Chain", "Joint", "Part", "Point", "Problem",
    "ProblemCertificate", "ProblemId", "QdotError", "Solution", "certify", "generate", "load_assignment",
    "read_robot", "show", "solve",
]  # fmt: skip


def __getattr__(name: str) -> Any:
    from importlib import import_module

    for home, names in _HOMES.items():
        if name in names:
            return getattr(import_module(f"qdot.exercises.{home}"), name)
    raise AttributeError(f"module 'qdot.exercises' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
