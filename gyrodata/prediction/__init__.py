"""What theory says for given numbers: `answers` works it out, `words` tells it."""

from __future__ import annotations

from gyrodata.prediction.answers import (
    SCHEMA,
    document,
    predict_earth,
    predict_platform,
    predict_precession,
    predict_tip,
)
from gyrodata.prediction.words import prediction_text

__all__ = [
    "SCHEMA",
    "document",
    "predict_earth",
    "predict_platform",
    "predict_precession",
    "predict_tip",
    "prediction_text",
]
