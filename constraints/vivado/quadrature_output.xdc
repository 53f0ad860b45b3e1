# SPDX-License-Identifier: Apache-2.0
#
# Constrains quadrature_output for Vivado in every design in which it drives pins: the registers of A, B and Z are
# placed in their pads, so that all three signals have the same delay. Read this file scoped: read_xdc -ref
# quadrature_output.
set_property IOB TRUE [get_cells {a_reg b_reg z_reg}]
