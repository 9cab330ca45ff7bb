"""What lists and comparisons read of a diagnosis: everything but its drawings."""

from tests.helpers.diagnosis.answers import make_diagnosis, make_finding, make_unexplained
from truepose.storage.results.diagnoses import without_drawings


def test_lists_read_findings_great_and_small_without_their_curves():
    listed = without_drawings(make_diagnosis(small=(make_finding(),)))

    assert [finding.curve for finding in listed.all_findings] == [None, None]
    assert listed.small[0].amplitude == make_finding().amplitude
    assert (listed.errors, listed.model) == (None, None)


def test_lists_read_what_is_left_without_its_curves():
    (left,) = without_drawings(make_unexplained()).remaining.depends_on

    assert (left.variable, left.curve) == ("angle of joint 4", None)
