"""What an export is made from: a model's rigid arm, what that leaves out, and what the loss comes to."""

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

from truepose.correction.zone_errors import ZoneError, nominal_error, rigid_error, zone_targets
from truepose.correction.zone_fit import nearest_arm
from truepose.domain.errors import UnsuitableModelError
from truepose.domain.results.identification import Model
from truepose.domain.sentences import Sentence, said
from truepose.identification.model.rigid import RigidArm, rigid_arm

_GEOMETRY: Final = ("base", "tool", "geometry")
_FIT_SEED, _JUDGE_SEED = 1, 2


@dataclass(frozen=True, slots=True)
class Subject:
    """A model as others can take it."""

    model: Model
    arm: RigidArm
    fitted: bool  # the table was fitted to the full model, else it is the identified one
    error: ZoneError | None  # of the arm against the full model; None: nobody can say
    nominal: ZoneError | None  # of the nominal robot against the full model

    @property
    def left_out(self) -> dict[str, int]:
        """Effects that others cannot take, and how many parameters each has."""
        return dict(Counter(parameter.effect for parameter in self.arm.left_out))


def subject_of(model: Model, *, fitted: bool = False) -> Subject:
    """Return a model as others can take it.

    Parameters
    ----------
    model : Model
    fitted : bool
        Fit base, tool and table to the full model over the measured zone, in the place of those identified.

    Raises
    ------
    UnsuitableModelError
        It shall be fitted, and the model does not know its zone or needs measured torques.
    """
    arm = _fitted(model) if fitted else rigid_arm(model)
    error, nominal = rigid_error(model, arm, _JUDGE_SEED), nominal_error(model, _JUDGE_SEED)
    return Subject(model, arm, fitted, error, nominal)


def _fitted(model: Model) -> RigidArm:
    targets = zone_targets(model, _FIT_SEED)
    if targets is None:
        raise UnsuitableModelError(
            "A table is fitted only to a model that knows its measured zone and needs no measured torques: "
            "identify again with this version, without torques, or take the identified table."
        )
    return nearest_arm(model, targets, _GEOMETRY)


def remarks(subject: Subject) -> Iterator[Sentence]:
    """Yield what the file does not hold, and what that costs."""
    if not subject.left_out:
        yield said("exports.whole")
    for effect, count in subject.left_out.items():
        yield said("exports.left_out", effect=effect, count=count)
    if subject.fitted:
        yield said("exports.fitted")
    yield from _costs(subject)


def _costs(subject: Subject) -> Iterator[Sentence]:
    if subject.error is None or subject.nominal is None:
        yield said("exports.error_unknown")
        return
    yield said(
        "exports.error",
        mean_mm=subject.error.mean_mm,
        largest_mm=subject.error.max_mm,
        nominal_mm=subject.nominal.mean_mm,
        nominal_largest_mm=subject.nominal.max_mm,
    )
    if not subject.fitted and subject.error.mean_mm > subject.nominal.mean_mm:
        yield said("exports.worse")
