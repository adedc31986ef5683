"""Printers of formulas: a file for each notation.

Of layouts (`qdot.exercises.formula.layout`), whatever they were made from:

    latex, mathml           for documents and pages; for browsers
    unicode, typst          for terminals; for PDF
    speech                  in words, for those who hear a page

Of SymPy's expressions, where what they mean is wanted:

    maxima, python          for STACK; for notebooks
"""
