"""Find the singular configurations of an arm, describe them, and rate the difficulty of the arm.

The *singular set* consists of all singular configurations. It is divided into *components*, each given by conditions on
the joint variables. Each module uses only modules above it in this list:

    existence_conditions    the lengths for which a condition can hold
    joint_solvability       whether conditions can hold simultaneously
    singular_set            the singular set: where the Jacobian loses rank
    normalized_arm          an arm without joint offsets and base position, on which singularities do not depend
    reciprocal              the singular set of an arm with more joints than task rows, by elimination
    axes                    how joint axes are arranged at a configuration
    reason                  whether an arrangement of axes is the reason for a singularity
    appearance              descriptions of singular configurations, such as "arm stretched out"
    reach                   whether an arm reaches a point, or points just beyond its current position
    singularity_kinds       whether a singular configuration is a boundary or an internal singularity
    classification          the kind and the description of a component
    difficulty              how hard an arm is to work through by hand
    directions              the direction of motion that is lost at a singular configuration
    meanings                true and false statements about a singular configuration, for questions with options
"""
