"""Rows of stops: one for each nest."""

from dataclasses import fields

import numpy as np

from service.domain.arrays import IntArray
from service.domain.campaign import Stops


def taken(stops: Stops, rows: IntArray) -> Stops:
    """Return some rows of a table of stops, shape (m,) indices."""
    columns = {field.name: getattr(stops, field.name) for field in fields(stops)}
    return Stops(**{name: None if c is None else c[rows] for name, c in columns.items()})


def each_nest(stops: Stops, nests: IntArray) -> tuple[Stops, IntArray]:
    """Return every stop once per nest, stops in their order, and the nest of each row."""
    rows = np.repeat(np.arange(len(stops)), len(nests))
    return taken(stops, rows), np.tile(nests, len(stops))


def sites(stops: Stops) -> IntArray:
    """Return the number of each row's configuration, a revisit counting as the one it revisits, shape (n,)."""
    if stops.repeat_of is None:
        return stops.config
    return np.where(stops.repeat_of >= 0, stops.repeat_of, stops.config)
