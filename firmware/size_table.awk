# From `size` of the ELF: the table with its limits; fails beyond one of them.
NR == 2 {
    row("text + rodata", $1, code)
    row("data + bss + stacks", $2 + $3, data)
}
function row(name, used, limit) {
    printf "%-20s %7d of %7d bytes\n", name, used, limit
    failed = failed || used > limit
}
END { if (failed) { print "the firmware is too large"; exit 1 } }
