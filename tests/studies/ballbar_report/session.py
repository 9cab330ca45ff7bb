"""One recorded ballbar session, the tracker campaign of the same robot, and the truth of both."""

import json
import shutil
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from tests.studies.diagnosis_report.recorder import Recorder
from truepose.demo.errors import TruthUnknownError
from truepose.domain.arrays import FloatArray
from truepose.domain.campaign import Campaign, FixtureLengths, PointReadings
from truepose.domain.robot import Nest
from truepose.exchange.campaigns.folder import DESCRIPTION, read_campaign
from truepose.identification.observations.fixture import TOOL_PLACEMENT

_TRACKER = "tracker.json"  # describes the tracker campaign of the same folder
_TRUTH = "truth.json"
_TRUE_POSITIONS = "true_validation.csv"  # config, nest, x, y, z
Cup = tuple[int, int]  # placement, base point


@dataclass(frozen=True, slots=True, eq=False)
class Session:
    """What was measured, and what is true."""

    ballbar: Campaign
    tracker: Campaign
    validation_mm: FloatArray  # (n, 3) true places of the nests of the validation readings, world
    cups_mm: dict[Cup, FloatArray]  # true places of the cups, world
    nests_mm: FloatArray  # (3, 3) true, flange frame
    legs_mm: FloatArray  # true lengths of the legs, in their order
    out_of_range: int  # legs

    @property
    def readings(self) -> PointReadings:
        """The validation readings, of which only stops and nests count here."""
        if self.ballbar.validation is None:
            raise TruthUnknownError("The recorded campaign has no validation readings.")
        return self.ballbar.validation

    @property
    def poses(self) -> int:
        """Number of configurations with a leg."""
        legs = self.ballbar.legs
        return 0 if legs is None else len(np.unique(legs.stops.config))


def record_session(
    recorder: Recorder, scenario: str, seed: int, plan: Path, folder: Path, validation: int
) -> Session:
    """Record a session as after a pre-calibration and read it back.

    Raises
    ------
    RecorderFailedError, InputFileError, TruthUnknownError
        The session cannot be recorded, or not read.
    """
    recorder.record(
        *(scenario, "--quiet", "--seed", str(seed), "--ballbar", str(plan), "--aimed"),
        *("--validation", str(validation), "--out", str(folder)),
    )
    ballbar = read_campaign(folder)
    shutil.copyfile(folder / _TRACKER, folder / DESCRIPTION)
    return _session(ballbar, read_campaign(folder), folder)


def _session(ballbar: Campaign, tracker: Campaign, folder: Path) -> Session:
    try:
        truth = json.loads((folder / _TRUTH).read_text(encoding="utf-8"))
        return Session(
            ballbar=ballbar,
            tracker=tracker,
            validation_mm=_true_positions(ballbar, folder / _TRUE_POSITIONS),
            cups_mm={
                (cup["placement"], cup["base_point"]): np.array(cup["position_mm"]) for cup in truth["cups"]
            },
            nests_mm=np.array(truth["tool_nests_mm"]),
            legs_mm=np.array(truth["true_legs_mm"]),
            out_of_range=len(truth["out_of_range"]),
        )
    except (OSError, ValueError, KeyError) as error:
        raise TruthUnknownError(f"The truth of a recorded session cannot be read: {error!r}.") from error


def _true_positions(campaign: Campaign, path: Path) -> FloatArray:
    if campaign.validation is None:
        return np.zeros((0, 3))
    table = np.loadtxt(path, delimiter=",", skiprows=1, ndmin=2)
    places = {(int(row[0]), int(row[1])): row[2:] for row in table}
    asked = zip(campaign.validation.stops.config.tolist(), campaign.validation.nest.tolist(), strict=True)
    return np.array([places[key] for key in asked])


def without_noise(session: Session) -> Campaign:
    """Return the session as an exact ballbar and an arm without scatter would have given it, nests known."""
    campaign = session.ballbar
    if campaign.legs is None or campaign.fixture is None:
        return campaign
    nests = tuple(
        Nest((float(x), float(y), float(z)), nest.standard_uncertainty_mm, nest.facing)
        for nest, (x, y, z) in zip(campaign.nests, session.nests_mm, strict=True)
    )
    return replace(
        campaign,
        nests=nests,
        legs=replace(campaign.legs, length_mm=session.legs_mm),
        fixture=replace(campaign.fixture, length_mm=_true_sides(session, campaign.fixture)),
    )


def _true_sides(session: Session, fixture: FixtureLengths) -> FloatArray:
    def place(placement: int, point: int) -> FloatArray:
        return (
            session.nests_mm[point - 1] if placement == TOOL_PLACEMENT else session.cups_mm[placement, point]
        )

    rows = zip(fixture.placement.tolist(), fixture.point_a.tolist(), fixture.point_b.tolist(), strict=True)
    return np.array([np.linalg.norm(place(p, a) - place(p, b)) for p, a, b in rows])
