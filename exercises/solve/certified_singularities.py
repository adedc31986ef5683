"""Describe the singular configurations of a user's own arm for `qdot solve`.

A user's own arm has no certificate. Its descriptions pass the same test as those of a certified problem before they are
reported. If the test fails, only what is true of all singular configurations is reported.
"""

from collections.abc import Sequence
from dataclasses import replace

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.singularities.axes import Sample
from qdot.exercises.singularities.classification import Classification
from qdot.exercises.singularities.normalized_arm import normalize_arm
from qdot.exercises.singularities.singularity import Component
from qdot.exercises.verify.appearance import all_have_kind, sample_component, statement_holds
from qdot.exercises.writing.problem_texts import get_solution_steps
from qdot.exercises.writing.solution_steps import SingularComponent


def certified_components(chain: Chain) -> tuple[SingularComponent, ...]:
    """Return the certified components of the singular set, and store them in the arm's worked steps.

    Raises TooLong.
    """
    steps = get_solution_steps(chain)
    steps.singular_components = [_certify_component(chain, component) for component in steps.singular_components]
    return tuple(steps.singular_components)


def certified_component(chain: Chain, component: Component) -> SingularComponent:
    """Return a component with its certified kind and description; its conditions stay unchanged."""
    return replace(
        _certify_component(chain, get_solution_steps(chain).classify_component(component)),
        conditions=component.conditions,
    )


def certified_statement(chain: Chain, statement: str, samples: Sequence[Sample]) -> str:
    """Return a description of singular configurations; empty if it is false for a sample, or there are no samples."""
    return statement if samples and all(statement_holds(chain, statement, sample) for sample in samples) else ""


def _certify_component(chain: Chain, singular: SingularComponent) -> SingularComponent:
    component = Component(singular.conditions, singular.solutions)
    kind = _certify_kind(chain, component, singular.kind)
    cases = tuple((values, _certify_kind(chain, component.at(values), case)) for values, case in singular.cases)
    return replace(singular, kind=kind, cases=cases)


def _certify_kind(chain: Chain, component: Component, kind: Classification) -> Classification:
    normalized, samples = normalize_arm(chain), sample_component(chain, component)
    meaning = certified_statement(normalized, kind.meaning, samples) or convention_of(chain).universal_statement
    return replace(kind, meaning=meaning, uniform=kind.uniform and all_have_kind(normalized, kind, samples))
