"""How problems and solutions are put: notation, wording, worked steps, Markdown to other markups.

From formulas to whole texts:

    latex, latex_tree           formulas as the textbook prints them; that LaTeX as trees, for other notations
    direct, mathml, fit         LaTeX as MathML; wide formulas on several lines
    unicode_math, spoken        formulas for a terminal, and in words for those who hear a page
    typst, maxima               our Markdown for Typst; formulas for Maxima
    typeset                     the LaTeX of what somebody typed
    markup, on_paper            our Markdown as HTML, LaTeX and text; what is left out on paper
    wording, worked             the words for an arm; what a solution shows between formula and result
    hint_context                what hints tell of an arm
    statement, short_answer     statements, prompts, hints and solutions; an answer without the way to it
"""
