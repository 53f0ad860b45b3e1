"""An error of the reference that every pass shows at the same places, in words and as JSON."""

from __future__ import annotations

from dataclasses import dataclass

MOST = 0.5
"""If the repeated error has more than this share of the residual's mean square, a change in time
has less. The same limit applies to a slow change."""


@dataclass(frozen=True)
class Spot:
    """One place, or several neighbouring places, with an error of its own."""

    angle_deg: float
    """Angle of the largest error."""
    size_arcsec: float
    sigma_arcsec: float
    width_deg: float
    """Angle from the first to the last of neighbouring places; 0 for one station."""


@dataclass(frozen=True)
class RepeatedError:
    """An error of the reference that every pass shows at the same places."""

    rms_arcsec: float
    """RMS of the repeated error over all places, without the noise of their means."""
    passes: int
    places: int
    spots: tuple[Spot, ...] = ()
    """Single places that cause the error; empty if they do not explain most of it."""
    stations: bool = True
    """True for stations, False for places of a log in motion."""
    share: float = 0.0
    """Share of the mean square of the residual that repeats."""
    over_travel: bool = False
    """True if the error repeats over the unwrapped angle of several turns."""
    step: Spot | None = None
    """Step of the error at one angle, in place of single places; its size is the error after the
    step minus that before, in the direction of increasing angle."""
    beyond_order: int = 0
    """Order up to which a curve is removed, if the higher orders of the model contain the place;
    otherwise 0."""

    @property
    def is_most(self) -> bool:
        """True if the repeated error has more than half of the residual's mean square."""
        return self.share > MOST

    @property
    def largest_arcsec(self) -> float:
        """Size of the largest error of a single place, or half of a step; 0 without both."""
        if self.step is not None:
            return 0.5 * abs(self.step.size_arcsec)
        return max((abs(item.size_arcsec) for item in self.spots), default=0.0)

    @property
    def is_located(self) -> bool:
        """True if single places, or a step at one angle, cause the error."""
        return bool(self.spots) or self.step is not None

    def words(self) -> str:
        """Return the detection in words."""
        if self.step is not None:
            return (
                f"in each of {self.passes} passes the error steps at {_of_spot(self.step)} and "
                "returns over the turn: the levels before and after this angle differ, as at a "
                "joint of the scale"
            )
        if not self.spots:
            where = "angle of travel" if self.over_travel else "angle"
            return (
                f"the error repeats at equal {where} in {self.passes} passes, "
                f"{self.rms_arcsec:.3g}″ RMS over {self.places} places: it belongs to the place, "
                "not to the time"
            )
        first = sorted(self.spots, key=lambda item: -abs(item.size_arcsec))
        said = "; ".join(_of_spot(item) for item in first[:SHOWN_SPOTS])
        more = "" if len(first) <= SHOWN_SPOTS else f" and {len(first) - SHOWN_SPOTS} more"
        kind = "station" if self.stations else "place"
        kind = f"a single {kind} is" if len(first) == 1 else f"single {kind}s are"
        among = ""
        if self.beyond_order:
            among = (
                f", beyond a curve of the orders 1 to {self.beyond_order}; the higher orders of "
                "the model contain this error, so that no residual shows it"
            )
        return f"{kind} off in each of {self.passes} passes: {said}{more}{among}"

    def data(self) -> dict[str, object]:
        """Return the detection as JSON."""
        return {
            "rms_arcsec": self.rms_arcsec,
            "passes": self.passes,
            "places": self.places,
            "single_places": [
                {
                    "angle_deg": item.angle_deg,
                    "size_arcsec": item.size_arcsec,
                    "sigma_arcsec": item.sigma_arcsec,
                    "width_deg": item.width_deg,
                }
                for item in self.spots
            ],
            "step": None
            if self.step is None
            else {
                "angle_deg": self.step.angle_deg,
                "size_arcsec": self.step.size_arcsec,
                "sigma_arcsec": self.step.sigma_arcsec,
            },
        }


SHOWN_SPOTS = 8
"""Largest number of single places in a sentence; the JSON contains all."""


def _of_spot(item: Spot) -> str:
    wide = f", {item.width_deg:.2g}° wide" if item.width_deg > 0.0 else ""
    return f"{item.angle_deg:.4g}° by {item.size_arcsec:.3g}″ (u {item.sigma_arcsec:.2g}″{wide})"
