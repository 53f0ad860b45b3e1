# Defines fake commands in place of the commands of Vivado that scripts/bitstream_vivado.tcl calls. Each command notes
# its words in FAKE_COMMANDS and has only the effects that the script can see.
# Usage: tclsh vivado_prelude.tcl SCRIPT WORDS...

set argv [lassign $argv script]
set noted [open $::env(FAKE_COMMANDS) w]

proc note {args} {
    puts $::noted [join $args " "]
    flush $::noted
}

proc setting {name value} {
    return [expr {[info exists ::env($name)] ? $::env($name) : $value}]
}

proc read_vhdl {kind file} {
    if {![file exists $file]} { error "no such file $file" }
    note read_vhdl $kind [file rootname [file tail $file]]
}

foreach name {all_inputs all_outputs all_registers get_ports get_pins get_cells create_clock create_generated_clock set_false_path set_max_delay set_input_delay
              set_input_jitter} {
    proc $name args "note $name {*}\$args; return $name"
}
proc set_property args { note set_property {*}$args }

proc read_xdc args {
    set file [lindex $args end]
    note read_xdc {*}[lrange $args 0 end-1] [file tail $file]
    uplevel #0 [list source $file]
}

foreach name {opt_design place_design phys_opt_design route_design} {
    proc $name {} "note $name"
}
proc synth_design args {
    note synth_design {*}$args
    if {[setting FAKE_FAILURE ""] eq "synth"} { error "ERROR: \[Synth 8-27\] fake failure" }
}

foreach name {report_utilization report_cdc report_drc report_methodology
              report_route_status report_power} {
    proc $name args "
        note $name {*}\$args
        close \[open \[lindex \$args \[expr {\[lsearch \$args -file\] + 1}\]\] w\]
    "
}
proc report_timing_summary args {
    set file [open [lindex $args [expr {[lsearch $args -file] + 1}]] w]
    puts $file [setting FAKE_SUMMARY "All user specified timing constraints are met."]
    close $file
}
proc write_checkpoint args { close [open [lindex $args end] w] }

proc get_clocks args { return [setting FAKE_CLOCKS fabric_clock] }
proc get_timing_paths {option args} {
    return [setting FAKE_PATHS [list [string range $option 1 end]]]
}
proc get_property {property path} {
    if {$property eq "SLACK"} {
        return [setting FAKE_SLACK_[string toupper $path] 0.125]
    }
    return "core/${path}_$property"
}

proc write_bitstream args {
    note write_bitstream {*}$args
    set file [open [lindex $args end] wb]
    puts -nonewline $file [string repeat \0 100]
    puts -nonewline $file [binary format H* aa9955662000000030018001[setting FAKE_IDCODE 23727093]]
    puts -nonewline $file [binary format H* 30004000500f6c78]
    puts -nonewline $file [string repeat \0 4043232]
    close $file
}

# If FAKE_NETLIST names a netlist, constraints find their objects in this netlist.
if {[info exists ::env(FAKE_NETLIST)]} { source [file join [file dirname [info script]] vivado_netlist.tcl] }

source $script
