"""Write the texts of problems and solutions: notation, wording, worked steps, conversion of Markdown.

From formulas to whole texts:

    shortening, angles          shorter sums; one name for each angle of an arm
    constant_angles             sines and cosines of an arm's constant angles instead of roots
    fit                         wide formulas on several lines
    latex, typeset              layout of SymPy's formulas in the textbook's notation, and of a student's answer
    markup, typst, on_paper     our Markdown as HTML, LaTeX, text and Typst; removal of remarks on typing for paper
    wording                     the words for an arm, and the names of its axes and vectors in its convention
    expansion, solution_steps   the steps that expand a determinant; all steps between formula and result
    hint_context                what hints say about an arm and show of its results
    problem_texts, short_answer  statements, prompts, hints and solutions; an answer without its derivation
    translatable_phrases        English phrases in problems
    languages, render           the messages of a language; rendering of templates
"""
