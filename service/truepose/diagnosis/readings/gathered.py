"""Bad readings that gather: what they share may be their cause.

A beam that was brushed or a reflector that was not seated spoils readings anywhere. Where more of the bad
ones than chance gives are of one nest, of one mounting, or of one part of the campaign or of a joint's range,
they are not bad one by one.
"""

from collections.abc import Iterator
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from truepose.diagnosis.distributions import so_many_drawn
from truepose.domain.arrays import BoolArray, FloatArray, IntArray
from truepose.domain.sentences import Sentence, said
from truepose.effects.causes import Scene, varied
from truepose.effects.names import joint_subject
from truepose.effects.shapes.times import spoken

_LEVEL = 0.01  # chance that bad readings which fell anywhere gather, over everything that they may share
_PARTS = 4  # of the campaign, or of a joint's range, with as many readings in each


class On(NamedTuple):
    """A variable that readings may depend on, in the words of the families."""

    variable: str
    kind: str
    joint: int | None = None  # 0-based


class Gathered(NamedTuple):
    """What bad readings share."""

    on: On
    p_value: float  # corrected for everything that they may share
    sentence: Sentence


class _Shared(NamedTuple):
    """What some readings have in common."""

    words: Sentence
    on: On
    readings: BoolArray  # (n,)
    by_stop: bool  # all readings of a stop have it in common: they count once


def gathered(scene: Scene, bad: BoolArray) -> Gathered | None:
    """Return what the bad readings (n,) share beyond chance; None where they may have fallen anywhere."""
    everything = tuple(_shareable(scene)) if bad.any() else ()
    chances = [len(everything) * _chance(scene.stops.config, bad, one) for one in everything]
    p_value, nearest = min(zip(chances, range(len(chances)), strict=True), default=(1.0, 0))
    if p_value > _LEVEL:
        return None
    shared = everything[nearest]
    sentence = said(
        "gathered",
        bad=int((bad & shared.readings).sum()),
        shared=shared.words,
        readings=int(shared.readings.sum()),
    )
    return Gathered(shared.on, p_value, sentence)


def _chance(config: IntArray, bad: BoolArray, shared: _Shared) -> float:
    """Return the chance that at least as many of the bad ones share it where they fall anywhere."""
    marked = shared.readings
    if shared.by_stop:
        _, first = np.unique(config, return_index=True)
        bad, marked = np.isin(config[first], config[bad]), marked[first]
    return so_many_drawn(int((bad & marked).sum()), int(bad.sum()), int(marked.sum()), len(bad))


def _shareable(scene: Scene) -> Iterator[_Shared]:
    """Yield everything that readings may share."""
    yield from _nests(scene)
    time_s, turns_deg = scene.stops.time_s, np.rad2deg(scene.stops.joints_rad.T)
    if time_s is not None and varied(time_s):
        yield from _times(time_s - scene.origin_s)
    for joint, turn_deg in enumerate(turns_deg):
        yield from _angles(joint, turn_deg)


def _nests(scene: Scene) -> Iterator[_Shared]:
    """Yield nests, mountings of the tool, and each nest in each mounting."""
    mounting, nests = scene.stops.attachment, np.unique(scene.nest).tolist()
    for nest in nests:
        yield _Shared(said("gathered.nest", nest=nest), On("nest", "nest"), scene.nest == nest, by_stop=False)
    if mounting is None:
        return
    for number in np.unique(mounting).tolist():
        words, mounted = said("gathered.mounting", mounting=number), mounting == number
        yield _Shared(words, On("attachment of the tool", "attachment"), mounted, by_stop=True)
        for nest in nests:
            both = On("nest and attachment of the tool", "attachment")
            words = said("gathered.nest_and_mounting", nest=nest, mounting=number)
            yield _Shared(words, both, mounted & (scene.nest == nest), by_stop=False)


def _times(time_s: FloatArray) -> Iterator[_Shared]:
    for low, high, within in _parts(time_s):
        words = said("gathered.time", low=spoken(low), high=spoken(high))
        yield _Shared(words, On("time", "time"), within, by_stop=True)


def _angles(joint: int, turn_deg: FloatArray) -> Iterator[_Shared]:
    name = joint_subject(joint)
    for low, high, within in _parts(turn_deg):
        words = said("gathered.angle", joint=name, low_deg=low, high_deg=high)
        yield _Shared(words, On(f"angle of {name}", "angle", joint), within, by_stop=True)


def _parts(values: FloatArray) -> Iterator[tuple[float, float, BoolArray]]:
    """Yield the ends of each part of a range, and the readings within."""
    edges = np.nanquantile(values, np.linspace(0.0, 1.0, _PARTS + 1))
    for part, (low, high) in enumerate(pairwise(edges.tolist())):
        last = part == _PARTS - 1
        yield low, high, (values >= low) & (values <= high if last else values < high)
