"""Statistics of errors as documents: the same keys everywhere, angles in degrees."""

import math

from pydantic import Field, model_validator

from truepose.domain.results.identification import Statistics, TurnStatistics
from truepose.exchange.json_text import Json
from truepose.exchange.outgoing import Quantity
from truepose.exchange.results.document_base import Document


class StatisticsDocument(Document):
    """Norms of errors of n observations; `noise_mm` is the mean norm that stated uncertainties alone give."""

    n: int = Field(examples=[50])
    mean_mm: Quantity = Field(examples=[0.021])
    rms_mm: Quantity = Field(examples=[0.023])
    sd_mm: Quantity = Field(examples=[0.009])
    max_mm: Quantity = Field(examples=[0.047])
    noise_mm: Quantity = Field(examples=[0.019])


class PairDocument(Document):
    """The same statistics for the nominal model and the identified one."""

    nominal: StatisticsDocument
    identified: StatisticsDocument


class TurnStatisticsDocument(Document):
    """Angles between measured orientations and a model's; `noise_deg`: what stated noise alone gives."""

    n: int = Field(examples=[50])
    mean_deg: Quantity = Field(examples=[0.035])
    rms_deg: Quantity = Field(examples=[0.038])
    sd_deg: Quantity = Field(examples=[0.015])
    max_deg: Quantity = Field(examples=[0.081])
    noise_deg: Quantity = Field(examples=[0.043])

    @model_validator(mode="before")
    @classmethod
    def _in_degrees(cls, turns: object) -> object:
        if not isinstance(turns, TurnStatistics):
            return turns
        figures = ("mean", "rms", "sd", "max", "noise")
        return {"n": turns.n} | {
            f"{name}_deg": math.degrees(getattr(turns, f"{name}_rad")) for name in figures
        }


class TurnPairDocument(Document):
    """The same for the nominal model and the identified one."""

    nominal: TurnStatisticsDocument
    identified: TurnStatisticsDocument


def statistics_document(statistics: Statistics) -> dict[str, Json]:
    """Return a statistics block: the same six keys everywhere."""
    return StatisticsDocument.of(statistics).printed()
