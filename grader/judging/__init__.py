"""Parse one answer, compare it with its reference, and judge it correct, wrong or partly correct.

From the rest of the grader it imports only parts of the sandbox.

    verdict                     outcomes and points; counterexamples in words
    answer                      parses an answer once, or refuses it with a reason
    formulas, choices           judge formulas, numbers, directions and sets; letters of options
    functions                   judges Python functions by their values
    answer_parser, judge        the entry points: parse the answer to a part in the expected form; judge it
    compare                     compares two texts (`qdot compare`)
"""
