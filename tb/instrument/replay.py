"""Compiles a netlist to a program that reads inputs from a file and writes outputs to a file.

One C++ text serves every entity; this module inserts the entity's ports, which it reads from the
header that Verilator writes. The files contain words of 32 bits, clock by clock: low word first,
port after port in the header's order.
"""

from __future__ import annotations

import re
import subprocess
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from arctrue.base.netlist import sources_of, write_netlist
from arctrue.instrument.build import (
    CXX_DEFINES,
    ROOT,
    VERILATOR_FLAGS,
    building,
    digest,
    run_tool,
    runtime,
    tool_versions,
    verilate,
    verilator_include,
)
from tb.support.flat_ports import flat_name

BUILT = ROOT / "build" / "instrument" / "equal"
# The compiler does not optimise, because the compilation takes most of the time: the model runs for
# only some thousand clocks.
OPTIMISE = "-O0"
MOST_SECONDS = 600
PORT = re.compile(r"VL_(IN|OUT)(?:8|16|64|W)?\(&?(\w+),(\d+),0(?:,\d+)?\);")
# GHDL's netlist has a port for each element of a record port, named after the record port and the
# element.
RECORD_PORT = re.compile(r"(\w+_axil_request|\w+_axil_response|decoded)_(\w+)")

PROGRAM = """
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <vector>
#include "V{entity}.h"

double sc_time_stamp() {{ return 0; }}

struct Port {{ void *value; size_t bytes, words; }};

int main(int, char **arguments) {{
    VerilatedContext context;
    context.randSeed(std::atoi(arguments[3]));
    V{entity} model(&context);
    const std::vector<Port> inputs = {{ {inputs} }};
    const std::vector<Port> outputs = {{ {outputs} }};
    size_t words_in = 0, words_out = 0;
    for (const Port &port : inputs) words_in += port.words;
    for (const Port &port : outputs) words_out += port.words;
    std::vector<uint32_t> in(words_in), out(words_out);
    FILE *given = std::fopen(arguments[1], "rb"), *result = std::fopen(arguments[2], "wb");
    if (!given || !result) return 1;
    model.clock = 0;
    model.eval();
    while (std::fread(in.data(), 4, words_in, given) == words_in) {{
        const uint32_t *word = in.data();
        for (const Port &port : inputs) {{
            std::memcpy(port.value, word, port.bytes);
            word += port.words;
        }}
        model.clock = 0;
        model.eval();
        model.clock = 1;
        model.eval();
        uint32_t *place = out.data();
        std::memset(place, 0, 4 * words_out);
        for (const Port &port : outputs) {{
            std::memcpy(place, port.value, port.bytes);
            place += port.words;
        }}
        std::fwrite(out.data(), 4, words_out, result);
    }}
    std::fclose(result);
    return 0;
}}
"""


