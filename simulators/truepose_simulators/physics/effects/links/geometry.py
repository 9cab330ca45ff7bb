"""Identified errors of the links: rows of the table that are off, as rigid motions of whole links."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from truepose_simulators.physics.effects.stated import Stated
from truepose_simulators.physics.rigid import FloatArray
from truepose_simulators.physics.table_arm import RowErrors, TableRow, link_motion

_FIELDS = {"alpha": "alpha_rad", "a": "a_mm", "beta": "beta_rad", "theta": "theta_rad", "d": "d_mm"}
_FORM = "alpha_<joint>, a_, beta_, theta_, d_"


def identified_links(rows: Sequence[TableRow], stated: Sequence[Stated]) -> FloatArray:
    """Motions of all links in the seats of their joints, shape (J, 6) [mm, rad].

    Several effects may speak of one row, such as geometry and axis parallelism: their errors add up before
    the row is moved.
    """
    errors = [RowErrors()] * len(rows)
    for effect in stated:
        for (quantity, joint), value in effect.matching(r"(alpha|a|beta|theta|d)_([0-9]+)", _FORM):
            index, field = effect.index(joint, len(rows), "joint"), _FIELDS[quantity]
            errors[index] = replace(errors[index], **{field: getattr(errors[index], field) + value})
    return np.array([link_motion(row, error) for row, error in zip(rows, errors, strict=True)])
