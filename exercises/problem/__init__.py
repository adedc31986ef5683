"""The central data of qdot: a problem, its identity and its parts.

This package imports common, formula, arm and answer_types.

    problem                     identity, problem, part
    record                      converts a problem to plain data, and computes the digests that identify it
    credit                      the rules for partial credit, which an assignment may change
"""
