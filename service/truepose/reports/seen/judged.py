"""What the figures of judged readings show, by the name of the figure."""

import numpy as np

from truepose.domain.sentences import Text
from truepose.identification.verdict.judge import Judged
from truepose.judgement.places import distance_from_axis_1
from truepose.reports.figures.curves.joint_residuals import residuals_by_joint
from truepose.reports.seen.errors import errors_sentence
from truepose.reports.seen.joints import joints_sentence
from truepose.reports.seen.places import neighbours_sentence, reach_sentence


def seen_by(judged: Judged) -> dict[str, Text]:
    """Return a sentence for histogram, reach, joints and arrows."""
    before, after = np.linalg.norm(judged.nominal_mm, axis=1), np.linalg.norm(judged.identified_mm, axis=1)
    reach = distance_from_axis_1(judged.identified.state.chain)
    return {
        "histogram": errors_sentence(before, after),
        "reach": reach_sentence(reach, after),
        "joints": joints_sentence(
            judged.stops.joints_rad, residuals_by_joint(judged), float(np.sqrt(judged.variance.mean()))
        ),
        "space": _space(judged),
    }


def _space(judged: Judged) -> Text:
    """Return what arrows show; those of lengths lie along the bar, whatever the error."""
    if judged.block.quantity == "length":
        return ""
    vectors = judged.vectors_mm(judged.identified_mm)
    share = float(judged.variance.mean() / np.maximum((vectors**2).mean(), 1e-12))
    return neighbours_sentence(judged.position_mm, vectors, min(share, 1.0))
