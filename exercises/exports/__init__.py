"""Export an assignment: as quizzes for learning platforms, on paper, and for platforms that grade notebooks with qdot.

Each export format has a module. These modules are shared:

    registry                    all export formats by name
    export_format               what an export format is, and the `ExportRequest` for an export
    assignment_files            the files that a platform needs to grade
    bank, handouts              certified variants of an assignment's problems; the notebooks of its class
    items, numeric_part         questions for learning platforms; parts whose formulas are evaluated to numbers
    typed_numbers               the texts of a number that platforms recognise
    platform_markup             figures, HTML and numbers in the form that learning platforms need
    known_wrong_answers         the wrong answers that known mistakes lead to
    stack_parts, stack_maxima   parts in STACK's form, with their marking; the Maxima functions for marking
    moodle_quiz                 a quiz as a Moodle backup
    sheet, boxes, marking       the content of paper sheets; boxes for answers; which answers earn which points
    wheel                       qdot itself as a Python package
"""
