"""Lists the proofs of ``make formal`` and the faults that each must notice, by folder of rtl; see
scripts/formal.py."""

from scripts.formal_proofs.coefficients import (
    AMPLITUDE_SWEEP,
    COEFFICIENT_MEMORY,
    COEFFICIENT_MEMORY_FOLDED,
    TURN_OFFSET_SWEEP,
)
from scripts.formal_proofs.compensation import CORRECTION_RAMP
from scripts.formal_proofs.conditions import STOP_OPERATOR, TABLE_CONDITIONS
from scripts.formal_proofs.core import ARCTRUE_CORE, COMPENSATION_PIPELINE
from scripts.formal_proofs.in_and_out import (
    AXI3_TO_AXI_LITE,
    QUADRATURE_DECODER,
    QUADRATURE_OUTPUT,
    SAMPLER,
)
from scripts.formal_proofs.mean import HEAD_FAILOVER, PREPARED_SETS, TURN_DIFFERENCE
from scripts.formal_proofs.phase import TURN_COUNTER
from scripts.formal_proofs.proof import Break, Proof

PROOFS = (
    QUADRATURE_OUTPUT,
    AXI3_TO_AXI_LITE,
    QUADRATURE_DECODER,
    SAMPLER,
    COEFFICIENT_MEMORY,
    COEFFICIENT_MEMORY_FOLDED,
    ARCTRUE_CORE,
    PREPARED_SETS,
    HEAD_FAILOVER,
    TURN_DIFFERENCE,
    TURN_COUNTER,
    STOP_OPERATOR,
    TABLE_CONDITIONS,
    COMPENSATION_PIPELINE,
    AMPLITUDE_SWEEP,
    TURN_OFFSET_SWEEP,
    CORRECTION_RAMP,
)
"""Proofs in the order of docs/proofs.md."""

__all__ = ["PROOFS", "Break", "Proof"]
