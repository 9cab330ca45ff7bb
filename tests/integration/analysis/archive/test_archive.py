"""An archive computed anew: each campaign once, whatever interrupts it, and what differs is told."""

import json
import shutil

import pytest

from tests.helpers.archive import ThisProcess, computed, written_archive
from truepose.analysis.archive import in_folder
from truepose.domain.errors import ConfigurationError


@pytest.fixture(scope="module")
def archive(tmp_path_factory):
    """Campaigns of which the second one has enough readings; the others say at once that they have not."""
    return written_archive(tmp_path_factory.mktemp("archive"), readings=(2, 12, 3))


@pytest.fixture(scope="module")
def results(archive, tmp_path_factory):
    """An archive that was computed."""
    out = tmp_path_factory.mktemp("results")
    anew, _ = computed(archive, out)
    assert (anew.computed, anew.there_already, anew.failed) == (3, 0, ())
    return out


@pytest.fixture
def out(results, tmp_path):
    return shutil.copytree(results, tmp_path / "out")


def _documents(out):
    return {file.name: json.loads(file.read_text()) for file in sorted((out / "results").glob("*.json"))}


def _bits(out):
    return {one["campaign"].removesuffix(".zip"): one["bits_sha256"] for one in _documents(out).values()}


def _found_by_another_version(out, change):
    """Let every result be that of another version, which found something else."""
    for file in (out / "results").glob("*.json"):
        document = json.loads(file.read_text())
        document["program"] = "0.0.9"
        change(document)
        file.with_name(f"{document['campaign']}.0123456789ab.json").write_text(json.dumps(document))
        file.unlink()


def test_what_is_there_is_not_computed_again(archive, out):
    before = _documents(out)

    anew, performed = computed(archive, out)

    assert performed == 0
    assert (anew.computed, anew.there_already) == (0, 3)
    assert _documents(out) == before


def test_an_interrupted_run_goes_on_and_ends_with_the_same_bits(archive, results, tmp_path):
    with pytest.raises(KeyboardInterrupt):
        computed(archive, tmp_path, ThisProcess(most=2))

    anew, performed = computed(archive, tmp_path)

    assert performed == 1
    assert (anew.computed, anew.there_already) == (1, 2)
    assert _documents(tmp_path) == _documents(results)


def test_a_campaign_with_other_readings_or_effects_is_computed_again(archive, out, tmp_path):
    changed = shutil.copytree(archive, tmp_path / "changed")
    table = changed / "campaign-2" / "calibration.csv"
    table.write_text("\n".join(table.read_text().splitlines()[:-1]) + "\n")

    _, by_data = computed(changed, out)
    _, by_effects = computed(archive, tmp_path / "out2", effects=("base", "tool"))

    assert by_data == 1
    assert by_effects == 3


def test_a_campaign_that_cannot_be_read_is_named_and_the_others_are_computed(archive, tmp_path):
    broken = shutil.copytree(archive, tmp_path / "broken")
    (broken / "campaign-1" / "campaign.json").write_text("{")
    (broken / "no.zip").write_bytes(b"none")

    anew, _ = computed(broken, tmp_path / "out")

    assert [row.campaign for row in anew.failed] == ["campaign-1", "no.zip"]
    assert "campaign.json" in anew.failed[0].failed
    assert anew.computed == 2


@pytest.mark.parametrize("text", [b"", b'{"format": ', b"[1]", b'{"campaign": "campaign-1"}', b"\xff"])
def test_a_file_that_is_no_result_is_passed_over(archive, out, text):
    torn, *_ = (out / "results").glob("campaign-1.*.json")
    torn.write_bytes(text)
    (out / "results" / "campaign-2.notes.json").write_bytes(text)

    anew, _ = computed(archive, out)

    assert (anew.computed, anew.there_already, anew.failed) == (1, 2, ())
    assert json.loads(torn.read_text())["campaign"] == "campaign-1"


def test_the_same_results_of_another_version_differ_in_nothing(archive, out):
    _found_by_another_version(out, lambda document: None)

    anew, performed = computed(archive, out)

    assert performed == 3
    assert all(row.compared for row in anew.changes)
    assert [row.campaign for row in anew.changes if row.differs] == []


def test_what_another_version_found_with_other_effects_says_nothing_of_this_one(archive, out):
    _found_by_another_version(out, lambda document: document.update(effects=["base"]))

    anew, _ = computed(archive, out)

    assert not any(change.compared for change in anew.changes)


def test_what_another_version_found_otherwise_is_told(archive, out):
    def other(document):
        if document["campaign"] != "campaign-2":
            return
        parameter = document["identification"]["parameters"][3]
        parameter["value"] += 2.5 * parameter["standard_uncertainty"]
        document["diagnosis"]["verdict"] = "explained"
        document["diagnosis"]["findings"] = [{"effect": "backlash", "subject": "joint 3"}]

    _found_by_another_version(out, other)

    anew, _ = computed(archive, out)

    (row,) = (row for row in anew.changes if row.differs)
    assert row.campaign == "campaign-2"
    assert row.changed_by_u == pytest.approx(2.5, rel=1e-3)  # documents are rounded
    assert (row.verdict_before, row.causes_gone, row.causes_new) == ("explained", "backlash joint 3", "")


def test_results_of_an_earlier_run_are_elsewhere_where_somebody_says_so(archive, out, tmp_path):
    _found_by_another_version(out, lambda document: None)

    anew, _ = computed(archive, tmp_path / "new", against=out)

    assert all(row.compared for row in anew.changes)


def test_zips_and_folders_of_the_same_campaign_give_the_same(archive, results, tmp_path):
    for seed in (1, 2):
        shutil.make_archive(tmp_path / "zips" / f"campaign-{seed}", "zip", archive / f"campaign-{seed}")

    computed(tmp_path / "zips", tmp_path / "out")

    bits = _bits(tmp_path / "out")
    assert len(bits) == 2
    assert bits.items() <= _bits(results).items()


def test_a_folder_without_campaigns_and_one_without_results_are_refused(archive, tmp_path):
    with pytest.raises(ConfigurationError, match="No campaign found in"):
        in_folder(tmp_path)
    with pytest.raises(ConfigurationError, match="No results of an earlier run found"):
        computed(archive, tmp_path / "out", against=tmp_path)
