"""Printers of formulas: of layouts as LaTeX, MathML, text, Typst and words, of SymPy's expressions as code."""
