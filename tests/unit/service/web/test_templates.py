"""Templates: what is typed into a form never stands in an address by mistake, and a style outlives a part."""

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


@pytest.mark.parametrize("template", TEMPLATES, ids=lambda path: path.name)
def test_a_stylesheet_stands_in_the_head_where_no_replaced_part_takes_it_away(template):
    body = re.sub(
        r"<head>.*?</head>|{% block (head|styles) %}.*?{% endblock %}",
        "",
        template.read_text(),
        flags=re.DOTALL,
    )

    assert 'rel="stylesheet"' not in body
