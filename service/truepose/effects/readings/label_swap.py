"""Label swap: what is written down for one nest was read at another.

No parameters: the readings say it one by one, when each fits the other nest. `describe` is given the share of
the readings of the two nests that are swapped as the one value of what was fitted.
"""

import numpy as np

from truepose.domain.arrays import distinct_values
from truepose.domain.diagnosis import Detail
from truepose.effects.causes import Candidate, Description, FittedCause, Scene, Signature
from truepose.effects.ports import Trait, WithoutParameters
from truepose.messages.message import Text, message

NAME = "label_swap"
_SEVERAL = 2


def pair_subject(first: int, second: int) -> str:
    """Return e.g. `nest 1, nest 3`, ascending."""
    # One name for the pair, whichever of the two was read at the other.
    return f"nest {min(first, second)}, nest {max(first, second)}"


class LabelSwap(WithoutParameters):
    """Two nests whose labels were swapped."""

    name = NAME
    traits = frozenset({Trait.SEARCHED, Trait.OF_READINGS})
    signature = Signature("readings", "constant", "group", "fraction of the readings")

    def unseen(self, scene: Scene) -> Text | None:
        """Need several nests."""
        if len(distinct_values(scene.nest)) < _SEVERAL:
            return message("unseen.one_nest")
        return None

    def candidates(self, scene: Scene) -> tuple[Candidate, ...]:
        """Return none: readings are tried one by one against the other nests."""
        return ()

    def describe(self, subject: str, fitted: FittedCause, scene: Scene) -> Description:
        """Say how many of the readings of two nests are swapped."""
        share, uncertainty = float(fitted.values[0]), float(np.sqrt(fitted.covariance[0, 0]))
        first, second = (int(part.split()[1]) for part in subject.split(", "))
        readings = int(np.isin(scene.nest, (first, second)).sum())
        swapped = round(share * readings)
        sentence = message(
            "causes.label_swap", first=first, second=second, swapped=swapped, readings=readings
        )
        details = (Detail("readings", float(swapped), "1", 0.0),)
        return Description(subject, share, "1", uncertainty, sentence, details)
