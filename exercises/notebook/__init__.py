"""A problem as a notebook, and in every other format of `qdot show`.

It imports what writes texts and draws figures; assignments are above it.

    notebook                    the notebook to hand out, and the staff's
    self_check                  what a notebook checks of its own answers, without the right ones
    setup_cell                  the first cell of a notebook
    problem_formats             one problem in every format
"""
