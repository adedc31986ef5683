"""Compute statistics for the report on a class.

This package imports problems and their certificates.

    class_statistics            compute the discrimination of parts, the reliability, and permutation tests
    fairness_tests              test whether some variants were harder than others
    shared_answers              count the students of a class who share an answer
"""
