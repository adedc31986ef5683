"""Programs that call qdot, and programs that qdot calls.

It is the top: nothing imports it except by name.

    nbgrader_cells              notebooks in nbgrader's form: cells restored, marks filled in
    nbgrader_plugin             what nbgrader runs; the only module that needs nbgrader
    otter_marks, otter_plugin   marks that Otter's tests look up; what Otter runs, the only module that needs Otter
    prairielearn, gradescope    what an exported PrairieLearn question calls; Gradescope's autograder
    git_hosts, git_submissions  GitHub and GitLab; repositories fetched as they were at the deadline, feedback
"""
