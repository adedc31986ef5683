"""The mistakes that students make in derivations: one catalogue for diagnosis, quizzes and verification.

A derivation is computed in stages, such as the table, the link vectors and the Jacobian (`derivation.graph`). A mistake
changes the results of one or more stages. A variant of a mistake specifies the details, such as the joint at which the
mistake is made.

catalogue.toml describes the mistakes, and the modules make them: `position`, `columns`, `screws`, `algebra`, `table`,
`arrangement`, `numeric`, `question_formulas`, `sets` and `choices`. The other modules are:

    base            define a mistake: a change to a derivation, or to an answer
    formula_edits   change a finished formula, such as a sign or a factor
    configurations  sample the configurations at which an answer is evaluated
    catalogue       list all mistakes by name, and compute the wrong answers that they lead to
"""
