"""Formulas as people write them: parsed, evaluated, compared as functions and as sets of configurations.

From the bottom up:

    printing, sympy_text                SymPy's expressions as text, fast
    order                               terms and factors in the order in which a person writes them
    layout, latex                       how a formula is laid out, one tree whatever it was made from; our LaTeX as such
    printers/                           a file for each notation that it is printed in; Maxima and Python from SymPy
    vocabulary                          words, signs, units and habits of those who write: vocabulary.json
    names, trees                        what a name stands for; expressions as trees of plain nodes
    algebra                             trees added, multiplied and differentiated, without SymPy
    notation, tables                    LaTeX, typography and units as plain text; vectors and matrices without commas
    products                            operations on matrices carried out
    metres                              the unit m distinguished from a whole number
    parser                              text to a tree by a grammar, in whatever notation it was written
    noise                               removes what floating-point numbers leave of zero
    program                             trees evaluated at many points at once
    field, angles, exact                rational functions of sines and cosines, compared modulo a random prime
    identity                            are two expressions the same function
    scale                               are they the same but for a sign, or for a constant factor
    set_parser, conditions              conditions as a union of pieces; are two sets the same
"""
