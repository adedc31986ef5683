"""Make problems: robots, questions, reference solutions, and every form in which they are released.

The map, from the bottom up: nothing here imports what stands below it, nor anything of `grader` (pyproject.toml,
`tool.importlinter`). Each folder says in its `__init__` what is in it.

    common/                     errors, files, processes, the terminal
    formula/                    text to a tree, a tree to numbers; are two expressions, or two sets, the same
    arm/                        a DH table, and all that follows from it
    singularities/              where an arm is singular, and which motion it loses there
    reference_answers/               the types of answers, a class each
    problem/                    identity, problem, part; what half an answer earns
    questions/, mistakes/       what is asked of an arm; what goes wrong in a derivation, and what comes of it
    short_questions/            short questions, their wrong options made by mistakes; all that can be asked
    families/, generation       which arms there are; from an identity to a problem
    verify/                     the certificate of a problem, by ways the reference was not derived by
    writing/                    statements, hints, solutions; formulas as LaTeX, MathML, Typst, Maxima; languages
    figure/                     the drawing of an arm, as SVG and as TikZ, and its description in words
    notebook/                   notebooks; one problem in every format
    assignment/                 an instructor's folder, read and checked; its notebooks written
    solve/                      all that is derived for an arm of your own (`qdot solve`)
    chapter/                    the chapter's examples, solved, and its errata
    site/                       the web site: pages, and problems that a browser can grade
    exports/                    every other form in which an assignment is released (`qdot export`)
"""
