"""The readings of a campaign as observations: the one place that asks which kind they are.

What answers for a kind is imported where it comes: most campaigns have one.
"""

from truepose.domain.measurement.campaign import LegReadings, PointReadings, Readings
from truepose.identification.model.parameters.structure import Structure
from truepose.identification.observations.blocks import Block
from truepose.identification.observations.positions import position_block


def observed(readings: Readings, scatter_mm: float, structure: Structure) -> Block:
    """Return readings as observations of a model.

    Parameters
    ----------
    readings : PointReadings, LegReadings or ContactReadings
    scatter_mm : float
        Of the arm per axis, beside what the readings state.
    structure : Structure
        Of the model that they are held against.

    Raises
    ------
    ConfigurationError
        A leg is from a cup, or a contact against a target, that the model does not know.
    """
    if isinstance(readings, PointReadings):
        return position_block(readings, scatter_mm)
    if isinstance(readings, LegReadings):
        from truepose.identification.observations.legs import leg_block

        return leg_block(readings, scatter_mm, structure.anchors)
    from truepose.identification.observations.contacts.block import contact_block

    return contact_block(readings, scatter_mm, structure.targets)
