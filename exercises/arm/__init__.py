"""Describe an arm by a DH table, and compute its frames.

Each module uses only modules above it in this list:

    vectors             rotations about axes; norms and products of numeric vectors
    conventions/        how arms are presented: a class for each convention, with all that depends on the convention
    chain               an arm: its DH table, base, point of interest and task
    axes_to_dh          the standard DH table of an arm that is described by its axes
    kinematics          frames and Jacobians, symbolic and numeric
    trigonometry        exact equality of trigonometric polynomials; their textbook forms
    standard_table      conversion of tables and axes to the standard table, and back to axes
    transforms          the poses of the frames; the Jacobian in the last frame
    mpmath_kinematics   an arm in numbers of 30 digits
    path                the motion along a straight line
"""
