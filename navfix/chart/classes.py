"""The classes of charted objects that a radar may see, and how they are recognised under the names of many sources."""

from __future__ import annotations

from collections.abc import Mapping

from navfix.chart.records import ChartClass, ObjectKind, Role

_BUOYS = {
    "BOYLAT": "lateral buoy", "BOYCAR": "cardinal buoy", "BOYISD": "isolated danger buoy", "BOYSAW": "safe water buoy",
    "BOYSPP": "special purpose buoy", "BOYINB": "installation buoy", "LITFLT": "light float", "LITVES": "light vessel",
}  # fmt: skip
_FIXED = {
    "BCNLAT": "lateral beacon", "BCNCAR": "cardinal beacon", "BCNISD": "isolated danger beacon",
    "BCNSAW": "safe water beacon", "BCNSPP": "special purpose beacon", "OFSPLF": "offshore platform", "PILPNT": "pile",
    "MORFAC": "mooring dolphin", "WRECKS": "wreck above water",
}  # fmt: skip
_EQUIPMENT = {"LIGHTS": "light", "DAYMAR": "daymark"}
_APPENDAGES = {
    "TOPMAR": "topmark", "FOGSIG": "fog signal", "RTPBCN": "racon", "RETRFL": "radar reflector",
    "RADSTA": "radar station",
}  # fmt: skip
_LAND = {"LNDMRK": "landmark", "SILTNK": "silo or tank", "BUISGL": "building"}


def _classes(table: Mapping[str, str], kind: ObjectKind, role: Role) -> dict[str, ChartClass]:
    return {code: ChartClass(code, words, kind, role) for code, words in table.items()}


VIRTUAL = ChartClass("VIRTUAL", "virtual aid", "fixed", "virtual")
MOORING_BUOY = ChartClass("MORFAC", "mooring buoy", "floating")
CLASSES: dict[str, ChartClass] = {
    **_classes(_BUOYS, "floating", "structure"),
    **_classes(_FIXED, "fixed", "structure"),
    **_classes(_EQUIPMENT, "fixed", "equipment"),
    **_classes(_APPENDAGES, "fixed", "appendage"),
    **_classes(_LAND, "fixed", "land"),
    VIRTUAL.code: VIRTUAL,
}

# IHO S-57 object class numbers (appendix A, chapter 1)
_NUMBERS = {
    5: "BCNCAR", 6: "BCNISD", 7: "BCNLAT", 8: "BCNSAW", 9: "BCNSPP", 12: "BUISGL", 14: "BOYCAR", 15: "BOYINB",
    16: "BOYISD", 17: "BOYLAT", 18: "BOYSAW", 19: "BOYSPP", 39: "DAYMAR", 58: "FOGSIG", 74: "LNDMRK", 75: "LIGHTS",
    76: "LITFLT", 77: "LITVES", 84: "MORFAC", 87: "OFSPLF", 90: "PILPNT", 102: "RADSTA", 103: "RTPBCN", 113: "RETRFL",
    125: "SILTNK", 144: "TOPMAR", 159: "WRECKS",
}  # fmt: skip

# OpenSeaMap, value of seamark:type
_SEAMARK = {
    "buoy_lateral": "BOYLAT", "buoy_cardinal": "BOYCAR", "buoy_isolated_danger": "BOYISD", "buoy_safe_water": "BOYSAW",
    "buoy_special_purpose": "BOYSPP", "buoy_installation": "BOYINB", "light_float": "LITFLT", "light_vessel": "LITVES",
    "beacon_lateral": "BCNLAT", "beacon_cardinal": "BCNCAR", "beacon_isolated_danger": "BCNISD",
    "beacon_safe_water": "BCNSAW", "beacon_special_purpose": "BCNSPP", "platform": "OFSPLF", "pile": "PILPNT",
    "light": "LIGHTS", "light_major": "LIGHTS", "light_minor": "LIGHTS", "daymark": "DAYMAR", "topmark": "TOPMAR",
    "fog_signal": "FOGSIG", "radar_transponder": "RTPBCN", "radar_reflector": "RETRFL", "landmark": "LNDMRK",
    "virtual_aton": "VIRTUAL",
}  # fmt: skip

_FLOATING_WORDS = ("buoy", "float", "lightship", "light vessel")
_FIXED_WORDS = ("beacon", "light", "tower", "platform", "pile", "dolphin", "pylon", "turbine", "post", "pole", "fixed")


def recognise(text: str) -> ChartClass | None:
    """Return the class that a source names: an S-57 acronym or number, an OpenSeaMap type, or plain words.

    Plain words ("green buoy", "wind turbine") keep their wording and are floating or fixed by what they contain; None
    where nothing is recognised.
    """
    plain = text.strip()
    if plain.upper() in CLASSES:
        return CLASSES[plain.upper()]
    if plain.isdecimal() and int(plain) in _NUMBERS:
        return CLASSES[_NUMBERS[int(plain)]]
    code = _SEAMARK.get(plain.lower().replace(" ", "_").replace("-", "_"))
    return CLASSES[code] if code else _by_words(plain.lower().replace("_", " "))


def _by_words(words: str) -> ChartClass | None:
    known = next((c for c in (*CLASSES.values(), MOORING_BUOY) if c.words == words), None)
    if known is not None:
        return known
    if "virtual" in words or "synthetic" in words:
        return VIRTUAL
    for group, kind in ((_FLOATING_WORDS, "floating"), (_FIXED_WORDS, "fixed")):
        if any(word in words for word in group):
            return plain_class(words, kind)  # type: ignore[arg-type]
    return None


def plain_class(words: str, kind: ObjectKind) -> ChartClass:
    """Return the class of an object that is described by words alone."""
    return ChartClass("", words, kind)
