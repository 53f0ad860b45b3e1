# SPDX-License-Identifier: Apache-2.0
#
# Runs Vivado without a project: synthesis, placement, routing, timing, bitstream.
# scripts/bitstream_vivado.py calls it:
#
#   vivado -mode batch -source bitstream_vivado.tcl -tclargs -top ENTITY -part PART -output FOLDER
#       [-generic NAME=VALUE]... [-scoped ENTITY.xdc]... -xdc FILE... -vhdl FILE...
#
# Vivado reads a scoped file, ENTITY.xdc, for every instance of this entity, before all other files.
# The script writes FOLDER/arctrue.bit only if all requirements for setup, hold and pulse width are met. It writes
# reports to FOLDER/reports in either case.

set top ""
set part ""
set output ""
set generics {}
set constraints {}
set scoped {}
set sources {}
foreach {option value} $argv {
    switch -- $option {
        -top { set top $value }
        -part { set part $value }
        -output { set output $value }
        -generic { lappend generics -generic $value }
        -scoped { lappend scoped $value }
        -xdc { lappend constraints $value }
        -vhdl { lappend sources $value }
        default { error "bitstream_vivado.tcl: unknown option $option" }
    }
}
set reports [file join $output reports]

foreach source $sources {
    read_vhdl -vhdl2008 $source
}
foreach constraint $scoped {
    read_xdc -ref [file rootname [file tail $constraint]] $constraint
}
foreach constraint $constraints {
    read_xdc $constraint
}

synth_design -top $top -part $part {*}$generics -flatten_hierarchy rebuilt
# If Vivado does not find the entity of a scoped file, it only prints a warning and continues without the constraints.
foreach constraint $scoped {
    set entity [file rootname [file tail $constraint]]
    set named "REF_NAME =~ $entity* || ORIG_REF_NAME =~ $entity*"
    if {[llength [get_cells -quiet -hierarchical -filter $named]] == 0} {
        error "expected an instance of $entity after synthesis, found none: $constraint has no effect."
    }
}
report_utilization -hierarchical -file [file join $reports utilization_synthesis.rpt]
opt_design
place_design
phys_opt_design
route_design

report_timing_summary -max_paths 20 -file [file join $reports timing.rpt]
report_utilization -hierarchical -file [file join $reports utilization.rpt]
report_cdc -details -file [file join $reports cdc.rpt]
report_drc -file [file join $reports drc.rpt]
report_methodology -file [file join $reports methodology.rpt]
report_route_status -file [file join $reports route_status.rpt]
report_power -file [file join $reports power.rpt]
write_checkpoint -force [file join $output routed.dcp]

proc not_met {why} {
    puts "ARCTRUE TIMING NOT MET: $why"
    exit 1
}

# A path without a clock has no slack. Therefore check that a clock exists and that it times paths.
if {[llength [get_clocks]] == 0} {
    not_met "no clock reached the design, so nothing was timed."
}
foreach {kind option} {setup -setup hold -hold} {
    set path [lindex [get_timing_paths $option -max_paths 1 -nworst 1] 0]
    set worst($kind) [expr {$path eq "" ? "" : [get_property SLACK $path]}]
    if {![string is double -strict $worst($kind)]} {
        not_met "no path was timed for $kind."
    }
    if {$worst($kind) < 0} {
        set from [get_property STARTPOINT_PIN $path]
        set to [get_property ENDPOINT_PIN $path]
        not_met "the worst $kind slack is $worst($kind) ns, from $from to $to."
    }
}
# The verdict of the summary covers all kinds of requirements, also pulse widths.
set summary [open [file join $reports timing.rpt]]
if {![string match "*All user specified timing constraints are met*" [read $summary]]} {
    not_met "the summary does not say that all user specified timing constraints are met."
}
close $summary

write_bitstream -force [file join $output arctrue.bit]
puts "ARCTRUE TIMING MET: worst setup slack $worst(setup) ns, worst hold slack $worst(hold) ns."
