"""An identified model in a notebook."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from truepose.domain.results import identification as domain
from truepose.exchange.json_text import Json
from truepose.exchange.models.document import model_document
from truepose.exchange.models.file import read_model_file, write_model
from truepose.notebook.given.things import path_of, read_if_path
from truepose.notebook.shown import html
from truepose.notebook.shown.frames import frame
from truepose.notebook.shown.wording import counted, parameter_table

if TYPE_CHECKING:
    from pandas import DataFrame


@dataclass(frozen=True, slots=True, repr=False)
class Model:
    """An identified model: predicts every configuration, and says how well it knows it.

    Attributes
    ----------
    data : truepose.domain.results.identification.Model
        Parameters in mm, rad, N·mm; `data.covariance` has the shape (P, P).

    Examples
    --------
    >>> import truepose as tp
    >>> model = tp.identify(tp.read_campaign("docs/examples/campaign")).model
    >>> model
    Model of ABB IRB 120, simulated: base, geometry, compliance; 31 parameters
    >>> model.data.covariance.shape
    (31, 31)
    """

    data: domain.Model

    @property
    def document(self) -> dict[str, Json]:
        """The content of a model file: angles in deg."""
        return model_document(self.data)

    def save(self, file: str | Path) -> None:
        """Write a model file (JSON), which the command line reads as well; raises OSError."""
        write_model(self.data, Path(file))

    def to_frame(self) -> "DataFrame":
        """Return one row per parameter, as in a model file: name, effect, value, unit, standard uncertainty.

        Raises MissingExtraError where pandas is not installed.
        """
        return frame(self.document["parameters"])

    def __repr__(self) -> str:
        effects = ", ".join(self.data.effects)
        count = counted(len(self.data.parameters), "parameter")
        return f"Model of {self.data.robot.name}: {effects}; {count}"

    def _repr_html_(self) -> str:
        return html.page(html.paragraphs([repr(self)]), parameter_table(self.data.parameters))


def read_model(file: str | Path, *, accept_edited: bool = False) -> Model:
    """Read a model file, as `Model.save` or `truepose identify --model-out` writes it.

    Parameters
    ----------
    file : path
    accept_edited : bool
        Read a file that was edited after truepose wrote it.

    Returns
    -------
    Model

    Raises
    ------
    InputFileError
        With file, line and key: it is not there, cut off, or a value in it cannot be meant.
    NewerVersionError
        A later program wrote it.
    EditedFileError
        It was edited after truepose wrote it.

    Examples
    --------
    >>> import tempfile, pathlib
    >>> import truepose as tp
    >>> file = pathlib.Path(tempfile.mkdtemp(), "robot.json")
    >>> tp.identify(tp.read_campaign("docs/examples/campaign")).model.save(file)
    >>> tp.read_model(file)
    Model of ABB IRB 120, simulated: base, geometry, compliance; 31 parameters
    >>> tp.read_model("no-such-robot.json")
    Traceback (most recent call last):
    ...
    truepose.exchange.errors.MissingFileError: no-such-robot.json: there is no such file.
    """
    path = path_of(file, "model file", "give its path")
    return Model(read_model_file(path, accept_edited=accept_edited).model)


def model_given(given: Model | str | Path) -> Model:
    """Return a model, read first where a path is given; raises ConfigurationError, InputFileError."""
    advice = "give a model file, or the .model of tp.identify(...), None where nothing could be fitted"
    return read_if_path(given, Model, read_model, advice)
