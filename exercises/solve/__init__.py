"""An arm of your own: all that is derived for it (`qdot solve`).

It imports what makes, certifies and writes problems.

    certified_singularities     what is said of an arm's singular set once it has passed a certificate's test
    redundant, locus            seven joints; a map of where it is singular
    special_lengths             what differs for special lengths
    solver, time_limited        all that is derived; the same as it is ready, until the time is over
"""
