"""Print formulas: one module for each notation.

These print layouts (`qdot.exercises.formula.layout`):

    latex, mathml           for documents and pages; for browsers
    unicode, typst          for terminals; for PDF
    speech                  in words, for screen readers

These print SymPy expressions, so that the text has the same meaning:

    maxima, python          for STACK; for notebooks
"""
