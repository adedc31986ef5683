"""The central data of the program: a problem, its identity and its parts.

It imports common, formula, arm and answers.

    problem                     identity, problem, part
    record                      a problem as plain data, and the digests that identify it
    credit                      the rules for partial credit, which an assignment may change
"""
