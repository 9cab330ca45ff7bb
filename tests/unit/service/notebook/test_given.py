"""What functions take: the thing itself, or a path to it; of anything else they say what it is not."""

import inspect
import pydoc
from dataclasses import replace

import numpy as np
import pytest
from threadpoolctl import threadpool_info, threadpool_limits

import truepose as tp
from tests.unit.service.notebook.conftest import EXAMPLES
from truepose.domain.errors import ConfigurationError
from truepose.exchange.errors import InputFileError
from truepose.messages.catalogue import english

_HELD_OUT = EXAMPLES / "campaign" / "validation.csv"


def test_a_folder_is_read_at_once(identified):
    folder = EXAMPLES / "campaign"

    assert tp.identify(str(folder)).document == identified.document
    assert (
        tp.diagnose(folder, ["base", "geometry"]).document
        == tp.diagnose(tp.read_campaign(folder), ["base", "geometry"]).document
    )


def test_a_model_file_is_read_at_once(model, tmp_path):
    model.save(tmp_path / "robot.json")

    judged = tp.validate(tmp_path / "robot.json", _HELD_OUT)
    predicted = tp.predict(str(tmp_path / "robot.json"), _HELD_OUT)

    assert judged.document == tp.validate(model, _HELD_OUT).document
    assert np.array_equal(predicted.position_mm, tp.predict(model, _HELD_OUT).position_mm)


@pytest.mark.parametrize("function", [tp.identify, tp.diagnose])
def test_what_is_no_campaign_is_refused_in_a_sentence(function, model):
    with pytest.raises(
        ConfigurationError, match=r"^A dict is not a campaign: give a folder, or create a campaign"
    ):
        function({"config": [1]})
    with pytest.raises(ConfigurationError, match=r"^A Model is not a campaign: .* tp\.read_campaign"):
        function(model)
    with pytest.raises(InputFileError, match="no-such-folder"):
        function("no-such-folder")


@pytest.mark.parametrize("function", [tp.validate, tp.predict])
def test_what_is_no_model_is_refused_in_a_sentence(function, identified):
    with pytest.raises(ConfigurationError, match=r"^An Identification is not a model: .* \.model of tp"):
        function(identified, _HELD_OUT)
    with pytest.raises(
        ConfigurationError, match=r"^A NoneType is not a model: .* None if nothing was fitted"
    ):
        function(None, _HELD_OUT)


def test_what_is_no_path_is_refused_in_a_sentence(campaign):
    with pytest.raises(
        ConfigurationError, match=r"^A Campaign is not a cell file: give the path of a cell file"
    ):
        tp.plan(campaign, 10)
    with pytest.raises(ConfigurationError, match=r"^A Campaign is not a model file: give its path"):
        tp.read_model(campaign)


def test_pages_say_a_thing_once(identified, diagnosed):
    page, found = identified._repr_html_(), diagnosed._repr_html_()

    assert page.lower().count("converged") == 1
    assert page.count("31 parameters") == 1
    assert "RMS" not in page  # the table has it
    assert found.count(english(diagnosed.answer.remaining.sentence)) == 1


def test_what_the_message_says_already_is_not_said_below_it(diagnosed):
    answer = diagnosed.answer
    rest = english(answer.remaining.sentence)
    told = replace(answer, message=f"Something is wrong. {rest}")

    assert tp.Diagnosis(told)._repr_html_().count(rest) == 1


@pytest.mark.parametrize("threads", [1, 2])
def test_linear_algebra_has_one_thread_while_it_is_computed_and_its_own_again_after(campaign, threads):
    def used():
        return {library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas"}

    seen = []
    with threadpool_limits(threads, user_api="blas"):
        tp.identify(campaign, ["base"], lambda *_: seen.append(used()))
        after = used()

    assert seen
    assert all(threads_then == {1} for threads_then in seen)
    assert after == {threads}


def test_a_decorated_function_is_still_told_by_help():
    told = pydoc.plain(pydoc.render_doc(tp.identify))

    assert list(inspect.signature(tp.identify).parameters)[:2] == ["campaign", "effects"]
    assert "Identify the robot of a campaign" in told
