"""Turn what a class submitted into results: marked, stored, overridden, certified.

It imports submissions, judging and diagnosis; reports are above it.

    result                      a student's result: the fields of a line of results.jsonl
    partial_credit, marking     the share that an answer earns; a student's answers to a problem
    attempt                     one notebook of a class graded; a notebook without a class
    copied_answers, overrides   whether an answer is right for another student; points that a person sets
    final_result                from notebooks to a student's result: overrides, lateness, which attempt counts
    cluster                     notebooks graded by the workers of a Dask cluster
    batch                       a class graded, which can be resumed; one student graded
    history                     results that a later run replaced, and whose mark moved
    check                       `qdot check`: what a student can know before submitting
    certificates, certify       a student's certificate; `qdot verify`
    forgetting                  everything about one student, removed
    class_check                 a run that can't be right, stopped before it writes
"""
