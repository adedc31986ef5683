"""Write a problem as a notebook, and in every other format of `qdot show`.

This package imports the packages that write texts and draw figures; the assignment package imports it.

    notebook                    the student's notebook, and the notebook with the answers and solutions
    self_check                  checks of a notebook's answers against each other, without the correct answers
    setup_cell                  the first cell of a notebook
    problem_formats             one problem in every format
"""
