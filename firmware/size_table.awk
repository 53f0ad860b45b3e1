# Prints the sizes in the output of `size -A`, each with its limit; fails if a size exceeds its limit.
$1 ~ /^\.(text|ARM\.exidx|pages|data)$/ { used_code += $2 }
$1 == ".texts" { used_texts += $2 }
$1 ~ /^\.(data|bss|stack)$/ { used_data += $2 }
$1 == ".upper" { used_upper += $2 }
END {
    row("code and constants", used_code, code)
    row("texts", used_texts, texts)
    row("data and stacks", used_data, data)
    row("upper 64 KB", used_upper, upper)
    if (failed) { print "the firmware is too large"; exit 1 }
}
function row(name, used, limit) {
    printf "%-20s %7d of %7d bytes\n", name, used, limit
    failed = failed || used > limit
}
