"""The robot and what stands around it, as they are described."""

import pytest

from truepose.domain.robot import FixedNest, span_triangle


@pytest.mark.parametrize(
    ("places_mm", "spans"),
    [
        ([], False),
        ([(0.0, 0.0, 0.0)], False),
        ([(0.0, 0.0, 0.0), (500.0, 0.0, 0.0)], False),
        ([(0.0, 0.0, 0.0), (500.0, 0.0, 0.0), (900.0, 1.0, 0.0)], False),
        ([(0.0, 0.0, 0.0), (500.0, 0.0, 0.0), (0.0, 300.0, 0.0)], True),
    ],
)
def test_fixed_nests_place_a_frame_where_three_are_off_a_line(places_mm, spans):
    assert span_triangle([FixedNest(place, 0.01) for place in places_mm]) is spans
