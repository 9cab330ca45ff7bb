import pytest

import truepose as tp
from tests.helpers.checkout import CHECKOUT

EXAMPLES = CHECKOUT / "docs" / "examples"


@pytest.fixture(scope="session")
def campaign():
    return tp.read_campaign(EXAMPLES / "campaign")


@pytest.fixture(scope="session")
def identified(campaign):
    return tp.identify(campaign)


@pytest.fixture(scope="session")
def model(identified):
    return identified.model


@pytest.fixture(scope="session")
def readings():
    """Readings of a robot with a wave in a joint, to calibrate and to validate: a DataFrame each."""
    pandas = pytest.importorskip("pandas")
    return (
        pandas.read_csv(EXAMPLES / "wave" / "readings.csv"),
        pandas.read_csv(EXAMPLES / "wave" / "held-out.csv"),
    )


@pytest.fixture(scope="session")
def diagnosed(readings):
    calibration, held_out = readings
    return tp.diagnose(tp.read_campaign(calibration, robot="abb-irb-120", validation=held_out))
