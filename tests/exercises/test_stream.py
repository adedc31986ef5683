"""The random stream: the same numbers everywhere for good, and fair."""

from collections import Counter

import pytest
from hypothesis import given
from hypothesis import strategies as st

from exercises.stream import Stream, derived_seed


def test_a_seed_gives_the_same_numbers_for_good() -> None:
    stream = Stream("qdot")
    assert [stream.below(10) for _ in range(20)] == [5, 8, 1, 3, 5, 4, 0, 1, 0, 4, 6, 9, 0, 3, 7, 7, 3, 0, 1, 3]
    assert Stream("qdot").uniform(0, 1) == 0.2965712178569676
    assert Stream("qdot").shuffled("abcdef") == list("abcedf")
    assert derived_seed("secret", "anna", "p1") == 1761065311792996335


def test_streams_of_other_seeds_are_others_and_long() -> None:
    assert len({Stream(f"planar-2r/{seed}").integer(0, 999) for seed in range(200)}) > 150
    stream = Stream("long")  # it outlasts its first block
    assert len({stream.below(1 << 64) for _ in range(1000)}) == 1000
    with pytest.raises(ValueError, match="positive"):
        stream.below(0)


@given(st.text(st.characters(codec="utf-8"), max_size=20), st.integers(min_value=1, max_value=1 << 64))
def test_below_stays_below(seed: str, n: int) -> None:
    assert 0 <= Stream(seed).below(n) < n


def test_draws_are_fair() -> None:
    stream = Stream("fair")
    counts = Counter(stream.below(6) for _ in range(6000))
    assert set(counts) == set(range(6))
    assert max(abs(count - 1000) for count in counts.values()) < 150


@given(st.lists(st.integers(), max_size=12), st.integers(min_value=0, max_value=99))
def test_shuffling_keeps_the_items(items: list[int], seed: int) -> None:
    assert sorted(Stream(str(seed)).shuffled(items)) == sorted(items)


@given(st.floats(-1e6, 1e6), st.floats(0.001, 1e6))
def test_uniform_keeps_to_its_interval(low: float, width: float) -> None:
    assert low <= Stream("u").uniform(low, low + width) <= low + width


def test_a_derived_seed_depends_on_each_part_and_on_their_borders() -> None:
    parts = ("secret", "anna", "p1", "planar-2r")
    others = [("secreT", *parts[1:]), ("secret", "annb", *parts[2:]), (*parts[:2], "p2", parts[3])]
    seeds = {derived_seed(*each) for each in (parts, *others, ("secret", "ann", "ap1", "planar-2r"))}
    assert len(seeds) == 5 and all(0 <= seed < 1 << 63 for seed in seeds)
    assert derived_seed(*parts) in seeds
