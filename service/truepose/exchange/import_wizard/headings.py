"""What a column can be, and what its heading says in the words of several trades and languages."""

import re
import unicodedata
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Final

AXES: Final = "xyz"
NOTHING: Final = "nothing"
_ANGLE: Final = MappingProxyType({"deg": 1.0, "rad": 57.29577951308232, "mrad": 0.05729577951308232})
_LENGTH: Final = MappingProxyType({"mm": 1.0, "m": 1000.0, "cm": 10.0, "um": 1e-3, "in": 25.4})
_TORQUE: Final = MappingProxyType({"Nm": 1.0, "Nmm": 1e-3, "kNm": 1000.0})
_TIME: Final = MappingProxyType({"s": 1.0, "ms": 1e-3, "us": 1e-6, "min": 60.0, "h": 3600.0})
_TEMPERATURE: Final = MappingProxyType({"C": 1.0, "K": 1.0, "F": 5.0 / 9.0})
_ZERO_C: Final = {"K": 273.15, "F": 32.0}
_NO_UNIT: Final[Mapping[str, float]] = MappingProxyType({})


@dataclass(frozen=True, slots=True)
class Quantity:
    """A kind of column; with `numbered` there is one a joint or an axis."""

    name: str  # as the catalogue and requests know it
    column: str  # of the file format; `{}` is the number of the joint, or the axis
    units: Mapping[str, float] = field(
        default_factory=lambda: _NO_UNIT
    )  # size of each in the format's own unit, which is the first
    numbered: str = ""  # "joint", "axis", or not

    def named(self, number: int) -> str:
        """Return the column of the file format for a joint, or an axis from 1."""
        return self.column.format(AXES[number - 1] if self.numbered == "axis" else number)


_TABLE: Final = (
    Quantity("joint", "q{}_deg", _ANGLE, "joint"),
    Quantity("position", "{}_mm", _LENGTH, "axis"),
    Quantity("nest", "nest"),
    Quantity("config", "config"),
    Quantity("direction", "dir{}", numbered="joint"),
    Quantity("torque", "tau{}_Nm", _TORQUE, "joint"),
    Quantity("time", "time_s", _TIME),
    Quantity("temperature", "temperature_C", _TEMPERATURE),
    Quantity("uncertainty", "u_mm", _LENGTH),
    Quantity("attachment", "attachment"),
    Quantity("qw", "qw"),
    Quantity("qx", "qx"),
    Quantity("qy", "qy"),
    Quantity("qz", "qz"),
    Quantity("length", "length_mm", _LENGTH),
    Quantity("base_point", "base_point"),
    Quantity("tool_point", "tool_point"),
    Quantity("placement", "placement"),
    Quantity("init", "init"),
    Quantity("repeat_of", "repeat_of"),
    Quantity("group", "group"),
    Quantity("rotation_uncertainty", "u_rot_deg"),
    Quantity("uncertainty_along", "u_along_mm"),
    Quantity("uncertainty_across", "u_across_mm"),
    Quantity(NOTHING, ""),
)
QUANTITIES: Final[Mapping[str, Quantity]] = MappingProxyType({one.name: one for one in _TABLE})
OF_THE_FORMAT: Final = MappingProxyType({
    one.column: one for one in _TABLE if one.column and not one.numbered
})
LABELS: Final = frozenset({"nest", "config", "base_point", "tool_point", "placement", "attachment", "init"})


@dataclass(frozen=True, slots=True)
class ColumnMeaning:
    """What a column is."""

    quantity: str  # of QUANTITIES
    number: int = 0  # of the joint, or the axis from 1; 0: neither
    unit: str = ""
    point: int = 0  # which of several points of its row, from 1; 0: there is one

    @property
    def column(self) -> str:
        """Its name in the file format; "" where it is nothing."""
        return QUANTITIES[self.quantity].named(self.number)

    def converted(self, value: float) -> float:
        """Return a number of this column in the unit of the file format."""
        size = QUANTITIES[self.quantity].units.get(self.unit, 1.0)
        offset = _ZERO_C.get(self.unit, 0.0) if self.quantity == "temperature" else 0.0
        return (value - offset) * size


MEANS_NOTHING: Final = ColumnMeaning(NOTHING)


