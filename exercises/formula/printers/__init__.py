"""Print formulas: one module for each notation.

These print layouts (`qdot.exercises.formula.layout`):

    latex, mathml           for documents and pages; for browsers
    unicode, typst          for terminals; for PDF
    speech                  in words, for screen readers

These print SymPy expressions, because the meaning must be preserved:

    maxima, python          for STACK; for notebooks
"""
