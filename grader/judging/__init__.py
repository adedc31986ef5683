"""One answer against its reference: read, compared, and judged right, wrong or in part.

It imports the sandbox's clock, and nothing else of the grader.

    verdict, counterexample     outcomes and points; where an answer differs, in words
    function_values, answer     what Python functions return, and where; an answer, read once, or why it is none
    formulas, choices           formulas and sets; letters
    direction, functions        vectors up to a factor; Python functions, judged by their values
    answer_parser, judge        the door: an answer to a part, read in the form that is due; and judged
    compare                     two texts (`qdot compare`)
"""
