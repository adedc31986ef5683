"""What is handed in: reading, running, comparing, marking, reporting; the command line on top.

The map, from the bottom up: nothing here imports what stands below it.

    verdict, counterexample         outcomes and points; where an answer differs, in words
    levels, clock                   how much of that a student is told; budgets of processor time
    contained/                      all that is in the process in which students' code runs
    function_values, answer         what Python functions return, and where; an answer, read once, or why it is none
    formulas, choices, direction    one answer against its reference: formulas and sets; letters; vectors up to a factor
    functions                       answers that are Python functions, judged by their values
    reading, parts                  the door: an answer to a part, read in the form that is due; and judged
    compare                         two texts (`qdot compare`)
    residuals                       what an answer lacks
    numbers, finished, rounded      an answer in numbers; slips in the finished formulas; what is right but for rounding
    set_mistakes                    the mistake behind a set of singular configurations, or what is wrong in it
    diagnosis                       the mistake behind a wrong answer
    advice, terms, follow           what to look at without one; terms of the solution; what follows from a wrong answer
    credit                          what an answer earns in part
    similar, groups                 answers compared as they are written; the key of equal wrong answers
    marking                         a student's answers to a problem
    prairielearn                    what an exported PrairieLearn question calls
    own_folder                      temporary folders that no killed process leaves behind
    sandbox, guarantees             the grader's side of `contained`; what this machine guarantees, by a probe
    cells, archives                 a file as cells; zip and tar archives, within limits
    layouts, roster, submission     how platforms name what was handed in; whose it is; what may be graded
    positions, finding              the line of its file, and the cell, in which the answer to each part is
    uncounted, notebook             which cells need not be run; a notebook by itself
    copies, overrides               whether an answer is right for somebody else; points that a person set
    attempt, settle                 one notebook graded; from notebooks to a student's result
    remote, cluster                 notebooks graded by an executor on any machine; a Dask cluster as one
    batch, single, history          the class, resumable; one student; what earlier runs gave, and whose mark moved
    certificates, sharing           a student's certificate; how many of a class share an answer
    certify                         `verify`
    class_check                     a run that can't be right, stopped before it writes
    upgrade                         what this version would make of a folder that another one wrote
    forgetting                      all that a folder has of one student, removed
    check                           what a student can know before handing in
    statistics, variants            what the class's page is worked out from
    reports/                        results for people and for other programs
    nbgrader_cells                  notebooks as nbgrader has them, made whole and filled with marks
    student_command                 the command for students, `qdot check`
    demo, commands                  the simulated class; the commands about what is handed in
    keeping                         the commands for a folder that is kept: what an upgrade changes, `qdot forget`
    pytest_plugin, nbgrader_plugin  `pytest --qdot`; what nbgrader runs, the one module that needs nbgrader
    hosts, pushed                   GitHub and GitLab; repositories fetched as they were when work was due, feedback
    gradescope                      Gradescope's autograder
    otter_marks, otter_plugin       marks as Otter's tests look them up; what Otter runs, the one module that needs it
    outlets, site                   `qdot export` and `qdot report`; `qdot site`
    docs, examples, cli             docs/outlets.md; examples of each command; the program `qdot`

What a library or a notebook needs stands in this package itself (`__all__`), and is loaded when it is asked for:

>>> from qdot import generate
>>> from qdot import judge
>>> problem = generate("polar-rp/1", ["determinant"])
>>> judge(problem, problem["determinant"], "-(7/10 + d2)")
Judgement(correct, 1: right)
"""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from qdot.exercises.formula.identity import Certificate as Certificate
    from qdot.grader.answer import Given as Given
    from qdot.grader.check import check_notebook as check_notebook
    from qdot.grader.diagnosis import diagnose as diagnose
    from qdot.grader.marking import mark as mark
    from qdot.grader.notebook import grade_notebook as grade_notebook
    from qdot.grader.parts import judge as judge
    from qdot.grader.reading import read_answer as read_answer
    from qdot.grader.verdict import Diagnosis as Diagnosis
    from qdot.grader.verdict import Judgement as Judgement
    from qdot.grader.verdict import Outcome as Outcome
    from qdot.grader.verdict import Verdict as Verdict

_HOMES = {
    "exercises.formula.identity": ("Certificate",), "grader.answer": ("Given",), "grader.check": ("check_notebook",),
    "grader.diagnosis": ("diagnose",), "grader.marking": ("mark",), "grader.notebook": ("grade_notebook",),
    "grader.parts": ("judge",), "grader.reading": ("read_answer",),
    "grader.verdict": ("Diagnosis", "Judgement", "Outcome", "Verdict"),
}  # fmt: skip
"""Where what is offered here is made."""

__all__ = [
    "Certificate", "Diagnosis", "Given", "Judgement", "Outcome", "Verdict", "check_notebook", "diagnose",
    "grade_notebook", "judge", "mark", "read_answer",
]  # fmt: skip


def __getattr__(name: str) -> Any:
    from importlib import import_module

    for home, names in _HOMES.items():
        if name in names:
            return getattr(import_module(f"qdot.{home}"), name)
    raise AttributeError(f"module 'qdot.grader' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
