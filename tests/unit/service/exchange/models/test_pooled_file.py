"""What is believed of a further robot, written and read back; what cannot be meant is refused."""

import json

import numpy as np
import pytest

from tests.helpers.fleet.linear import drawn
from truepose.exchange.errors import InputFileError, NewerVersionError
from truepose.exchange.models.file import Pooled, pooled_text, read_pooled, write_pooled
from truepose.fleet.changes import account_of
from truepose.fleet.predicted_accuracy import of_a_new_robot


@pytest.fixture(scope="module")
def pooled():
    fleet = drawn(10, readings=30).fleet()
    return Pooled("IRB 120", of_a_new_robot(account_of(fleet)))


def test_it_comes_back_within_rounding(pooled, tmp_path):
    file = tmp_path / "pooled.json"

    write_pooled(file, pooled)
    read = read_pooled(file)

    assert (read.robot, read.belief.names, read.belief.owners) == (
        pooled.robot,
        pooled.belief.names,
        pooled.belief.owners,
    )
    np.testing.assert_allclose(read.belief.mean, pooled.belief.mean, rtol=1e-14)
    np.testing.assert_allclose(read.belief.covariance, pooled.belief.covariance, rtol=1e-13)
    for one, other in zip(read.belief.specs, pooled.belief.specs, strict=True):
        assert one[:2] == other[:2]
        assert one[2:] == pytest.approx(other[2:], rel=1e-14)


def _forget(covariance):
    """Leave the first parameter's row and column unknown."""
    for row in covariance:
        row[0] = None
    covariance[0] = [None] * len(covariance)


@pytest.mark.parametrize(
    ("change", "kind", "sentence"),
    [
        (lambda d: d.update(truepose_fleet=2), NewerVersionError, "a later version"),
        (lambda d: d.pop("covariance"), InputFileError, "covariance"),
        (lambda d: d["parameters"][0].update(unit="inch"), InputFileError, "'inch' is not a unit"),
        (lambda d: d["parameters"][0].update(effect="nothing"), InputFileError, "nothing"),
        (lambda d: d["parameters"][0].update(prior_width=0.0), InputFileError, "prior_width"),
        (lambda d: _forget(d["covariance"]), InputFileError, "known completely"),
    ],
)
def test_a_file_that_cannot_be_meant_is_refused_at_its_place(pooled, tmp_path, change, kind, sentence):
    document = json.loads(pooled_text(pooled))
    change(document)
    file = tmp_path / "pooled.json"
    file.write_text(json.dumps(document))

    with pytest.raises(kind, match=sentence):
        read_pooled(file)
