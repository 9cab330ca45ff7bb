"""Outliers: single bad readings (a reflector not seated, a beam brushed, a person leaning on the table).

No parameters: bad readings are known by what they are off by, and get no weight. `shown` is given their share
as the one value of what was fitted.
"""

import numpy as np

from truepose.domain.results.causes import Detail
from truepose.domain.sentences import Text, said
from truepose.effects.causes import Candidate, Fitted, Scene, Shown
from truepose.effects.ports import Trait
from truepose.effects.without_parameters import WithoutParameters

NAME = "outliers"
_FEWEST = 10  # readings among which one can stand out


class Outliers(WithoutParameters):
    """Readings that belong to no model."""

    name = NAME
    traits = frozenset({Trait.SEARCHED, Trait.OF_READINGS})

    def unseen(self, scene: Scene) -> Text | None:
        """Need readings enough for one to stand out."""
        if len(scene.stops) < _FEWEST:
            return said("unseen.few_for_outliers")
        return None

    def candidates(self, scene: Scene) -> tuple[Candidate, ...]:
        """Return none: readings are judged one by one."""
        return ()

    def shown(self, subject: str, fitted: Fitted, scene: Scene) -> Shown:
        """Say how many readings are bad."""
        share, uncertainty = float(fitted.values[0]), float(np.sqrt(fitted.covariance[0, 0]))
        bad, all_readings = round(share * len(scene.stops)), len(scene.stops)
        key = "causes.outliers.one" if bad == 1 else "causes.outliers.several"
        sentence = said(key, bad=bad, readings=all_readings)
        return Shown(subject, share, "1", uncertainty, sentence, (Detail("readings", float(bad), "1", 0.0),))
