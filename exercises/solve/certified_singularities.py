"""What `qdot solve` says of singular configurations: what passed the test of a problem's certificate, and no more.

An arm of one's own has no certificate. What its configurations look like is put to the same test before it is told,
and where that fails, what is left is what is true of all singular configurations.
"""

from collections.abc import Sequence
from dataclasses import replace

from qdot.exercises.arm.axes import Sample
from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.classification import Kind, part_at
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.arm.normalized_arm import bare
from qdot.exercises.arm.singularity import Component
from qdot.exercises.verify.appearance import holds, is_of_kind, places_on
from qdot.exercises.writing.statement import worked_steps
from qdot.exercises.writing.worked import SingularComponent


def sound_components(chain: Chain) -> tuple[SingularComponent, ...]:
    """Return the components of the singular set, of which worked steps of the arm tell from then on what is sound.

    Raises TooLong.
    """
    steps = worked_steps(chain)
    steps.found = [_sound(chain, one) for one in steps.found]
    return tuple(steps.found)


def sound_component(chain: Chain, component: Component) -> SingularComponent:
    """Return the same of one component, however it was found; its conditions stay as they are."""
    return replace(_sound(chain, worked_steps(chain).classified(component)), conditions=component.conditions)


def sound_words(chain: Chain, words: str, samples: Sequence[Sample]) -> str:
    """Return words on singular configurations, nothing where they are false of one of these, or these are none."""
    return words if samples and all(holds(chain, words, sample) for sample in samples) else ""


def _sound(chain: Chain, one: SingularComponent) -> SingularComponent:
    component = Component(one.conditions, one.solutions)
    kind = _sound_kind(chain, component, one.kind)
    cases = tuple((values, _sound_kind(chain, part_at(component, values), case)) for values, case in one.cases)
    return replace(one, kind=kind, cases=cases)


def _sound_kind(chain: Chain, component: Component, kind: Kind) -> Kind:
    plain, samples = bare(chain), places_on(chain, component)
    meaning = sound_words(plain, kind.meaning, samples) or convention_of(chain).true_of_all
    return replace(kind, meaning=meaning, uniform=kind.uniform and is_of_kind(plain, kind, samples))
