"""Certify problems: test every reference numerically, by methods independent of its derivation.

The references, which are the correct answers, come from symbolic algebra (`derivation`). Here, their text is
parsed like an answer, and evaluated at random configurations. Their values are compared with products of 4 x 4
matrices, finite differences of the poses and NumPy's linear algebra.

A singular set is tested in both directions: J loses rank on every piece of the set, and the set contains every
configuration of lower rank that Newton's method finds.

`qdot verify` is `grader.grading.certify`, which also judges the references. Modules:

    certificate                 `certify`, and the tests of questions, listed in its `CHECKS`
    formulas, numbers           tests of questions whose answers are formulas, vectors or numbers
    rank, singular              tests of ranks and lost directions, and of singular sets
    screws, path                tests of screws and exponentials, and of the motion along a line
    concepts, short_questions   tests of questions on concepts, and of short questions
    custom                      tests of questions that instructors define
    numeric_model               a numeric model of the arm: 4 x 4 products, finite differences, exponentials
    singularity_statements      tests of what a worked solution says about singular configurations
"""
