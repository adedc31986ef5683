"""Describe the singular configurations of a user's own arm for `qdot solve`, and test the descriptions.

A user's own arm has no certificate. Therefore descriptions of the arm's singular configurations are tested here like
those in the certificate of a problem. If the test fails, only what is true of all singular configurations is reported.
"""

from collections.abc import Sequence
from dataclasses import replace

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.conventions.base import NO_SIMPLE_MEANING
from qdot.exercises.singularities.axes import Sample
from qdot.exercises.singularities.classification import Classification
from qdot.exercises.singularities.normalized_arm import normalize_arm
from qdot.exercises.singularities.singular_set import Component
from qdot.exercises.verify.singularity_statements import all_have_kind, sample_component, statement_holds
from qdot.exercises.writing.problem_texts import get_solution_steps
from qdot.exercises.writing.solution_steps import SingularComponent


def certify_components(chain: Chain) -> tuple[SingularComponent, ...]:
    """Return the components of the singular set with certified kinds and descriptions. Raises TooLong.

    The components are also stored in the arm's `solution_steps`, which texts use.
    """
    steps = get_solution_steps(chain)
    steps.singular_components = [_certify_classifications(chain, component) for component in steps.singular_components]
    return tuple(steps.singular_components)


def certify_component(chain: Chain, component: Component) -> SingularComponent:
    """Return a component with certified kind and description, and with unchanged conditions."""
    certified_component = _certify_classifications(chain, get_solution_steps(chain).classify_component(component))
    return replace(certified_component, conditions=component.conditions)


def certify_statement(chain: Chain, statement: str, samples: Sequence[Sample]) -> str:
    """Return a description of singular configurations; empty if it is false at a sample, or if there are no samples."""
    return statement if samples and all(statement_holds(chain, statement, sample) for sample in samples) else ""


def _certify_classifications(chain: Chain, singular_component: SingularComponent) -> SingularComponent:
    """Return a component whose classification, and those of its cases, claim only what is true at all samples."""
    component = Component(singular_component.conditions, singular_component.solutions)
    classification = _certify_classification(chain, component, singular_component.classification)
    cases = []
    for values, case in singular_component.cases:
        cases.append((values, _certify_classification(chain, component.restrict_to(values), case)))
    return replace(singular_component, classification=classification, cases=tuple(cases))


def _certify_classification(chain: Chain, component: Component, classification: Classification) -> Classification:
    arm, samples = normalize_arm(chain), sample_component(chain, component)
    meaning = certify_statement(arm, classification.meaning, samples) or NO_SIMPLE_MEANING
    is_uniform = classification.is_uniform and all_have_kind(arm, classification, samples)
    return replace(classification, meaning=meaning, is_uniform=is_uniform)
