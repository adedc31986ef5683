"""Explain a wrong answer: name the mistake behind it if that is very likely, else say what to look at.

The package imports judging. Its modules:

    diagnosis                   the mistake behind a wrong answer
    set_mistakes                the mistake behind a set of singular configurations, or the pieces that are wrong
    formula_mistakes, rounding  mistakes in the finished formulas; answers that are correct except for rounding
    numbers, residuals          the numeric values of an answer; the links that an answer lacks
    advice, term_overlap        what to look at if no mistake is named; terms in common with the solution
    follow_through              what follows from a student's wrong answer to an earlier part
    similar, groups             answers compared as written; the key that equal wrong answers share
"""
