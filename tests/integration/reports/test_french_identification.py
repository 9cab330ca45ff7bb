"""An identification is told in French throughout: its report, its tables, and the reasons that it gives."""

import re
from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from tests.helpers.domain.builders import make_identification, make_pair
from tests.helpers.identification.synthetic import leg_campaign, measured, nominal_campaign, shifted
from tests.helpers.printed import printed
from tests.helpers.web.pages import Page
from tests.helpers.words.english import english_in
from truepose.domain.identification import Outlier, PositionsJudged, PureError, Status
from truepose.exchange.tables.points import in_files
from truepose.identification import identify
from truepose.messages.catalogue import catalogue
from truepose.messages.message import message
from truepose.reports.identification.headline import basis_of
from truepose.reports.identification.judged_figures import figures_table
from truepose.reports.identification.report import IdentificationReport
from truepose.reports.identification.summary import TrueParameter, Truth, identification_summary, truth_table
from truepose.reports.tables import on_terminal
from truepose.reports.traceability import Period, ReportConditions

PAINTED_ELSEWHERE = pytest.mark.usefixtures("empty_pictures")
FRENCH = catalogue("fr")
FAR = Outlier(3, 4, 1, 5.2, message("gross.turned", turn_deg=5.0))


@pytest.fixture(scope="module")
def points():
    """Readings of three nests, two of them exchanged and one far off, beside held-out ones."""
    campaign, truth = measured(nominal_campaign(60))
    held_out, _ = measured(nominal_campaign(20, seed=9), np.array(list(truth.values.values())), seed=3)
    position = campaign.calibration.position_mm
    position[[9, 12]] = position[[12, 9]]
    campaign = shifted(campaign, [20], 5.0)
    return replace(campaign, validation=held_out.calibration)


@pytest.fixture(scope="module")
def of_points(points):
    return identify(points)


@pytest.fixture(scope="module")
def lengths():
    return leg_campaign(60)


@pytest.fixture(scope="module")
def of_lengths(lengths):
    return identify(lengths)


def page_of(path, identification, campaign, language="fr", **parts):
    IdentificationReport(identification, campaign, language=language, **parts).write(path)
    html = path.read_text(encoding="utf-8")
    return re.sub("<style.*?</style>", "", html, flags=re.DOTALL)


def test_a_report_of_positions_is_french_throughout(tmp_path, of_points, points):
    html = page_of(tmp_path / "report.html", of_points, points)

    assert of_points.counts.outliers == 3
    assert 'lang="fr"' in html
    assert "Jugé sur 20 positions réservées" in Page(html).text
    assert "les deux lignes sont sans doute échangées" in Page(html).text
    assert english_in(Page(html).text) == []


def test_a_report_of_lengths_is_french_throughout(tmp_path, of_lengths, lengths):
    text = Page(page_of(tmp_path / "report.html", of_lengths, lengths)).text

    assert "chacune prédite par un modèle qui n\u2019a jamais vu sa configuration" in text
    assert "seule la somme de leurs d se voit" in text
    assert english_in(text) == []


@PAINTED_ELSEWHERE
def test_what_is_beside_the_readings_is_told_in_french_too(tmp_path, of_lengths, lengths):
    truth = Truth(
        (TrueParameter("a_3", 0.2, 0.1, 0.01, "mm"),), ((message("truth.aligned"), make_pair().nominal),)
    )
    conditions = ReportConditions(simulated=True, sessions=(Period("12"),), temperature_c=(20.0, 21.0))
    ignored = in_files(["legs.csv", "validation_legs.csv"], message("ignored.column", column="operator"))
    repeated = replace(of_lengths, pure_error=PureError(5, 5, 0.01, 1.2, 0.3), outliers=(FAR,))

    told = replace(lengths, ignored=(ignored,))
    page = page_of(tmp_path / "report.html", repeated, told, conditions=conditions, truth=truth)

    assert "après alignement rigide" in Page(page).text
    assert "la colonne operator ne fait pas partie du format" in Page(page).text
    assert "aussi bien qu\u2019elles se répètent" in Page(page).text
    assert english_in(Page(page).text) == []


def test_what_was_not_fitted_is_told_in_french(tmp_path, points):
    failed = make_identification(
        status=Status.TOO_FEW_DATA,
        model=None,
        message="",
        parameters=(),
        calibration=None,
        cross_validation=None,
    )

    text = Page(page_of(tmp_path / "report.html", failed, points)).text

    assert "Aucun modèle n\u2019a été identifié." in text
    assert english_in(text) == []


@PAINTED_ELSEWHERE
def test_a_report_in_english_is_seen(tmp_path, of_lengths, lengths):
    text = Page(page_of(tmp_path / "report.html", of_lengths, lengths, language="en")).text

    assert {"the", "of", "with"} <= set(english_in(text))


def test_a_terminal_speaks_french_too(of_points):
    text = printed(identification_summary(of_points, FRENCH))

    assert re.search("Sans poids\u00a0: configuration 21, nid 3\u00a0: écart de", text)
    assert "Paramètres, ajoutés aux valeurs nominales" in text
    assert english_in(text) == []


def test_a_table_of_truth_speaks_french_too():
    text = printed(on_terminal(truth_table([TrueParameter("a_3", 0.2, 0.1, 0.01, "mm")], FRENCH)))

    assert "Écart / u" in text
    assert english_in(text) == []


def test_every_row_of_figures_has_a_french_name_and_remark():
    positions = PositionsJudged(tied=make_pair(), aligned=make_pair())
    blocks = {"positions": positions, "calibration_without_outliers": make_pair()}
    validated = make_identification(validation=make_pair(), **blocks)

    rows = [
        row for one in (validated, make_identification(**blocks)) for row in figures_table(one, FRENCH).rows
    ]

    told = [text for label, *_ in rows if label for text in (label, label.remark)]
    assert len(told) == 2 * 10
    assert english_in(" ".join(told)) == []


def test_figures_stand_on_one_reading_or_on_several_in_every_language():
    judged_by = ({"validation": make_pair()}, {}, {"cross_validation": None})
    for blocks, quantity, n in product(judged_by, ("position", "length"), (1, 1200)):
        identification = make_identification(quantity=quantity, **blocks)
        statistics = replace(make_pair().nominal, n=n)

        told = FRENCH.spoken(basis_of(identification, statistics))

        assert told.startswith(f"{n} {'position' if quantity == 'position' else 'longueur'}{'s' * (n > 1)}")
        assert english_in(told) == []
