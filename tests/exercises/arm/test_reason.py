"""What is told of singular configurations is why they are singular: it is so at no regular configuration."""

import re
from functools import partial

import numpy as np
import pytest

from exercises.arm import reason
from exercises.arm.appearance import NEAR, Statement, reason_of
from exercises.arm.axes import Sample, distance, off_level, off_line, off_one_way, off_plane, slope, spread
from exercises.arm.chain import TASK_ROWS, Chain
from exercises.arm.classification import samples_on
from exercises.arm.derivation import structure
from exercises.arm.kinematics import NumericChain
from exercises.arm.reason import is_reason
from exercises.arm.singularity import singular_set
from exercises.families import FAMILIES
from exercises.generation import sample_chain
from exercises.problem import ProblemId
from exercises.stream import Stream


def arm(family: str, seed: int = 1) -> Chain:
    return structure(sample_chain(ProblemId(family, seed, variation="chapter"))).chain


def always(_: Sample) -> bool:
    return True


def samples_of(chain: Chain, condition: str) -> list[Sample]:
    """Return configurations at which a condition holds, on arms of other lengths than those that were looked at."""
    return samples_on(chain, condition, "another draw", arms=4)


def test_what_is_so_at_regular_configurations_too_is_no_reason() -> None:
    """Axes 1 and 3 of an arm of seven joints on one line cost no rank; axes 3 and 5 do."""
    seven, elbow = arm("lbr-7r"), arm("elbow-3r")
    samples = samples_of(seven, "sin(theta2) = 0 and sin(theta6) = 0")
    assert max(sample.off(partial(off_line, i=0, j=2)) for sample in samples) < NEAR
    assert not is_reason(seven, samples, partial(off_line, i=0, j=2), always)
    assert is_reason(seven, samples_of(seven, "sin(theta4) = 0"), partial(off_line, i=2, j=4), always)
    on_axis = samples_of(elbow, "a1 + a2*cos(theta2) + a3*cos(theta2 + theta3) = 0")
    assert is_reason(elbow, on_axis, partial(distance, joint=0), always)
    assert not is_reason(elbow, on_axis, partial(slope, joint=0, movers=(1,)), always)


def test_measures_are_the_same_in_many_poses_at_once() -> None:
    """The measures take many poses; one by one they say the same."""
    chain = arm("ur-6r")
    sample = samples_of(chain, "sin(theta5) = 0")[0]
    poses = np.array([[Stream(f"measures/{k}").uniform(-3, 3) for _ in range(chain.n)] for k in range(5)])
    for off in MEASURES:
        together = off(sample.arm, poses)
        assert together.shape == (5,)
        assert together == pytest.approx([Sample(sample.arm, q).off(off) for q in poses], abs=1e-12)


MEASURES = (
    partial(distance, joint=1), partial(slope, joint=0, movers=(1, 2)), partial(spread, joints=(3, 5)),
    partial(spread, joints=(0, 3, 5)), partial(off_line, i=3, j=5), partial(off_plane, row=(1, 2, 3)), off_level,
    partial(off_one_way, joints=(0, 1)),
)  # fmt: skip


def test_axes_are_parallel_where_their_directions_are() -> None:
    """At s5 = 0 of a UR, axes 4 and 6 are parallel, and with them 2 and 3."""
    chain = arm("ur-6r")
    for sample in samples_of(chain, "sin(theta5) = 0"):
        z = sample.arm.frames(sample.q)[[1, 2, 3, 5], :3, 2]
        assert np.linalg.matrix_rank(z, 1e-6) == 1
        assert sample.off(partial(spread, joints=(3, 5))) < NEAR < sample.off_beside(partial(spread, joints=(3, 5)))


@pytest.mark.families(("stanford-6r", "ur-6r", "scara", "scorbot-wrist", "puma-560", "industrial-6r"), most=3)
def test_parallel_axes_are_a_reason_only_where_their_own_columns_depend_on_each_other(family: str) -> None:
    """At s2 = 0 of a Stanford arm axes 1 and 4 are parallel, which costs no rank by itself."""
    chain = arm(family)
    rows = [TASK_ROWS.index(row) for row in chain.task]
    for component in singular_set(chain) or ():
        samples = [sample for piece in component.pieces() for sample in samples_of(chain, piece)]
        said = reason_of(chain, samples)
        if said is not None and (joints := re.search(r"axes of joints ([\d, and]+) are parallel", said.words)):
            columns = [int(number) - 1 for number in re.findall(r"\d", joints[1])]
            for sample in samples:
                assert np.linalg.matrix_rank(sample.arm.jacobian(sample.q)[np.ix_(rows, columns)], 1e-6) < len(columns)


@pytest.mark.families(tuple(name for name in FAMILIES if name != "cartesian"), most=6)
def test_the_reason_that_is_told_holds_at_no_regular_configuration(
    family: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It is looked for from other starts, on arms of other lengths than those from which it was read."""
    chain = arm(family)
    for component in singular_set(chain) or ():
        read_from = [sample for piece in component.pieces() for sample in samples_on(chain, piece, "classify", arms=3)]
        said = reason_of(chain, read_from)
        others = [sample for piece in component.pieces() for sample in samples_of(chain, piece)]
        if said is None:
            continue
        assert all(sample.off(said.off) < NEAR for sample in others), said.words
        assert sum(map(said.true, others)) >= 0.9 * len(others), said.words  # here and there it can't be told
        with monkeypatch.context() as changed:
            changed.setattr(reason, "_starts", starts)
            found = {id(sample.arm): zeros(sample.arm, said) for sample in others}
        for sample in others:
            for q in found[id(sample.arm)]:
                assert not said.true(Sample(sample.arm, q)) or _is_singular(sample.arm, chain, q), said.words


def zeros(arm: NumericChain, said: Statement) -> np.ndarray:
    """Return configurations at which it is so, of those to which the search leads."""
    (q,) = reason._descended(arm, said.off, 1)
    return np.asarray(q[said.off(arm, q) < reason._CLOSE])


def starts(kinds: tuple[str, ...]) -> np.ndarray:
    """Other starts than those of qdot, and more."""
    stream = Stream("other starts")
    return np.array(
        [[stream.uniform(-3, 3) if kind == "R" else stream.uniform(0, 1) for kind in kinds] for _ in range(40)]
    )


def _is_singular(arm: NumericChain, chain: Chain, q: np.ndarray) -> bool:
    rows = [TASK_ROWS.index(row) for row in chain.task]
    sigma = np.linalg.svd(arm.jacobian(q)[rows], compute_uv=False)
    return bool(sigma[-1] < 1e-4 * sigma[0])
