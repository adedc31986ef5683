"""Write the texts of problems and solutions: notation, wording, steps of solutions, conversion of Markdown.

The texts of each kind of question are macros in templates/questions: its prompt, hints and solution. The modules, from
formulas to complete texts:

    shortening, angles          shorter sums; one name for each angle of an arm
    line_breaking               wide formulas on several lines
    latex, typeset              SymPy's formulas in the textbook's notation; the formulas of a student's answer
    markup, typst               Markdown as HTML, LaTeX, text and Typst
    paper_texts                 texts without remarks on typing
    wording                     the words for an arm, and the names of its axes and vectors
    expansion, solution_steps   the steps that expand a determinant; all steps of a worked solution
    hint_context                what hints show of an arm and its results
    problem_texts, short_answer  statements, prompts, hints and solutions; answers without a derivation
    units                       units with superscripts
    custom_texts                the texts of questions that instructors define, with the values of an arm
    translatable_phrases        English phrases in problems
    languages, render           the messages of a language; rendering of templates
"""
