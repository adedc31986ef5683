"""Reports on graded work: one module for each export format, all made from the same results.

Beside the reports for other programs, which are in `formats`:

    feedback_levels                 how much a student is told about a wrong answer
    rows, tables                    a result as rows, one for each part; results.jsonl and grades.csv
    class_view, charts, class_page  the figures of `qdot report`, its charts, its page
    answers, differs, example       an answer as it was read; where it differs, as a table and as a drawing
    feedback                        the feedback page
    write                           all of them, written only if they are not up to date
    formats                         the reports by name
"""
