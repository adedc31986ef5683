"""Mistakes in results that are computed from a Jacobian: its determinant, its inverse, joint rates and torques.

For an arm with n joints, the stage "jacobian" is J (task rows, n, …). If J is square, "minors" and "cofactors" are (n,
n, …), and entry (i, j) belongs to J without row i and column j. "link derivatives" are (n joints, n + 1 links, 3, …);
the third axis stands for x, y and z. Here "…" stands for the axes of the arithmetic (`mistakes.base`). A maximal minor
is the determinant of as many columns of J as J has rows.
"""

from collections.abc import Iterator, Sequence
from functools import partial
from itertools import combinations, product

import numpy as np
import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.derivation.arithmetic import apply_matrix, cofactor_signs, determinant, matrix_product
from qdot.exercises.derivation.derivation import derive, make_symbolic_arm
from qdot.exercises.derivation.graph import Change, StageResults, decompose_jacobian, list_links_to_point
from qdot.exercises.mistakes import base
from qdot.exercises.mistakes.base import AnswerShape, MistakeVariant, VariantGenerator


def _has_square_jacobian(chain: Chain, *, min_joints: int = 2, max_joints: int = 6) -> bool:
    """Return whether J is square and the number of joints is in a range."""
    return chain.has_square_jacobian and min_joints <= chain.n <= max_joints


def _has_wide_jacobian(chain: Chain) -> bool:
    return chain.n > len(chain.task)


def _vary_if_wide(stage: str, *changes: Change) -> VariantGenerator:
    """Return a function that yields a variant for each change of a stage, if J has more columns than rows."""
    return base.combine(*(base.vary_if(_has_wide_jacobian, {stage: change}) for change in changes))


def _vary_if_square(stage: str, change: Change, *, min_joints: int = 2, max_joints: int = 6) -> VariantGenerator:
    """Return a function that yields one variant if J is square and the number of joints is in a range."""
    return base.vary_if(partial(_has_square_jacobian, min_joints=min_joints, max_joints=max_joints), {stage: change})


def _expand_without_signs(stages: StageResults, _: np.ndarray) -> np.ndarray:
    """Return the expansion of det J along the first row, with correct minors but a plus sign for every term."""
    return (stages["jacobian"][0] * stages["minors"][0]).sum(axis=0)


def _list_determinant_factors(chain: Chain) -> list[tuple[sp.Expr, int]]:
    """Return the factors of an arm's det J with their powers; [] if J is not square."""
    if not chain.has_square_jacobian:
        return []
    values_of_symbols = dict(make_symbolic_arm(chain).values)  # the arm's values for the symbols of its symbolic arm
    (symbolic_determinant,) = derive(chain).symbolic_minors
    return [(factor.xreplace(values_of_symbols), power) for factor, power in symbolic_determinant.factors]


