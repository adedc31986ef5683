"""Describe an arm by a DH table, and derive its kinematics by two routes, once per structure.

From the bottom up:

    vectors                     rotations about axes; cross products
    conventions/                how arms are presented: a class for each convention, with all that depends on it
    chain                       an arm: its DH table, base, point of interest and task
    kinematics, trigonometry    frames and Jacobians; exact equality of trigonometric polynomials, and textbook factors
    transforms                  the poses of the frames of a structure; its Jacobian in the last frame
    axes_to_dh, standard_table  the standard table of an arm that is described by its axes or by a modified table
    arithmetic                  the arithmetic of a derivation: numbers, SymPy or formula trees
    derivation_graph            a derivation in stages, any of which may contain a mistake
    derivation                  all results, by both routes, once per structure
    lengths                     lengths replaced by symbols, and values substituted for symbolic lengths
    mpmath_kinematics, path     the numeric arm with many digits; its motion along a straight line
    entry                       parser for one entry of a table
    urdf, robot_file            readers of the user's own arm: a URDF; a ROBOT.toml in any convention
    robot_text                  writer of an arm as ROBOT.toml
    library                     the library of real robots
"""
