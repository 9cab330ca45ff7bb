"""Identification: nominal robot plus effects, fitted to observations; everything here is pure."""

from truepose.identification.identify import identify
from truepose.identification.model.prediction import predict, unpredictable
from truepose.identification.verdict.judge import judge, unpredictable_readings

__all__ = ["identify", "judge", "predict", "unpredictable", "unpredictable_readings"]
