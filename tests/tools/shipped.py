"""`python -m tests.tools.shipped`: compute the results for structures of the registered families, to ship them.

These are the structures of arms at each step of variation, as far as DRAWS draws find them; of the chapter's arms in
all conventions; of random arms, all clean structures; and of all real robots.
"""

from collections.abc import Callable, Iterator

from qdot.exercises.arm.chain import CONVENTIONS, TASK_ROWS, Chain
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.arm.derivation import results, structure
from qdot.exercises.arm.library import robot_path, robots
from qdot.exercises.arm.robot_file import read_robot
from qdot.exercises.arm.shipped import FILE, code_digest, results_to_text, structure_key
from qdot.exercises.arm.transforms import in_tool_frame, poses, seen_from_tool, terms_in_tool_frame, terms_of_last_pose
from qdot.exercises.common.console import say
from qdot.exercises.common.files import write_atomically
from qdot.exercises.common.variation import STEPS
from qdot.exercises.families import FAMILIES
from qdot.exercises.families.structures import build_arm, read_clean_structures
from qdot.exercises.generation import sample_chain
from qdot.exercises.problem.problem import ProblemId
from qdot.exercises.questions import QUESTIONS
from qdot.exercises.questions.transforms import MOST_JOINTS

BY_TRANSFORMS: tuple[tuple[str, Callable[[Chain], object], *tuple[Callable[[Chain], object], ...]], ...] = (
    ("transform", terms_of_last_pose, poses),
    ("tool-jacobian", terms_in_tool_frame, seen_from_tool, in_tool_frame),
)
"""Questions, the function that counts the terms of the answer, and further functions if there are not too many terms.

Random arms don't need these, which would be half of the file.
"""
DRAWS = 300
"""Number of draws of each family and step that are searched for structures."""


def arms() -> Iterator[Chain]:
    """Yield an arm of each structure."""
    seen = set()
    for arm in _all_arms():
        its = structure(arm).chain
        if its not in seen:
            seen.add(its)
            yield arm


def _all_arms() -> Iterator[Chain]:
    for name, family in FAMILIES.items():
        if not family.varied:
            yield from (sample_chain(ProblemId(name, 1, convention=convention)) for convention in CONVENTIONS)
            for step in STEPS:
                yield from (sample_chain(ProblemId(name, seed, variation=step)) for seed in range(1, DRAWS + 1))
    for n, clean in read_clean_structures().items():
        yield from (build_arm(clean_structure.rows, clean_structure.task, f"random-{n}") for clean_structure in clean)
    yield from (read_robot(robot_path(name)) for name in robots())


def lines(arm: Chain) -> dict[bytes, str]:
    """Return the lines of an arm's structure and of those of its first joints, by their keys."""
    by_key = {structure_key(structure(arm).chain): results_to_text(results_of(arm))}
    for joints in range(1, arm.n):
        part = structure(convention_of(arm).first_joints(joints)).chain
        by_key.setdefault(structure_key(part), results_to_text(results(part)))
    return by_key


def results_of(arm: Chain) -> dict[str, object]:
    """Return the results for an arm's structure that its questions may need."""
    its = structure(arm).chain
    has_minors = arm.name in FAMILIES or arm.n <= len(TASK_ROWS)  # else it is solved by elimination
    is_inverted = has_minors and QUESTIONS["inverse-jacobian"].refusal(arm) is None
    outcome = results(its, has_minors, is_inverted)
    for name, count, *more in BY_TRANSFORMS:
        if arm.n <= MOST_JOINTS and QUESTIONS[name].objects(arm) is None:
            is_random = arm.name in FAMILIES and FAMILIES[arm.name].varied
            is_asked = QUESTIONS[name].too_long(arm) is None and not is_random
            wanted = [count, *more] if is_asked else [count]
            outcome |= {work.__name__: work(its) for work in wanted}
    return outcome


def text() -> str:
    """Return the file."""
    by_key: dict[bytes, str] = {}
    for arm in arms():
        for its_key, line in lines(arm).items():  # of an arm that is the first joints of another, all is kept
            by_key[its_key] = max(by_key.get(its_key, ""), line, key=len)
    return "\n".join([code_digest(), *(f"{its_key.decode()} {line}" for its_key, line in sorted(by_key.items())), ""])


if __name__ == "__main__":
    write_atomically(FILE, text())
    say(f"wrote {FILE.name}")
