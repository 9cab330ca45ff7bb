"""What a worker process is asked, and how it answers; the numerics are imported there and only there.

The imports inside the functions are the point: scipy takes most of a second, and the service, which
imports this module for the task classes, must not wait for it.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeAlias

from truepose.analysis.campaigns.ballbar import ValidReadings
from truepose.analysis.errors import NothingMeasuredError
from truepose.analysis.job_queue.accuracy_tasks import OutlookTask, PromiseTask, SessionForecast
from truepose.analysis.job_queue.file_tasks import (
    BroughtRead,
    CampaignRead,
    CheckFileTask,
    CorrectFileTask,
    FileChecked,
    FileCorrected,
    ReadBroughtTask,
)
from truepose.analysis.pose_requests import PoseRequest
from truepose.domain.ballbar import BallbarPlan, PreCalibration, SpherePlanRequest
from truepose.domain.campaign import Campaign, Readings, ReadingsSetAside
from truepose.domain.contacts import ContactPlan
from truepose.domain.diagnosis import Diagnosis
from truepose.domain.identification import Identification, Model
from truepose.domain.robot import FramePlacement
from truepose.domain.session import SessionPlan, Turn
from truepose.domain.set_aside import without_readings
from truepose.domain.validation import Validation
from truepose.messages.message import Text, message
from truepose.storage.documents import is_packed, pack, unpack
from truepose.storage.records import SessionSetup

if TYPE_CHECKING:
    from truepose.planning.contacts.plan_request import ContactPlanRequest


@dataclass(frozen=True, slots=True)
class DrawTask:
    """Call a function of a module with one argument that can travel; its answer travels back."""

    draw: Callable[[Any], str | bytes]
    of: object

    def perform(self, report: Callable[[float, Text], None]) -> str | bytes:
        """Return what is drawn; raises TrueposeError."""
        report(0.0, message("job.doing.drawing"))
        return self.draw(self.of)


Report: TypeAlias = Callable[[float, Text], None]  # fraction from 0 to 1, what is being done


@dataclass(frozen=True, slots=True)
class IdentifyTask:
    """Identify a campaign; `effects` None chooses them from the campaign."""

    campaign: bytes  # as it is stored
    effects: tuple[str, ...] | None
    set_aside: ReadingsSetAside | None = None  # as they were found in it

    def perform(self, report: Report) -> Identification:
        """Return the identification; raises TrueposeError."""
        from truepose.identification import identify

        report(0.0, message("job.doing.reading"))
        return identify(stored_campaign(self.campaign, self.set_aside), self.effects, progress=report)


@dataclass(frozen=True, slots=True)
class ValidateTask:
    """Judge a model on the validation readings of a campaign."""

    campaign: bytes  # as it is stored
    model: Model
    limit_mm: float | None

    def perform(self, report: Report) -> Validation:
        """Return the validation; raises TrueposeError."""
        from truepose.validation.validate import validate

        report(0.0, message("job.doing.reading"))
        readings = held_out(stored_campaign(self.campaign))
        report(0.5, message("job.doing.predicting", readings=len(readings)))
        return validate(self.model, readings, limit_mm=self.limit_mm)


@dataclass(frozen=True, slots=True)
class DiagnoseTask:
    """Say what the model of a campaign gets wrong; `effects` None starts from the usual ones."""

    campaign: bytes  # as it is stored
    effects: tuple[str, ...] | None
    set_aside: ReadingsSetAside | None = None  # as they were found in it

    def perform(self, report: Report) -> Diagnosis:
        """Return the diagnosis; raises TrueposeError."""
        from truepose.diagnosis.diagnose import diagnose

        report(0.0, message("job.doing.reading"))
        return diagnose(stored_campaign(self.campaign, self.set_aside), self.effects, progress=report)


@dataclass(frozen=True, slots=True)
class PlanTask:
    """Choose the configurations of a session: by observability, at random to validate, in pairs to prove."""

    setup: SessionSetup
    template: SessionPlan  # role, speeds and limits; its stops are chosen here
    n_configurations: int
    seed: int
    proved: Model | None = None  # whose corrections are to be proved; each configuration is a target then

    @property
    def asked(self) -> dict[str, Any]:
        """What was asked for, in words of requests."""
        return {"configurations": self.n_configurations, "seed": self.seed}

    @property
    def work_count(self) -> int:
        """How much there is to choose."""
        return self.n_configurations

    def perform(self, report: Report) -> SessionPlan:
        """Return the plan; raises TrueposeError."""
        from truepose.correction.proof import plan_proof
        from truepose.planning.tracker.plans import plan_session
        from truepose.planning.workspace.space import space_to_measure

        report(0.0, message("job.doing.configurations", configurations=self.n_configurations))
        space = space_to_measure(self.setup.cell, self.template.approach_offset_rad)
        if self.proved is not None:
            return plan_proof(space, self.template, self.proved, self.n_configurations, self.seed)
        return plan_session(space, self.template, self.n_configurations, self.seed)


@dataclass(frozen=True, slots=True)
class CirclePlanTask:
    """Plan the single-axis circle test of a cell."""

    setup: SessionSetup
    template: SessionPlan  # role, speeds and limits
    turns: tuple[Turn, ...]  # none: the usual ones

    @property
    def asked(self) -> dict[str, Any]:
        """What was asked for, in words of requests."""
        return {"method": "circles", "joints": [turn.joint for turn in self.turns]}

    @property
    def work_count(self) -> int:
        """How much there is to choose."""
        return max(len(self.turns), 1)

    def perform(self, report: Report) -> SessionPlan:
        """Return the plan; raises TrueposeError."""
        from truepose.planning.tracker.circles import plan_circles
        from truepose.planning.workspace.space import space_to_measure

        report(0.0, message("job.doing.circles"))
        return plan_circles(space_to_measure(self.setup.cell, None), self.template, self.turns)


@dataclass(frozen=True, slots=True)
class PosePlanTask(PoseRequest):
    """Plan the five poses of ISO 9283 and their cycles."""

    @property
    def asked(self) -> dict[str, Any]:
        """What was asked for, in words of requests."""
        return {"method": "iso9283", "test": self.test}

    @property
    def work_count(self) -> int:
        """How much there is to choose."""
        return self.cycles

    def perform(self, report: Report) -> SessionPlan:
        """Return the plan; raises TrueposeError."""
        from truepose.analysis.pose_plans import plan_pose_session

        report(0.0, message("job.doing.five_poses"))
        return plan_pose_session(self)


@dataclass(frozen=True, slots=True)
class RepeatTask:
    """Take over the plan of an earlier session as it is, for the cell of now."""

    setup: SessionSetup
    plan: SessionPlan | BallbarPlan | ContactPlan
    asked: Mapping[str, Any]  # of the job that planned the earlier one: it says what kind of test it is

    @property
    def work_count(self) -> int:
        """Nothing is chosen."""
        return 0

    def perform(self, report: Report) -> SessionPlan | BallbarPlan | ContactPlan:
        """Return the plan."""
        report(0.0, message("job.doing.taking_over"))
        return self.plan


@dataclass(frozen=True, slots=True)
class BallbarPlanTask:
    """Choose the poses of a ballbar session, and where the base fixture goes unless `frames` say so."""

    setup: SessionSetup
    frames: tuple[FramePlacement, ...]
    n_placements: int  # how many are suggested where no frame is given
    n_poses: int  # of the whole session
    seed: int
    sphere: SpherePlanRequest | None = None  # a sphere test at the one frame; None: six legs a pose

    @property
    def asked(self) -> dict[str, Any]:
        """What was asked for, in words of requests."""
        chosen = {"poses": self.n_poses, "placements": len(self.frames) or self.n_placements}
        return {**chosen, "seed": self.seed, "method": None if self.sphere is None else "sphere"}

    @property
    def work_count(self) -> int:
        """How many poses there are to choose."""
        return self.n_poses if self.sphere is None else self.sphere.stops

    def perform(self, report: Report) -> BallbarPlan:
        """Return the plan; raises TrueposeError."""
        from truepose.analysis.ballbar_plans import plan_ballbar_session

        report(0.0, message("job.doing.placements"))
        return plan_ballbar_session(
            self.setup.cell,
            self.frames,
            placements=self.n_placements,
            poses=self.n_poses,
            seed=self.seed,
            sphere=self.sphere,
        )


@dataclass(frozen=True, slots=True)
class ContactPlanTask:
    """Choose the stops of a session of closed loops."""

    setup: SessionSetup
    wish: "ContactPlanRequest"

    @property
    def asked(self) -> dict[str, Any]:
        """What was asked for, in words of requests."""
        return {"configurations": self.wish.stops, "seed": self.wish.seed}

    @property
    def work_count(self) -> int:
        """How many stops there are to choose."""
        return self.wish.stops

    def perform(self, report: Report) -> ContactPlan:
        """Return the plan; raises TrueposeError."""
        from truepose.planning.contacts.plan import plan_of

        report(0.0, message("job.doing.stops", stops=self.wish.stops))
        return plan_of(self.setup.cell, self.wish)


@dataclass(frozen=True, slots=True)
class PrecalibrateTask:
    """Identify with what a ballbar session has so far, and aim the rest by it."""

    setup: SessionSetup
    plan: BallbarPlan
    counting: ValidReadings

    def perform(self, report: Report) -> PreCalibration:
        """Return what was found; raises TrueposeError."""
        from truepose.analysis.ballbar_plans import precalibrate

        report(0.0, message("job.doing.legs"))
        return precalibrate(self.setup, self.plan, self.counting)


@dataclass(frozen=True, slots=True)
class ReadCampaignTask:
    """Read an archive that somebody sent, once; the campaign is kept as arrays beside it (decision 0035)."""

    archive: bytes
    name: str  # what the user calls it

    def perform(self, report: Report) -> CampaignRead:
        """Return how much it holds; raises TrueposeError."""
        from truepose.analysis.campaigns.tracker import summary_of
        from truepose.exchange.campaigns.zip_file import read_campaign_zip

        campaign = read_campaign_zip(self.archive, self.name)
        return CampaignRead(campaign.robot.name, summary_of(campaign), pack(campaign))


SessionPlanTask: TypeAlias = PlanTask | CirclePlanTask | PosePlanTask
Task: TypeAlias = (
    IdentifyTask
    | ValidateTask
    | DiagnoseTask
    | SessionPlanTask
    | BallbarPlanTask
    | ContactPlanTask
    | RepeatTask
    | PrecalibrateTask
    | ReadCampaignTask
    | ReadBroughtTask
    | CheckFileTask
    | CorrectFileTask
    | OutlookTask
    | DrawTask
    | PromiseTask
)
Answer: TypeAlias = (
    Identification
    | Validation
    | Diagnosis
    | SessionPlan
    | BallbarPlan
    | ContactPlan
    | PreCalibration
    | CampaignRead
    | BroughtRead
    | FileChecked
    | FileCorrected
    | SessionForecast
)


def stored_campaign(content: bytes, set_aside: ReadingsSetAside | None = None) -> Campaign:
    """Return a campaign from what the storage keeps, or from the zip of a folder.

    `set_aside` are readings that were found in it, and that it is wanted without.
    """
    campaign = _whole(content)
    return campaign if set_aside is None else without_readings(campaign, set_aside)


def _whole(content: bytes) -> Campaign:
    # The storage keeps arrays; an archive of folders that is analysed anew hands on zips.
    if is_packed(content):
        return unpack(Campaign, content)
    from truepose.exchange.campaigns.zip_file import read_campaign_zip

    return read_campaign_zip(content)


def held_out(campaign: Campaign) -> Readings:
    """Return the validation readings of a campaign; raises NothingMeasuredError where it has none.

    Calibration readings never stand in: a model may have been made from them.
    """
    others = (campaign.validation, campaign.validation_legs, campaign.validation_contacts)
    for readings in (campaign.held_out, *others):
        if readings is not None:
            return readings
    raise NothingMeasuredError(message("refused.campaign_without_validation"))


def judging_or_own(campaign: Campaign) -> Readings:
    """Return the readings that judge a model; of a campaign that keeps none, those that it is made from."""
    own = campaign.readings
    if campaign.held_out is None and own is not None:
        return own
    return held_out(campaign)
