"""Compute statistics for the class overview.

This package imports results, and the modules that judge answers.

    statistics                  compute the discrimination of parts, the reliability, and permutation tests
    fairness_tests              test whether some variants were harder than others
    shared_answers              count the students of a class who share an answer
"""
