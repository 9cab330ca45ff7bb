"""Link mass: a link weighs something else, or elsewhere, than its maker states.

Mass and first moment of a frame add torques (`loads.mass_terms`), which wind up the springs of the model.
"""

from truepose.effects.arm import loads
from truepose.effects.causes import OF_SUBJECT, Candidate, Description, FittedCause, Scene, Signature
from truepose.effects.ports import Need, ParameterSpec, Rows, Setting, Term
from truepose.messages.message import Text, message

NAME = "link_mass"


class LinkMasses:
    """Mass and first moment of every link with a stated mass; that of the flange frame is the payload."""

    name = NAME
    needs: frozenset[Need] = frozenset({"torque"})
    signature = Signature(OF_SUBJECT, "load", "line", "deviation of the link mass", plural="links", at="link")

    def specs(self, setting: Setting) -> tuple[ParameterSpec, ...]:
        """Return mass and three first moments per link where torques come from masses."""
        return tuple(spec for link in _links(setting) for spec in _specs(setting, link))

    def terms(self, names: tuple[str, ...], rows: Rows) -> list[Term]:
        """Load the joints: torques [N mm] per kg or per kg mm, one for each joint that carries the link."""
        return [
            term
            for k, name in enumerate(names)
            for quantity, link, *axis in (name.split("_"),)
            for term in loads.mass_terms(k, int(link) - 1, axis[0] if axis else quantity, rows)
        ]

    def unseen(self, scene: Scene) -> Text | None:
        """Need springs that gravity loads."""
        return loads.unseen_masses(scene)

    def candidates(self, scene: Scene) -> tuple[Candidate, ...]:
        """Propose each link with a stated mass, and all of them together."""
        # A rigid arm stands where it does whatever it weighs: without springs there is nothing to look for.
        if loads.unseen_masses(scene) is not None:
            return ()
        single = [
            Candidate(NAME, f"link {link}", specs)
            for link in _links(scene.setting)
            for specs in (_specs(scene.setting, link),)
            if scene.present.isdisjoint(spec.name for spec in specs)
        ]
        if len(single) < 2:
            return tuple(single)
        together = tuple(spec for candidate in single for spec in candidate.specs)
        return (*single, Candidate(NAME, "links", together))

    def describe(self, subject: str, fitted: FittedCause, scene: Scene) -> Description:
        """Say how much heavier the link is; of several the one that is off most, all in the details."""
        wrong = _wrong_masses(fitted, scene)
        link, worst = max(wrong.items(), key=lambda item: abs(item[1].extra_kg))
        stated = loads.stated_mass(scene.setting.robot, link - 1)
        who = "causes.link_mass.several" if len(wrong) > 1 else "causes.link_mass.one"
        sentence = message(
            "causes.link_mass.more" if worst.extra_kg >= 0.0 else "causes.link_mass.less",
            who=message(who, link=link),
            extra_kg=abs(worst.extra_kg),
            stated_kg=stated.mass_kg,
        )
        details = tuple(
            detail
            for number, item in wrong.items()
            for detail in item.details(prefix=f"link {number}: " if len(wrong) > 1 else "")
        )
        # Of the link that is told; the others are judged when they are told alone.
        limits = loads.mass_limits(stated)
        return Description(subject, worst.extra_kg, "kg", worst.extra_spread_kg, sentence, details, limits)


def _links(setting: Setting) -> list[int]:
    if setting.torque_source != "masses":
        return []
    stated = {mass.frame for mass in setting.robot.masses if mass.mass_kg > 0.0}
    # A mass of the flange frame is the tool's, whose name is the payload: one thing must not have two names.
    return sorted(stated - {setting.robot.n_joints})


def _specs(setting: Setting, link: int) -> tuple[ParameterSpec, ...]:
    x, y, z = (f"moment_{link}_{axis}" for axis in "xyz")
    return loads.mass_specs((f"mass_{link}", x, y, z), loads.stated_mass(setting.robot, link - 1))


def _wrong_masses(fitted: FittedCause, scene: Scene) -> dict[int, loads.WrongMass]:
    """Return the links that were fitted, each with its amount and centre of gravity told apart."""
    return {
        link: loads.wrong_mass(fitted, specs, loads.stated_mass(scene.setting.robot, link - 1))
        for link in _links(scene.setting)
        for specs in (_specs(scene.setting, link),)
        if specs[0].name in fitted.names
    }
