"""Generate problems: arms, questions, reference solutions, and every format in which problems are released.

No package imports one that is listed after it, nor anything of `grader` (pyproject.toml, `tool.importlinter`). The
`__init__` of each package describes its modules.

    common/                     errors, files, processes, the terminal
    formula/                    parse, print and evaluate formulas; compare them as functions and as sets
    arm/                        describe an arm by a DH table or screws, and compute its frames
    derivation/                 derive the Jacobian and all that follows from it, in stages
    robots/                     read an arm from a file; the library of real robots
    singularities/              find the singular configurations of an arm, and the motions that it loses there
    reference_answers/          the types of answers, one class for each
    problem/                    problems, their identities and parts; the rules for partial credit
    questions/, mistakes/       the kinds of questions; the mistakes that students make in the derivations
    short_questions/            short questions, whose wrong options come from these mistakes; the list of all questions
    families/, generation       the families of arms; from the identity of a problem to the problem
    verify/                     certify problems by methods that are independent of the derivation
    writing/                    statements, hints and solutions; their formulas and languages
    figure/                     draw an arm as SVG and as TikZ, and describe the drawing in words
    notebook/                   write problems as notebooks and in every other format of `qdot show`
    assignment/                 read and check an instructor's assignment folder, and write its notebooks
    solve/                      derive all results for a user's own arm (`qdot solve`)
    chapter/                    the chapter's examples with their solutions, and its errata
    site/                       build the web site: pages, and problems that a browser can grade
    exports/                    export an assignment in formats other than notebooks (`qdot export`)
"""
