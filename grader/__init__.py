"""Grade submissions: read, run, compare, mark and report them; the command line on top.

The map, from the bottom up: nothing here imports what stands below it (pyproject.toml, `tool.importlinter`). Each
folder says in its `__init__` what is in it.

    sandbox/                    where students' code runs, and what this machine keeps it from
    judging/                    one answer against its reference: read, compared, judged
    submissions/                submissions: found, unpacked, read as cells; whose they are
    diagnosis/                  the mistake behind a wrong answer
    grading/                    from submissions to results: marked (with follow-through), stored, overridden
    statistics/                 what the class's page is worked out from
    reports/                    results for people and for other programs
    cli/                        the program `qdot`
    integrations/               nbgrader, Otter, PrairieLearn, Gradescope, pytest, repositories on GitHub and GitLab
"""
