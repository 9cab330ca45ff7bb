"""A report on paper: the same numbers as on the screen and in the document, and a page that stands alone."""

import html
import io
import re
import sys
from collections import Counter

import pytest
from pypdf import PdfReader

from truepose.exchange.results.identification import identification_document
from truepose.reports.identification.report import IdentificationReport
from truepose.reports.paper import NoPdfError, UnwritableReportError, pdf_of, require_pdf, write_report_text
from truepose.reports.rounding import millimetres
from truepose.reports.traceability import ReportConditions, css_string

_NUMBER = re.compile(r"\d+(?:[.,]\d+)*(?:e[-+]\d+)?")
CONDITIONS = ReportConditions(
    simulated=True, robot_serial_number="120-500123", person="R. Calder", written_at="2026-11-23"
)


def numbers(text):
    return Counter(_NUMBER.findall(text))


def shown(page):
    """What a reader of the page sees, pictures among it."""
    body = re.sub(r"<(style|title)>.*?</\1>|<head>|<[^>]+>", " ", page, flags=re.DOTALL)
    return html.unescape(body)


@pytest.fixture(scope="module")
def made(text_library, tmp_path_factory, identification, campaign):
    """The page of an identification, and the PDF of it; setting one takes a second or two."""
    path = tmp_path_factory.mktemp("paper") / "report.html"
    IdentificationReport(identification, campaign, conditions=CONDITIONS).write(path)
    page = path.read_text(encoding="utf-8")
    return page, PdfReader(io.BytesIO(pdf_of(page)))


@pytest.fixture(scope="module")
def printed(made):
    return [one.extract_text() for one in made[1].pages]


def test_every_number_of_the_page_is_in_the_pdf(made, printed):
    missing = numbers(shown(made[0])) - numbers(" ".join(printed))

    assert not missing


def test_the_figures_of_the_document_are_in_the_pdf_as_they_are_rounded(printed, identification):
    document = identification_document(identification, "test robot")
    text = " ".join(printed)

    for data in ("calibration", "validation"):
        for model in ("nominal", "identified"):
            block = document["statistics"][data][model]
            for key in ("mean_mm", "rms_mm", "sd_mm", "max_mm", "noise_mm"):
                assert millimetres(block[key]) in text, (data, model, key)


def test_each_page_says_what_it_belongs_to(printed):
    for number, text in enumerate(printed, start=1):
        assert "serial number 120-500123" in text
        assert "SIMULATED." in text
        assert f"{number} / {len(printed)}" in text


def test_the_pdf_says_who_and_what_and_is_tagged(made):
    pdf = made[1]

    assert pdf.metadata.title == "Identification of elbow"
    assert pdf.metadata.author == "R. Calder"
    assert pdf.trailer["/Root"]["/MarkInfo"]["/Marked"]
    assert pdf.trailer["/Root"]["/Lang"] == "en"


def test_no_heading_ends_a_page(made, printed):
    headings = [
        re.sub(r"<[^>]+>", "", html.unescape(one)) for one in re.findall(r"<h2[^>]*>(.*?)</h2>", made[0])
    ]

    for text in printed:
        assert text.strip().splitlines()[-1] not in headings


def test_nothing_is_fetched_for_a_page(text_library, tmp_path):
    secret = tmp_path / "secret.png"
    secret.write_bytes(b"not for print")

    body = pdf_of(f'<p>before<img src="{secret.as_uri()}"><img src="http://127.0.0.1:9/x.png">after</p>')

    assert "after" in PdfReader(io.BytesIO(body)).pages[0].extract_text()


@pytest.mark.parametrize("text", ['"; } </style><script>', "a\\b", "line\nbreak"])
def test_text_of_others_stays_within_its_string(text):
    inside = css_string(text)[1:-1]

    assert not set('"<>;{}\n') & set(inside)


@pytest.fixture
def printer_that(monkeypatch, tmp_path):
    """Have another program in the place of the one that prints."""

    def does(text):
        (tmp_path / "weasyprint.py").write_text(text)
        monkeypatch.syspath_prepend(tmp_path)
        monkeypatch.delitem(sys.modules, "weasyprint", raising=False)

    return does


def test_without_the_text_library_one_sentence_says_what_to_install(printer_that, tmp_path, capsys):
    printer_that("print('-----\\nfollow the steps\\n-----')\nraise OSError('cannot load library libpango')")

    with pytest.raises(NoPdfError, match=r"install libpango-1\.0-0.*brew install pango"):
        require_pdf()
    write_report_text(tmp_path / "report.html", "<p>still written</p>")
    assert (tmp_path / "report.html").read_text() == "<p>still written</p>"
    assert capsys.readouterr().out == ""  # which may be read by a program


def test_what_a_later_printer_will_need_stops_none_today(printer_that):
    printer_that("import warnings\nwarnings.warn('HarfBuzz-Subset will be required', DeprecationWarning)")

    require_pdf()


def test_a_folder_that_takes_no_file_is_said(tmp_path):
    (tmp_path / "file").touch()

    with pytest.raises(UnwritableReportError, match=r"cannot be written to .*file"):
        write_report_text(tmp_path / "file" / "report.html", "<p></p>")
