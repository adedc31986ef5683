"""What the class's page is worked out from.

It imports results, and what judges answers.

    statistics                  scores, difficulty and discrimination of every part
    fairness_tests              whether some variants were harder
    shared_answers              how many of a class share an answer
"""
