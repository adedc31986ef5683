"""Every form but notebooks in which an assignment is handed out: quizzes for learning platforms, paper, CI.

One module per export format, all listed in `registry`. They share:

    export_format               what an export format is, and the order that it gets
    bank, handouts              certified variants of an assignment's problems; the notebooks of its class
    items, numbers, markup      quiz items; formulas asked for as numbers; pictures and HTML
    known_wrong                 wrong answers that known mistakes lead to
    stack_parts, stack_maxima   a part as STACK asks and marks it; the Maxima functions for marking
    moodle_quiz                 a quiz as Moodle restores it
    sheet, boxes, marking       a sheet of paper as data; boxes for answers; which answers earn which points
    wheel                       qdot itself as a wheel
    registry                    the export formats by name
"""
