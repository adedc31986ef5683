"""The central data of qdot: a problem, its identity and its parts.

This package imports only common, formula, arm and reference_answers.

    problem                     a problem, its identity and its parts
    record                      convert a problem to plain data, and compute the digests that identify it
    credit                      the rules for partial credit, which an assignment may change
    rounding                    the tolerances for rounded answers
"""
