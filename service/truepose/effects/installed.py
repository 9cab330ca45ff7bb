"""Effects, causes and cells that other packages bring, in the entry-point group `truepose.causes`.

What cannot be loaded, or is none of these, is kept with its reason: it must not take the others down. What
fails later, while it works, is refused in one sentence with its name (`InstalledCauseError`). This module is
the one place where causes of other packages are called, and where their exceptions are caught broadly.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from importlib.metadata import EntryPoint, entry_points
from typing import Any, ParamSpec, TypeGuard, TypeVar, get_args

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.campaign import Stops
from truepose.domain.diagnosis import Shape
from truepose.domain.errors import ConfigurationError, InstalledCauseError, TrueposeError
from truepose.domain.identification import NotIdentifiable
from truepose.effects.causes import Candidate, Cause, Description, FittedCause, Scene, Signature
from truepose.effects.ports import (
    Effect,
    Need,
    ParameterSpec,
    Port,
    Rows,
    Setting,
    Term,
    Trait,
)
from truepose.effects.unclassified.kinds import Kind, Variants
from truepose.messages.message import Text

GROUP = "truepose.causes"
_OF_EFFECTS = ("specs", "terms")
_OF_CAUSES = ("unseen", "candidates", "describe")

P = ParamSpec("P")
T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Installed:
    """What other packages bring, by name.

    Attributes
    ----------
    effects : mapping of str to Effect
        Causes among them.
    causes : mapping of str to Cause
    kinds : mapping of str to Kind
    broken : mapping of str to str
        Why an entry cannot be used.
    """

    effects: Mapping[str, Effect]  # causes among them
    causes: Mapping[str, Cause]
    kinds: Mapping[str, Kind]
    broken: Mapping[str, str]


def load_installed(entries: Iterable[EntryPoint]) -> Installed:
    """Load entries, in their order; what is wrong with one is kept in `broken`.

    Parameters
    ----------
    entries : iterable of EntryPoint
        Of two of one name neither counts.
    """
    effects: dict[str, Effect] = {}
    causes: dict[str, Cause] = {}
    kinds: dict[str, Kind] = {}
    broken: dict[str, str] = {}
    for entry in entries:
        # Neither is taken: which of two comes first depends on the order of the search path, and a model that
        # one of them extended would be predicted by the other.
        if any(entry.name in known for known in (effects, kinds, broken)):
            for known in (effects, causes, kinds):
                known.pop(entry.name, None)
            broken[entry.name] = "two installed packages provide it; remove one of them"
            continue
        try:
            match _loaded(entry):
                case Kind() as kind:
                    kinds[entry.name] = _guarded_kind(kind)
                case cause if _is_cause(cause):
                    effects[entry.name] = causes[entry.name] = _GuardedCause(cause)
                case effect:
                    effects[entry.name] = _GuardedEffect(effect)
        except ConfigurationError as error:
            broken[entry.name] = str(error)
        # Whatever foreign code does while it is imported, and what it brings while that is looked at.
        # SystemExit too: a package that ends the program would end every command.
        except (Exception, SystemExit) as error:
            broken[entry.name] = f"loading {entry.value} failed with {type(error).__name__}: {error}"
    return Installed(effects, causes, kinds, broken)


def _loaded(entry: EntryPoint) -> Kind | Effect:
    """Return what an entry names; raises ConfigurationError where it is nothing known."""
    found: Kind | Effect = entry.load()
    if isinstance(found, Kind):
        return _checked_kind(found, entry.name)
    _check_effect(found, entry.name, _OF_EFFECTS + (_OF_CAUSES if _is_cause(found) else ()))
    return found


def _is_cause(effect: Effect) -> TypeGuard[Cause]:
    return isinstance(getattr(effect, "signature", None), Signature)


def _checked_kind(kind: Kind, name: str) -> Kind:
    """Return a kind whose names can be told apart again; raises ConfigurationError."""
    _check_name(kind.name, name)
    if any("_" in one for one in (kind.name, *(part.name for part in kind.parts))):
        raise ConfigurationError("the names of a kind and of its parts must not contain underscores")
    if kind.shape not in get_args(Shape):
        raise ConfigurationError(f"its shape {kind.shape!r} must be one of {', '.join(get_args(Shape))}")
    return kind


def _check_effect(effect: Effect, name: str, methods: tuple[str, ...]) -> None:
    """Refuse what lacks a method, has another name, or needs what no row tells: ConfigurationError."""
    lacking = [one for one in methods if not callable(getattr(effect, one, None))]
    if lacking:
        raise ConfigurationError(
            f"its entry point is a {type(effect).__name__} without {', '.join(lacking)}, so it is neither an "
            "effect nor a Kind"
        )
    # A model names its effects; under another name than the registered one it would not find this one again.
    _check_name(getattr(effect, "name", None), name)
    unknown = set(effect.needs) - set(get_args(Need))
    if unknown:
        raise ConfigurationError(f"it needs {', '.join(sorted(unknown))}, which rows do not provide")


def _check_name(own: object, registered: str) -> None:
    if own != registered:
        raise ConfigurationError(f"its name is {own!r}, but it is registered as {registered!r}")


def _asked(name: str, what: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T:
    """Ask foreign code, and raise InstalledCauseError with its name for whatever it raises itself.

    Errors of truepose pass: a package may say in a sentence of its own why it refuses.
    """
    try:
        return what(*args, **kwargs)
    except TrueposeError:
        raise
    except Exception as error:
        raise InstalledCauseError(
            f"The installed cause {name!r} failed with {type(error).__name__}: {error}. Repair or remove the "
            "package that provides it."
        ) from error


class _GuardedEffect:
    """An effect of another package, with every ability that one may have.

    What it lacks is answered as for an effect that does nothing of the kind: who asks for an ability has to
    find it on the guard itself, which `isinstance` does not look through.
    """

    def __init__(self, effect: Effect) -> None:
        self._effect = effect
        self.name = effect.name
        self.needs = effect.needs
        self.traits: frozenset[Trait] = frozenset(getattr(effect, "traits", ()))

    def specs(self, setting: Setting) -> tuple[ParameterSpec, ...]:
        # Taken at once: a generator would fail later, outside of the guard.
        return _asked(self.name, lambda: tuple(self._effect.specs(setting)))

    def terms(self, names: tuple[str, ...], rows: Rows) -> list[Term]:
        return _asked(self.name, lambda: list(self._effect.terms(names, rows)))

    def goes_on(self, names: tuple[str, ...]) -> bool:
        return bool(self._able("goes_on", False, names))

    def automatic(self, setting: Setting) -> bool:
        return bool(self._able("automatic", False, setting))

    def left_open(self, names: tuple[str, ...], setting: Setting) -> list[NotIdentifiable]:
        return _asked(self.name, list, self._able("left_open", (), names, setting))

    def unmodelled(self, setting: Setting, stops: Stops) -> bool:
        return bool(self._able("unmodelled", False, setting, stops))

    def softness(
        self, names: tuple[str, ...], values: FloatArray, joint: int, load_n_mm: FloatArray | None
    ) -> FloatArray | float:
        found: FloatArray | float = self._able("softness", 0.0, names, values, joint, load_n_mm)
        return found

    def sums(self, names: tuple[str, ...], values: FloatArray, rows: Rows) -> dict[Port, FloatArray]:
        summed: dict[Port, FloatArray] | None = self._able("sums", None, names, values, rows)
        # A guard has `sums` whatever the effect has, since it is asked by `isinstance`: without it, its terms
        # are added up.
        return _added_up(self.terms(names, rows), values, len(rows.nest)) if summed is None else summed

    def _able(self, ability: str, without: Any, *told: Any) -> Any:
        """Ask the effect by one of its methods, which a wrapper of its own may answer for; else `without`."""
        # By attribute and not by `isinstance`: since Python 3.12 that does not look through a wrapper's
        # __getattr__.
        method = getattr(self._effect, ability, None)
        return _asked(self.name, method, *told) if callable(method) else without


def _added_up(terms: Iterable[Term], values: FloatArray, n: int) -> dict[Port, FloatArray]:
    moved: dict[Port, FloatArray] = {}
    for term in terms:
        moved[term.port] = moved.get(term.port, np.zeros(n)) + term.weight * float(values[term.parameter])
    return moved


class _GuardedCause(_GuardedEffect):
    """A cause of another package."""

    def __init__(self, cause: Cause) -> None:
        super().__init__(cause)
        self._cause = cause
        self.signature = cause.signature

    def unseen(self, scene: Scene) -> Text | None:
        return _asked(self.name, self._cause.unseen, scene)

    def candidates(self, scene: Scene) -> tuple[Candidate, ...]:
        return _asked(self.name, lambda: tuple(self._cause.candidates(scene)))

    def describe(self, subject: str, fitted: FittedCause, scene: Scene) -> Description:
        return _asked(self.name, self._cause.describe, subject, fitted, scene)


def _guarded_kind(kind: Kind) -> Kind:
    """Return a kind whose functions name it where they fail; what they yield is taken at once."""
    return replace(
        kind,
        where=lambda place: _asked(kind.name, lambda: _words(kind.where(place))),
        over=lambda place: _asked(kind.name, lambda: _words(kind.over(place))),
        places=lambda scene: _asked(kind.name, lambda: tuple(kind.places(scene))),
        variants=lambda scene: _asked(kind.name, lambda: _labelled(kind, kind.variants(scene))),
        moves=lambda key, rows: _asked(kind.name, lambda: list(kind.moves(key, rows))),
        sentence=lambda key, size, scene: _asked(kind.name, kind.sentence, key, size, scene),
        variant_known_to=lambda variant, scene: _asked(kind.name, kind.variant_known_to, variant, scene),
    )


def _words(words: str) -> str:
    """Return words of a place or a variable; raises ValueError where no subject of them comes apart again."""
    if ", " in words:
        raise ValueError(f"{words!r} contains a comma and a space, which separate place, variable and shape")
    return words


def _labelled(kind: Kind, variants: Variants) -> Variants:
    """Return variants; raises ValueError where a label does not lead back from the name of a parameter."""
    taken = tuple(variants)
    for label, _ in taken:
        if "_" in label:
            raise ValueError(
                f"the variant {label!r} contains an underscore, which separates the names of parameters"
            )
        if kind.variant_is is not None:
            float(label)  # findings tell it as a number
    return taken


INSTALLED = load_installed(entry_points(group=GROUP))
