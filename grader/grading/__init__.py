"""From what a class handed in to results: marked, kept, overridden, certified.

It imports submissions, judging and diagnosis; reports are above it.

    result                      what a student gets: the fields of a line of results.jsonl
    partial_credit, marking     what an answer earns in part; a student's answers to a problem
    notebook, attempt           a notebook by itself; one notebook of a class graded
    copied_answers, overrides   whether an answer is right for somebody else; points that a person set
    final_result                from notebooks to a student's result: overrides, lateness, which attempt counts
    batch, one_student          the class, resumable; one student
    remote, cluster             notebooks graded by an executor on any machine; a Dask cluster as one
    history                     what earlier runs gave, and whose mark moved
    check                       what a student can know before handing in
    certificates, certify       a student's certificate; `verify`
    class_check                 a run that can't be right, stopped before it writes
    upgrade, forgetting         what this version would make of an old folder; all that there is of one student, removed
"""
