"""How problems and solutions are put: notation, wording, worked steps, Markdown to other markups.

From formulas to whole texts:

    shortening, angles, turns   shorter sums; one name for each angle of an arm; its constant angles instead of roots
    fit                         wide formulas on several lines
    latex, typeset              formulas laid out: SymPy's as the textbook has them, and what a student typed
    markup, typst, on_paper     our Markdown as HTML, LaTeX, text and Typst; what is left out on paper
    wording                     the words for an arm, and what its axes and vectors are called in its convention
    expansion, solution_steps   how a determinant is worked out; what a solution shows between formula and result
    hint_context                what hints say about an arm and show of its results
    problem_texts, short_answer  statements, prompts, hints and solutions; an answer without the way to it
    translatable_phrases        words that problems carry
    languages, render           the messages of a language; the templates filled in
"""
