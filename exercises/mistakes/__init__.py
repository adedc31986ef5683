"""The mistakes that students make in these derivations: one catalogue for diagnosis, quizzes and verification.

The modules with mistakes are listed in `catalogue.SECTIONS`. The others are:

    base            what a mistake is: a change to a derivation, or to an answer
    configurations  the configurations at which an answer is evaluated
    catalogue       every mistake by name, and the wrong answers that each leads to
"""
