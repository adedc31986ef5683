"""What is asked: robots, problems, their reference solutions, and every form they are handed out in.

The map, from the bottom up: nothing here imports what stands below it, nor anything of `grader`. A folder has a map of
its own in its `__init__`.

    errors                          the one exception that users are meant to read
    files, input_file               files written whole or not at all; files that people wrote, and where they are wrong
    stream                          the random stream behind every problem (SHAKE-256)
    console, parallel               results, notes and progress; one thing done to many items on several processes
    formula/                        text to a tree, a tree to numbers; are two expressions, or two sets, the same
    arm/                            a DH table, all that follows from it, and where it is singular
    credit, decimals, lateness      what half an answer earns, decimals may be off, and late work loses
    difficulty                      how hard an arm is to work through by hand
    answers/                        the types of answers, a class each
    problem                         the nouns: identity, problem, part
    families/, questions/           which arms there are; what is asked of them
    mistakes/                       what goes wrong in a derivation, and what that makes of an answer
    quizzes/                        short questions, their wrong options made by mistakes; all that can be asked
    generation                      from an identity to a problem
    record                          a problem as plain data, and the digests by which it is known again
    verify/                         the certificate of a problem, by ways the reference was not derived by
    languages, render               the words of other languages; the templates filled in
    writing/                        statements, hints, solutions; formulas as LaTeX, MathML, Typst, Maxima, text
    figure/                         the drawing of an arm, as SVG and as TikZ, and its description in words
    notebook, show, solving         notebooks; one problem in every format; your own arm (`qdot solve`)
    docs/                           the pages of docs/ that are made from the code (`make docs`)
    gradebook                       Canvas's and Moodle's own exports as rosters
    assignment                      an instructor's folder, read and checked
    store, release                  what was worked out, kept for grading; an assignment made, its notebooks written
    exports/                        every other form in which an assignment is handed out (`qdot export`)
    site/                           the web site: pages, and problems that a browser can grade
    commands                        the commands about what is asked
"""

ENGINE = 1
"""Version of the problem generator: any change of what an id regenerates raises it."""

__all__ = ["ENGINE"]
