"""Certify problems: test every reference numerically, by methods independent of its derivation.

The references come from symbolic algebra on a structure (`derivation`). Here they are parsed from their text, as an
answer is, evaluated at random places and compared with products of 4 x 4 matrices, finite differences of the poses and
NumPy's linear algebra. A singular set is tested both ways: on every piece of it rank is lost, and every configuration
of lower rank that Newton's method finds lies in it.

    certificate         `certify`, and the tests of questions, listed in its `CHECKS`
    formulas, numbers   tests of questions: formulas and vectors, numbers,
    rank, singular      ranks and lost directions, singular sets,
    screws, path        screws and exponentials, a path,
    concepts, quizzes   statements, short questions
    numeric_reference   the arm in numbers, by 4 x 4 products, finite differences and the product of exponentials
    appearance          what a worked solution says about singular configurations, by moving joints
"""
