# SPDX-License-Identifier: Apache-2.0
#
# What quadrature_output needs of Vivado in any design whose pins it drives: A, B and Z leave from registers in
# their pads, all alike. Scoped: read_xdc -ref quadrature_output.
set_property IOB TRUE [get_cells {a_reg b_reg z_reg}]
