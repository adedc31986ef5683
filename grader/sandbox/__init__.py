"""Where students' code runs: a process that holds nothing of the reference, and what this machine keeps it from.

It imports nothing else of the grader.

    contained/                  all that is in the process in which students' code runs
    clock, own_folder           budgets of processor time; temporary folders that no killed process leaves behind
    sandbox, guarantees         the grader's side of `contained`; what this machine guarantees, by a probe
"""
