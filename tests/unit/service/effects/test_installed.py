"""What other packages bring: judged when it is loaded, named when it fails."""

import sys
from dataclasses import replace
from importlib.metadata import EntryPoint
from types import ModuleType

import numpy as np
import pytest

from tests.helpers.diagnosis.point_scenes import rows_at_start, telling_problem, telling_scene
from truepose.domain.errors import ConfigurationError, InstalledCauseError
from truepose.domain.identification import NotIdentifiable
from truepose.effects.arm.joint_gain import JointGain
from truepose.effects.causes import Signature
from truepose.effects.installed import GROUP, load_installed
from truepose.effects.ports import (
    Automatic,
    Compliant,
    Discrepancy,
    Drifting,
    EffectWithTraits,
    LeavesOpen,
    Port,
    PortKind,
    Summed,
    Trait,
)
from truepose.effects.registry import EFFECTS, is_unbounded_in_time
from truepose.effects.unclassified.cause import OWN
from truepose.effects.unclassified.kinds import once

CELL = Signature("{subject}", "angle of {subject}", "line")


class Acme(JointGain):
    name = "acme"
    signature = CELL


class Plain(Acme):
    """An effect that no diagnosis looks for."""

    signature = None


class Lacking:
    """What calls itself a cause and does nothing."""

    signature = CELL


class Floating(Acme):
    traits = frozenset({Trait.ON_FIXED_NESTS})


class Able(Acme):
    """A cause with every ability that one may declare."""

    def goes_on(self, names):
        return names == ("acme_1",)

    def automatic(self, setting):
        return True

    def left_open(self, names, setting):
        return [NotIdentifiable(names, "there is no such thing")]

    def unmodelled(self, setting, stops):
        return True

    def softness(self, names, values, joint, load_n_mm):
        return 1e-9 * (joint + 1)

    def sums(self, names, values, rows):
        return {Port(PortKind.THETA, 0): 2.0 * values[0] * np.ones(len(rows.nest))}


class Wrapped:
    """A cause behind a wrapper of the other package's own."""

    def __init__(self, cause):
        self.cause = cause

    def __getattr__(self, name):
        return getattr(self.cause, name)


class Failing(Acme):
    def candidates(self, scene):
        raise ValueError("three is no joint")

    def unseen(self, scene):
        raise ConfigurationError("The licence names another robot.")


class Needy(Acme):
    needs = frozenset({"humidity"})


class Needless(Acme):
    needs = None


class Unfinished:
    """An effect that does not say what it needs."""

    name = "acme"
    specs = terms = Acme.specs


class Mistraited(Acme):
    traits = 3


class Shy(Acme):
    @property
    def signature(self):
        raise RuntimeError("no licence")


def setting_and_rows():
    """Of a campaign that tells everything."""
    problem = telling_problem(("base", "geometry"))
    return problem.setting, rows_at_start(problem)


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

    plain = brought(acme=Plain(), leap=kind)
    named = brought(acme=Acme())

    assert (set(plain.effects), set(plain.causes), set(plain.kinds)) == ({"acme"}, set(), {"leap"})
    assert (set(named.effects), set(named.causes)) == ({"acme"}, {"acme"})
    assert named.causes["acme"].signature == CELL
    assert plain.broken == named.broken == {}


def test_what_is_brought_tells_its_traits_and_no_others(brought):
    telling, inheriting = brought(acme=Floating()), brought(acme=Acme())

    assert inheriting.effects["acme"].traits == JointGain.traits
    assert telling.effects["acme"].traits == Floating.traits


@pytest.mark.parametrize("thing", [Able(), Wrapped(Able())])
def test_every_ability_of_what_is_brought_is_seen_through_its_guard(brought, thing):
    guarded = brought(acme=thing).effects["acme"]
    setting, rows = setting_and_rows()

    assert isinstance(guarded, Drifting)
    assert guarded.goes_on(("acme_1",))
    assert not guarded.goes_on(("acme_2",))
    assert isinstance(guarded, Automatic)
    assert guarded.automatic(setting)
    assert isinstance(guarded, LeavesOpen)
    assert guarded.left_open(("acme_1",), setting) == Able().left_open(("acme_1",), setting)
    assert isinstance(guarded, Summed)
    (moved,) = guarded.sums(("acme_1",), np.array([0.25]), rows).values()
    assert moved == pytest.approx(0.5)
    assert isinstance(guarded, Discrepancy)
    assert guarded.unmodelled(setting, rows.stops)
    assert isinstance(guarded, Compliant)
    assert guarded.softness(("acme_1",), np.array([0.25]), 2, None) == pytest.approx(3e-9)
    assert isinstance(guarded, EffectWithTraits)


def test_what_lacks_an_ability_does_nothing_of_the_kind(brought):
    guarded = brought(acme=Acme()).effects["acme"]
    setting, rows = setting_and_rows()
    names, values = ("gain_1", "gain_3"), np.array([1e-3, -2e-3])

    moved = guarded.sums(names, values, rows)

    assert not guarded.goes_on(names)
    assert not guarded.automatic(setting)
    assert guarded.left_open(names, setting) == []
    assert not guarded.unmodelled(setting, rows.stops)
    assert guarded.softness(names, values, 2, None) == 0.0
    assert moved[Port(PortKind.THETA, 0)] == pytest.approx(1e-3 * rows.turn_rad[:, 0])
    assert moved[Port(PortKind.THETA, 2)] == pytest.approx(-2e-3 * rows.turn_rad[:, 2])


