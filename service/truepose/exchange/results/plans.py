"""A plan with its promise, as a document."""

from collections.abc import Sequence
from typing import Literal

import numpy as np
from pydantic import Field

from truepose.exchange.results.document import Document, Quantities, Quantity, Spoken
from truepose.messages.message import Text
from truepose.planning.prediction.outcome import plan_outcome
from truepose.planning.prediction.plan import Assumptions, BallbarPoses, PromisedPlan


class PromiseDocument(Document):
    """Predicted accuracy for a number of configurations: norms of position errors over the work volume."""

    n: int
    mean_mm: Quantity = Field(
        description="Expected mean error over the work volume, for the mean attained position."
    )
    worst_mm: Quantity = Field(description="Expected largest error in the work volume.")
    interval_90_mm: Quantities = Field(
        description="Interval that contains the mean error of nine calibrations out of ten."
    )
    visit_mean_mm: Quantity = Field(
        description="Expected mean error of single visits, including the repeatability of the arm."
    )


class UndeterminedParameters(Document):
    """Parameters that the configurations cannot determine, with the reason."""

    parameters: list[str]
    reason: Spoken


class PlanAssumptions(Document):
    """Assumptions behind the predicted accuracy; standard deviations are per axis."""

    reading_mm: Quantity
    repeatability_mm: Quantity
    discrepancy_mm: Quantity = Field(description="Assumed model discrepancy.")
    discrepancy_known_to: Quantity = Field(
        description="Relative standard deviation of the assumed discrepancy."
    )
    kept_out: list[str] = Field(
        description="Names of the keep-out volumes that the arm and tool must not enter."
    )


class PlacementDocument(Document):
    """Position of the ballbar base fixture: its cups in the world frame."""

    number: int
    cups_mm: list[list[float]]


class PlanDocument(Document):
    """Planned configurations and their predicted accuracy."""

    outcome: Spoken = Field(
        description="Summary: mean error before (nominal) and predicted after, limit, predicted pass or fail "
        "or what is missing for it."
    )
    robot: str
    instrument: Literal["tracker", "ballbar", "closed loop"]
    configurations_deg: list[list[float]]
    nests: list[int] | None = Field(None, description="Tool nest to be measured, for each configuration.")
    targets: list[list[int]] | None = Field(
        None, description="Targets read at each configuration, in a closed loop."
    )
    legs: list[list[list[int]]] | None = Field(
        None, description="Base point and tool point of each length, for each configuration."
    )
    placement: list[int] | None = Field(
        None, description="Placement of the base fixture for each configuration."
    )
    placements: list[PlacementDocument] | None = None
    n: int = Field(
        description="Number of configurations behind the predicted accuracy, including those already "
        "measured."
    )
    measured: int
    advised: int = Field(
        description="Recommended number of configurations, at the knee of the accuracy curve."
    )
    predicted: list[PromiseDocument]
    open: list[UndeterminedParameters]
    observability: dict[str, float] = Field(examples=[{"O1": 64.8}])
    minutes: Quantity
    assumptions: PlanAssumptions
    remarks: list[Spoken]


def plan_document(
    plan: PromisedPlan,
    robot: str,
    minutes: float,
    remarks: Sequence[Text],
    nominal_mm: float | None = None,
    limit_mm: float | None = None,
) -> PlanDocument:
    """Return what `truepose plan --json` prints and the API shows; errors as of `plan_outcome`."""
    document = {
        "outcome": plan_outcome(plan, nominal_mm, limit_mm),
        "robot": robot,
        "instrument": _instrument(plan),
        # The digits that tables have: a plan is the same from either.
        "configurations_deg": np.round(np.degrees(plan.joints_rad), 9).tolist(),
        **({} if plan.nest is None else {"nests": plan.nest.tolist()}),
        **({} if plan.targets is None else {"targets": [list(own) for own in plan.targets]}),
        **({} if plan.poses is None else _ballbar(plan.poses)),
        "n": plan.total,
        "measured": plan.measured,
        "advised": plan.advised,
        "predicted": plan.curve,
        "open": plan.left_open,
        "observability": plan.observability,
        "minutes": minutes,
        "assumptions": _assumed(plan.assumptions),
        "remarks": remarks,
    }
    return PlanDocument.model_validate(document)


def _instrument(plan: PromisedPlan) -> str:
    if plan.targets is not None:
        return "closed loop"
    return "tracker" if plan.poses is None else "ballbar"


def _assumed(assumptions: Assumptions) -> PlanAssumptions:
    lack = assumptions.discrepancy
    return PlanAssumptions.of(
        assumptions, discrepancy_mm=lack.per_axis_mm, discrepancy_known_to=lack.known_to
    )


def _ballbar(poses: BallbarPoses) -> dict[str, object]:
    placements = [
        PlacementDocument(number=fixture.number, cups_mm=fixture.cups_mm.tolist())
        for fixture in poses.fixtures
    ]
    legs = [[list(leg) for leg in own] for own in poses.legs]
    return {"legs": legs, "placement": poses.placement.tolist(), "placements": placements}
