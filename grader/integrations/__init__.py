"""Connect qdot with other programs: those that call qdot, and those that qdot calls.

This is the top package: no other package imports it, and its modules are loaded only by name. Platforms that open qdot
by LTI are in `serve.lti`.

    nbgrader_cells              restore the cells of nbgrader's notebooks; fill in marks
    nbgrader_plugin             run in nbgrader; the only module that needs nbgrader
    otter_marks, otter_plugin   provide marks for Otter's tests; run in Otter, the only module that needs Otter
    prairielearn, gradescope    serve an exported PrairieLearn question; grade as Gradescope's autograder
    git_hosts, git_submissions  query GitHub and GitLab; fetch repositories as of the deadline, and return feedback
"""
