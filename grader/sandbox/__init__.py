"""Run students' code in a process without the reference answers, under the restrictions that this machine enforces.

This package imports no other package of the grader.

    notebook_process/           everything in the process in which students' code runs
    time_budgets                limits of processor time for tasks of the grader
    temporary_folder            temporary folders that are removed even after a crash
    sandbox, guarantees         the grader's end of the sandbox; the guarantees of this machine, tested by a probe
"""
