"""Mistakes in results computed from a Jacobian: its determinant, its inverse, rates and torques."""

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from itertools import combinations
from itertools import product as product_of

import numpy as np
import sympy as sp

from qdot.exercises.arm.arithmetic import apply_matrix, cofactor_signs, determinant, matrix_product
from qdot.exercises.arm.chain import TASK_ROWS, Chain
from qdot.exercises.arm.derivation import derive, structure
from qdot.exercises.arm.derivation_graph import Change, Working, links_to_point, singular_vectors
from qdot.exercises.mistakes.base import AnswerShape, Mistake, MistakeVariant, VariantGenerator, scale_entries


def _is_square(chain: Chain, min_joints: int = 2, max_joints: int = 6) -> bool:
    return len(chain.task) == chain.n and min_joints <= chain.n <= max_joints


def _is_wide(chain: Chain) -> bool:
    return chain.n > len(chain.task)


def _variants_if(applies: Callable[[Chain], bool], stage: str, *changes: Change) -> VariantGenerator:
    """Return a function that yields one variant per change of `stage`, for arms that satisfy `applies`."""
    return lambda chain, _: (MistakeVariant({stage: change}) for change in (changes if applies(chain) else ()))


def _combine(*all_variants: VariantGenerator) -> VariantGenerator:
    """Return a function that yields the variants of all the given functions, one after another."""
    return lambda chain, shape: (variant for variants in all_variants for variant in variants(chain, shape))


def _variants_if_square(stage: str, change: Change, min_joints: int = 2, max_joints: int = 6) -> VariantGenerator:
    return _variants_if(partial(_is_square, min_joints=min_joints, max_joints=max_joints), stage, change)


def _expand_without_signs(w: Working, _: np.ndarray) -> np.ndarray:
    """Return the determinant expanded along the first row, with correct 2 x 2 minors but without their signs."""
    return np.asarray((w["jacobian"][0] * w["minors"][0]).sum(axis=0))


def _multiply_diagonal(w: Working, _: np.ndarray) -> np.ndarray:
    diagonal_product = w["jacobian"][0, 0]
    for k in range(1, w.n):
        diagonal_product = diagonal_product * w["jacobian"][k, k]
    return np.asarray(diagonal_product)


def _factor_determinant(chain: Chain) -> list[tuple[sp.Expr, int]]:
    """Return the factors of this arm's det J with their powers; no factors if J is not square."""
    if not _is_square(chain, 1):
        return []
    values = dict(structure(chain).values)
    return [(factor.xreplace(values), power) for factor, power in derive(chain).generic_minors[0].factors]


