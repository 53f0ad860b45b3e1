"""Physical causes of a wrong reading, one file a cause."""

from arctrue.table.causes.base import PhysicalEffect
from arctrue.table.causes.disc_eccentricity import DiscEccentricity
from arctrue.table.causes.graduation_harmonics import GraduationHarmonics

__all__ = ["DiscEccentricity", "GraduationHarmonics", "PhysicalEffect"]
