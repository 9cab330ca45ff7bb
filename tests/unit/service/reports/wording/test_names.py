"""What the reports offer by name is there: names are looked up when they are first used."""

import pytest

from truepose import reports


@pytest.mark.parametrize("name", reports.__all__)
def test_every_name_leads_to_what_it_names(name):
    assert getattr(reports, name).__module__.startswith("truepose.reports")