@pytest.mark.parametrize("ask", ["goes_on", "automatic", "left_open", "sums", "unmodelled", "softness"])
def test_an_ability_that_fails_is_refused_with_the_name_of_what_is_installed(brought, ask):
    class Broken(Able):
        def goes_on(self, *told):
            raise ValueError("three is no joint")

        automatic = left_open = sums = unmodelled = softness = goes_on

    guarded = brought(acme=Broken()).effects["acme"]
    told = {"goes_on": 1, "automatic": 1, "left_open": 2, "sums": 3, "unmodelled": 2, "softness": 4}[ask]

    with pytest.raises(InstalledCauseError, match="'acme' failed with ValueError: three is no joint"):
        getattr(guarded, ask)(*[None] * told)


def test_a_made_model_holds_a_brought_cause_that_drifts(brought, monkeypatch):
    monkeypatch.setitem(EFFECTS, "acme", brought(acme=Able()).effects["acme"])

    assert is_unbounded_in_time("acme", ("acme_1",))
    assert not is_unbounded_in_time("acme", ("acme_2",))


def test_what_is_brought_does_what_it_does_at_home(brought):
    scene = telling_scene()
    found = brought(acme=Acme(), jump=OWN["jump"])
    cause, kind = found.causes["acme"], found.kinds["jump"]

    assert cause.candidates(scene) == Acme().candidates(scene)
    assert cause.unseen(scene) is None
    assert cause.needs == Acme.needs
    assert kind.places(scene) == tuple(OWN["jump"].places(scene))
    assert kind.subject((3,)) == "joint 3, time, jump"


@pytest.mark.parametrize(
    ("thing", "why"),
    [
        (object(), "its entry point is a object without specs, terms"),
        (Lacking(), "without specs, terms, unseen, candidates, describe"),
        (JointGain(), "its name is 'joint_gain', but it is registered as 'acme'"),
        (Needy(), "it needs humidity, which rows do not provide"),
        (replace(OWN["jump"], name="leap"), "its name is 'leap'"),
        (Needless(), "loading acme_module:acme failed with TypeError"),
        (Unfinished(), "loading acme_module:acme failed with AttributeError"),
        (Mistraited(), "loading acme_module:acme failed with TypeError"),
        (Shy(), "loading acme_module:acme failed with RuntimeError: no licence"),
        (replace(OWN["jump"], name="acme", shape="hump"), "its shape 'hump' must be one of"),
        (replace(OWN["jump"], name="acme", parts=None), "loading acme_module:acme failed with TypeError"),
    ],
)
def test_what_is_none_of_these_is_left_out_with_its_reason(thing, why, brought):
    found = brought(acme=thing)

    assert why in found.broken["acme"]
    assert not found.effects and not found.kinds


def test_a_name_that_would_not_lead_back_is_refused(brought):
    assert (
        "must not contain underscores"
        in brought(acme_jump=replace(OWN["jump"], name="acme_jump")).broken["acme_jump"]
    )


def test_one_that_cannot_be_loaded_does_not_take_the_others_down(brought):
    brought(acme=Acme())
    entries = [EntryPoint("gone", "no_such_module:X", GROUP), EntryPoint("acme", "acme_module:acme", GROUP)]

    found = load_installed(entries)

    assert set(found.effects) == {"acme"}
    assert found.broken["gone"].startswith("loading no_such_module:X failed with ModuleNotFoundError")


@pytest.mark.parametrize("thing", [Acme(), Plain(), replace(OWN["jump"], name="acme"), object()])
def test_of_two_of_one_name_neither_is_taken(thing, brought):
    brought(acme=thing)

    found = load_installed([EntryPoint("acme", "acme_module:acme", GROUP)] * 2)

    assert "two installed packages provide it" in found.broken["acme"]
    assert not found.effects and not found.causes and not found.kinds


def test_a_failure_at_work_becomes_a_sentence_with_its_name(brought):
    cause = brought(acme=Failing()).causes["acme"]

    with pytest.raises(InstalledCauseError, match="'acme' failed with ValueError: three is no joint"):
        cause.candidates(telling_scene())


def test_a_sentence_of_its_own_is_left_as_it_is(brought):
    cause = brought(acme=Failing()).causes["acme"]

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


@pytest.mark.parametrize("field", ["where", "over"])
def test_words_that_a_subject_could_not_be_taken_apart_at_are_refused(field, brought):
    kind = brought(jump=replace(OWN["jump"], **{field: once("hall 3, east")})).kinds["jump"]

    with pytest.raises(
        InstalledCauseError, match="'jump' failed with ValueError: 'hall 3, east' contains a comma"
    ):
        kind.subject((3,))


def test_a_variant_that_would_not_lead_back_from_a_name_is_refused(brought):
    kind = brought(jump=replace(OWN["jump"], variants=lambda _scene: [("by_day", 0.0)])).kinds["jump"]

    with pytest.raises(
        InstalledCauseError, match="'jump' failed with ValueError: the variant 'by_day' contains an"
    ):
        kind.variants(telling_scene())


def test_a_variant_is_a_word_only_where_no_finding_tells_it_as_a_number(brought):
    worded = replace(OWN["jump"], variants=lambda _scene: [("noon", 0.0)])
    told, kept = (brought(jump=kind).kinds["jump"] for kind in (worded, replace(worded, variant_is=None)))

    assert OWN["jump"].variant_is is not None
    assert kept.variants(telling_scene()) == (("noon", 0.0),)
    with pytest.raises(InstalledCauseError, match="could not convert string to float: 'noon'"):
        told.variants(telling_scene())
