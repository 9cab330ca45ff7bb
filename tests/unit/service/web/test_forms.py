"""Forms of the pages: what is typed into them never stands in an address by mistake."""

import re
from pathlib import Path

import pytest

import truepose.web

TEMPLATES = sorted(Path(truepose.web.__file__).parent.rglob("templates/**/*.html"))
FORM = re.compile(r"<form\b[^>]*>")


@pytest.mark.parametrize("template", TEMPLATES, ids=lambda path: path.name)
def test_a_form_asks_for_a_page_or_is_sent_by_a_script_alone(template):
    forms = FORM.findall(template.read_text())

    assert [form for form in forms if not re.search(r'method="(get|dialog)"', form)] == []


def test_there_are_forms():
    assert sum(len(FORM.findall(template.read_text())) for template in TEMPLATES) > 15
