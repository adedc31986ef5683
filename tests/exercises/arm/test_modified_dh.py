"""Arms described by a modified DH table (Craig): the same motion, other frames, and every text names these."""

import re
from dataclasses import replace

import numpy as np
import pytest
import sympy as sp

from qdot.exercises.arm.chain import Base, Chain, Joint
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.arm.conventions.modified_dh import ModifiedDh
from qdot.exercises.arm.kinematics import NumericChain, compute_link_frames
from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.stream import Stream
from qdot.exercises.derivation.derivation import derive
from qdot.exercises.families import FAMILIES
from qdot.exercises.figure.arm_parts import compute_convention_frames
from qdot.exercises.figure.pose import compute_skeleton, make_drawable_chain
from qdot.exercises.generation import generate, list_questions_of_family, sample_chain
from qdot.exercises.problem.problem import Problem, ProblemId
from qdot.exercises.verify.certificate import certify
from qdot.exercises.verify.numeric_model import compute_modified_frames
from qdot.exercises.writing.problem_texts import write_hints, write_prompt, write_solutions, write_statement
from tests.support.suites import few_families, on_families, select_for_suite

MODIFIED = "modified-dh"
FIXED = [name for name, family in FAMILIES.items() if not family.has_varied_structure]
SOME = select_for_suite(("polar-rp", "wrist-zyz"), FIXED)
FRAME_QUESTIONS = ("transform", "position-vectors", "joint-axes", "link-velocity", "tool-jacobian", "wrist-block",
             "own-frame-velocity")  # fmt: skip
"""Questions whose answers depend on the frames."""


def sample_modified_arm(family: str, seed: int = 1, variation: str = "full") -> Chain:
    return sample_chain(ProblemId(family, seed, variation=variation, convention=MODIFIED))


def sample_values(chain: Chain, poses: int = 3) -> tuple[dict[str, float], np.ndarray]:
    """Return lengths and joint values (poses x n)."""
    stream = Stream(f"told/{chain.name}")
    lengths = {symbol.name: stream.uniform(0.2, 1.2) for symbol in chain.parameters}
    return lengths, np.array([[stream.uniform(-2, 2) for _ in chain.q] for _ in range(poses)])


def evaluate_matrix(chain: Chain, matrix: sp.Matrix, lengths: dict[str, float], q: np.ndarray) -> np.ndarray:
    known = {sp.Symbol(name): value for name, value in lengths.items()} | dict(zip(chain.q, q.tolist(), strict=True))
    return np.array(matrix.subs(known).evalf().tolist(), dtype=float)


@few_families
def test_frames_are_those_of_the_modified_table(family: str) -> None:
    arm = sample_modified_arm(family)
    lengths, poses = sample_values(arm)
    expected, frames = compute_modified_frames(arm, lengths, poses), compute_link_frames(arm)
    standard = NumericChain(arm, lengths)
    for k, q in enumerate(poses):
        for i, frame in enumerate(frames):
            assert np.allclose(evaluate_matrix(arm, frame.rotation, lengths, q), expected[k, i, :3, :3], atol=1e-9)
            assert np.allclose(evaluate_matrix(arm, frame.origin, lengths, q)[:, 0], expected[k, i, :3, 3], atol=1e-9)
        point = convention_of(arm).point
        offset = [float(entry.subs(lengths)) for entry in point.offset]
        point_world = expected[k, point.frame, :3, :3] @ offset + expected[k, point.frame, :3, 3]
        assert np.allclose(point_world, standard.compute_point(q), atol=1e-9)
        p_star = standard.compute_point(q)[:, None] - expected[k, 1:, :3, 3].T
        assert np.allclose(evaluate_matrix(arm, derive(arm).p_star, lengths, q), p_star, atol=1e-9)


@on_families(SOME)
def test_questions_about_frames_are_certified(family: str) -> None:
    questions = [name for name in list_questions_of_family(family, MODIFIED) if name in FRAME_QUESTIONS]
    certificate = certify(generate(ProblemId(family, 2, tuple(questions), variation="full", convention=MODIFIED)))
    assert certificate.passed, certificate.failures
    assert {check.name for check in certificate.checks} >= {"modified table: axes", "modified table: point"}


