"""What is handed in: reading, running, comparing, marking, reporting; the command line on top.

The map, from the bottom up: nothing here imports what stands below it (pyproject.toml, `tool.importlinter`). Each
folder says in its `__init__` what is in it.

    sandbox/                    where students' code runs, and what this machine keeps it from
    judging/                    one answer against its reference: read, compared, judged
    submissions/                what was handed in: found, unpacked, read as cells; whose it is
    diagnosis/                  the mistake behind a wrong answer; what follows from it
    grading/                    from what a class handed in to results: marked, kept, overridden, certified
    statistics/                 what the class's page is worked out from
    reports/                    results for people and for other programs
    cli/                        the program `qdot`
    integrations/               nbgrader, Otter, PrairieLearn, Gradescope, pytest, repositories on GitHub and GitLab
"""