def _drop_factor(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    """Yield variants without one of several factors of det J, except numbers."""
    factors = _list_determinant_factors(chain)
    for factor, _power in factors if len(factors) > 1 else ():
        if not factor.is_number:
            yield _make_variant_without_factor("determinant", chain, factor, factor)


def _drop_repeated_factor(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    """Yield variants without one of the repeated factors of the manipulability |det J|."""
    for factor, power in _list_determinant_factors(chain):
        if power > 1 and not factor.is_number:
            yield _make_variant_without_factor("manipulability", chain, factor, sp.Abs(factor))


def _exchange_sine_and_cosine(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    """Yield variants that replace a sine by a cosine, or vice versa, in a factor of det J with a single sine or cosine.

    If the angle contains a joint offset, the factor can be written as a sine or as a cosine. The exchange may then give
    either sign, so variants with both signs are yielded.
    """
    offset_by_joint = dict(zip(chain.q, chain.offsets, strict=True))
    for factor, _power in _list_determinant_factors(chain):
        trigs = list(factor.atoms(sp.sin, sp.cos))
        if len(trigs) != 1 or not (factor / trigs[0]).is_number:
            continue
        (trig,) = trigs
        cofunction = (sp.cos if isinstance(trig, sp.sin) else sp.sin)(*trig.args)
        yield MistakeVariant({"determinant": _divide_by(trig / cofunction)})
        if any(offset_by_joint.get(symbol, 0) != 0 for symbol in trig.free_symbols):
            yield MistakeVariant({"determinant": _divide_by(-trig / cofunction)})


def _make_variant_without_factor(stage: str, chain: Chain, factor: sp.Expr, divisor: sp.Expr) -> MistakeVariant:
    """Return the variant in which `factor` is missing from the result of a stage.

    To omit the factor, the result is divided by `divisor`, the factor or its absolute value.
    """
    symbols = {str(symbol) for symbol in factor.free_symbols}
    joint_symbols = symbols & set(map(str, chain.q))
    factor_words = "an expression in the joint variables" if joint_symbols else "a length"
    return MistakeVariant(
        {stage: _divide_by(divisor)},
        words={"factor": factor_words},
        missing_symbols=", ".join(sorted(joint_symbols or symbols)),
    )


def _divide_by(divisor: sp.Expr) -> Change:
    """Return the change that divides the result of a stage, which has no derivatives, by an expression."""
    return lambda stages, value: value / stages.arithmetic.drop_derivatives(stages.arithmetic.convert_entry(divisor))


def _take_reciprocals(stages: StageResults, _: np.ndarray) -> np.ndarray:
    """Return the reciprocal of each entry of J that is not zero."""
    jacobian = stages["jacobian"]
    ones = jacobian * 0 + 1  # 1 in the arithmetic of the stages, such as a formula tree
    return np.where(jacobian == 0, jacobian, ones / np.where(jacobian == 0, 1, jacobian))


def _compute_maximal_minor(stages: StageResults, columns: Sequence[int]) -> np.ndarray:
    return determinant(stages["jacobian"][:, list(columns)])


def _add_minors(stages: StageResults, sign: int = 1) -> np.ndarray:
    """Return the sum of the maximal minors of J, or their alternating sum if `sign` is -1."""
    column_sets = combinations(range(stages.n), len(stages.chain.task))
    return np.asarray(sum(sign**k * _compute_maximal_minor(stages, columns) for k, columns in enumerate(column_sets)))


def _miscount_minors(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    """Yield variants with a wrong sum of the squared maximal minors: only one of the squares, or all but one."""

    def miscount(
        stages: StageResults, gram_determinant: np.ndarray, columns: Sequence[int], is_omitted: bool
    ) -> np.ndarray:
        squared_minor = _compute_maximal_minor(stages, columns) * _compute_maximal_minor(stages, columns)
        return gram_determinant - squared_minor if is_omitted else squared_minor

    for columns in combinations(range(chain.n), len(chain.task)) if _has_wide_jacobian(chain) else ():
        for is_omitted in (False, True):
            yield MistakeVariant({"gram determinant": partial(miscount, columns=columns, is_omitted=is_omitted)})


def _flip_product_sign(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    """Yield variants with the wrong sign of one term of the cofactor expansion.

    A term is the product of an entry of J, or of one link's contribution to the entry, and the cofactor of the entry.
    """

    def flip(
        stages: StageResults, correct_determinant: np.ndarray, i: int, j: int, link: int | None = None
    ) -> np.ndarray:
        factor = stages["jacobian"][i, j] if link is None else stages["link derivatives"][j, link, chain.task_rows[i]]
        return correct_determinant - 2 * factor * stages["cofactors"][i, j]

    for i, j in product(range(chain.n), repeat=2) if _has_square_jacobian(chain, max_joints=3) else ():
        yield MistakeVariant({"determinant": partial(flip, i=i, j=j)})
        for link in list_links_to_point(chain) if chain.task[i] in ("vx", "vy", "vz") else ():
            yield MistakeVariant({"determinant": partial(flip, i=i, j=j, link=link)})


VARIANTS: dict[str, VariantGenerator] = {
    "determinant-plus": _vary_if_square(
        "determinant", lambda stages, _: determinant(stages["jacobian"], sign=1), max_joints=3
    ),
    "expansion-signs": _vary_if_square("determinant", _expand_without_signs, min_joints=3, max_joints=3),
    "diagonal-only": _vary_if_square("determinant", lambda stages, _: np.diagonal(stages["jacobian"]).prod(axis=-1)),
    "determinant-sign": _vary_if_square("determinant", lambda stages, value: -value, min_joints=1),
    "wave-exchanged": _exchange_sine_and_cosine,  # sine for cosine, or cosine for sine
    "factor-lost": _drop_factor,
    "transpose-for-inverse": base.combine(
        _vary_if_square("inverse", lambda stages, _: stages["transposed jacobian"]),
        _vary_if_wide("pseudo-inverse", lambda stages, _: stages["transposed jacobian"]),
    ),
    "gram-not-inverted": _vary_if_wide(
        "pseudo-inverse", lambda stages, _: matrix_product(stages["transposed jacobian"], stages["gram matrix"])
    ),
    "determinant-forgotten": _vary_if_square("inverse", lambda stages, _: stages["adjugate"]),
    "determinant-multiplied": _vary_if_square(
        "inverse", lambda stages, _: stages["adjugate"] * stages["determinant"], min_joints=1
    ),
    "determinant-squared": _vary_if_square(
        "inverse", lambda stages, value: value / stages["determinant"], min_joints=1
    ),
    "adjugate-not-transposed": _vary_if_square("adjugate", lambda stages, _: stages["cofactors"]),
    "cofactor-signs": base.combine(
        _vary_if_square("cofactors", lambda stages, _: stages["minors"]),
        base.vary_if(
            lambda chain: chain.n == len(chain.task) + 1,
            # rate i of a self-motion is the maximal minor without column i, with alternating signs
            {"self-motion": lambda stages, motion: motion * cofactor_signs(stages.n)[0][:, None]},
        ),
    ),
    "reciprocal-entries": _vary_if_square("inverse", _take_reciprocals),
    "jacobian-for-inverse": _vary_if_square(
        "required rates", lambda stages, _: apply_matrix(stages["jacobian"], stages["wanted velocity"])
    ),
    "minor-missing": _miscount_minors,
    "minors-not-squared": _vary_if_wide("gram determinant", lambda stages, _: _add_minors(stages)),
    "root-taken": _vary_if_wide("gram determinant", lambda stages, value: stages.arithmetic.sqrt(value)),
    "direction-that-moves": base.vary_if(
        lambda chain: len(chain.task) == 2, {"lost direction": lambda stages, _: decompose_jacobian(stages).u[:, 0]}
    ),  # the direction perpendicular to the lost direction
    "null-vector-of-jacobian": _vary_if_square(
        "lost direction", lambda stages, _: decompose_jacobian(stages).v_transposed[-1]
    ),
    "jacobian-for-transpose": _vary_if_square("transposed jacobian", lambda stages, _: stages["jacobian"]),
    "product-sign": _flip_product_sign,
    "blocks-added": _vary_if_square(
        "determinant",
        lambda stages, _: determinant(stages["arm block"]) + determinant(stages["wrist block"]),
        min_joints=6,
    ),
    "wrist-alone": _vary_if_square(  # the angular rows of joints 1 to 3 are zero
        "jacobian", base.scale_entries((slice(3, None), slice(3)), factor=0), min_joints=6
    ),
    "sum-squared": _vary_if_wide(
        "gram determinant",
        lambda stages, _: _add_minors(stages) ** 2,
        lambda stages, _: _add_minors(stages, sign=-1) ** 2,
    ),
    "square-lost": _drop_repeated_factor,
    "velocity-sign": base.vary_each(
        lambda chain: enumerate(chain.task),
        lambda i, name: MistakeVariant({"wanted velocity": base.scale_entries(i, factor=-1)}, words={"name": name}),
    ),
    "velocity-components-exchanged": _vary_if_square(
        "wanted velocity", lambda stages, velocity: velocity[::-1], max_joints=2
    ),
}
