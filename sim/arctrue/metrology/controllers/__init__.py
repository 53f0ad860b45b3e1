"""Writes correction tables for other controllers of rotary axes, and models the controllers'
interpolation between rows.

Each format follows the controller's public sources, which docs/reports.md names. A model of the
controller's interpolation reads each table back.
"""

from collections.abc import Mapping

from arctrue.metrology.controllers.aerotech import Aerotech
from arctrue.metrology.controllers.bidirectional_csv import Bidirectional
from arctrue.metrology.controllers.ecmc import Ecmc
from arctrue.metrology.controllers.linuxcnc import LinuxCnc
from arctrue.metrology.controllers.moteus import Moteus32, Moteus256
from arctrue.metrology.controllers.onstep import OnStep
from arctrue.metrology.controllers.siemens import Siemens
from arctrue.metrology.controllers.simplefoc import SimpleFoc
from arctrue.metrology.controllers.table_format import Left, TableFormat
from arctrue.metrology.controllers.twincat import TwinCat

__all__ = ["FORMATS", "Left", "TableFormat"]

FORMATS: Mapping[str, TableFormat] = {
    one.name: one
    for one in (
        Bidirectional(),
        LinuxCnc(),
        TwinCat(),
        Siemens(),
        Aerotech(),
        Ecmc(),
        Moteus32(),
        Moteus256(),
        SimpleFoc(),
        OnStep(),
    )
}
