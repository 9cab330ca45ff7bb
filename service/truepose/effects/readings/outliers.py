"""Outliers: single bad readings (a reflector not seated, a beam brushed, a person leaning on the table).

No parameters: bad readings are known by what they are off by, and get no weight. `describe` is given their
share as the one value of what was fitted.
"""

import numpy as np

from truepose.domain.diagnosis import Detail
from truepose.effects.causes import Candidate, Description, FittedCause, Scene, Signature
from truepose.effects.ports import Trait, WithoutParameters
from truepose.messages.message import Text, message

NAME = "outliers"
_FEWEST = 10  # readings among which one can stand out


class Outliers(WithoutParameters):
    """Readings that no model explains."""

    name = NAME
    traits = frozenset({Trait.SEARCHED, Trait.OF_READINGS})
    signature = Signature("readings", "constant", "group", "fraction of the readings")

    def unseen(self, scene: Scene) -> Text | None:
        """Need readings enough for one to stand out."""
        if len(scene.stops) < _FEWEST:
            return message("unseen.few_for_outliers")
        return None

    def candidates(self, scene: Scene) -> tuple[Candidate, ...]:
        """Return none: readings are judged one by one."""
        return ()

    def describe(self, subject: str, fitted: FittedCause, scene: Scene) -> Description:
        """Say how many readings are bad."""
        share, uncertainty = float(fitted.values[0]), float(np.sqrt(fitted.covariance[0, 0]))
        bad, all_readings = round(share * len(scene.stops)), len(scene.stops)
        sentence = message("causes.outliers", n=bad, readings=all_readings)
        return Description(
            subject, share, "1", uncertainty, sentence, (Detail("readings", float(bad), "1", 0.0),)
        )
