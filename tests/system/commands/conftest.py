"""A campaign that the commands read, and the model that they make of it."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.commands import installed
from tests.helpers.identification.synthetic import measured, nominal_campaign
from truepose.exchange.campaigns.folder import write_campaign


@pytest.fixture(scope="session")
def campaign():
    calibration, truth = measured(nominal_campaign(45))
    fresh = nominal_campaign(40, seed=9)
    held_out, _ = measured(fresh, np.array(list(truth.values.values())), seed=31)
    return replace(calibration, validation=held_out.calibration)


@pytest.fixture(scope="session")
def good(campaign, tmp_path_factory):
    """A campaign folder and the model that `identify` makes of it."""
    folder = tmp_path_factory.mktemp("good")
    write_campaign(campaign, folder / "campaign")
    done = installed("identify", folder / "campaign", "--model-out", folder / "model.json", "--json")
    assert done.returncode == 0, done.stderr
    (folder / "identify.json").write_text(done.stdout)
    return folder


@pytest.fixture
def folder(campaign, tmp_path):
    """A campaign folder of one's own, to be spoilt."""
    write_campaign(campaign, tmp_path / "campaign")
    return tmp_path / "campaign"
