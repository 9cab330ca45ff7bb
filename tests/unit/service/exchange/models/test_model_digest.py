"""A model file carries a digest: an edited file is named as such, an older one is read."""

import hashlib
import json
from pathlib import Path

import pytest

from tests.helpers.domain.builders import make_model
from truepose.exchange.errors import EditedFileError
from truepose.exchange.models.digest import Integrity, digest_of
from truepose.exchange.models.file import model_file_from_text, model_text, write_model

VECTOR = json.loads(Path("tests/vectors/model_digest.json").read_text(encoding="utf-8"))


def read(text, **options):
    return model_file_from_text(text.encode(), "arm.json", **options)


def test_the_canonical_form_is_that_of_the_vector():
    assert hashlib.sha256(VECTOR["canonical"].encode()).hexdigest() == VECTOR["digest"].removeprefix(
        "sha256:"
    )
    assert digest_of(VECTOR["document"]) == VECTOR["digest"]


def test_a_file_as_it_was_written_is_intact():
    assert read(model_text(make_model())).integrity is Integrity.INTACT


def edited():
    """Return a model file in which somebody changed one digit."""
    document = json.loads(model_text(make_model()))
    document["robot"]["dhm_nominal"][0]["d_mm"] = 351.0
    return json.dumps(document)


def test_a_digit_changed_by_hand_is_named_as_an_edit():
    with pytest.raises(EditedFileError, match=r"arm.json, line \d+, key digest: the model was edited after"):
        read(edited())


@pytest.mark.parametrize(
    "poison", ["9" * 400, "1e999", "[" * 90 + "]" * 90], ids=["400 digits", "1e999", "a deep nest"]
)
def test_what_truepose_never_writes_is_an_edit_as_well(poison):
    text = model_text(make_model()).replace('"digest":', f'"more": {poison}, "digest":')

    with pytest.raises(EditedFileError):
        read(text)
    assert read(text, accept_edited=True).integrity is Integrity.EDITED


def test_an_edited_file_is_read_where_that_is_accepted_and_still_called_edited():
    found = read(edited(), accept_edited=True)

    assert found.integrity is Integrity.EDITED
    assert found.model.robot.joints[0].d_mm == 351.0


def test_a_file_from_before_there_were_digests_is_read_and_says_so():
    document = json.loads(model_text(make_model()))
    del document["digest"]

    assert read(json.dumps(document)).integrity is Integrity.NO_DIGEST


def test_another_program_may_print_the_file_in_its_own_way():
    document = json.loads(model_text(make_model()))
    shuffled = dict(sorted(document.items(), reverse=True))
    whole = json.dumps(shuffled, indent=7).replace(".0,", ",")

    assert read(whole).integrity is Integrity.INTACT


def test_a_file_that_was_read_and_written_again_carries_the_digest_of_what_it_says(tmp_path):
    file = tmp_path / "arm.json"
    write_model(read(model_text(make_model())).model, file)

    assert read(file.read_text(encoding="utf-8")).integrity is Integrity.INTACT
