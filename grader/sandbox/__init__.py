"""Run students' code in a process without the reference answers, under the restrictions that this machine enforces.

This package imports no other package of the grader.

    contained/                  everything in the process in which students' code runs
    clock, temporary_folder     budgets of processor time; temporary folders that are removed even after a crash
    sandbox, guarantees         the grader's side of `contained`; the guarantees of this machine, tested by a probe
"""
