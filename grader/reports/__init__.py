"""Write reports on graded work, all based on the same results: one module for each format.

Each format for other programs has its own module, which `formats` lists. All other modules:

    formats                         lists the formats that other programs read
    feedback_levels                 limit what a student sees about a wrong answer
    part_rows, grades_table         list a result part by part; write results.jsonl and grades.csv
    class_summary                   compute the numbers of `qdot report`
    class_page                      write the page of `qdot report`
    answer_display                  show an answer as it was parsed
    counterexample_table            show where an answer is wrong, as a table
    counterexample_figure           draw the arm where an answer is wrong
    feedback                        write a student's feedback page
    graded_folder                   write the files in graded/ that are not up to date
    returned_feedback               pack the feedback pages for upload to a platform
"""
