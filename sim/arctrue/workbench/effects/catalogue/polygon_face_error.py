"""The faces of the polygon are not at equal angles."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.special import betaincc, chdtrc, fdtrc

from arctrue.base.figures import with_uncertainty
from arctrue.workbench.effects.base import (
    CONTRADICTED_P,
    Columns,
    Effect,
    FitContext,
    Nonlinear,
    Parameter,
)
from arctrue.workbench.effects.missing import lacking_capture, lacking_key
from arctrue.workbench.observations import Observations, ReferenceRows

LEAST_FACES = 8
"""Smallest number of faces for the tests; with fewer faces, independent errors look like a wave."""
WIDEST_PLACE = 3
"""Largest number of neighbouring faces that are tested together as one place of the table: three of
24 faces are an eighth of a turn."""
LEAST_FACES_LEFT = 0.1
"""Smallest share of the face errors' mean square that must remain without order 1 to count as face
errors. A smaller remainder, less than a third of the wave, may belong to a wave that is not a
sinusoid."""
SURE_P = 1e-4
"""Significant face errors remain without order 1 if their p is at most this: the limit of a sure
lack of fit."""
LISTED_FACES = 3
"""Largest number of faces in the sentence on their sizes; the JSON contains all faces."""
MAGNIFIED = 0.25
"""If |e^{jnα} − 1| is below this value, order n is removed from the face errors. The fit divides
the heads' difference by this factor to find the graduation's order n, so that an error of the
difference appears in the reference magnified four times or more."""


class PolygonFaceError(Effect):
    """Adds one constant per face to the reference run."""

    name = "polygon_face_error"
    physics = (
        "Each face of the polygon deviates from its nominal angle by its own amount. This error "
        "belongs to the polygon, not to the table, and moves with the polygon when the polygon "
        "is re-indexed."
    )
    equation = "ε = f_i at face i, Σ f_i = 0; reference only"
    source = "the paper (docs/paper.md), Table 3, u₁; EURAMET cg-19"
    capture_sees = "nothing"
    reference_sees = "the same error each time a face is read"
    separated_by = (
        "the error belongs to the face: if the polygon is re-indexed, the error moves with the face"
    )
    next_measurement = "a reference run with the polygon re-indexed by some faces"
    plausible = "0.1 to 0.5″"
    parameter_units = {"rms": "arcsec", "face_I": "arcsec"}
    compensation = "reference"
    compensation_note = "an error of the reference, not of the table"
    fixed_to_polygon = True

    def missing(self, observations: Observations) -> list[str]:
        lacking: list[str] = []
        if observations.reference is None:
            lacking.append("a reference run")
        elif observations.reference.face is None:
            lacking.append(lacking_key("reference.faces", "stations at the faces"))
        if observations.capture is None:
            lacking.append(lacking_capture("the table's own error hides the faces"))
        return lacking

    def column_names(self, observations: Observations) -> list[str]:
        return [f"face {index}" for index in range(observations.faces or 0)]

    def reference_columns(
        self, rows: ReferenceRows, nonlinear: Nonlinear, context: FitContext
    ) -> Columns | None:
        if rows.face is None or rows.faces is None:
            return None
        columns = np.zeros((rows.face.size, rows.faces))
        columns[np.arange(rows.face.size), rows.face] = 1.0
        # Σ f_i = 0: the constant that all faces share belongs to a₀.
        return columns - 1.0 / rows.faces

    def contradiction(
        self,
        coefficients: NDArray[np.float64],
        covariance: NDArray[np.float64],
        nonlinear: Nonlinear,
        observations: Observations,
    ) -> str | None:
        """Refuse face errors with a pattern, because faces are lapped one by one and their errors
        are independent.

        Patterns are a wave over the faces (Fisher's test of the periodogram, Proc. R. Soc. A 125
        (1929) 54), neighbours that resemble each other, one face or some neighbouring faces as
        outliers among the other faces (Grubbs, Ann. Math. Stat. 21 (1950) 27), or a shape that
        repeats several times a turn (analysis of variance). A motion of the table itself causes
        such patterns, and the polygon on the table shows this motion too.

        A wave of order 1 alone does not refuse the effect, because the gain of the autocollimator
        or an eccentric polygon adds this wave to the faces. The test is then repeated without order
        1, if significant face errors remain.
        """
        values = coefficients - coefficients.mean()
        if values.size < LEAST_FACES or float(values @ values) <= 0.0:
            return None
        why = _pattern(values, observations.head_separation_rad)
        if why is None or _largest_wave(values)[0] != 1:
            return why
        left = _without_first_order(values)
        noise = float(np.trace(covariance)) / values.size
        square, freedom = float(left @ left), values.size - 3
        if square < LEAST_FACES_LEFT * float(values @ values):
            return why
        if chdtrc(freedom, square / max(noise, 1e-300)) > SURE_P:
            return why
        # If the remaining face errors have a pattern too, the wave is a part of this pattern.
        return why if _pattern(left, observations.head_separation_rad, first=2) else None

    def parameters(
        self,
        coefficients: NDArray[np.float64],
        covariance: NDArray[np.float64],
        nonlinear: Nonlinear,
        observations: Observations,
    ) -> dict[str, Parameter]:
        count = coefficients.size
        centre = np.eye(count) - 1.0 / count
        values, spread = centre @ coefficients, centre @ covariance @ centre
        sigma = np.sqrt(np.maximum(np.diag(spread), 0.0))
        found = {
            "rms": Parameter(
                float(np.sqrt(np.mean(values**2))), float(np.sqrt(np.mean(sigma**2))), "arcsec"
            )
        }
        for index, (value, error) in enumerate(zip(values, sigma, strict=True)):
            found[f"face_{index}"] = Parameter(float(value), float(error), "arcsec")
        return found

    def describe_values(self, parameters: Mapping[str, Parameter]) -> str:
        """State the RMS and the largest face errors; name the second cause if order 1 exceeds that
        of independent faces."""
        faces = [(key, item) for key, item in parameters.items() if key != "rms"]
        values = np.array([item.value for _, item in faces])
        if values.size < LEAST_FACES or not float(values @ values):
            return ""
        order, share, p_value = _largest_wave(values)
        sizes = _sizes(parameters.get("rms"), [item for _, item in faces])
        if order != 1 or p_value >= CONTRADICTED_P:
            return sizes
        return (
            f"{sizes} A wave of order 1 has {100.0 * share:.0f} % of the variance of the faces: "
            "the faces contain the error of a second cause, autocollimator_gain or "
            "polygon_eccentricity."
        )


def _sizes(rms: Parameter | None, faces: Sequence[Parameter]) -> str:
    """Return a sentence with the RMS of the faces and the largest errors, with the angles of these
    faces from face 0.

    If the table may have an order of the faces as well, the rows do not determine this order: the
    faces then have no uncertainty, and their sizes do not contain this order.
    """
    known = all(np.isfinite(item.sigma) for item in faces)
    largest = sorted(range(len(faces)), key=lambda face: -abs(faces[face].value))[:LISTED_FACES]
    words = ", ".join(
        f"face {face} ({360.0 * face / len(faces):.4g}° after face 0) {faces[face].value:+.3g}″"
        + (f" (u {faces[face].sigma:.2g}″)" if known else "")
        for face in largest
    )
    whole = ""
    if known and rms is not None:
        whole = f"Fitted size: {with_uncertainty(rms.value, rms.sigma, rms.unit)} RMS. "
    lacks = "" if known else ", without the orders that this set cannot separate from the table's"
    return f"{whole}The largest errors of the {len(faces)} faces: {words}{lacks}."


def _pattern(values: NDArray[np.float64], separation_rad: float, first: int = 1) -> str | None:
    """Describe the pattern of the face errors in words; None if they may be independent.

    ``first``: lowest order that the values have; lower orders have been removed.
    """
    size, level = values.size, CONTRADICTED_P
    order, share, p_value = _largest_wave(values, first)
    if p_value < 0.4 * level:
        return (
            f"a wave of order {order} has {100.0 * share:.0f} % of the variance of the face "
            "errors; the errors of a polygon's faces are independent of each other"
        )
    correlation, p_value = _serial(values, first)
    if p_value < 0.2 * level:
        return (
            f"neighbouring faces resemble each other (correlation {correlation:.2f}), as an error "
            "that changes slowly with the angle does; the errors of a polygon's faces are "
            "independent of each other"
        )
    face, width, p_value = _place(values, separation_rad, first)
    if p_value < 0.2 * level:
        found = values[(face + np.arange(width)) % size].mean()
        faces = f"face {face} deviates"
        if width > 1:
            faces = f"{width} faces from {face} on deviate"
        return (
            f"{faces} from the other faces by {found:.2g}″: an error at one place of the table "
            "looks the same as wrong faces side by side"
        )
    times, p_value = _comes_again(values)
    if p_value < 0.2 * level:
        return (
            f"the faces repeat {times} times a turn, as a cam or a lobed bearing does; the "
            "errors of a polygon's faces are independent of each other"
        )
    return None


def _without_first_order(values: NDArray[np.float64]) -> NDArray[np.float64]:
    wave = np.exp(2j * np.pi * np.arange(values.size) / values.size)
    return np.asarray(values - 2.0 / values.size * np.real(wave * (values @ wave.conj())))


def _largest_wave(values: NDArray[np.float64], first: int = 1) -> tuple[int, float, float]:
    """Return the order from ``first`` on with the most power, its share of the power, and the p
    value of Fisher's test."""
    power = np.abs(np.fft.rfft(values)[first : (values.size + 1) // 2]) ** 2
    share = float(power.max() / power.sum())
    p_value = power.size * (1.0 - share) ** (power.size - 1)
    return first + int(np.argmax(power)), share, float(p_value)


def _serial(values: NDArray[np.float64], first: int) -> tuple[float, float]:
    """Return the correlation of neighbouring faces around the circle, and the probability of a
    correlation at least as large if the errors are independent (von Neumann's ratio on a circle).

    Anderson (Ann. Math. Stat. 13 (1942) 1) gives the distribution from the eigenvalues cos(2πk/n)
    of the orders k. Orders below ``first`` have been removed; their eigenvalues are
    missing.
    """
    size = values.size
    found = float(values @ np.roll(values, 1)) / float(values @ values)
    pairs = np.cos(2.0 * np.pi * np.arange(first, (size + 1) // 2) / size)
    single = size % 2 == 0  # order n/2 of an even number of faces, with the eigenvalue −1
    p_value = 0.0
    for place in np.flatnonzero(pairs > found):
        apart = pairs[place] - np.delete(pairs, place)
        scale = float(np.prod(apart)) * np.sqrt(pairs[place] + 1.0 if single else 1.0)
        p_value += float(pairs[place] - found) ** (pairs.size - (0.5 if single else 1.0)) / scale
    return found, min(max(p_value, 0.0), 1.0)


def _place(
    values: NDArray[np.float64], separation_rad: float, first: int
) -> tuple[int, int, float]:
    """Return first face, number and p value of the neighbouring faces with the largest deviation.

    The share of these faces in the sum of squares has a beta distribution; the p value has a
    Bonferroni correction for all places and widths. Orders with a factor below MAGNIFIED are
    removed first, because they spread a motion of the axis at one place over the whole turn. Orders
    below ``first`` have been removed too.
    """
    size = values.size
    orders = np.arange(1, (size + 1) // 2)
    magnified = np.abs(np.exp(1j * orders * separation_rad) - 1.0) < MAGNIFIED
    weak = orders[magnified | (orders < first)]
    waves = np.exp(2j * np.pi * np.outer(np.arange(size), weak) / size)
    taken = np.column_stack([np.ones(size), waves.real, waves.imag])
    taken /= np.linalg.norm(taken, axis=0)
    freedom = size - taken.shape[1]
    if freedom < LEAST_FACES:
        return 0, 1, 1.0
    left = values - taken @ (taken.T @ values)
    windows = np.concatenate(
        [
            sum((np.roll(np.eye(size), step, axis=1) for step in range(width)), np.zeros(()))
            for width in range(1, WIDEST_PLACE + 1)
        ]
    )
    own = windows - (windows @ taken) @ taken.T
    share = (own @ left) ** 2 / np.sum(own**2, axis=1) / float(left @ left)
    best = int(np.argmax(share))
    p_value = share.size * float(betaincc(0.5, 0.5 * (freedom - 1), float(share[best])))
    return best % size, best // size + 1, p_value


def _comes_again(values: NDArray[np.float64]) -> tuple[int, float]:
    """Return the number of repetitions of the face errors per turn, and its p value.

    For each number of equal parts of a turn, the F distribution compares the variance of the mean
    part with the variance within the parts. The p value has a Bonferroni correction for all
    numbers.
    """
    size = values.size
    found = [(1, 1.0)]
    counts = [count for count in range(2, size // 2 + 1) if size % count == 0]
    for count in counts:
        mean = values.reshape(count, -1).mean(axis=0)
        between = count * float(np.sum((mean - values.mean()) ** 2))
        within = float(np.sum((values.reshape(count, -1) - mean) ** 2))
        freedom = size // count - 1, size - size // count
        ratio = between / freedom[0] / max(within / freedom[1], 1e-300)
        found.append((count, len(counts) * float(fdtrc(*freedom, ratio))))
    return min(found, key=lambda item: item[1])