SYMBOLS: Final = {
    "\u03b8": " theta ",
    "\u03c4": " tau ",
    "\u00b0": " deg ",
    "\u00b5": "u",
    "\u03bc": "u",
    "\u03c3": " sigma ",
}
_SPELLED: Final = {
    "deg": "deg degs degree degrees grad degre degres gradi grados",
    "rad": "rad radian radians",
    "mrad": "mrad",
    "mm": "mm millimeter millimetre millimeters millimetres",
    "m": "m meter metre meters metres",
    "cm": "cm",
    "um": "um",
    "in": "in inch inches zoll pouces",
    "Nm": "nm",
    "Nmm": "nmm",
    "kNm": "knm",
    "s": "s sec sek seconds",
    "ms": "ms",
    "us": "us",
    "min": "min",
    "h": "h",
    "C": "c degc celsius",
    "K": "k kelvin",
    "F": "f fahrenheit",
}
UNITS: Final = {word: unit for unit, words in _SPELLED.items() for word in words.split()}
_WORDS: Final = {
    "joint": (
        "q j jt jnt rax axis axe axes achse achsen gelenk gelenkwinkel achswinkel joint joints "
        "theta th winkel angle angles jointangle articulation eje asse giunto articulacion junta os "
        "kloub led akse nivel lenk a"
    ),
    "direction": ("dir direction richtung sens sense approach anfahrrichtung direccion direzione d"),
    "torque": "tau torque torques moment drehmoment couple effort par coppia mom",
    "nest": (
        "nest nid smr reflector reflektor reflecteur marker prisma prism ball kugel ziel target "
        "cible nido targetid nestid"
    ),
    "config": (
        "config configuration konfiguration cfg pose stellung posture messpunkt messung punkt nr no "
        "num number nummer index id idx row zeile point poseid configid pt punto posa lp poloha "
        "mesure"
    ),
    "time": ("time zeit temps timestamp uhrzeit zeitstempel t tiempo tempo cas heure date datetime"),
    "temperature": "temp temperature temperatur temperatura teplota",
    "uncertainty": (
        "u uncertainty unc sigma unsicherheit messunsicherheit incertitude incertidumbre incertezza "
        "sd std stdev rms"
    ),
    "attachment": "attachment mounting montage aufspannung",
    "length": (
        "length distance dist laenge lange abstand longueur longitud lunghezza distanza wire leg "
        "barlength seillaenge"
    ),
    "base_point": "basepoint basenest base anchor basispunkt",
    "tool_point": "toolpoint toolnest",
    "placement": "placement",
    "init": "init initialisation initialization",
}
MEANT_BY: Final = {word: name for name, words in _WORDS.items() for word in words.split()}
_BESIDE: Final = {
    "nominal": (
        "cmd command commanded controller ctrl desired ideal nenn nom nominal ref reference soll "
        "target teorico theo theoretical theorique"
    ),
    "measured": ("act actual ist istwert meas measured medido mess mesure misurato obs observed"),
    "no place": (
        "abweichung d delta dev deviation diff dx dy dz ecart err error f force fx i j k n normal q "
        "quat quaternion r rot rotation v vel velocity"
    ),
}
NOMINAL: Final = frozenset(_BESIDE["nominal"].split())
MEASURED: Final = frozenset(_BESIDE["measured"].split())
NOT_A_PLACE: Final = frozenset(_BESIDE["no place"].split())  # with one of these beside it, x is none
SPREAD: Final = frozenset(_WORDS["uncertainty"].split())
MOTOMAN: Final = "slurbt"
NAMED_JOINTS: Final = {
    "base": 1,
    "shoulder": 2,
    "shoulderpan": 1,
    "shoulderlift": 2,
    "elbow": 3,
    "wrist1": 4,
    "wrist2": 5,
    "wrist3": 6,
}


_LONGEST: Final = 200  # characters of a name that are looked at
_SIGN: Final = re.compile(r"[a-z]+|\d+")
_IN_BRACKETS: Final = re.compile(r"[\[(]\s*([^\])]*?)\s*[\])]")


@dataclass(frozen=True, slots=True)
class Heading:
    """What the name of a column says; words that it does not know tell columns of a kind apart."""

    meaning: ColumnMeaning
    stem: str = ""  # the name without number, axis and unit
    nominal: bool = False
    measured: bool = False


def heading(name: str) -> Heading:
    """Return what the name of a column says."""
    exact = OF_THE_FORMAT.get(name)
    if exact is not None:
        return Heading(ColumnMeaning(exact.name, 0, next(iter(exact.units), "")))
    tokens, unit = _taken_apart(name)
    nominal, measured = bool(NOMINAL & set(tokens)), bool(MEASURED & set(tokens))
    words = [token for token in tokens if token not in MEASURED] or tokens
    found = _axis(words, unit) or _orientation(words) or _numbered(words, unit) or _plain(words, unit)
    stem = " ".join(token for token in tokens if not token.isdecimal() and token not in AXES)
    return Heading(found or MEANS_NOTHING, stem, nominal, measured)


