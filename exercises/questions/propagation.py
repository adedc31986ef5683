"""Axes, position vectors, columns and twists by velocity propagation (6.9 to 6.13; Example 6.4)."""

from exercises.answers import Matrix
from exercises.arm.chain import Chain
from exercises.arm.derivation import derive
from exercises.questions.base import Asked, Question, by_hand
from exercises.stream import Stream


def _axes(chain: Chain, rng: Stream) -> Asked:
    return Matrix(derive(chain).z), {}


def _vectors(chain: Chain, rng: Stream) -> Asked:
    return Matrix(derive(chain).p_star), {}


def _point_on_last_link(chain: Chain) -> str | None:
    return None if chain.point.frame == chain.n else f"its point moves with frame {chain.point.frame}, not the last"


def _geometric(chain: Chain, rng: Stream) -> Asked:
    return Matrix(derive(chain).geometric), {}


def _twist(chain: Chain, rng: Stream) -> Asked:
    return Matrix(derive(chain).twist()), {}


def _link_velocity(chain: Chain, rng: Stream) -> Asked:
    # Frame 1 moves alike on too many arms; frames beyond the third are too much work.
    k = rng.integer(min(2, chain.n - 1), min(chain.n - 1, 3))
    found = derive(chain)
    return Matrix(found.twist(found.link_jacobian(k))), {"frame": k}


def _has_inner_frame(chain: Chain) -> str | None:
    return None if chain.n > 1 else "it has one joint, so no frame between base and end"


QUESTIONS = (
    Question("joint-axes", "Joint axes", "below 6.10", _axes, too_long=by_hand("z")),
    Question(
        "position-vectors", "Position vectors p*", "6.13", _vectors, (), 2.0,
        _point_on_last_link, by_hand("p_star"),
    ),
    Question(
        "geometric-jacobian", "Geometric Jacobian by propagation", "6.12", _geometric,
        ("joint-axes", "position-vectors"), 2.0, too_long=by_hand("geometric"),
    ),
    Question(
        "twist", "Twist of the end effector", "6.9 and 6.10", _twist, ("geometric-jacobian",), 1.0,
        too_long=by_hand("geometric"),
    ),
    Question("link-velocity", "Velocity of a link frame", "6.9 and 6.10", _link_velocity, (), 1.0, _has_inner_frame),
)  # fmt: skip
