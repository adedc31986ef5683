"""The nouns of the whole program: a problem, its identity and its parts.

It imports common, formula, arm and answers.

    problem                     identity, problem, part
    record                      a problem as plain data, and the digests by which it is known again
    credit                      what half an answer earns: the rules that an assignment may change
"""