def unit_of(word: str) -> str:
    """Return the unit that a word is; "" where it is none."""
    return UNITS.get(_plain_letters(word).replace(" ", ""), "")


def series(name: str) -> tuple[str, int] | None:
    """Return the name before the one number in it, and that number: columns named alike are one thing."""
    tokens, _ = _taken_apart(name)
    numbers = [token for token in tokens if token.isdecimal()]
    if len(numbers) != 1:
        return None
    return " ".join(token for token in tokens if not token.isdecimal()), int(numbers[0])


def _taken_apart(name: str) -> tuple[list[str], str]:
    """Return the words and numbers of a name, and the unit that it says."""
    name = name[:_LONGEST]
    bracketed = _IN_BRACKETS.search(name)
    unit = unit_of(bracketed[1].split("/")[0]) if bracketed else ""
    bare = _IN_BRACKETS.sub(" ", name) if unit else name
    tokens = _SIGN.findall(_plain_letters(bare))
    if not unit and len(tokens) > 1 and tokens[-1] in UNITS:
        return tokens[:-1], UNITS[tokens[-1]]
    return tokens, unit


def _plain_letters(text: str) -> str:
    """Return a text in small letters without accents; Greek letters and signs by their names."""
    spelled = "".join(SYMBOLS.get(letter, letter) for letter in text)
    marked = unicodedata.normalize("NFKD", spelled.replace("\u00df", "ss"))
    joined = "".join(letter for letter in marked if not unicodedata.combining(letter))
    # "PosX" and "TcpX" are two words, "POSX" is one.
    return re.sub(r"(?<=[a-z])(?=[A-Z])", " ", joined).lower()


def _axis(words: list[str], unit: str) -> ColumnMeaning | None:
    """Return a coordinate: a name with one of x, y, z in it; or how uncertain coordinates are."""
    found = [AXES.index(word) + 1 for word in words if len(word) == 1 and word in AXES]
    if not found:
        found = [AXES.index(word[-1]) + 1 for word in words if word in _AXIS_WORDS]
    others = {word for word in words if word not in AXES}
    if len(found) != 1 or others & NOT_A_PLACE:
        return None
    if others & SPREAD:
        return ColumnMeaning("uncertainty", 0, unit)
    return ColumnMeaning("position", found[0], unit)


_AXIS_WORDS: Final = frozenset(f"{word}{axis}" for word in ("pos", "p", "tcp", "t") for axis in AXES)


def _orientation(words: list[str]) -> ColumnMeaning | None:
    joined = "".join(words)
    match = re.fullmatch(r"(?:.*quat(?:ernion)?|q)([wxyz])", joined)
    return ColumnMeaning(f"q{match[1]}") if match else None


def _numbered(words: list[str], unit: str) -> ColumnMeaning | None:
    """Return what has a number behind its word: a joint, a torque, a direction."""
    joined = "".join(word for word in words if word not in NOMINAL)
    if joined in NAMED_JOINTS and unit in {"deg", "rad", "mrad"}:
        return ColumnMeaning("joint", NAMED_JOINTS[joined], unit)
    match = re.fullmatch(r"(\D+?)(\d{1,2})\D*", joined)
    if match is None:
        return None
    names = [word for word in words if not word.isdecimal()]
    kinds = [MEANT_BY[word] for word in (match[1], *names) if word in MEANT_BY]
    kind = next((one for one in ("torque", "direction", "joint") if one in kinds), None)
    return None if kind is None else ColumnMeaning(kind, int(match[2]), unit)


def _plain(words: list[str], unit: str) -> ColumnMeaning | None:
    joined = "".join(words)
    known = [MEANT_BY[word] for word in (joined, *words) if word in MEANT_BY]
    kind = next((name for name in known if not QUANTITIES[name].numbered), None)
    if kind is None:
        return None
    units = QUANTITIES[kind].units
    return ColumnMeaning(kind, 0, unit if unit in units else "")


def motoman(names: list[str]) -> dict[int, int]:
    """Return the joints, by column, of a table whose columns are called S L U R B T."""
    plain = [_taken_apart(name)[0] for name in names]
    found = {
        tokens[0]: at for at, tokens in enumerate(plain) if len(tokens) == 1 and tokens[0] in set(MOTOMAN)
    }
    return (
        {at: MOTOMAN.index(letter) + 1 for letter, at in found.items()} if len(found) == len(MOTOMAN) else {}
    )
