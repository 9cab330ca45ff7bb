"""Stops of the arm at which a person connects six legs, over the fixtures of the thesis."""

from tests.helpers.ballbar.pose_device import CUPS, NESTS
from tests.studies.ballbar_report.coded_stops import CODES_MM, READING_U_MM, ZERO_U_MM, StopMaker

READINGS = {"reading_u_mm": READING_U_MM, "zero_u_mm": ZERO_U_MM, "range_mm": 1.0}
BALLBAR = {**READINGS, "nominal_mm": 300.0}
_MAKER = StopMaker(CUPS, NESTS)


def coded_stop(rng, u_mm=0.06, offsets_mm=CODES_MM):
    """Return a stop whose six lengths are aimed at 300 mm and these offsets, in random order."""
    return _MAKER.stop(rng, u_mm, offsets_mm)
