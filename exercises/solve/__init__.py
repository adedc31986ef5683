"""Derive everything for a user's own arm (`qdot solve`).

This package imports the packages that generate, certify and write problems.

    certified_singularities     descriptions of an arm's singular set that have passed a certificate's test
    redundant                   arms of seven joints
    special_lengths             results that differ for special lengths
    solver, time_limited        the whole derivation; the same, result by result, within a time limit
"""
