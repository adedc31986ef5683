"""Every form but notebooks in which an assignment is handed out: quizzes for learning platforms, paper, CI.

Beside the outlets, which stand in `registry`:

    outlet                      what an outlet is, and what it is given
    bank, handouts              certified variants of an assignment's problems; the notebooks of its class
    items, numbers, markup      what platforms ask: options, matches, formulas asked for in numbers; texts and archives
    known_wrong                 what mistakes make of an answer
    stack_parts, stack_maxima   a part as STACK asks and marks it; what marking calls in Maxima
    stack_cost                  what marking costs
    moodle_quiz                 a quiz as Moodle restores it
    sheet, boxes, marking       a sheet of paper as data; where answers are written; what earns which points
    wheel                       qdot itself, to be carried along
    registry                    the outlets by name
"""
