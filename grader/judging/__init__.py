"""Parse one answer, compare it with its reference, and judge it correct, wrong or partly correct.

This package imports only parts of the sandbox from the rest of the grader.

    verdict                     define outcomes, judgements and verdicts; describe counterexamples in words
    answer_parser               parse an answer once, or refuse it with a reason
    formulas, choices           judge formulas, numbers, directions and sets; judge the letters of options
    functions                   judge Python functions by their values
    expected_form, judge        the entry points: parse the answer to a part as its expected type; judge it
    compare_command             compare two texts (`qdot compare`)

The grammar of typed formulas, and whether two formulas or sets are equal, is in `exercises.formula` (`parser`,
`equality`, `conditions`).
"""
