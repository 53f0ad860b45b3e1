"""Lists the names, in several languages, that other programs give to the quantities."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Mapping

_NAMES: Mapping[str, str] = {
    "time": "time timestamp zeit zeitstempel messzeit uhrzeit elapsed temps horodatage heure "
    "tiempo tempo tijd tid cas czas 时间",
    "target": "target reference ref referenz sollwert soll setpoint commanded command nominal "
    "consigne cible referencia objetivo riferimento nominale nennwert true 参考",
    "error": "error err fehler abweichung messabweichung winkelfehler deviation erreur ecart "
    "desviacion errore deviazione scostamento 误差",
    "head1": "head1 reading istwert ist actual measured encoder enc encoder1 enc1 messwert kopf1 "
    "lesekopf1 abtastkopf1 tete1 testa1 cabeza1 mesure medido medida misura misurato lettura "
    "codeur drehgeber 读数",
    "head2": "head2 encoder2 enc2 kopf2 lesekopf2 abtastkopf2 tete2 testa2 cabeza2",
    "head3": "head3 encoder3 enc3 kopf3 lesekopf3 abtastkopf3 tete3 testa3 cabeza3",
    "head4": "head4 encoder4 enc4 kopf4 lesekopf4 abtastkopf4 tete4 testa4 cabeza4",
    "run": "run lauf laufnummer messlauf durchlauf pass essai pasada",
    "cycle": "cycle zyklus zyklusnummer ciclo",
    "direction": "direction dir richtung drehrichtung sens direccion direzione verso",
    "temperature": "temperature temp temperatur temperatura",
}
_MEANS = {name: quantity for quantity, names in _NAMES.items() for name in names.split()}
_WITH_UNIT_ONLY = {"t": "time"}
"""Names that mean time only if the column also states a unit of time: ``t`` alone may be a
temperature."""
_ENDINGS = ("winkel", "angle", "position", "pos", "value", "wert", "angulo", "angolo")
"""Words that may follow a name without changing its meaning: Sollwinkel, target position."""


def quantity_meant(name: str, *, unit_of_time: bool = False) -> str | None:
    """Return the quantity that a column's ``name`` (without its unit) denotes; None if the name is
    unknown.

    Case, accents and separators between the words are ignored. ``unit_of_time``: the column's name
    contains a unit of time.
    """
    # A text in brackets that is not a known unit does not belong to the name.
    bare_name = re.sub(r"[\[(][^\])]*[\])]\s*$", "", name)
    plain = unicodedata.normalize("NFKD", bare_name.strip().casefold())
    bare = "".join(sign for sign in plain if not unicodedata.combining(sign))
    bare = re.sub(r"[\W_]+", "", bare)
    if unit_of_time and bare in _WITH_UNIT_ONLY:
        return _WITH_UNIT_ONLY[bare]
    if bare in _MEANS:
        return _MEANS[bare]
    for ending in _ENDINGS:
        if bare.endswith(ending) and bare.removesuffix(ending) in _MEANS:
            return _MEANS[bare.removesuffix(ending)]
    return None


UNLOCKS: Mapping[str, str] = {
    "time": "latency, drift, vibration and all that depends on speed",
    "temperature": "the effects of heat",
    "direction": "hysteresis, if the motion does not show the direction",
    "head2": "graduation and head angle without a reference",
    "head3": "orders that two heads hardly show, and a mean without the motion of the axis",
    "head4": "the motion of the axis separately from the error of the disc, and a mean that can "
    "leave out a failed head",
}
"""Tests and results, by quantity, that are possible only if the set has this quantity."""
