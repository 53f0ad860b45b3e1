"""Physical causes of a wrong reading, one file a cause."""

from arctrue.table.effects.base import PhysicalEffect
from arctrue.table.effects.disc_eccentricity import DiscEccentricity
from arctrue.table.effects.graduation_harmonics import GraduationHarmonics
from arctrue.table.effects.graduation_lines import GraduationLines

__all__ = ["DiscEccentricity", "GraduationHarmonics", "GraduationLines", "PhysicalEffect"]
