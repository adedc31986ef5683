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


def test_streams_of_other_seeds_are_others() -> None:
    draws = {tuple(Stream(f"planar-2r/{seed}").integer(0, 999) for _ in range(1)) for seed in range(200)}
    assert len(draws) > 150


def test_a_stream_outlasts_its_first_block() -> None:
    stream = Stream("long")
    values = [stream.below(1 << 64) for _ in range(1000)]
    assert len(set(values)) == 1000


@given(st.text(max_size=20), st.integers(min_value=1, max_value=1 << 64))
def test_below_stays_below(seed: str, n: int) -> None:
    try:
        seed.encode()
    except UnicodeEncodeError:
        return
    assert 0 <= Stream(seed).below(n) < n


def test_below_refuses_nothing_to_choose_from() -> None:
    with pytest.raises(ValueError, match="positive"):
        Stream("x").below(0)


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
    base = derived_seed("secret", "anna", "p1", "planar-2r")
    assert base == derived_seed("secret", "anna", "p1", "planar-2r")
    others = {
        derived_seed("secreT", "anna", "p1", "planar-2r"),
        derived_seed("secret", "annb", "p1", "planar-2r"),
        derived_seed("secret", "anna", "p2", "planar-2r"),
        derived_seed("secret", "ann", "ap1", "planar-2r"),
    }
    assert len(others | {base}) == 5
    assert all(0 <= seed < 1 << 63 for seed in others)
