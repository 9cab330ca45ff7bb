"""Fixtures that several folders use."""

import os
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

# How long an example takes says how busy the machine is, not whether the code is right.
settings.register_profile("any machine", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("any machine")


@pytest.fixture(scope="session")
def measured_data() -> Path:
    """The folder of example campaigns, which is not part of the repository."""
    folder = Path(os.environ.get("TRUEPOSE_DATA", ""))
    if not (folder / "campaigns").is_dir():
        pytest.skip("TRUEPOSE_DATA does not name the folder of example campaigns")
    return folder
