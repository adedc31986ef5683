"""Other programs that call qdot, and those that it calls.

It is the top: nothing imports it but by name.

    nbgrader_cells              notebooks as nbgrader has them, made whole and filled with marks
    nbgrader_plugin             what nbgrader runs, the one module that needs it
    otter_marks, otter_plugin   marks as Otter's tests look them up; what Otter runs, the one module that needs it
    prairielearn, gradescope    what an exported PrairieLearn question calls; Gradescope's autograder
    pytest_plugin               `pytest --qdot`
    git_hosts, git_submissions  GitHub and GitLab; repositories fetched as they were when work was due, feedback
"""
