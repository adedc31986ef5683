"""Grade the submissions of a class: run and mark them, store the results, apply overrides, check certificates.

This package imports marking, submissions and judging; the package reports imports this one.

    result                      define a student's result: the fields of a line of results.jsonl
    attempt                     grade one notebook of a class, or a notebook without a class
    copied_answers, overrides   find answers that are correct for another student; read points that a person sets
    final_result                compute a student's result: the attempt that counts, overrides, late penalty
    cluster                     grade notebooks on the workers of a Dask cluster
    batch                       grade a class, resuming an interrupted run; grade one student
    history                     store results that a later run replaced; report changed marks
    check                       check a notebook before it is submitted (`qdot check`)
    certificates, certify       read and write a student's certificate; verify problems (`qdot verify`)
    forgetting                  remove everything about one student
    class_check                 stop a run with wrong inputs before it writes anything
"""
