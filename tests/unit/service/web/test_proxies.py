"""Who asks behind a proxy: its word counts, and nobody else's."""

import pytest

from truepose.web.middleware.hosts import Proxies, UnusableProxyError

TABLET, OTHER, PROXY = "192.168.1.40", "203.0.113.9", "192.168.1.2"


@pytest.mark.parametrize(
    ("told", "peer", "forwarded", "asks"),
    [
        ([], PROXY, [TABLET], PROXY),  # off by default
        ([PROXY], TABLET, [OTHER], TABLET),  # somebody past the proxy says who they would like to be
        ([PROXY], TABLET, ["127.0.0.1"], TABLET),
        ([PROXY], PROXY, [TABLET], TABLET),
        ([PROXY], PROXY, [f"{OTHER}, {TABLET}"], TABLET),  # what the tablet wrote stands before what was seen
        ([PROXY], PROXY, [OTHER, TABLET], TABLET),
        ([PROXY], PROXY, [f"{TABLET}, {PROXY}"], TABLET),  # two of ours
        ([PROXY], PROXY, [f"{OTHER}, {TABLET}, {PROXY}"], TABLET),
        (["127.0.0.1"], "127.0.0.1", [f"{PROXY}, {PROXY}"], PROXY),  # the other is none of ours here
        ([PROXY], PROXY, [], PROXY),
        ([PROXY], PROXY, [""], PROXY),
        ([PROXY], PROXY, ["unknown"], PROXY),
        ([PROXY], PROXY, [f"{TABLET}, unknown"], PROXY),
        ([PROXY], PROXY, [f"{TABLET}, ' OR 1=1"], PROXY),
        ([PROXY], PROXY, [f"{TABLET}:51820"], TABLET),
        (["::1"], "::1", ["[2001:db8::7]:443"], "2001:db8::7"),
        (["::1"], "::1", ["2001:DB8:0::7"], "2001:db8::7"),
        ([PROXY], f"::ffff:{PROXY}", [TABLET], TABLET),  # as a socket of IPv6 calls it
        ([PROXY], PROXY, [f"::ffff:{TABLET}"], TABLET),
        (["172.18.0.0/16"], "172.18.0.5", [TABLET], TABLET),
        (["172.18.0.0/16"], "172.19.0.5", [TABLET], "172.19.0.5"),
        ([PROXY], "", [TABLET], ""),  # a socket of the file system
        ([PROXY], PROXY, [", ".join([OTHER] * 100_000 + [TABLET])], TABLET),
        ([PROXY], PROXY, [", ".join([PROXY] * 100_000)], PROXY),
    ],
)
def test_who_asks_is_whom_a_proxy_has_seen(told, peer, forwarded, asks):
    assert Proxies(told).who_asks(peer, forwarded) == asks


@pytest.mark.parametrize(
    ("told", "says"),
    [
        ("proxy.shop", "give the address"),
        ("192.168.1.2:80", "give the address"),
        ("192.168.1.2/24", "has host bits set"),
        ("0.0.0.0/0", "covers every address"),
        ("::/0", "covers every address"),
        ("", "give the address"),
    ],
)
def test_what_can_be_no_proxy_is_refused_with_a_sentence(told, says):
    with pytest.raises(UnusableProxyError, match=says):
        Proxies([told])
