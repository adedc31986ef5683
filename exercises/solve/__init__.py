"""Derive the results of the chapter for a user's own arm (`qdot solve`).

The Jacobian and the other results themselves are derived in `derivation`. This package imports the packages that
generate, certify and write problems. Modules:

    certified_singularities     descriptions of an arm's singular set that have passed a certificate's test
    numeric_rank_check          the numeric check of a singular set
    redundant                   the singular set of arms with more joints than task rows, such as seven joints
    solver                      the whole derivation: as data, step by step for a terminal, and as LaTeX
    time_limited                the derivation within a time limit, result by result
"""
