"""Identified models written for other programs from a notebook."""

from pathlib import Path

from truepose.exchange.exports.formats import Format
from truepose.exchange.exports.formats import export as export_model
from truepose.notebook.given.things import path_of
from truepose.notebook.model import Model, model_given
from truepose.words.catalogue import english


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
    truepose.domain.errors.UnsuitableModelError: ABB IRB 120, simulated has not the axes of ... as URDF.
    """
    path = path_of(file, "file", "give its path")
    as_csv = path.suffix.lower() == ".csv"
    exported = export_model(model_given(model).data, form, fitted=fitted, as_csv=as_csv)
    exported.write(path)
    return tuple(map(english, exported.remarks))
