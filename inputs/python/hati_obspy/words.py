"""What the words of headers mean: units, quantities, directions, steps."""

import math
import re

ACCELERATION, VELOCITY, DISPLACEMENT = "acceleration", "velocity", "displacement"

# Unit of a sample -> (quantity, how many of the SI unit).
UNITS = {
    "m/s2": (ACCELERATION, 1.0),
    "cm/s2": (ACCELERATION, 1e-2),
    "gal": (ACCELERATION, 1e-2),
    "g": (ACCELERATION, 9.80665),
    "g/10": (ACCELERATION, 0.980665),
    "mm/s2": (ACCELERATION, 1e-3),
    "nm/s2": (ACCELERATION, 1e-9),
    "m/s": (VELOCITY, 1.0),
    "cm/s": (VELOCITY, 1e-2),
    "mm/s": (VELOCITY, 1e-3),
    "nm/s": (VELOCITY, 1e-9),
    "m": (DISPLACEMENT, 1.0),
    "cm": (DISPLACEMENT, 1e-2),
    "mm": (DISPLACEMENT, 1e-3),
    "nm": (DISPLACEMENT, 1e-9),
}

_SPELLINGS = {"gals": "gal", "cms": "cm", "kine": "cm/s", "kines": "cm/s", "g's": "g", "gs": "g", "gravity": "g"}
_LENGTH = r"(nm|mm|cm|m)"
_PER_S2 = re.compile(_LENGTH + r"s?(?:/s2|/s/s|/ss|/\(s2\)|s-2|_s2|_s_s|/s\*s|ps2)$")
_PER_S = re.compile(_LENGTH + r"s?(?:/s|s-1|_s|ps)$")
# "ms" would be milliseconds.
_LENGTH_ONLY = re.compile(r"(nm|mm|cm|m)$")


def unit(word):
    """The unit that a word names, or "" where it names none that is known."""
    plain = word.strip().strip("()[]{}.,;:\"'").strip().lower()
    if len(plain) > 30:
        return ""
    for old, new in (("²", "2"), ("⁻", "-"), ("**", ""), ("^", ""), ("·", ""), (" ", ""), ("sec", "s"), ("seg", "s"),
                     ("centimeters", "cm"), ("meters", "m"), ("metres", "m"), ("per", "/")):
        plain = plain.replace(old, new)
    plain = _SPELLINGS.get(plain, plain)
    if plain in UNITS:
        return plain
    if plain in ("g/10", "g*0.1", "0.1g", "10-1g", "tenthg"):
        return "g/10"
    for pattern, tail in ((_PER_S2, "/s2"), (_PER_S, "/s"), (_LENGTH_ONLY, "")):
        match = pattern.match(plain)
        if match:
            return match.group(1) + tail
    return ""


_QUANTITIES = (
    (ACCELERATION, re.compile(r"(?<![a-z])acc(?:el\w*|n)?(?![a-z])|(?<![a-z])acel\w*|beschleunigung|ivme", re.I)),
    (VELOCITY, re.compile(r"(?<![a-z])vel(?:oc\w*|o)?(?![a-z])|vitesse|geschwindigkeit|hiz(?![a-z])", re.I)),
    (DISPLACEMENT, re.compile(r"(?<![a-z])dis(?:pl\w*|p|t)?(?![a-z])|depl\w*|spost\w*|desplaz\w*", re.I)),
)


def quantities(text):
    """The quantities that a text names, in a fixed order."""
    return [name for name, pattern in _QUANTITIES if pattern.search(text)]


def quantity(text):
    """The one quantity that a text names, else ""."""
    named = quantities(text)
    return named[0] if len(named) == 1 else ""


_BEARING = re.compile(r"([NS])\s*([0-9]{1,2}(?:\.[0-9]+)?)\s*(?:DEG\s*)?([EW])$")
_CARDINAL = {
    "N": 0.0, "NS": 0.0, "N-S": 0.0, "SN": 0.0, "NORTH": 0.0, "S": 180.0, "SOUTH": 180.0,
    "E": 90.0, "EW": 90.0, "E-W": 90.0, "WE": 90.0, "EAST": 90.0, "W": 270.0, "WEST": 270.0,
    "NORTH-SOUTH": 0.0, "EAST-WEST": 90.0,
}
_UP = {"UP", "Z", "UD", "U-D", "U"}
_VERTICAL = {"V", "VERT", "VERTICAL", "VER"}
_DOWN = {"DOWN", "DN", "DWN", "DOW"}
_DEGREES = re.compile(r"([0-9]{1,3}(?:\.[0-9]+)?)\s*(?:DEG(?:REES?)?|°)?\.?$")


def direction(word):
    """Header keys of a direction: `azimuth_deg` clockwise from north, or `vertical` (and its `sense`
    where the word tells whether up or down is positive).

    Takes `90 DEG`, `N08W`, `S82E`, `EW`, `UP`, `DOWN`; nothing for other words.
    """
    plain = " ".join(word.upper().split())[:40]
    if plain in _UP:
        return {"vertical": True, "sense": "up"}
    if plain in _DOWN:
        return {"vertical": True, "sense": "down"}
    if plain in _VERTICAL:
        return {"vertical": True}
    if plain in _CARDINAL:
        return {"azimuth_deg": _CARDINAL[plain], "vertical": False}
    match = _BEARING.match(plain)
    if match and float(match.group(2)) <= 90.0:
        angle = float(match.group(2)) * (1.0 if match.group(3) == "E" else -1.0)
        angle = angle if match.group(1) == "N" else 180.0 - angle
        return {"azimuth_deg": angle % 360.0, "vertical": False}
    match = _DEGREES.match(plain)
    if match and float(match.group(1)) <= 360.0:
        return {"azimuth_deg": float(match.group(1)) % 360.0, "vertical": False}
    return {}


def code(word, length=8):
    """A short code for an id: letters and digits only, upper case."""
    return "".join(c for c in word.upper() if c.isascii() and c.isalnum())[:length]


def channel_code(keys, otherwise=""):
    """The channel part of an id from a direction: `090`, `UP`, `DOWN`, `V`, else the other word."""
    if keys.get("vertical"):
        return keys.get("sense", "v").upper()
    if "azimuth_deg" in keys:
        angle = keys["azimuth_deg"]
        return "%03d" % round(360.0 if angle == 0.0 else angle)
    return code(otherwise)


NUMBER = r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eEdD][+-]?[0-9]{1,3})?"


def as_float(token):
    """A printed number, or None."""
    try:
        value = float(token.replace("D", "E").replace("d", "e"))
    except (ValueError, AttributeError):
        return None
    return value if math.isfinite(value) else None


def last_digit(token):
    """What one unit of the last printed digit is worth."""
    plain = token.strip().upper().replace("D", "E")
    mantissa, _, exponent = plain.partition("E")
    decimals = len(mantissa.partition(".")[2])
    try:
        power = int(exponent or 0)
    except ValueError:
        power = 0
    return 10.0 ** max(min(power - decimals, 300), -300)


def is_plain_word(word):
    """Whether a word is one of ordinary speech, which cannot be meant as a unit."""
    return word.strip("()[]").lower() in {
        "of", "are", "in", "the", "is", "and", "for", "unknown", "none", "used", "when", "follow"}
