"""Derive the kinematics of an arm from its DH table: the Jacobian, its determinant and inverse, and the joint rates.

Each module uses only modules above it in this list:

    arithmetic    the kinds of values in a derivation: numbers, expressions or trees
    graph         a derivation in stages, any of which may contain a mistake
    derivation    the symbolic arm, and all results by two routes
    lengths       lengths replaced by symbols, and symbols replaced by values
"""