@dataclass(frozen=True)
class Port:
    """Port of the compiled entity; ``name`` is its name in the benches, ``member`` in Verilator's
    model."""

    name: str
    member: str
    width: int
    is_input: bool

    @property
    def words(self) -> int:
        return -(-self.width // 32)


def ports_of(header: Path) -> list[Port]:
    def in_the_bench(name: str) -> str:
        element = RECORD_PORT.fullmatch(name)
        return flat_name(*element.groups()) if element else name

    found = [
        Port(in_the_bench(name.removeprefix("__SYM__")), name, int(high) + 1, kind == "IN")
        for kind, name, high in PORT.findall(header.read_text(encoding="utf-8"))
    ]
    return [port for port in found if port.name != "clock"]


@dataclass(frozen=True)
class Replay:
    """Compiled entity, whose program replays recorded inputs."""

    program: Path
    ports: tuple[Port, ...]

    def outputs(
        self, inputs: Mapping[str, list[int]], folder: Path, seed: int = 1
    ) -> dict[str, list[int]]:
        """Return the outputs after each clock; ``inputs`` has, for each input, a value per clock.

        All values are unsigned. ``seed``, above 0, is the seed for random initial values of
        registers, if the netlist has them.
        """
        wanted = [port for port in self.ports if port.is_input]
        unlike = {port.name for port in wanted} ^ set(inputs)
        assert not unlike, f"inputs that only the netlist or only the stimulus has: {unlike}"
        given, output_file = folder / "inputs.bin", folder / "outputs.bin"
        np.hstack([_as_words(inputs[port.name], port.words) for port in wanted]).tofile(given)
        subprocess.run(
            [self.program, given, output_file, str(seed)], check=True, timeout=MOST_SECONDS
        )
        outputs = [port for port in self.ports if not port.is_input]
        rows = np.fromfile(output_file, dtype="<u4").reshape(
            -1, sum(port.words for port in outputs)
        )
        ends = np.cumsum([port.words for port in outputs])
        return {
            port.name: _as_numbers(rows[:, end - port.words : end])
            for port, end in zip(outputs, ends, strict=True)
        }


def _as_words(values: list[int], words: int) -> NDArray[np.uint32]:
    data = b"".join(value.to_bytes(4 * words, "little") for value in values)
    return np.frombuffer(data, dtype="<u4").reshape(-1, words)


def _as_numbers(words: NDArray[np.uint32]) -> list[int]:
    data = np.ascontiguousarray(words).tobytes()
    size = 4 * words.shape[1]
    return [int.from_bytes(data[at : at + size], "little") for at in range(0, len(data), size)]


def compiled(
    entity: str,
    generics: Mapping[str, int | str],
    change: Callable[[str], str] | None = None,
) -> Replay:
    """Return ``entity`` as a compiled netlist; ``change`` may modify the netlist's text before it
    is compiled."""
    texts = [f"{name}={value}" for name, value in generics.items()]
    texts += [*tool_versions().values(), *VERILATOR_FLAGS, OPTIMISE, PROGRAM]
    texts += [change(f"of {entity}") if change else ""]
    key = digest(texts, sources_of(entity))
    target = BUILT / f"{entity}-{key}"
    log = target.with_suffix(".log")
    with building(target, log) as folder:
        if folder is not None:
            netlist = write_netlist(entity, folder / "netlist", generics=generics)
            if change:
                netlist.write_text(change(netlist.read_text(encoding="utf-8")), encoding="utf-8")
            # The replay compares no initial values of wide memories.
            verilate(netlist, folder / "verilated", log)
            _compile(entity, folder, log)
    header = target / "verilated" / f"V{entity}.h"
    return Replay(target / "replay", tuple(ports_of(header)))


def _compile(entity: str, folder: Path, log: Path) -> None:
    def rows(ports: list[Port]) -> str:
        return ", ".join(
            f"{{&model.{port.member}, sizeof model.{port.member}, {port.words}}}" for port in ports
        )

    verilated = folder / "verilated"
    ports = ports_of(verilated / f"V{entity}.h")
    main = folder / "main.cpp"
    main.write_text(
        PROGRAM.format(
            entity=entity,
            inputs=rows([port for port in ports if port.is_input]),
            outputs=rows([port for port in ports if not port.is_input]),
        ),
        encoding="utf-8",
    )
    # Compile all files as one, because the headers take longer to compile than the files
    # themselves.
    everything = folder / "everything.cpp"
    parts = [*sorted(verilated.glob("*.cpp")), main]
    everything.write_text("".join(f'#include "{part}"\n' for part in parts), encoding="utf-8")
    include = verilator_include()
    command = [
        *("g++", "-std=gnu++17", OPTIMISE, "-w", *CXX_DEFINES),
        *(f"-I{path}" for path in (verilated, include, include / "vltstd")),
        *(str(everything), *map(str, runtime()), "-o", str(folder / "replay")),
        *("-lpthread", "-latomic"),
    ]
    run_tool(command, log, f"Compiling {entity}")
