"""Describe an arm by a DH table, and derive its kinematics.

Each module uses only modules above it in this list:

    vectors             rotations about axes; norms and products of numeric vectors
    conventions/        how arms are presented: a class for each convention, with all that depends on the convention
    chain               an arm: its DH table, base, point of interest and task
    axes_to_dh          the standard DH table of an arm that is described by its axes
    kinematics          frames and Jacobians, symbolic and numeric
    trigonometry        exact equality of trigonometric polynomials; their textbook forms
    arithmetic          the kinds of values with which a derivation computes: numbers, expressions or trees
    standard_table      conversion of tables and axes to the standard table, and back to axes
    derivation_graph    a derivation in stages, any of which may contain a mistake
    derivation          the symbolic arm, and all results by two routes
    transforms          the poses of the frames; the Jacobian in the last frame
    lengths             lengths replaced by symbols, and symbols replaced by values
    mpmath_kinematics   an arm in numbers of 30 digits
    path                the motion along a straight line
    entry               parser for one entry of a table
    urdf, robot_file    readers of a user's own arm: a URDF; a ROBOT.toml in any convention
    robot_text          writer of an arm as ROBOT.toml
    library             the library of real robots
"""
