# Models how Vivado finds the objects of a constraint in a netlist, after UG903, "XDC Scoping Mechanism" and "Scoped
# Queries Guidelines". In a file that is read with -ref, names of cells and pins are relative to each instance of the
# module, but NAME in a filter is the whole path. all_registers finds registers inside the instance, get_clocks finds
# all clocks, and all_inputs and all_outputs cannot be used. If a query finds nothing, Vivado only prints a warning, and
# the constraint has no effect; this model notes "nothing". vivado_prelude.tcl sources this file and provides `note`.

set scope ""
set ports {}
set reference [dict create]
set pins [dict create]
set clocks {}

proc read_netlist {file} {
    set lines [open $file]
    while {[gets $lines line] >= 0} {
        switch -- [string range $line 0 3] {
            port { lappend ::ports [string range $line 5 end] }
            cell {
                set words [split [string trimright $line] " "]
                dict set ::reference [lindex $words 1] [lindex $words 2]
                dict set ::pins [lindex $words 1] [lrange $words 3 end]
            }
        }
    }
    close $lines
}

# Matches a name with a pattern in which brackets enclose the number of a bit, not a set of characters.
proc matches {pattern name} {
    return [string match [string map {\[ \\\[ \] \\\]} $pattern] $name]
}

proc passes {filter values} {
    if {$filter eq ""} { return 1 }
    foreach condition [split [string map {|| \n} $filter] \n] {
        lassign $condition property operator wanted
        set found [expr {[dict exists $values $property] ? [dict get $values $property] : ""}]
        if {$operator eq "=~" ? [matches $wanted $found] : $wanted eq $found} { return 1 }
    }
    return 0
}

# Returns the words of a query as a dictionary, with the query's options and "names".
proc words_of {words switches} {
    set given [dict create -hierarchical 0 -quiet 0 -filter "" -of_objects "" -clock "" names {}]
    while {[llength $words]} {
        set words [lassign $words word]
        if {$word in $switches} {
            dict set given $word 1
        } elseif {[string match -* $word]} {
            set words [lassign $words value]
            dict set given $word $value
        } else {
            dict lappend given names {*}$word
        }
    }
    return $given
}

proc inside {name} {
    return [string range $name [string length $::scope] end]
}

proc in_scope {} {
    return [lmap name [dict keys $::reference] {
        if {![string equal -length [string length $::scope] $::scope $name]} continue
        set name
    }]
}

proc get_cells args {
    set given [words_of $args {-hierarchical -quiet}]
    set found {}
    foreach cell [in_scope] {
        set name [inside $cell]
        if {[dict get $given -hierarchical]} {
            set name [lindex [split $name /] end]
        }
        set names [dict get $given names]
        set named [expr {$names eq "" && [dict get $given -hierarchical]}]
        foreach pattern $names {
            if {[matches $pattern $name] && [llength [split $pattern /]] == [llength [split $name /]]} { set named 1 }
        }
        set values [dict create NAME $cell REF_NAME [dict get $::reference $cell]]
        if {$named && [passes [dict get $given -filter] $values]} { lappend found $cell }
    }
    return $found
}

proc get_pins args {
    set given [words_of $args {-hierarchical -quiet}]
    set found {}
    set cells [expr {[dict get $given -of_objects] eq "" ? [in_scope] : [dict get $given -of_objects]}]
    foreach cell $cells {
        foreach pin [dict get $::pins $cell] {
            set values [dict create NAME $cell/$pin REF_PIN_NAME $pin]
            set named [expr {[dict get $given names] eq ""}]
            foreach pattern [dict get $given names] {
                if {[matches $pattern [inside $cell/$pin]]} { set named 1 }
            }
            if {$named && [passes [dict get $given -filter] $values]} { lappend found $cell/$pin }
        }
    }
    return $found
}

proc outside_only {command} {
    if {$::scope ne ""} { error "$command cannot be used in a scoped file" }
}

proc get_ports args {
    outside_only get_ports
    set found {}
    foreach pattern [concat {*}$args] {
        foreach port $::ports { if {[matches $pattern $port]} { lappend found $port } }
    }
    return $found
}
proc all_inputs {} { outside_only all_inputs; return $::ports }
proc all_outputs {} { outside_only all_outputs; return $::ports }

proc all_registers args {
    return [lmap cell [in_scope] { if {[dict get $::reference $cell] ne "FDRE"} continue; set cell }]
}

proc get_clocks args {
    return [lmap clock $::clocks { if {$args ne "" && $clock ni $args} continue; set clock }]
}

foreach name {create_clock create_generated_clock set_false_path set_max_delay set_input_delay set_input_jitter} {
    proc $name args "constrain $name \$args"
}

proc constrain {name words} {
    foreach word $words {
        if {$word eq ""} { note nothing $name {*}[string map {\{\} NOTHING} $words] }
    }
    if {[string match create_* $name]} {
        lappend ::clocks [lindex $words [expr {[lsearch $words -name] + 1}]]
    }
    note constraint $name {*}[lmap word $words { join $word , }]
}

proc set_property {property value objects} {
    if {$objects eq ""} { note nothing set_property $property }
    foreach object $objects { note property $property $value $object }
}

proc read_xdc args {
    set file [lindex $args end]
    if {[lindex $args 0] ne "-ref"} {
        uplevel #0 [list source $file]
        return
    }
    set instances 0
    dict for {cell module} $::reference {
        if {$module eq [lindex $args 1]} {
            incr instances
            set ::scope $cell/
            uplevel #0 [list source $file]
            set ::scope ""
        }
    }
    if {!$instances} { note nothing read_xdc -ref [lindex $args 1] }
}

read_netlist $::env(FAKE_NETLIST)
