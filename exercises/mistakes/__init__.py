"""The mistakes that people make in these derivations: one catalogue for diagnosis, quizzes and verification.

Beside the mistakes, whose modules stand in `catalogue.SECTIONS`:

    base            what a mistake is: a change to a derivation, or to an answer
    given           the configurations at which an answer is looked at
    catalogue       every mistake by name, and what each makes of an answer
"""
