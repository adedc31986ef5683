"""Parse, print and evaluate formulas, and compare them as functions and as sets of configurations.

A formula is a SymPy expression (one of qdot's results), a tree of nodes (a parsed answer), or a layout (for printing).
Whole answers, such as a vector in a notebook's variable, are parsed by `grader/judging`. From the bottom up:

    printing, sympy_text                print SymPy expressions as text, fast
    order                               puts terms and factors in the order in which a person writes them
    layout                              the layout of a formula as a tree
    styles, latex                       letters in bold and other styles; parses LaTeX into a layout
    printers/                           one module for each notation in which formulas are printed
    vocabulary                          words, signs, units and notations in typed answers: vocabulary.json
    names, trees                        the meaning of a name; expressions as trees of nodes, with operators + - * / **
    algebra                             splits trees into terms and factors, and differentiates them, without SymPy
    units                               the size and the dimension of a unit
    notation, tables                    LaTeX, typography and units as plain text; vectors and matrices without commas
    products                            evaluates operations on matrices
    metres                              distinguishes the unit m from a whole number
    parser                              parses a text in any common notation into a tree
    noise                               removes rounding errors of zeros computed with floating-point numbers
    program                             evaluates trees at many points at once
    field, angles, exact                compare rational functions of sines and cosines modulo a random prime
    equality                            decides whether two expressions are the same function
    scale                               decides whether they are the same up to signs and a constant factor
    set_parser, conditions              parse conditions as a union of pieces; decide whether two sets are equal
"""
