"""Derive everything for a user's own arm (`qdot solve`).

It imports what makes, certifies and writes problems.

    certified_singularities     descriptions of an arm's singular set that have passed a certificate's test
    redundant                   arms of seven joints
    special_lengths             what differs for special lengths
    solver, time_limited        the whole derivation; the same result by result, within a time limit
"""
