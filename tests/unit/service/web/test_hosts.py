import pytest

from truepose.web.middleware.hosts import AllowedHosts, AskedHost, UnusableHostError, requested_host


def allowed(name, hosts):
    host = requested_host(name)
    return host is not None and hosts.scheme(host) is not None


@pytest.mark.parametrize(
    ("text", "host"),
    [
        ("localhost", AskedHost("localhost", None)),
        ("Cell-3.Shop:8000", AskedHost("cell-3.shop", 8000)),
        ("truepose_service:80", AskedHost("truepose_service", 80)),
        ("[::1]:8000", AskedHost("[::1]", 8000)),
        ("[0000::0001]", AskedHost("[::1]", None)),
    ],
)
def test_a_host_is_read_in_one_form(text, host):
    assert requested_host(text) == host


@pytest.mark.parametrize("listening", ["0.0.0.0", "::", "0", "", "0x0", "00.0"])
def test_an_address_that_stands_for_all_allows_no_name(listening):
    hosts = AllowedHosts(listening=listening)

    assert not allowed(listening, hosts)
    assert not allowed("192.168.1.20", hosts)
    assert allowed("localhost", hosts)


@pytest.mark.parametrize(
    ("listening", "name"),
    [("192.168.1.20", "192.168.1.20:8000"), ("Cell3", "cell3"), ("fd00::0:1", "[fd00::1]:8000")],
)
def test_the_address_that_is_listened_to_is_allowed(listening, name):
    assert allowed(name, AllowedHosts(listening=listening))


@pytest.mark.parametrize(
    "name", ["cell3.shop", "http://cell3.shop", "https://CELL3.shop", "fd00::1", "[fd00::1]"]
)
def test_names_and_addresses_can_be_allowed(name):
    bare = name.rpartition("://")[2]

    assert allowed(bare if bare[0] == "[" or ":" not in bare else f"[{bare}]", AllowedHosts([name]))


@pytest.mark.parametrize(
    "name", ["", "*", "*.shop", "cell3.shop:8000", "ftp://cell3", "https://cell3/", "a b", "cell3.", "[x]"]
)
def test_what_is_no_name_cannot_be_allowed(name):
    with pytest.raises(UnusableHostError, match="cannot be an allowed host"):
        AllowedHosts([name])
