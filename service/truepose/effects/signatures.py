"""What signatures of causes tell: where each acts, what it depends on, with which shape, and which are alike.

A cause declares its own; what has no trade name says it by its subject: where, over what, shape.
"""

from typing import get_args

from truepose.domain.diagnosis import Cause, Shape
from truepose.effects.causes import OF_SUBJECT, Candidate, Drawn, ErrorSignature, Signature
from truepose.effects.registry import CAUSES

# What leaves similar residuals: words of the places and variables of signatures.
_KIN = (
    frozenset({"torque", "load"}),
    frozenset({"time", "temperature", "mounting", "ballbar", "placement"}),  # these run together
    frozenset({"nest", "mounting", "readings", "placement"}),  # where nests are
    frozenset({"range", "temperature", "ballbar"}),  # how long lengths are
)
_UNKNOWN = Signature(OF_SUBJECT, "constant", "group")  # of what another version named
_APART = frozenset({"constant", "direction"})  # that two signatures share such a variable says little
_ALL_JOINTS = frozenset({"joint", "joints"})
_SHAPES: dict[str, Shape] = {shape: shape for shape in get_args(Shape)}


def signature_of(candidate: Candidate) -> ErrorSignature:
    """Return where a candidate acts, over what, with which shape.

    Parameters
    ----------
    candidate : Candidate
        Its variant and whether it is a function choose the shape.
    """
    declared = _declared(candidate.effect)
    if declared is None:
        return named_signature(candidate.effect, candidate.subject)
    signature = declared.of(candidate.subject, candidate.variant)
    if candidate.function:
        return signature._replace(shape=declared.function or declared.shape)
    return signature._replace(shape=declared.searched or declared.shape) if candidate.variant else signature


def named_signature(effect: str, subject: str) -> ErrorSignature:
    """Return the signature of a cause by name, before anything is searched; without a subject, of any.

    Parameters
    ----------
    effect : str
        Of a cause; one that is not known here, as of a result of another version, has a signature without
        words.
    subject : str
        Of a cause without a trade name: place, variable and shape, with commas between.
    """
    declared = _declared(effect)
    if declared is not None:
        return declared.of(subject)
    # A cell of the table has no entry of its own: its subject is made of these three (`Kind.subject`).
    where, over, shape = subject.split(", ")
    return ErrorSignature(where, over, _SHAPES[shape])


def place_of(cause: Cause) -> tuple[str, str] | None:
    """Return where a cause acts and over what.

    Returns
    -------
    tuple of str, or None
        None where its name alone does not say it: of an unknown effect, and of one whose variable is only
        found by a search.
    """
    declared = _declared(cause.effect)
    # The variable of a coupling is the joint that drags, which a subject does not name.
    if declared is not None and (declared is _UNKNOWN or "{variant" in declared.over):
        return None
    signature = named_signature(cause.effect, cause.subject)
    return signature.where, signature.over


def has_trade_name(effect: str) -> bool:
    """Whether an effect is one error source; else each of its subjects is one of its own."""
    return _declared(effect) is not None


def _declared(effect: str) -> Signature | None:
    # Results of other versions are read and compared too: a cause that is gone since then has a place all the
    # same.
    return CAUSES[effect].signature if effect in CAUSES else _UNKNOWN


def plural_of(effect: str) -> str:
    """Return the subject of several that share a cause; "" where each stands alone."""
    return (_declared(effect) or _UNKNOWN).plural


def amplitude_of(effect: str) -> str:
    """Return what the amplitude of a cause is."""
    declared = _declared(effect)
    return "largest deviation, as described in the finding" if declared is None else declared.amplitude


def curve_kind(effect: str) -> Drawn:
    """Return which curve shows a cause over the readings."""
    return (_declared(effect) or _UNKNOWN).drawn


def words_of(signature: ErrorSignature) -> frozenset[str]:
    """Return the words of a signature without its numbers: place, variable, both together, shape.

    Parameters
    ----------
    signature : ErrorSignature

    Returns
    -------
    frozenset of str
        E.g. joint, angle, "joint angle", wave.
    """
    where, over = _kind(signature.where), _kind(signature.over)
    return frozenset({where, over, f"{where} {over}", signature.shape})


def of_instrument(effect: str) -> bool:
    """Whether an effect lies in the instrument instead of the robot, whatever its subject."""
    return has_trade_name(effect) and bool({"tracker", "instrument"} & words_of(named_signature(effect, "")))


def of_legs(signature: ErrorSignature) -> bool:
    """Whether a signature is one of a ballbar or of its base: campaigns of positions have none."""
    return bool({"ballbar", "placement"} & words_of(signature))


def alike(one: ErrorSignature, other: ErrorSignature) -> bool:
    """Say whether two signatures leave similar residuals: the same place, the same variable, or kin.

    Symmetric. Of two that lie in joints only the joint counts, or that one is of all of them.

    Parameters
    ----------
    one, other : ErrorSignature
    """
    if one.over == other.over and one.over not in _APART:
        return True
    # Two joints move the tool along ways of their own; as kin by their words, the torques of any two would be
    # alike.
    if {_kind(one.where), _kind(other.where)} <= _ALL_JOINTS:
        return one.where == other.where or bool(_ALL_JOINTS & {one.where, other.where})
    words = [words_of(signature) for signature in (one, other)]
    return one.where == other.where or any(kin & words[0] and kin & words[1] for kin in _KIN)


def _kind(words: str) -> str:
    """Return a place or a variable without what it is of: `angle` of `angle of joint 3`."""
    return words if words == "last move" else words.partition(" ")[0]
