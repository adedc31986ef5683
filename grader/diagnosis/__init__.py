"""The mistake behind a wrong answer: named where it is very likely, else what to look at.

It imports judging.

    diagnosis                   the mistake behind a wrong answer
    set_mistakes                the mistake behind a set of singular configurations, or what is wrong in it
    formula_mistakes, rounding  slips in the finished formulas; what is right but for rounding
    numbers, residuals          an answer in numbers; what an answer lacks
    advice, term_overlap        what to look at without a mistake's name; terms of the solution
    follow_through              what follows from a wrong answer
    similar, groups             answers compared as they are written; the key of equal wrong answers
"""
