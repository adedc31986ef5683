"""One answer against its reference: parsed, compared, and judged right, wrong or in part.

It imports the sandbox's clock, and nothing else of the grader.

    verdict                     outcomes and points; where an answer differs, in words
    answer                      an answer, parsed once, or why it is refused
    formulas, choices           formulas, numbers, directions and sets; letters
    functions                   Python functions: where they are called, and their values judged
    answer_parser, judge        the door: an answer to a part, parsed in the form that is expected; and judged
    compare                     two texts (`qdot compare`)
"""
