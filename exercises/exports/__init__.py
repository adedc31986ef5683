"""Export formats of an assignment, other than notebooks: quizzes for learning platforms, paper, CI.

There is one module per export format, and `registry` lists them all. They share:

    export_format               the definition of an export format, and of the `Order` that it receives
    bank, handouts              certified variants of an assignment's problems; the notebooks of its class
    items, numbers, markup      quiz items; formulas asked for as numbers; pictures and HTML
    known_wrong                 the wrong answers that known mistakes lead to
    stack_parts, stack_maxima   a part in STACK's form, with its marking; the Maxima functions for marking
    moodle_quiz                 a quiz as a Moodle backup
    sheet, boxes, marking       a sheet of paper as data; boxes for answers; which answers earn which points
    wheel                       qdot itself as a wheel
    registry                    the export formats by name
"""
