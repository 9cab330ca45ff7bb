"""What sizes of errors before and after show."""

from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.sentences import Sentence, Text, said, together
from truepose.reports.wording.rounding import millimetres

_FAR: Final = 5.0  # typical (median) errors
_MOST: Final = 0.95


def errors_sentence(before_mm: FloatArray, after_mm: FloatArray) -> Text:
    """Return where nearly all errors lie before and after, and which lie far out.

    Parameters
    ----------
    before_mm, after_mm : ndarray, shape (n,)
        Sizes of the errors of the same readings.
    """
    before, after = (float(np.quantile(sizes, _MOST)) for sizes in (before_mm, after_mm))
    key = "seen.errors.better" if after < before else "seen.errors.no_better"
    told = said(key, before=millimetres(before), after=millimetres(after))
    far = int((after_mm > _FAR * np.median(after_mm)).sum())
    if not far:
        return told
    return together(told, said("seen.errors.far_one" if far == 1 else "seen.errors.far", number=far))


def distances_sentence(mean_mm: float, positive_share: float, pairs: int) -> Sentence:
    """Return whether distances err to one side.

    Pairs share points: the share is believed only where it is far from one half.
    """
    if pairs < 1 or abs(positive_share - 0.5) < 0.15:
        return said("seen.distances.nothing")
    percent = 100.0 * max(positive_share, 1.0 - positive_share)
    key = "seen.distances.long" if positive_share > 0.5 else "seen.distances.short"
    return said(key, percent=percent, mean=millimetres(abs(mean_mm)))
