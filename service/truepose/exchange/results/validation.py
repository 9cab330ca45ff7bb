"""Validations as documents."""

from typing import Literal

from pydantic import AliasChoices, Field, model_validator

from truepose.domain.results.identification import NominalAndIdentified
from truepose.domain.results.validation import DecisionRule, ErrorsByPlace, Shell, Validation, Verdict
from truepose.exchange.json_text import Json
from truepose.exchange.outgoing import Quantity
from truepose.exchange.results.document_base import Document
from truepose.exchange.results.statistics import PairDocument, TurnPairDocument


class HistogramDocument(Document):
    """Counts in bins of one width."""

    width_mm: Quantity = Field(examples=[0.02])
    from_mm: Quantity = Field(description="Where the first bin begins.", examples=[-0.4])
    counts: list[int] = Field(examples=[[3, 41, 38, 2]])


class SignedErrorsDocument(Document):
    """What the signs of errors tell, seen minus predicted."""

    mean_mm: Quantity = Field(description="With sign.", examples=[0.004])
    positive_share: Quantity = Field(examples=[0.52])
    histogram: HistogramDocument


class DistanceErrorsDocument(Document):
    """Errors of the distances between all pairs of points, with their signs."""

    nominal: SignedErrorsDocument
    identified: SignedErrorsDocument


class ZoneDocument(Document):
    """Where the readings lay that made the model; not `stated`: that judge it."""

    x_mm: Quantity
    y_mm: Quantity
    z_mm: Quantity
    radius_mm: Quantity
    stated: bool


class ShellDocument(PairDocument):
    """Errors of the readings at some distance from something."""

    from_mm: Quantity
    to_mm: Quantity


class BranchDocument(PairDocument):
    """Errors of the readings in one posture of the arm."""

    branch: str = Field(examples=["front/up/no flip"])


class PlacesDocument(Document):
    """Where errors are large; shells and branches without a reading are left out."""

    zone: ZoneDocument
    from_zone: list[ShellDocument] = Field(description="By distance from the middle of the zone.")
    from_axis: list[ShellDocument] = Field(description="By distance from the line of axis 1.")
    branches: list[BranchDocument] = Field(
        description="Empty where the arm has no closed inverse: its branches have no names then."
    )

    @model_validator(mode="before")
    @classmethod
    def _flat(cls, places: object) -> object:
        if not isinstance(places, ErrorsByPlace):
            return places
        x, y, z = places.zone_centre_mm
        return {
            "zone": {
                "x_mm": x,
                "y_mm": y,
                "z_mm": z,
                "radius_mm": places.zone_radius_mm,
                "stated": places.zone_stated,
            },
            "from_zone": [_shell(shell) for shell in places.from_zone],
            "from_axis": [_shell(shell) for shell in places.from_axis],
            "branches": [_of_both(one.errors, branch=one.branch) for one in places.branches],
        }


def _shell(shell: Shell) -> dict[str, object]:
    return _of_both(shell.errors, from_mm=shell.from_mm, to_mm=shell.to_mm)


def _of_both(errors: NominalAndIdentified, **where: object) -> dict[str, object]:
    return where | {"nominal": errors.nominal, "identified": errors.identified}


class DecisionDocument(Document):
    """Whether the largest error stays within the limit (ISO 14253-1), and the reading that decides it."""

    rule: DecisionRule
    limit_mm: Quantity
    error_mm: Quantity
    guard_mm: Quantity = Field(description="1.65 standard uncertainties of measuring it; 0 by simple rule.")
    verdict: Verdict


class FigureUncertaintyDocument(Document):
    """Standard uncertainty of each figure of that name, to first order (GUM)."""

    mean_mm: Quantity = Field(examples=[0.002])
    rms_mm: Quantity = Field(examples=[0.002])
    sd_mm: Quantity = Field(examples=[0.001])
    max_mm: Quantity = Field(examples=[0.008])
    signed_mean_mm: Quantity | None = Field(None, description="Of distances: of the mean with sign.")


class UncertaintyPairDocument(Document):
    """The same for the nominal model and the identified one."""

    nominal: FigureUncertaintyDocument
    identified: FigureUncertaintyDocument


class ValidationUncertaintyDocument(Document):
    """How well the figures of `position`, `relative` and `distance` are known."""

    position: UncertaintyPairDocument | None
    relative: UncertaintyPairDocument | None
    distance: UncertaintyPairDocument | None


class ValidationDocument(Document):
    """What `truepose validate --json` prints; `distance` is null where there are no pairs."""

    quantity: Literal["position", "length"]
    position: PairDocument
    relative: PairDocument | None = Field(
        None, description="Positions after the best rigid alignment: the base may stand anywhere."
    )
    distance: PairDocument | None
    distance_errors: DistanceErrorsDocument | None = Field(
        None, description="All pairs, with sign and histogram; null where there are no pairs."
    )
    places: PlacesDocument | None = Field(None, description="Null: of a program that did not tell it yet.")
    uncertainty: ValidationUncertaintyDocument | None = Field(
        None, description="Null: of a program that did not tell it yet."
    )
    orientation: TurnPairDocument | None = Field(
        None, validation_alias=AliasChoices("turns", "orientation"), description="Null: none were read."
    )
    limit_mm: Quantity
    decision: DecisionDocument | None = Field(None, description="Null without a limit.")
    passed: bool = Field(validation_alias=AliasChoices("passed", "pass"), serialization_alias="pass")


def validation_document(validation: Validation) -> dict[str, Json]:
    """Return what `validate --json` prints."""
    return ValidationDocument.of(validation).printed()
