"""The cells file of a plant, and what is said where it cannot be meant."""

import pytest

from truepose.exchange.cells.plant import PlantCell, read_plant_file
from truepose.exchange.errors import InputFileError

WHOLE = """
[[cell]]
name = "left arm"
url = "https://cell-3.plant:8443/"
token_file = "left.token"
certificate = "plant-ca.pem"

[[cell]]
name = "right arm"
url = "http://127.0.0.1:8001"

[due_after_days]
"ABB IRB 120" = 14
"""


def test_files_that_it_names_lie_beside_it(tmp_path):
    file = tmp_path / "cells.toml"
    file.write_text(WHOLE)

    assert read_plant_file(file).cells == (
        PlantCell(
            "left arm", "https://cell-3.plant:8443", tmp_path / "left.token", tmp_path / "plant-ca.pem"
        ),
        PlantCell("right arm", "http://127.0.0.1:8001"),
    )
    assert read_plant_file(file).due_after_days == {"ABB IRB 120": 14.0}


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "key cell is missing"),
        ('[[cell]]\nname = "a"', "key url is missing"),
        ('[[cell]]\nname = "a"\nurl = "cell-3"', "write the address as http:// or https://"),
        ('[[cell]]\nname = "a"\nurl = "http://c/api"', "write the address as http:// or https://"),
        ('[[cell]]\nname = "a"\nurl = "https://c?a=b"', "write the address as http:// or https://"),
        ('[[cell]]\nname = "a"\nurl = "https://c#"', "write the address as http:// or https://"),
        ('[[cell]]\nname = "a"\nurl = "https://ada:pw@c"', "write the address as http:// or https://"),
        ('[[cell]]\nname = "a"\nurl = "https://c:84433"', "write the address as http:// or https://"),
        ('[[cell]]\nname = "a"\nurl = "https://c:0"', "write the address as http:// or https://"),
        ('[[cell]]\nname = "a"\nurl = "https://c:x"', "write the address as http:// or https://"),
        ('[[cell]]\nname = "a"\nurl = "https://[::1"', "write the address as http:// or https://"),
        ('[[cell]]\nname = "a"\nurl = "http://10.0.0.7:8000"\ntoken_file = "t"', "sent over https:// only"),
        ('[[cell]]\nname = "a"\nurl = "http://c"\ntoken = "x"', "unknown key"),
        ('cells = 1\n[[cell]]\nname = "a"\nurl = "http://c"', "unknown key"),
        ('[[cell]]\nname = "a"\nurl = "http://c"\n' * 2, "two cells are called 'a'"),
        (
            '[[cell]]\nname = "a"\nurl = "http://c"\n[[cell]]\nname = "b"\nurl = "http://c/"',
            "'a' has the same",
        ),
        ('[[cell]]\nname = "a"\nurl = "http://c"\n[due_after_days]\n"IRB" = 0', "0 must be greater than 0"),
        ('[[cell]]\nname = "a"\nurl = "http://c"\n[due_after_days]\n"IRB" = "30d"', "is not a number"),
        ("[[cell]", "cells.toml"),
    ],
)
def test_what_cannot_be_meant_is_said(tmp_path, text, said):
    file = tmp_path / "cells.toml"
    file.write_text(text)

    with pytest.raises(InputFileError, match=r"cells\.toml") as raised:
        read_plant_file(file)

    assert said in str(raised.value)


@pytest.mark.parametrize(
    "url", ["https://10.0.0.7", "http://localhost:8000", "http://127.0.0.1:8000", "http://[::1]:8000"]
)
def test_a_token_goes_where_nobody_else_reads_it(tmp_path, url):
    file = tmp_path / "cells.toml"
    file.write_text(f'[[cell]]\nname = "a"\nurl = "{url}"\ntoken_file = "t"\n')

    assert read_plant_file(file).cells == (PlantCell("a", url, tmp_path / "t"),)
