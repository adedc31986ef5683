"""Statistics for the class overview.

It imports results, and what judges answers.

    statistics                  discrimination of every part, reliability, permutation tests
    fairness_tests              whether some variants were harder
    shared_answers              how many students of a class share an answer
"""
