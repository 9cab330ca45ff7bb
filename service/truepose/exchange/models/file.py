"""Model files: JSON, versioned, with a digest, readable by people."""

from dataclasses import dataclass
from pathlib import Path

from truepose.domain.results.identification import Model
from truepose.exchange.document import json_document
from truepose.exchange.input_file import read_bytes
from truepose.exchange.json_text import render_json
from truepose.exchange.models.digest import Integrity, integrity_of, require_unedited
from truepose.exchange.models.document import check_format, model_document, read_model_document


@dataclass(frozen=True, slots=True)
class ModelFile:
    """A model, and what its digest says."""

    model: Model
    integrity: Integrity


def model_text(model: Model) -> str:
    """Return the text of a model file."""
    return render_json(model_document(model)) + "\n"


def model_file_from_text(text: bytes, name: str, *, accept_edited: bool = False) -> ModelFile:
    """Read a model from the content of a file called `name`.

    Raises
    ------
    NewerVersionError
        A later program wrote it.
    EditedFileError
        It was edited after truepose wrote it, and that is not accepted.
    InputFileError
        It is cut off, of another kind, or a value in it cannot be meant.
    """
    root = json_document(name, text)
    check_format(root)
    integrity = integrity_of(root.entries()) if accept_edited else require_unedited(root)
    return ModelFile(read_model_document(root), integrity)


def model_from_text(text: bytes, name: str) -> Model:
    """Read a model that nobody edited; raises as `model_file_from_text`."""
    return model_file_from_text(text, name).model


def write_model(model: Model, file: Path) -> None:
    """Write a model file."""
    file.write_text(model_text(model), encoding="utf-8", newline="\n")


def read_model_file(file: Path, *, accept_edited: bool = False) -> ModelFile:
    """Read a model file; raises as `model_file_from_text`, and MissingFileError."""
    return model_file_from_text(read_bytes(file), file.name, accept_edited=accept_edited)


def read_model(file: Path) -> Model:
    """Read a model file that nobody edited; raises as `read_model_file`."""
    return read_model_file(file).model
