"""Stops as rows: one for each nest, and which of them are the same place."""

from collections.abc import Mapping

import numpy as np

from truepose.domain.arrays import IntArray, distinct_values
from truepose.domain.measurement.campaign import Stops


def each_nest(stops: Stops, nests: IntArray) -> tuple[Stops, IntArray]:
    """Return every stop once per nest, stops in their order, and the nest of each row."""
    rows = np.repeat(np.arange(len(stops)), len(nests))
    return stops.taken(rows), np.tile(nests, len(stops))


def sites(stops: Stops) -> IntArray:
    """Return the configuration of each row, a revisit counting as the one it revisits, shape (n,).

    Revisits of revisits lead back to the first; names that go round in a circle count as one site.
    """
    if stops.repeat_of is None:
        return stops.config
    named = stops.repeat_of >= 0
    earlier = dict(zip(stops.config[named].tolist(), stops.repeat_of[named].tolist(), strict=True))
    first = {config: _first(config, earlier) for config in distinct_values(stops.config).tolist()}
    return np.array([first[config] for config in stops.config.tolist()], dtype=np.int64)


def _first(config: int, earlier: Mapping[int, int]) -> int:
    seen: list[int] = []
    while config in earlier and config not in seen:
        seen.append(config)
        config = earlier[config]
    return min(seen[seen.index(config) :]) if config in seen else config