def test_certificate_detects_wrong_table(monkeypatch: pytest.MonkeyPatch) -> None:
    problem = generate("elbow-3r/1@modified-dh", ["transform"])

    table = ModifiedDh._make_base_and_rows

    def wrong(convention: ModifiedDh) -> tuple[Base, list[Joint]]:
        base, (first, second, third) = table(convention)
        return base, [first, replace(second, alpha=-second.alpha), third]

    monkeypatch.setattr(ModifiedDh, "_make_base_and_rows", wrong)
    failed = {check.name for check in certify(problem).failures}
    assert {"modified table: axes", "modified table: point"} <= failed


@on_families(SOME)
def test_no_text_names_frames_of_the_standard_table(family: str) -> None:
    """There is no z_0 and no p*_0: the frame on the axis of joint 1 is frame 1."""
    problem = generate(ProblemId(family, 1, variation="full", convention=MODIFIED))
    texts = {"statement": write_statement(problem, "").replace("replace the chapter's $z_{i-1}$ and $p^*_{i-1}$", "")}
    for part in problem.parts:
        texts[f"{part.name}, prompt"] = write_prompt(problem, part)
        texts[f"{part.name}, hints"] = "\n".join(write_hints(problem, part))
    texts |= {f"{name}, solution": text for name, text in write_solutions(problem).items()}
    wrong = re.compile(r"(?:z|p\^\*)_\{?0\b|p\^\*_\{i-1\} *\$|z_\{i-1\} \\times|R_z\(\\theta_i\)\\, T_z\(d_i\)\\, T_x")
    assert not {name: match[0] for name, text in texts.items() if (match := wrong.search(text))}


@on_families(FIXED)
def test_figure_shows_frames_of_the_modified_table(family: str) -> None:
    arm = make_drawable_chain(sample_modified_arm(family))
    _, poses = sample_values(arm)
    for q in poses:
        assert np.allclose(
            compute_convention_frames(arm, compute_skeleton(arm, q)),
            compute_modified_frames(arm, {}, q[None])[0],
            atol=1e-9,
        )


@pytest.mark.parametrize(("alpha", "a"), [(0, "3/10"), ("pi/2", 0), ("pi/3", "a0"), ("pi", "-3/10")])
def test_first_row_may_have_length_and_twist(alpha: object, a: object) -> None:
    """Then frame 0 is the world frame, unlike in the standard table."""
    base = Base((sp.S(a), sp.S.Zero, sp.S.Zero), sp.S.Zero, sp.S(alpha))
    arm = replace(sample_modified_arm("elbow-3r", variation="chapter"), base=base)
    first = convention_of(arm).rows[0]
    assert (first.a, first.alpha, convention_of(arm).base) == (base.position[0], base.tilt, Base())
    lengths, poses = sample_values(arm)
    expected = compute_modified_frames(arm, lengths, poses)
    assert np.allclose(expected[:, 0], np.eye(4))
    assert certify(Problem(ProblemId("mine", 1), arm, ())).passed
    drawable = make_drawable_chain(arm)
    for q in poses:
        assert np.allclose(
            compute_convention_frames(arm, compute_skeleton(drawable, q)),
            compute_modified_frames(drawable, {}, q[None])[0],
            atol=1e-9,
        )
    on_axis = "O_0" if first.a == 0 else None  # d_1 leads from the axis to O_1
    assert convention_of(arm).origin_name(0) == on_axis
    flat = replace(sample_modified_arm("planar-3r", variation="chapter"), base=base)
    assert [convention_of(flat).origin_name(k) for k in range(4)] == ["O_1", "O_2", "O_3", "P"]


def test_id_contains_the_convention() -> None:
    for text in ("planar-2r/7@modified-dh", "planar-2r/7@chapter@modified-dh"):
        assert str(ProblemId.parse(text)) == text
    for text, wrong in (("7@full@modified", "'modified'"), ("7@full@zeros", "two variations")):
        with pytest.raises(QdotError, match=wrong):
            ProblemId.parse(f"planar-2r/{text}")


def test_origins_have_the_names_of_the_convention() -> None:
    planar, puma = (
        convention_of(sample_modified_arm(family, variation="chapter")) for family in ("planar-3r", "puma-560")
    )
    assert [planar.origin_name(k) for k in range(4)] == ["O_1", "O_2", "O_3", "P"]
    assert puma.origin_name(1) == "O_2"
    assert puma.origin_name(2) is None  # d3 leads away from O_2 of the standard
