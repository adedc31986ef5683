"""Describe an arm by a DH table, derive its kinematics by two routes, and find its singular configurations.

From the bottom up:

    vectors                     rotations about axes; cross products
    conventions/                how arms are presented: a class for each convention, with all that depends on it
    chain                       an arm: its DH table, base, point of interest and task
    kinematics, trigonometry    frames and Jacobians; exact equality of trigonometric polynomials, and textbook factors
    existence_conditions        the lengths for which a condition can hold at some configuration
    transforms                  the poses of the frames of a structure; its Jacobian in the last frame
    axes_to_dh, standard_table  the standard table of an arm that is described by its axes or by a modified table
    arithmetic                  the arithmetic of a derivation: numbers, SymPy or formula trees
    derivation_graph            a derivation in stages, any of which may contain a mistake
    derivation                  all results, by both routes, once per structure
    joint_solvability           whether conditions can hold simultaneously
    singularity                 where the Jacobian loses rank
    axes, reason                how axes are arranged at a configuration; whether this is the reason for a singularity
    normalized_arm              an arm without joint offsets and base position, on which singularities do not depend
    lengths                     lengths replaced by symbols, and values substituted for symbolic lengths
    reach, three_joints         which points an arm reaches, and whether it reaches beyond its current position
    reciprocal                  more than six joints: where the Jacobian loses rank
    numeric_rank_check          a singular set checked numerically
    appearance, singularity_kinds  what a singular configuration looks like; whether one is boundary or internal
    classification              the kinds of singular sets, and what their configurations look like
    difficulty                  how hard an arm is to work through by hand
    directions, meanings        which motion is lost at a singular configuration; statements about its look
    mpmath_kinematics, path     the numeric arm with many digits; its motion along a straight line
    entry                       parser for one entry of a table
    urdf, robot_file            readers of the user's own arm: a URDF; a ROBOT.toml in any convention
    robot_text                  writer of an arm as ROBOT.toml
    library                     the library of real robots
"""
