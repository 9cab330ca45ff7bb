"""What other packages bring: judged when it is loaded, named when it fails."""

import sys
from dataclasses import replace
from importlib.metadata import EntryPoint
from types import ModuleType

import pytest

from tests.helpers.diagnosis.point_scenes import telling_scene
from truepose.domain.errors import ConfigurationError, InstalledCauseError
from truepose.effects.causes import CellRow, NamedCause
from truepose.effects.installed import GROUP, load_installed
from truepose.effects.joints.joint_gain import JointGain
from truepose.effects.ports import Trait
from truepose.effects.unnamed.table import OWN

CELL = CellRow("{subject}", "angle of {subject}", "line")


class Acme(JointGain):
    name = "acme"


class Floating(Acme):
    traits = frozenset({Trait.ON_FIXED_NESTS})


class Failing(Acme):
    def candidates(self, scene):
        raise ValueError("three is no joint")

    def unseen(self, scene):
        raise ConfigurationError("The licence names another robot.")


class Needy(Acme):
    needs = frozenset({"humidity"})


@pytest.fixture
def brought(monkeypatch):
    """Load what a module would bring, by entry names."""

    def load(**named):
        module = ModuleType("acme_module")
        module.__dict__.update(named)
        monkeypatch.setitem(sys.modules, "acme_module", module)
        return load_installed(EntryPoint(name, f"acme_module:{name}", GROUP) for name in named)

    return load


def test_an_effect_a_cause_and_a_kind_are_told_apart(brought):
    kind = replace(OWN["jump"], name="leap")

    plain = brought(acme=Acme(), leap=kind)
    named = brought(acme=NamedCause(Acme(), CELL))

    assert (set(plain.effects), set(plain.causes), set(plain.kinds)) == ({"acme"}, set(), {"leap"})
    assert (set(named.effects), set(named.causes)) == ({"acme"}, {"acme"})
    assert named.causes["acme"].cell == CELL
    assert plain.broken == named.broken == {}


def test_what_is_brought_tells_its_traits_and_no_others(brought):
    telling, inheriting = brought(acme=Floating()), brought(acme=Acme())

    assert inheriting.effects["acme"].traits == JointGain.traits
    assert telling.effects["acme"].traits == Floating.traits


def test_what_is_brought_does_what_it_does_at_home(brought):
    scene = telling_scene()
    found = brought(acme=NamedCause(Acme(), CELL), jump=OWN["jump"])
    cause, kind = found.causes["acme"].cause, found.kinds["jump"]

    assert cause.candidates(scene) == Acme().candidates(scene)
    assert cause.unseen(scene) is None
    assert cause.needs == Acme.needs
    assert kind.places(scene) == tuple(OWN["jump"].places(scene))
    assert kind.subject((3,)) == "joint 3, time, jump"


@pytest.mark.parametrize(
    ("thing", "why"),
    [
        (object(), "its entry point is a object without specs, terms"),
        (NamedCause(object(), CELL), "without specs, terms, unseen, candidates, shown"),
        (JointGain(), "it calls itself 'joint_gain' but is registered as 'acme'"),
        (Needy(), "it needs humidity, which no row tells"),
        (replace(OWN["jump"], name="leap"), "it calls itself 'leap'"),
    ],
)
def test_what_is_none_of_these_is_left_out_with_its_reason(thing, why, brought):
    found = brought(acme=thing)

    assert why in found.broken["acme"]
    assert not found.effects and not found.kinds


def test_a_name_that_would_not_lead_back_is_refused(brought):
    assert "no underscore" in brought(acme_jump=replace(OWN["jump"], name="acme_jump")).broken["acme_jump"]


def test_one_that_cannot_be_loaded_does_not_take_the_others_down(brought):
    brought(acme=Acme())
    entries = [EntryPoint("gone", "no_such_module:X", GROUP), EntryPoint("acme", "acme_module:acme", GROUP)]

    found = load_installed(entries)

    assert set(found.effects) == {"acme"}
    assert found.broken["gone"].startswith("loading no_such_module:X failed with ModuleNotFoundError")


def test_of_two_of_one_name_the_second_is_refused(brought):
    brought(acme=Acme())

    found = load_installed([EntryPoint("acme", "acme_module:acme", GROUP)] * 2)

    assert "another installed package brings one of that name" in found.broken["acme"]


def test_a_failure_at_work_becomes_a_sentence_with_its_name(brought):
    cause = brought(acme=NamedCause(Failing(), CELL)).causes["acme"].cause

    with pytest.raises(InstalledCauseError, match="'acme' failed with ValueError: three is no joint"):
        cause.candidates(telling_scene())


def test_a_sentence_of_its_own_is_left_as_it_is(brought):
    cause = brought(acme=NamedCause(Failing(), CELL)).causes["acme"].cause

    with pytest.raises(ConfigurationError, match=r"^The licence names another robot\.$"):
        cause.unseen(telling_scene())


@pytest.mark.parametrize("field", ["places", "variants"])
def test_a_kind_that_fails_while_it_is_gone_through_is_named_too(field, brought):
    def yielding(_scene):
        yield from ()
        raise KeyError("month")

    kind = brought(jump=replace(OWN["jump"], **{field: yielding})).kinds["jump"]

    with pytest.raises(InstalledCauseError, match="'jump' failed with KeyError"):
        getattr(kind, field)(telling_scene())
