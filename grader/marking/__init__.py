"""Mark a student's answers to a problem: the share of the points that each answer earns.

This package imports diagnosis and judging; the package grading, which grades classes, imports this one.

    marking             mark the answers to a problem, part by part
    partial_credit      compute the share that a partly correct answer earns
    follow_through      judge an answer against what follows from the student's wrong answer to an earlier part

Penalties for late work are subtracted from a student's total in `grading.final_result`.
"""
