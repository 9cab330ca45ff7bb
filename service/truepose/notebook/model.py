"""An identified model in a notebook, and models written for other programs."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from truepose.domain import identification as domain
from truepose.exchange.json_text import Json
from truepose.exchange.models.document import model_document
from truepose.exchange.models.exports import Format
from truepose.exchange.models.exports import export as export_model
from truepose.exchange.models.file import read_model_file, write_model
from truepose.messages.catalogue import english
from truepose.notebook import display
from truepose.notebook.display import count_text, frame, parameter_table
from truepose.notebook.inputs import path_of, read_if_path

if TYPE_CHECKING:
    from pandas import DataFrame


@dataclass(frozen=True, slots=True, repr=False)
class Model:
    """An identified model: predicts every configuration, and says how well it knows it.

    Attributes
    ----------
    data : truepose.domain.identification.Model
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
        count = count_text(len(self.data.parameters), "parameter")
        return f"Model of {self.data.robot.name}: {effects}; {count}"

    def _repr_html_(self) -> str:
        return display.page(display.paragraphs([repr(self)]), parameter_table(self.data.parameters))


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
    advice = "give a model file, or the .model of tp.identify(...), which is None if nothing was fitted"
    return read_if_path(given, Model, read_model, advice)


def export(
    model: Model | str | Path, form: Format, file: str | Path, *, fitted: bool = False
) -> tuple[str, ...]:
    """Write a model for another program, and say what is lost.

    Parameters
    ----------
    model : Model or path
    form : {"urdf", "ros", "dhm", "controller"}
        URDF; `calibrated_kinematics.yaml` of ROS for arms of Universal Robots; the DH-Modified table, as CSV
        where the file ends in `.csv`; joint zeros, base and tool that a controller can take.
    file : path
    fitted : bool
        Fit the table to the full model over the measured zone, so that what the format lacks (springs) is in
        it as far as it can be.

    Returns
    -------
    tuple of str
        What the file does not hold, and how far it is off the full model.

    Raises
    ------
    ConfigurationError
        The format cannot hold this robot, there is no such format, or the model does not know its zone.
    InputFileError
        The model file cannot be read.
    OSError
        The file cannot be written.

    Examples
    --------
    >>> import tempfile, pathlib
    >>> import truepose as tp
    >>> model = tp.identify(tp.read_campaign("docs/examples/campaign")).model
    >>> urdf = pathlib.Path(tempfile.mkdtemp(), "robot.urdf")
    >>> tp.export(model, "urdf", urdf, fitted=True)[0]
    'Not in the file: compliance (parameters: 5).'
    >>> tp.export(model, "ros", urdf.with_suffix(".yaml"))
    Traceback (most recent call last):
    ...
    truepose.domain.errors.UnsuitableModelError: ABB IRB 120, simulated does not have the axes of ... as URDF.
    """
    path = path_of(file, "file", "give its path")
    as_csv = path.suffix.lower() == ".csv"
    exported = export_model(model_given(model).data, form, fitted=fitted, as_csv=as_csv)
    exported.write(path)
    return tuple(map(english, exported.remarks))
