"""Identification: nominal robot plus effects, fitted to observations; everything here is pure."""

from truepose.identification.identify import identify
from truepose.identification.model.prediction import (
    predict,
    predict_lengths,
    predict_nominal,
    unpredictable,
    unpredictable_lengths,
)

__all__ = [
    "identify",
    "predict",
    "predict_lengths",
    "predict_nominal",
    "unpredictable",
    "unpredictable_lengths",
]
