"""The words by which people of several trades and languages call columns, and the units that they write."""

from typing import Final

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
