"""Reports on graded work: one module an outlet, all made from the same results.

Beside the reports for other programs, which stand in `formats`:

    feedback_levels                 how much a student is told of a wrong answer
    answer_positions                on which line of its file an answer stands
    rows, tables                    a result as rows, a part each; results.jsonl and grades.csv
    class_view, charts, class_page  what `qdot report` tells, draws and shows
    answers, differs, example       an answer as it was read; where it differs; that as a drawing
    feedback                        the feedback page
    write                           all of them, only what is not up to date
    formats                         the reports by name
"""
