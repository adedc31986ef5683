"""Grade submissions: read, run, compare, mark and report them; provide the command line.

No package imports one that is listed after it (pyproject.toml, `tool.importlinter`). The `__init__` of each package
describes its modules.

    sandbox/                    run students' code, isolated from the machine and from the answers
    judging/                    parse one answer, compare it with its reference, and judge it
    submissions/                find, unpack and read submissions; find their owners and the answers in them
    diagnosis/                  find the mistake behind a wrong answer
    marking/                    mark a student's answers: partial credit, and follow-through of wrong earlier answers
    grading/                    grade the submissions of a class, store the results, apply overrides
    statistics/                 compute the statistics for the page about the class
    reports/                    write results for people and for other programs
    serve/                      the service of `qdot serve`, in which a class answers online
    cli/                        the program `qdot`
    integrations/               nbgrader, Otter, PrairieLearn, Gradescope, repositories on GitHub and GitLab
"""
