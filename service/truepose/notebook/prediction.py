"""Predictions in a notebook."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.exchange.tables.files import write_predictions
from truepose.identification import predict as predict_positions
from truepose.messages.catalogue import english
from truepose.notebook import display
from truepose.notebook.display import count_text, frame
from truepose.notebook.inputs import TableOrFile, on_one_thread, readings_given
from truepose.notebook.model import Model, model_given
from truepose.reports.rounding import millimetres
from truepose.validation.cautions import prediction_cautions

if TYPE_CHECKING:
    from pandas import DataFrame


@dataclass(frozen=True, slots=True, repr=False)
class Predictions:
    """Where a model says that the nests are; n rows.

    Attributes
    ----------
    config : ndarray, shape (n,)
    nest : ndarray, shape (n,)
        From 1.
    position_mm : ndarray, shape (n, 3)
        In the frame of the readings that the model was made from.
    standard_uncertainty_mm : ndarray, shape (n,)
        Per axis; not the noise of a reading.
    remarks : tuple of str
        What was ignored in the table, and what the predictions do not contain.

    Examples
    --------
    >>> import truepose as tp
    >>> model = tp.identify(tp.read_campaign("docs/examples/campaign")).model
    >>> predicted = tp.predict(model, {"config": [1, 2], "joints_deg": [[0.0] * 6, [10.0] * 6], "nest": 1})
    >>> predicted.position_mm.shape, predicted.standard_uncertainty_mm.shape
    ((2, 3), (2,))
    """

    config: IntArray
    nest: IntArray
    position_mm: FloatArray
    standard_uncertainty_mm: FloatArray
    remarks: tuple[str, ...]

    def to_frame(self) -> DataFrame:
        """Return one row per prediction: `config, nest, x_mm, y_mm, z_mm, u_mm`.

        Raises MissingExtraError where pandas is not installed.
        """
        x_mm, y_mm, z_mm = self.position_mm.T
        return frame({
            "config": self.config,
            "nest": self.nest,
            "x_mm": x_mm,
            "y_mm": y_mm,
            "z_mm": z_mm,
            "u_mm": self.standard_uncertainty_mm,
        })

    def save(self, file: str | Path) -> None:
        """Write the rows as CSV, as `truepose predict --out` does; raises OSError."""
        write_predictions(Path(file), self.config, self.nest, self.position_mm, self.standard_uncertainty_mm)

    def __repr__(self) -> str:
        typical = millimetres(float(np.median(self.standard_uncertainty_mm)))
        count = count_text(len(self.config), "prediction")
        return f"{count} of nest positions; standard uncertainty {typical} mm (median)"

    def _repr_html_(self) -> str:
        numbers = np.column_stack([self.position_mm, self.standard_uncertainty_mm]).tolist()
        rows = [
            (str(config), str(nest), *(f"{number:.4f}" for number in row))
            for config, nest, row in zip(self.config, self.nest, numbers, strict=True)
        ]
        return display.page(
            display.paragraphs([repr(self)]),
            display.first_rows(("config", "nest", "x, mm", "y", "z", "u"), rows),
            display.paragraphs(self.remarks),
        )


@on_one_thread
def predict(model: Model | str | Path, points: TableOrFile) -> Predictions:
    """Predict where the nests are.

    Parameters
    ----------
    model : Model or path
        The path of a model file, which is read first.
    points : table or path
        n rows of `config`, the joints and what else is known of each stop, as in `read_campaign`; a file is
        CSV. Without a `nest` every nest of the model is predicted at every row.

    Returns
    -------
    Predictions

    Raises
    ------
    InputFileError
        The table cannot be used: with file and line, or row (from 0), and column.
    ConfigurationError
        The model needs measured joint torques that the rows do not give, or what is given is not a model.

    Examples
    --------
    >>> import truepose as tp
    >>> model = tp.identify(tp.read_campaign("docs/examples/campaign")).model
    >>> tp.predict(model, {"config": [1], "joints_deg": [[0.0, 10.0, 20.0, 0.0, 45.0, 0.0]]})
    3 predictions of nest positions; standard uncertainty 0.0... mm (median)
    """
    data = model_given(model).data
    nests = [nest.nest for nest in data.nests]
    table = readings_given(points, "points").stops(data.robot.n_joints, nests)
    stops, nest = table.of_each_nest(nests)
    position_mm, uncertainty_mm = predict_positions(data, stops, nest)
    remarks = tuple(map(english, (*table.ignored, *prediction_cautions(data, table.stops))))
    return Predictions(stops.config, nest, position_mm, uncertainty_mm, remarks)
