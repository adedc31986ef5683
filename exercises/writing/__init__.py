"""How problems and solutions are put: notation, wording, worked steps, Markdown to other markups.

From formulas to whole texts:

    gathering, shortening       sums gathered by the joint that turns the whole arm; what two terms are together
    angles, turns               one name for each angle of an arm; its constant angles in the place of roots
    latex, typeset              formulas laid out: SymPy's as the textbook has them, and what somebody typed
    fit                         wide formulas on several lines
    typst                       our Markdown for Typst
    markup, on_paper            our Markdown as HTML, LaTeX and text; what is left out on paper
    names                       what axes and vectors are called in the convention of an arm
    wording, worked             the words for an arm; what a solution shows between formula and result
    expansion, cases            how a determinant is worked out; where the minors of a wide or tall J vanish together
    hint_context, lost_example  what hints tell of an arm; a lost direction in numbers
    statement, short_answer     statements, prompts, hints and solutions; an answer without the way to it
    translatable_phrases        words that problems carry
    languages, render           the messages of a language; the templates filled in
    collect_messages            all messages collected, and merged into locale/CODE.po (`make messages`)
"""
