"""Write reports on graded work: one module for each export format, all based on the same results.

Besides the modules for other programs' formats, which `formats` lists, there are:

    feedback_levels                 limit what a student sees about a wrong answer
    rows, tables                    list a result part by part; write results.jsonl and grades.csv
    class_view, charts, class_page  compute the figures of `qdot report`; draw its charts; write its page
    answers, differs, example       show an answer as it was parsed; show where it is wrong, as a table and a drawing
    feedback                        write a student's feedback page
    write                           write the files in graded/ that are not up to date
    formats                         list the export formats by name
"""
