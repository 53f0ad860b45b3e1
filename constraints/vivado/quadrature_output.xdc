# SPDX-License-Identifier: Apache-2.0
#
# Vivado's constraints for quadrature_output in any design whose pins it drives: A, B and Z leave from registers in
# their pads, so that all three have the same delay. Scoped: read_xdc -ref quadrature_output.
set_property IOB TRUE [get_cells {a_reg b_reg z_reg}]