def _drop_factor(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    factors = _factor_determinant(chain)
    for factor, _power in factors if len(factors) > 1 else ():
        if not factor.is_number:
            yield _variant_without_factor("determinant", chain, factor, factor)


def _drop_repeated_factor(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    """Yield variants without one of the repeated factors of |det J|, the manipulability."""
    for factor, power in _factor_determinant(chain):
        if power > 1 and not factor.is_number:
            yield _variant_without_factor("manipulability", chain, factor, sp.Abs(factor))


def _exchange_sine_and_cosine(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    """Yield variants with sine and cosine exchanged in a factor of the determinant that contains only one of them.

    If the angle contains a constant offset, the factor can be written as a sine or as a cosine. Swapping them can then
    give either sign, so both are yielded.
    """
    offset_by_joint = dict(zip(chain.q, chain.offsets, strict=True))
    for factor, _power in _factor_determinant(chain):
        trig_terms = factor.atoms(sp.sin, sp.cos)
        if len(trig_terms) == 1 and (factor / (trig := trig_terms.pop())).is_number:
            cofunction = (sp.cos if isinstance(trig, sp.sin) else sp.sin)(*trig.args)
            yield MistakeVariant({"determinant": _divide_by(trig / cofunction)})
            if any(offset_by_joint.get(symbol, 0) != 0 for symbol in trig.free_symbols):
                yield MistakeVariant({"determinant": _divide_by(-trig / cofunction)})


def _variant_without_factor(stage: str, chain: Chain, factor: sp.Expr, divisor: sp.Expr) -> MistakeVariant:
    """Return the variant in which `factor` is missing from the result of a stage.

    The result is divided by `divisor`, which is the factor or its absolute value.
    """
    symbols = {str(symbol) for symbol in factor.free_symbols}
    joint_symbols = symbols & set(map(str, chain.q))
    factor_words = "one that depends on the joints" if joint_symbols else "a length"
    return MistakeVariant(
        {stage: _divide_by(divisor)},
        {"factor": factor_words},
        missing_symbols=", ".join(sorted(joint_symbols or symbols)),
    )


def _divide_by(divisor: sp.Expr) -> Change:
    def divide(w: Working, correct_value: np.ndarray) -> np.ndarray:
        with np.errstate(all="ignore"):
            return np.asarray(correct_value / w.arithmetic.drop_derivatives(w.arithmetic.table_entry(divisor)))

    return divide


def _take_reciprocals(w: Working, _: np.ndarray) -> np.ndarray:
    jacobian = w["jacobian"]
    with np.errstate(all="ignore"):
        return np.asarray(np.where(jacobian == 0, jacobian, (jacobian * 0 + 1) / np.where(jacobian == 0, 1, jacobian)))


def _divide_again(w: Working, correct_value: np.ndarray) -> np.ndarray:
    with np.errstate(all="ignore"):
        return np.asarray(correct_value / w["determinant"])


def _maximal_minor(w: Working, columns: Sequence[int]) -> np.ndarray:
    return np.asarray(determinant(w["jacobian"][:, list(columns)]))


def _add_minors(w: Working, sign: int = 1) -> np.ndarray:
    """Return the sum of the maximal minors of J, or their alternating sum if `sign` is -1."""
    column_sets = combinations(range(w.n), len(w.chain.task))
    return np.asarray(sum(sign**k * _maximal_minor(w, columns) for k, columns in enumerate(column_sets)))


def _miscount_minors(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    """Yield variants with a wrong sum of the squared maximal minors.

    Only one square is used instead of the sum, or one square is omitted from it.
    """

    def miscount(w: Working, gram_determinant: np.ndarray, columns: Sequence[int], is_omitted: bool) -> np.ndarray:
        square = _maximal_minor(w, columns) * _maximal_minor(w, columns)
        return gram_determinant - square if is_omitted else square

    for columns in combinations(range(chain.n), len(chain.task)) if _is_wide(chain) else ():
        for leaves_out in (False, True):
            yield MistakeVariant({"gram determinant": partial(miscount, columns=columns, is_omitted=leaves_out)})


def _flip_product_sign(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    """Yield variants with the sign of one term of the cofactor expansion flipped.

    A term is an entry of J, or one link's contribution to that entry, times the cofactor of the entry.
    """

    def flip(w: Working, correct_determinant: np.ndarray, i: int, j: int, link: int | None = None) -> np.ndarray:
        entry = w["jacobian"][i, j] if link is None else w["effects"][j, link, task_rows[i]]
        return np.asarray(correct_determinant - 2 * entry * w["cofactors"][i, j])

    task_rows = [TASK_ROWS.index(row) for row in chain.task]
    for i, j in product_of(range(chain.n), repeat=2) if _is_square(chain, 2, 3) else ():
        yield MistakeVariant({"determinant": partial(flip, i=i, j=j)})
        for link in links_to_point(chain) if task_rows[i] < 3 else ():
            yield MistakeVariant({"determinant": partial(flip, i=i, j=j, link=link)})


def _flip_velocity_sign(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    for i, name in enumerate(chain.task):
        yield MistakeVariant({"wanted velocity": scale_entries(i, -1)}, {"name": name})


MISTAKES = (
    Mistake("determinant-plus", "Plus instead of minus in the determinant",
            "You seem to have added all products of the determinant. Half of them are subtracted.", "appendix",
            _variants_if_square("determinant", lambda w, _: determinant(w["jacobian"], 1), 2, 3)),
    Mistake("expansion-signs", "Signs of the expansion left out",
            "You seem to have added all minors of the expansion. Their signs alternate.", "appendix",
            _variants_if_square("determinant", _expand_without_signs, 3, 3)),
    Mistake("diagonal-only", "Product of the diagonal instead of the determinant",
            "You seem to have multiplied the entries on the diagonal. This gives the determinant of triangular "
            "matrices only.",
            "appendix", _variants_if_square("determinant", _multiply_diagonal)),
    Mistake("determinant-sign", "Determinant with the wrong sign",
            "The determinant seems to have the wrong sign. Did you exchange two rows or columns?", "appendix",
            _variants_if_square("determinant", lambda w, value: -value, 1)),
    Mistake("wave-exchanged", "Sine and cosine exchanged in the determinant",
            "You seem to have exchanged sine and cosine in the determinant. Check which identity you used to simplify "
            "it.", "6.8", _exchange_sine_and_cosine),
    Mistake("factor-lost", "Factor of the determinant lost",
            "You seem to have lost a factor of the determinant: {factor}.", "6.8",
            _drop_factor),
    Mistake("transpose-for-inverse", "Transpose instead of inverse",
            "You seem to have used the transpose of J instead of its inverse. They are equal for a rotation matrix, "
            "but not for a Jacobian.",
            "6.7",
            _combine(
                    _variants_if_square("inverse", lambda w, _: w["transposed jacobian"]),
                    _variants_if(_is_wide, "pseudo-inverse", lambda w, _: w["transposed jacobian"]),
                )),
    Mistake("gram-not-inverted", "Product J J^T not inverted",
            "You seem to have multiplied by J J^T without inverting it. The pseudo-inverse contains its inverse.",
            "6.7",
            _variants_if(
                    _is_wide, "pseudo-inverse",
                    lambda w, _: matrix_product(w["transposed jacobian"], w["gram matrix"]),
                )),
    Mistake("determinant-forgotten", "Division by the determinant forgotten",
            "You seem to have forgotten to divide by det J. Look at the formula for the inverse again.", "appendix",
            _variants_if_square("inverse", lambda w, _: w["adjugate"])),
    Mistake("determinant-multiplied", "Multiplied by the determinant",
            "You seem to have multiplied the adjugate by det J. Divide it by det J instead.", "appendix",
            _variants_if_square("inverse", lambda w, _: w["adjugate"] * w["determinant"], 1)),
    Mistake("determinant-squared", "Divided twice by the determinant",
            "You seem to have divided by det J twice. Divide by it only once.",
            "appendix", _variants_if_square("inverse", _divide_again, 1)),
    Mistake("adjugate-not-transposed", "Adjugate without the transpose",
            "You seem to have left each cofactor at the entry that it belongs to. The adjugate is the transpose of "
            "the matrix of cofactors.", "appendix",
            _variants_if_square("adjugate", lambda w, _: w["cofactors"])),
    Mistake("cofactor-signs", "Signs of the cofactors left out",
            "The cofactors seem to lack their signs. Every other minor is multiplied by -1.", "appendix",
            _combine(
                    _variants_if_square("cofactors", lambda w, _: w["minors"]),
                    _variants_if(
                        lambda chain: chain.n == len(chain.task) + 1, "self-motion",
                        lambda w, motion: motion * cofactor_signs(w.n)[0][:, None],
                    ),
                )),
    Mistake("reciprocal-entries", "Reciprocals of the entries instead of the inverse",
            "You seem to have taken the reciprocal of each entry of J. This does not give the inverse of a matrix.",
            "appendix",
            _variants_if_square("inverse", _take_reciprocals)),
    Mistake("jacobian-for-inverse", "Jacobian instead of its inverse",
            "You seem to have multiplied the velocity by J. Multiply it by the inverse of J to find the joint rates.",
            "6.7",
            _variants_if_square("rates", lambda w, _: apply_matrix(w["jacobian"], w["wanted velocity"]))),
    Mistake("minor-missing", "Minor missing",
            "One or more maximal minors seem to be missing. By the Cauchy-Binet formula, the squares of all of them "
            "are added.", "6.8",
            _miscount_minors),
    Mistake("minors-not-squared", "Minors not squared",
            "You seem to have added the maximal minors without squaring them. By the Cauchy-Binet formula, their "
            "squares are added.", "6.8",
            _variants_if(_is_wide, "gram determinant", lambda w, _: _add_minors(w))),
    Mistake("root-taken", "Root taken", "You seem to have taken a square root. The question does not ask for it.",
            "6.8",
            _variants_if(_is_wide, "gram determinant", lambda w, value: w.arithmetic.sqrt(value))),
    Mistake("direction-that-moves", "A direction that is not lost",
            "You seem to have given a direction in which the arm can still move. No column of J has a component along "
            "the lost direction.",
            "6.8",
            _variants_if(
                    lambda chain: len(chain.task) == 2, "lost direction", lambda w, _: singular_vectors(w)[0][:, 0]
                )),
    Mistake("null-vector-of-jacobian", "Joint rates instead of a direction of motion",
            "You seem to have given joint rates that J maps to zero. A lost direction is a vector u with u J = 0.",
            "6.8",
            _variants_if_square("lost direction", lambda w, _: singular_vectors(w)[2][-1])),
    Mistake("jacobian-for-transpose", "Jacobian instead of its transpose",
            "You seem to have multiplied the load by J. By the principle of virtual work, multiply it by the "
            "transpose of J.", "dual of 6.4",
            _variants_if_square("transposed jacobian", lambda w, _: w["jacobian"])),
    Mistake("product-sign", "Sign of one product of the determinant",
            "One product of the determinant seems to have the wrong sign. Did you add terms that should cancel?",
            "appendix", _flip_product_sign, rare=True),
    Mistake("blocks-added", "Determinants of the blocks added",
            "You seem to have added the determinants of the blocks. The determinant of a block triangular matrix is "
            "their product.",
            "6.8",
            _variants_if_square(
                    "determinant", lambda w, _: determinant(w["arm block"]) + determinant(w["wrist block"]), 6
                ), rare=True),
    Mistake("wrist-alone", "Wrist solved for the whole angular velocity",
            "You seem to have solved the wrist for the whole angular velocity. First subtract the angular velocity "
            "that joints 1 to 3 produce.",
            "6.7", _variants_if_square("jacobian", scale_entries((slice(3, None), slice(3)), 0), 6),
            rare=True),
    Mistake("sum-squared", "Square of the sum of the minors",
            "You seem to have added the maximal minors before you squared them. By the Cauchy-Binet formula, square "
            "each of them first.",
            "6.8", _variants_if(
                _is_wide, "gram determinant",
                lambda w, _: _add_minors(w) ** 2, lambda w, _: _add_minors(w, -1) ** 2,
            ), rare=True),
    Mistake("square-lost", "Square of a factor lost",
            "You seem to have only one of several equal factors in the determinant: {factor}.", "6.8",
            _drop_repeated_factor, rare=True),
    Mistake("velocity-sign", "Component of the velocity with the wrong sign",
            "You seem to have used the component {name} of the velocity with the wrong sign.",
            "6.7", _flip_velocity_sign,
            rare=True),
    Mistake("velocity-components-exchanged", "Components of the velocity exchanged",
            "You seem to have exchanged components of the velocity. Compare their order with the rows of J.", "6.7",
            _variants_if_square("wanted velocity", lambda w, velocity: velocity[::-1], max_joints=2)),
)  # fmt: skip
