"""Find the singular configurations of an arm, say which motion each loses, and how hard an arm is.

From the bottom up:

    existence_conditions        the lengths for which a condition can hold at some configuration
    joint_solvability           whether conditions can hold simultaneously
    singularity                 where the Jacobian loses rank
    axes, reason                how axes are arranged at a configuration; whether this is the reason for a singularity
    normalized_arm              an arm without joint offsets and base position, on which singularities do not depend
    reach, three_joints         which points an arm reaches, and whether it reaches beyond its current position
    reciprocal                  more than six joints: where the Jacobian loses rank
    numeric_rank_check          a singular set checked numerically
    appearance, singularity_kinds  what a singular configuration looks like; whether one is boundary or internal
    classification              the kinds of singular sets, and what their configurations look like
    difficulty                  how hard an arm is to work through by hand
    directions, meanings        which motion is lost at a singular configuration; statements about its look
"""
