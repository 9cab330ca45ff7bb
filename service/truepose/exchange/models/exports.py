"""The formats in which an identified model is exported, by the name that the command line gives them."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final, Literal, get_args

from truepose.correction.reduced_models import ControllerValues, controller_values
from truepose.domain.errors import ConfigurationError
from truepose.domain.identification import Model
from truepose.exchange.models.rigid_arm import (
    Subject,
    controller_remarks,
    dhm_remarks,
    subject_of,
    table_csv,
    table_text,
    values_text,
)
from truepose.exchange.models.urdf_export import urdf_remarks, urdf_text
from truepose.exchange.robots.ros_calibrated_kinematics import kinematics_remarks, kinematics_text
from truepose.messages.message import Message

Format = Literal["urdf", "ros", "dhm", "controller"]
FORMATS: Final[tuple[Format, ...]] = get_args(Format)


@dataclass(frozen=True, slots=True)
class Export:
    """A file's content, and what is to be said of it."""

    form: Format
    text: str
    remarks: tuple[Message, ...]
    subject: Subject | None = None  # of a table
    values: ControllerValues | None = None  # of a controller

    def write(self, file: Path) -> None:
        """Write the file."""
        file.write_text(self.text, encoding="utf-8", newline="\n")


def export(model: Model, form: Format, *, fitted: bool = False, as_csv: bool = False) -> Export:
    """Return a model in the form of another program.

    Parameters
    ----------
    model : Model
    form : {"urdf", "ros", "dhm", "controller"}
    fitted : bool
        Fit the table to the full model over the measured zone, in the place of the identified one.
    as_csv : bool
        A DH-Modified table as CSV.

    Raises
    ------
    ConfigurationError
        The format cannot hold this robot, there is no such format, or the model does not know its zone.
    """
    if form not in FORMATS:
        raise ConfigurationError(f"{form!r} is not a model format; the formats are {', '.join(FORMATS)}.")
    # What is typed into a controller is no table: zeros, frames and tool points are worked out for it alone.
    if form == "controller":
        values = controller_values(model)
        return Export(form, values_text(model, values), tuple(controller_remarks(values)), values=values)
    written, said = _TABLES["csv" if form == "dhm" and as_csv else form]
    subject = subject_of(model, fitted=fitted)
    return Export(form, written(subject), tuple(said(subject)), subject=subject)


_Said = Callable[[Subject], Iterable[Message]]
_TABLES: Final[Mapping[str, tuple[Callable[[Subject], str], _Said]]] = {
    "urdf": (urdf_text, urdf_remarks),
    "ros": (kinematics_text, kinematics_remarks),
    "dhm": (table_text, dhm_remarks),
    "csv": (table_csv, dhm_remarks),
}
