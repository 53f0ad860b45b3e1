"""Reads the angles at which the heads stand from text."""

from __future__ import annotations


def places_from_text(text: str) -> tuple[float, ...]:
    """Return the angles of all heads relative to head 1, degrees, from ``0,64.3,177,257.9``.

    Raises ValueError if an angle is not a number between −360 and 360 or head 1 is not at 0.
    """
    try:
        places = tuple(float(word) for word in text.split(","))
    except ValueError:
        raise ValueError(f"expected degrees such as 0,64.3,177,257.9, found {text!r}") from None
    if places[0] != 0.0 or not all(abs(place) < 360.0 for place in places):
        raise ValueError("expected 0 for head 1, and all angles between -360 and 360")
    return places
