"""Model files: JSON, versioned, readable by people."""

from pathlib import Path

from truepose.domain.results.identification import Model
from truepose.exchange.document import json_document
from truepose.exchange.input_file import read_bytes
from truepose.exchange.json_text import render_json
from truepose.exchange.models.document import model_document, read_model_document


def model_text(model: Model) -> str:
    """Return the text of a model file."""
    return render_json(model_document(model)) + "\n"


def model_from_text(text: bytes, name: str) -> Model:
    """Read a model from the content of a file called `name`.

    Raises
    ------
    NewerVersionError
        A later program wrote it.
    InputFileError
        It is cut off, of another kind, or a value in it cannot be meant.
    """
    return read_model_document(json_document(name, text))


def write_model(model: Model, file: Path) -> None:
    """Write a model file."""
    file.write_text(model_text(model), encoding="utf-8", newline="\n")


def read_model(file: Path) -> Model:
    """Read a model file; raises as `model_from_text`, and MissingFileError."""
    return model_from_text(read_bytes(file), file.name)
