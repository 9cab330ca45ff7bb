"""Bodies become nouns of the domain and back: names, units, and what a body leaves to others."""

import math
from dataclasses import dataclass

import pytest

from truepose.web.schemas import Reply, Request


@dataclass(frozen=True)
class Noun:
    number: int
    joints_rad: tuple[float, ...]
    ways_rad: tuple[tuple[float, ...], ...]
    speed_rad_s: float | None
    legs: tuple[tuple[int, int], ...] = ()
    seen: str = "nobody"


class Body(Request):
    number: int
    joints_deg: list[float]
    ways_deg: list[list[float]]
    speed_deg_s: float | None = None
    legs: list[list[int]]
    note: str = "kept by nobody"


class Shown(Reply):
    joints_deg: list[float]
    speed_deg_s: float | None
    number: int


class Several(Reply):
    shown: list[Shown]
    other: Shown | None


BODY = Body(number=3, joints_deg=[90, -45.0], ways_deg=[[180.0], []], legs=[[1, 2]])


def test_a_body_becomes_a_noun_with_angles_in_rad_and_tuples_for_lists():
    assert BODY.into(Noun) == Noun(
        3, (math.pi / 2, -math.pi / 4), ((math.pi,), ()), None, legs=((1, 2),), seen="nobody"
    )


def test_what_is_said_besides_counts_for_the_body():
    assert BODY.into(Noun, number=4, speed_rad_s=1.0, seen="Ada").number == 4


def test_a_noun_is_not_made_of_half_of_its_fields():
    class Short(Request):
        number: int

    with pytest.raises(TypeError, match="joints_rad"):
        Short(number=1).into(Noun)


def test_a_noun_is_shown_with_angles_in_deg_also_within_another():
    noun = Noun(1, (math.pi / 2,), (), math.pi)

    several = Several.of(None, shown=[noun, noun], other=None)

    assert Shown.of(noun).model_dump() == {"joints_deg": [90.0], "speed_deg_s": 180.0, "number": 1}
    assert several.shown[1].joints_deg == [90.0]
    assert several.other is None


def test_an_angle_that_is_not_known_stays_unknown():
    assert Shown.of(Noun(1, (), (), None)).speed_deg_s is None
