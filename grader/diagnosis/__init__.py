"""Explain a wrong answer: name the mistake behind it if it is very likely, otherwise say what to look at.

The package imports judging. Its modules:

    diagnosis                   name the mistake behind a wrong answer
    set_mistakes                find the mistake behind a set of singular configurations, or the wrong pieces of the set
    evaluated_answer            evaluate a wrong answer and its reference, for all explanations
    formula_mistakes, rounding  find mistakes in the finished formulas; recognise answers with only rounding errors
    term_comparison             compare an answer with its reference term by term
    numbers, residuals          compare the values of an answer; find the links that an answer lacks
    advice, term_overlap        advise if no mistake is named; count the terms that an answer shares with the solution
    groups                      compute the key that equal wrong answers share
"""
