"""A campaign travels as a zip of its folder, and no archive harms the program."""

import random
import zipfile

import pytest

from tests.helpers.domain.builders import make_ballbar_campaign, make_campaign
from tests.helpers.exchange.archives import zipped
from truepose.exchange.campaigns.folder import campaign_files
from truepose.exchange.campaigns.zip_file import read_campaign_zip, write_campaign_zip
from truepose.exchange.errors import InputFileError, MissingFileError, UnreadableFileError, UnsafeArchiveError


def members(prefix=""):
    return [(prefix + name, text) for name, text in campaign_files(make_campaign()).items()]


def claiming(size, content, number=1):
    """An archive with further members whose directory says that they are of another size."""
    data = zipped([*members(), *((f"{k}.bin", content) for k in range(number))])
    return data.replace(len(content).to_bytes(4, "little"), size.to_bytes(4, "little"))


def test_a_campaign_survives_the_zip():
    campaign = make_ballbar_campaign()

    again = read_campaign_zip(write_campaign_zip(campaign))

    assert campaign_files(again) == campaign_files(campaign)


def test_equal_campaigns_give_equal_bytes():
    assert write_campaign_zip(make_campaign()) == write_campaign_zip(make_campaign())


@pytest.mark.parametrize("prefix", ["", "irb120/", "exports/2024/irb120/", "./", "./irb120/"])
def test_the_folder_may_be_in_the_zip(prefix):
    campaign = read_campaign_zip(zipped([*members(prefix), ("__MACOSX/" + prefix + "campaign.json", "x")]))

    assert len(campaign.calibration) == 3


@pytest.mark.parametrize(
    "name", ["../campaign.json", "/etc/campaign.json", "a/../../b", "C:/campaign.json", "..\\campaign.json"]
)
def test_members_that_lead_out_of_the_archive_are_refused(name):
    with pytest.raises(UnsafeArchiveError, match="points outside the archive"):
        read_campaign_zip(zipped([*members(), (name, "{}")]), "upload.zip")


@pytest.mark.filterwarnings("ignore:Duplicate name")
@pytest.mark.parametrize("name", ["campaign.json", "./campaign.json", ".//campaign.json"])
def test_a_member_that_is_there_twice_is_refused(name):
    with pytest.raises(UnsafeArchiveError, match=r"campaign.json' appears twice"):
        read_campaign_zip(zipped([*members(), (name, "{}")]))


def test_an_archive_that_claims_to_be_huge_is_refused_unread():
    data = claiming(2**26, b"\0" * 54_321, number=5)

    with pytest.raises(UnsafeArchiveError, match="exceeds 256 MB"):
        read_campaign_zip(data)


@pytest.mark.parametrize(
    ("name", "blanks", "method", "sentence"),
    [
        ("calibration.csv", 2**27, zipfile.ZIP_STORED, "exceeds 128 MB"),
        ("calibration.csv", 2**24, zipfile.ZIP_DEFLATED, "expands more than 200-fold"),
        ("campaign.json", 2**23, zipfile.ZIP_STORED, "exceeds 4 MB"),
    ],
)
def test_a_member_of_a_size_that_no_campaign_has_is_refused(name, blanks, method, sentence):
    sound = dict(members())
    padded = {**sound, name: sound[name] + " " * blanks}

    with pytest.raises(UnsafeArchiveError, match=f"'{name}' {sentence}"):
        read_campaign_zip(zipped(padded.items(), method))


def test_a_member_that_hides_its_size_is_cut_off():
    big = b"1" * 2**27 + b"1"
    honest = zipped([("campaign.json", members()[0][1]), ("calibration.csv", big)], zipfile.ZIP_STORED)
    size = len(big).to_bytes(4, "little")
    lying = honest.replace(size, (1000).to_bytes(4, "little"))
    assert lying != honest

    with pytest.raises(UnreadableFileError):
        read_campaign_zip(lying)


def test_a_directory_of_a_million_members_is_refused_unread():
    entry = b"PK\x01\x02" + bytes(42)

    with pytest.raises(UnsafeArchiveError, match="more than the 1000 members"):
        read_campaign_zip(entry * 1_000_000)


def test_too_many_members_are_refused():
    with pytest.raises(UnsafeArchiveError, match="1001 members"):
        read_campaign_zip(zipped([(f"{k}", "") for k in range(1001)]))


@pytest.mark.parametrize(
    ("data", "kind", "sentence"),
    [
        (b"", UnreadableFileError, "not a complete zip file"),
        (b"PK\x03\x04 and nothing more", UnreadableFileError, "not a complete zip file"),
        (zipped(members())[:-200], UnreadableFileError, "not a complete zip file"),
        (zipped([("readme.txt", "hello")]), MissingFileError, "no campaign.json in the archive"),
        (zipped([*members("a/"), *members("b/")]), UnreadableFileError, r"several campaigns .*\(a, b\)"),
    ],
    ids=["nothing", "a beginning", "cut off", "no campaign", "two campaigns"],
)
def test_what_is_no_campaign_is_refused(data, kind, sentence):
    with pytest.raises(kind, match=sentence) as refusal:
        read_campaign_zip(data, "upload.zip")

    assert refusal.value.file == "upload.zip"


def test_damaged_content_is_refused():
    data = bytearray(zipped(members()))
    data[60] ^= 0xFF  # inside the compressed campaign.json

    with pytest.raises(UnreadableFileError, match="not a complete zip file"):
        read_campaign_zip(bytes(data))


def test_a_locked_archive_is_refused():
    data = zipped(members())
    locked = data.replace(b"PK\x01\x02\x14\x03\x14\x00\x00", b"PK\x01\x02\x14\x03\x14\x00\x01")
    assert locked != data  # bit 0 of the flags: encrypted

    with pytest.raises(UnreadableFileError, match="unsupported feature"):
        read_campaign_zip(locked)


def test_a_file_named_and_not_there_is_missing():
    with pytest.raises(
        MissingFileError, match=r"campaign.json, line \d+, key files.calibration: file calibration.csv"
    ):
        read_campaign_zip(zipped(members()[:1]))


METHODS = [zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED, zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA]


@pytest.mark.parametrize("method", METHODS)
def test_damaged_content_of_every_packing_is_one_sentence(method):
    data = bytearray(zipped([("campaign.json", "{}" * 500)], method))
    begin = data.index(b"campaign.json") + len("campaign.json")
    data[begin + 4 : begin + 16] = b"\xff" * 12

    with pytest.raises(UnreadableFileError) as refused:
        read_campaign_zip(bytes(data), "upload.zip")
    assert str(refused.value).startswith("upload.zip: ")


def test_a_name_that_is_no_text_is_one_sentence():
    data = zipped([*members(), ("caf\u00e9.csv", "x")]).replace("caf\u00e9".encode(), b"caf\xff\xfe")

    with pytest.raises(UnreadableFileError, match="a member name in the zip file is not text"):
        read_campaign_zip(data, "upload.zip")


@pytest.mark.parametrize("method", METHODS)
def test_no_byte_that_is_changed_ends_in_a_traceback(method):
    whole = zipped(members(), method)
    draw = random.Random(1)
    refused = 0
    for _ in range(100):
        data = bytearray(whole)
        for _ in range(draw.randint(1, 4)):
            data[draw.randrange(len(data))] = draw.randrange(256)
        try:
            read_campaign_zip(bytes(data))
        except InputFileError:
            refused += 1
    assert refused > 20
