"""Runs the ARM image and its console in QEMU; plain memory replaces the core's register window."""

from __future__ import annotations

import fcntl
import itertools
import json
import re
import socket
import struct
import subprocess
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sim.tests.firmware.library import FIRMWARE, ROOT

from arctrue.gateware.register_access import register_named
from arctrue.generated.registers import MAP_BYTES

BOARD = "pynq_z2"
IMAGE = ROOT / "build" / "firmware" / BOARD / "arctrue.elf"
CORE_BASE = 0x4000_0000
CAPTURE = 0x20000
BOTH_INDICES_SEEN = 0b11
INSTRUCTION_TIME = "shift=3"
"""Option that sets the time of an instruction, 2³ ns; the clock continues while the processor
sleeps."""
PATIENCE_S = 60.0
"""Longest wait in real seconds, after which the test fails; even a busy machine needs much less."""


def build(board: str = BOARD) -> Path:
    """Build the image; if this fails, raise AssertionError with the output of make (of the
    compiler, or of the check of the image's size)."""
    folder = ROOT / "build" / "firmware"
    folder.mkdir(parents=True, exist_ok=True)
    # Two workers of pytest must not build the same image at the same time.
    with (folder / ".lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        command = ["make", "-C", str(FIRMWARE), f"BOARD={board}"]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, f"make firmware:\n{done.stdout}{done.stderr}"
    return ROOT / "build" / "firmware" / board / "arctrue.elf"


def core_window(
    counts: NDArray[np.integer] | None, counts_per_rev: int = 1 << 24, depth: int = 12288
) -> bytes:
    """Return the bytes of the register window of a core in which one capture is complete;
    ``counts`` (2, n) are the captured counts of both heads. Without ``counts`` no capture is
    complete."""
    words = np.zeros(MAP_BYTES // 4, dtype=np.uint32)

    def put(path: str, word: int) -> None:
        words[register_named(path).address // 4] = word & 0xFFFF_FFFF

    put("identification", 0x41524354)
    put("version", 0x000100)
    put("core_configuration", 32 | 18 << 8 | depth << 16)
    put("clock_hz", 100_000_000)
    put("counts_per_rev_active", counts_per_rev)
    if counts is not None:
        put("head1.flags", 1)
        put("head2.flags", 1)
        put("status", 1 << 2)
        put("capture_header.sample_count", counts.shape[1])
        put("capture_header.flags", BOTH_INDICES_SEEN)
        put("snapshot.head1_turn_position", int(counts[0, -1]))
        put("snapshot.head1_position", int(counts[0, -1]))
        put("snapshot.head1_angle", int(counts[0, -1]) % counts_per_rev)
        samples = counts.T.astype(np.int64).astype(np.uint32).ravel()
        words[CAPTURE // 4 : CAPTURE // 4 + samples.size] = samples
    return words.tobytes()


def symbol(name: str) -> int:
    """Return the address of a function without the Thumb bit."""
    listing = subprocess.run(
        ["arm-none-eabi-nm", str(IMAGE)], capture_output=True, text=True, check=True
    ).stdout
    (line,) = [entry for entry in listing.splitlines() if entry.split()[-1] == name]
    return int(line.split()[0], 16) & ~1


def member_offset(name: str) -> int:
    """Return the offset of a structure's member, from the debugging information. Only one structure
    may have a member of this name."""
    listing = subprocess.run(
        ["arm-none-eabi-readelf", "--debug-dump=info", str(IMAGE)],
        capture_output=True,
        text=True,
        check=True,
    ).stdout
    members = re.findall(
        r"\(DW_TAG_member\)\n[^\n]*DW_AT_name\s*:[^\n]*[ :](\w+)\n"
        r"(?:[^\n]*DW_AT_(?!name)[^\n]*\n)*?[^\n]*DW_AT_data_member_location: (\d+)",
        listing,
    )
    (offset,) = {int(place) for member, place in members if member == name}
    return offset


def machine_code(address: int, number: int) -> bytes:
    """Return the bytes of the image at an address."""
    with tempfile.NamedTemporaryFile() as file:
        subprocess.run(
            ["arm-none-eabi-objcopy", "-O", "binary", "-j", ".text", str(IMAGE), file.name],
            check=True,
        )
        text = Path(file.name).read_bytes()
    return text[address : address + number]


class Emulator:
    """One run of the emulator; ``said`` is all output of the console so far."""

    def __init__(self, console: socket.socket, folder: Path, process: Any) -> None:
        self.console = console
        self.debugger = folder / "debugger"
        self.bus = folder / "bus"
        self.control = folder / "control"
        self.process = process
        self._bus: Any = None
        self.said = ""

    def wait_for(self, text: str, seconds: float = PATIENCE_S, start: int = 0) -> str:
        """Return the output from the position ``start`` on, once this output contains ``text``."""
        end = time.monotonic() + seconds
        while text not in self.said[start:]:
            self._hear_more(end, text, start)
        return self.said[start:]

    def _hear_more(self, end: float, awaited: str, start: int) -> None:
        """Receive the characters that have arrived, or wait for more; raise TimeoutError if none
        comes before ``end``."""
        self.console.settimeout(max(end - time.monotonic(), 1e-3))
        try:
            data = self.console.recv(4096)
        except TimeoutError:
            heard = self.said[start:]
            raise TimeoutError(f"waited for {awaited!r}, heard {heard!r}") from None
        assert data, f"the emulator ended; heard {self.said[start:]!r}"
        self.said += data.decode("ascii")

    def next_line(self, beginning: str, seconds: float = PATIENCE_S) -> str:
        """Return the first complete line that begins with ``beginning``, among the lines that begin
        after this call."""
        end = time.monotonic() + seconds
        start = self.said.rfind("\n") + 1
        skipped = 1 if start < len(self.said) else 0
        while True:
            for line in self.said[start:].split("\r\n")[skipped:-1]:
                if line.startswith(beginning):
                    return line
            self._hear_more(end, f"a line with {beginning!r}", start)

    def send(self, line: str, seconds: float = PATIENCE_S) -> str:
        """Send a command and return its answer up to the line with ok or error.

        Telemetry may follow at once; it is not part of the answer.
        """
        end = time.monotonic() + seconds
        start = len(self.said)
        self.console.sendall(line.encode() + b"\r")
        while True:
            # The first line may be the end of an earlier line that was received in part.
            whole = self.said[start:].removeprefix("\n").split("\r\n")[:-1]
            for number, text in enumerate(whole, start=1):
                if text.startswith(("ok", "error")):
                    return "".join(f"{item}\r\n" for item in whole[:number])
            self._hear_more(end, f"the answer to {line}", start)

    def ask(self, line: str, expected: str, seconds: float = PATIENCE_S) -> str:
        """Repeat the command until the answer contains ``expected``, because characters are lost
        while the firmware restarts."""
        end = time.monotonic() + seconds
        late = False
        while time.monotonic() < end:
            try:
                answer = self.send(line, 1.0)
            except TimeoutError:
                late = True
                continue
            if late:
                # The received text may be the end of an answer to an earlier line.
                self.hear_late_answers()
                answer = self.send(line)
                late = False
            if expected in answer:
                return answer
        raise AssertionError(f"{line}: never heard {expected!r} but {self.said[-3000:]!r}")

    def hear_late_answers(self) -> None:
        """Receive late answers to earlier lines: send an unknown command and wait for its answer,
        which comes after them."""
        end = time.monotonic() + PATIENCE_S
        for number in itertools.count():
            start = len(self.said)
            self.console.sendall(f"marker{number}\r".encode())
            try:
                self.wait_for(f"try help: marker{number}\r\n", 5.0, start)
                return
            except TimeoutError:
                if time.monotonic() > end:
                    raise

    @contextmanager
    def debugging(self) -> Iterator[Callable[[str, bytes], bytes]]:
        """Yield a function that sends a command to the debugger's port while the processor is
        stopped.

        The function takes the command and the expected answer, and returns all output up to that
        answer.
        """
        with socket.socket(socket.AF_UNIX) as port:
            port.connect(str(self.debugger))
            port.settimeout(PATIENCE_S)

            def order(text: str, awaited: bytes) -> bytes:
                port.sendall(f"${text}#{sum(text.encode()) % 256:02x}".encode())
                answer = b""
                # The debugger may first report that the processor has stopped.
                while awaited not in answer:
                    answer += port.recv(4096)
                    assert b"$E" not in answer, answer
                port.sendall(b"+")
                return answer

            yield order
            order("D", b"$OK#")

    def write_memory(self, address: int, data: bytes) -> None:
        with self.debugging() as order:
            order(f"M{seen_at(address):x},{len(data):x}:{data.hex()}", b"$OK#")

    def read_own_register(self, address: int) -> int:
        """Return a register as the processor reads it in the processor's secure state; a bus access
        is not secure."""
        with self.debugging() as order:
            answer = b""
            while (found := re.search(rb"\$([0-9a-f]{8})#..", answer)) is None:
                answer = order(f"m{seen_at(address):x},4", b"#")
        return int.from_bytes(bytes.fromhex(found[1].decode()), "little")

    def write_own_register(self, address: int, value: int) -> None:
        """Write a register through the processor, and not by a bus access."""
        self.write_memory(address, word(value))

    @contextmanager
    def stopped_at(self, address: int) -> Iterator[Callable[[int, int], None]]:
        """Stop the processor when it next reaches this Thumb instruction; let the processor
        continue when the block ends.

        Within the block the yielded function writes words through the processor.
        """
        breakpoint_there = f"0,{address:x},2"
        with self.debugging() as order:
            order(f"Z{breakpoint_there}", b"$OK#")
            order("c", b"$T05")

            def write(place: int, value: int) -> None:
                order(f"M{seen_at(place):x},4:{word(value).hex()}", b"$OK#")

            yield write
            order(f"z{breakpoint_there}", b"$OK#")

    def fault_once(self, place: int, bad: bytes, handler: int) -> None:
        """Write bad code to ``place``, wait until the fault of this code reaches ``handler``, and
        restore the code."""
        good = machine_code(place, len(bad))
        with self.debugging() as order:
            order(f"Z0,{handler:x},2", b"$OK#")
            order(f"M{place:x},{len(bad):x}:{bad.hex()}", b"$OK#")
            order("c", b"$T05")
            order(f"M{place:x},{len(good):x}:{good.hex()}", b"$OK#")
            order(f"z0,{handler:x},2", b"$OK#")

    def on_the_bus(self, *commands: str) -> list[str]:
        """Access the bus with qtest's protocol, without the processor; return the answers without
        their OK."""
        if self._bus is None:
            port = socket.socket(socket.AF_UNIX)
            port.connect(str(self.bus))
            port.settimeout(PATIENCE_S)
            self._bus = port.makefile("rw", encoding="ascii")
            port.close()
        answers = []
        for text in commands:
            self._bus.write(f"{text}\n")
            self._bus.flush()
            answer = self._bus.readline().split()
            assert answer[:1] == ["OK"], f"{text}: {answer}"
            answers.append(" ".join(answer[1:]))
        return answers

    def read_register(self, address: int) -> int:
        (answer,) = self.on_the_bus(f"readl {address:#x}")
        return int(answer, 16)

    def write_register(self, address: int, value: int) -> None:
        self.on_the_bus(f"writel {address:#x} {value:#x}")

    def machine_command(self, name: str, **arguments: Any) -> Any:
        """Send one command of QEMU's machine protocol and return the result of the command."""
        with socket.socket(socket.AF_UNIX) as port:
            port.connect(str(self.control))
            port.settimeout(PATIENCE_S)
            lines = port.makefile("rw", encoding="utf-8")
            lines.readline()
            for asked in (
                {"execute": "qmp_capabilities"},
                {"execute": name, "arguments": arguments},
            ):
                lines.write(json.dumps(asked) + "\n")
                lines.flush()
                answer = json.loads(lines.readline())
                while "event" in answer:
                    answer = json.loads(lines.readline())
                assert "return" in answer, answer
            return answer["return"]


@contextmanager
def running(
    folder: Path, window: bytes, *options: str, image: Path = IMAGE, real_time: bool = False
) -> Iterator[Emulator]:
    """Start the image, and stop it when the block ends.

    Time advances with the executed instructions, unless ``real_time`` or ``-icount`` among the
    options changes this. In real time a busy machine could calibrate so slowly that the firmware
    would report a hang.
    """
    (folder / "core.bin").write_bytes(window)
    console, debugger = folder / "console", folder / "debugger"
    command = ["qemu-system-arm", "-M", "xilinx-zynq-a9", "-m", "2G", "-nographic"]
    command += ["-kernel", str(image), "-monitor", "none"]
    command += ["-device", f"loader,file={folder}/core.bin,addr={CORE_BASE:#x},force-raw=on"]
    command += ["-serial", f"unix:{console},server=on,wait=on"]
    command += ["-gdb", f"unix:{debugger},server=on,wait=off"]
    command += ["-accel", "tcg", "-qtest", f"unix:{folder}/bus,server=on,wait=off"]
    if not real_time and "-icount" not in options:
        command += ["-icount", INSTRUCTION_TIME]
    command += ["-qmp", f"unix:{folder}/control,server=on,wait=off", *options]
    with (folder / "qemu.log").open("wb") as log:
        process = subprocess.Popen(command, stdout=log, stderr=log, stdin=subprocess.DEVNULL)
    try:
        with socket.socket(socket.AF_UNIX) as port:
            _connect(port, console, process, folder / "qemu.log")
            yield Emulator(port, folder, process)
    finally:
        process.kill()
        process.wait()


def _connect(port: socket.socket, path: Path, process: Any, log: Path) -> None:
    end = time.monotonic() + PATIENCE_S
    while True:
        try:
            port.connect(str(path))
            return
        except OSError:
            assert process.poll() is None, log.read_text("utf-8", "replace")
            assert time.monotonic() < end, f"no console at {path}"
            time.sleep(0.05)


def seen_at(address: int) -> int:
    """Return the address at which the firmware, and therefore a debugger, reaches a device.

    The MMU of the firmware maps the devices into the first 256 MB (memory_mapped.h).
    """
    return (address ^ (address >> 4 & 0x0F00_0000)) & 0x0FFF_FFFF


def word(value: int) -> bytes:
    """Return the word as bytes in little-endian order."""
    return struct.pack("<I", value)
