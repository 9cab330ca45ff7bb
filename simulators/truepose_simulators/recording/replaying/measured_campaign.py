"""The description of a measured campaign, as far as a replay needs it."""

import json
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from truepose_simulators.errors import ReplayError
from truepose_simulators.physics.arm import Vector
from truepose_simulators.physics.rigid import FloatArray
from truepose_simulators.scenarios.input_file import read_text
from truepose_simulators.scenarios.table import convert

POINTS = ("calibration", "validation")
REFERENCE = "reference"
_NAME = "campaign.json"


def read_description(folder: Path) -> dict[str, Any]:
    """Read campaign.json of a folder; raises ReplayError."""
    path = folder / _NAME
    try:
        document = json.loads(read_text(path))
    except OSError as error:
        raise ReplayError(f"{path} cannot be read: {error.strerror}") from error
    except (ValueError, RecursionError) as error:
        raise ReplayError(f"{path} is no JSON: {error}") from error
    if not isinstance(document, dict):
        raise ReplayError(f"{path} must be a table of keys")
    return document


def tracker_files(document: Mapping[str, Any]) -> dict[str, str]:
    """Names of the tables by role; raises ReplayError for what no tracker reads."""
    files = document.get("files")
    if not isinstance(files, dict) or not files:
        raise ReplayError(f'{_NAME}: key "files" must name the tables of the campaign')
    for role, name in files.items():
        if role not in {*POINTS, REFERENCE}:
            raise ReplayError(
                f'{_NAME}: "{role}" of key "files" cannot be replayed: only a laser tracker is simulated here'
            )
        if not isinstance(name, str) or not re.fullmatch(r"[^/\\]+\.csv", name):
            raise ReplayError(f'{_NAME}: "{role}" of key "files" must name a CSV file of the folder')
    return files


def certified_nests_mm(document: Mapping[str, Any]) -> FloatArray:
    """Certified places of the fixed nests, shape (k, 3), of none where the campaign states none."""
    stated = document.get("fixed_nests_certified_mm")
    nests = () if stated is None else convert(tuple[Vector, ...], stated, f"{_NAME}: the fixed nests")
    return np.array(nests, dtype=np.float64).reshape(-1, 3)
