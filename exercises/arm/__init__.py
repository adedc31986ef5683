"""The arm: a DH table, its kinematics by two routes, and where it is singular.

From the bottom up:

    vectors                     rotations about axes; cross products
    conventions/                how arms are presented: a class for each convention, which answers what depends on it
    chain                       a DH table with base, point of interest and task: the only description of an arm
    kinematics, trigonometry    frames and Jacobians; exact equality of trigonometric polynomials, and textbook factors
    existence_conditions        for which lengths a condition holds anywhere
    transforms                  where the frames of a structure are; its Jacobian seen from the last one
    axes_to_dh, standard_table  the standard table of an arm that is described by its axes or by a modified table
    arithmetic                  what a derivation is computed in: numbers, SymPy or trees
    derivation_graph            a derivation in stages, in numbers, SymPy or trees, any of them changed by a mistake
    derivation                  all results, by both routes, once per structure
    joint_solvability           whether conditions ever hold together
    singularity                 where the Jacobian loses rank
    axes, reason                how axes lie at a configuration; whether that is why it is singular
    normalized_arm              an arm without what its singularities do not depend on: arms of a class share it
    lengths                     an arm's lengths left open, and numbers substituted for them
    reach, three_joints         which places an arm reaches, and whether it reaches beyond where it is
    reciprocal                  more than six joints: where the Jacobian loses rank
    numeric_rank_check          a singular set checked numerically
    appearance, singularity_kinds  what a singular configuration looks like; whether one is boundary or internal
    classification              what singular sets are: of which kind, and what their configurations look like
    difficulty                  how hard an arm is to work through by hand
    directions, meanings        which motion is lost there; what configurations look like
    mpmath_kinematics, path     the arm in numbers with many digits; along a straight line
    entry                       one entry of a table
    urdf, robot_file            the user's own arm: a URDF; a ROBOT.toml in any convention
    robot_text                  an arm written as ROBOT.toml
    library                     real robots, by their names
"""
