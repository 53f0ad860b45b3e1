"""Simulates an adapter with a Zynq's scan chain, for OpenOCD's remote_bitbang.

The simulation follows IEEE 1149.1 (state machine, two instruction registers, identification and
bypass) and has the two instructions of the fabric that a configuration needs (UG470): JPROGRAM and
CFG_IN. No code comes from OpenOCD.
"""

from __future__ import annotations

import socket
import threading
from dataclasses import dataclass, field

# Each state has its next state for TMS = 0 and its next state for TMS = 1 (IEEE 1149.1, figure
# 6-1).
NEXT = {
    "reset": ("idle", "reset"),
    "idle": ("idle", "select_dr"),
    "select_dr": ("capture_dr", "select_ir"),
    "capture_dr": ("shift_dr", "exit1_dr"),
    "shift_dr": ("shift_dr", "exit1_dr"),
    "exit1_dr": ("pause_dr", "update_dr"),
    "pause_dr": ("pause_dr", "exit2_dr"),
    "exit2_dr": ("shift_dr", "update_dr"),
    "update_dr": ("idle", "select_dr"),
    "select_ir": ("capture_ir", "reset"),
    "capture_ir": ("shift_ir", "exit1_ir"),
    "shift_ir": ("shift_ir", "exit1_ir"),
    "exit1_ir": ("pause_ir", "update_ir"),
    "pause_ir": ("pause_ir", "exit2_ir"),
    "exit2_ir": ("shift_ir", "update_ir"),
    "update_ir": ("idle", "select_dr"),
}
CFG_IN, JPROGRAM, FABRIC_IDCODE = 0x05, 0x0B, 0x09


@dataclass
class Tap:
    """Test access port (TAP); ``shift`` holds the bits of the register, instruction or data, that
    is being shifted."""

    instruction_bits: int
    idcode: int
    idcode_instruction: int
    data_registers: dict[int, list[int]] = field(default_factory=dict)
    instructions: list[int] = field(default_factory=list)
    instruction: int = 0
    shift: list[int] = field(default_factory=list)

    def reset(self) -> None:
        self.instruction = self.idcode_instruction

    def capture(self, instruction: bool) -> None:
        if instruction:
            self.shift = [1] + [0] * (self.instruction_bits - 1)
        elif self.instruction == self.idcode_instruction:
            self.shift = [self.idcode >> bit & 1 for bit in range(32)]
        else:
            self.shift = [0]

    def step(self, tdi: int) -> int:
        self.shift.append(tdi)
        return self.shift.pop(0)

    def update_instruction(self) -> None:
        self.instruction = sum(bit << place for place, bit in enumerate(self.shift))
        self.instructions.append(self.instruction)


class Chain:
    """Scan chain: the processor's test access port, then the fabric's port, whose output is TDO."""

    def __init__(self, fabric_idcode: int = 0x2372_7093) -> None:
        self.processor = Tap(4, 0x4BA0_0477, 0xE)
        self.fabric = Tap(6, fabric_idcode, FABRIC_IDCODE)
        self.taps = (self.processor, self.fabric)
        self.state = "reset"
        self.tdo = self.tck = 0
        # Bits that CFG_IN has received, one list per scan.
        self.configuration: list[list[int]] = []
        for tap in self.taps:
            tap.reset()

    def drive(self, tck: int, tms: int, tdi: int) -> None:
        rising, self.tck = tck and not self.tck, tck
        if not rising:
            return
        if self.state in ("shift_dr", "shift_ir"):
            if self.state == "shift_dr" and self.fabric.instruction == CFG_IN:
                # The bypass register of the processor delays the bits by one clock.
                self.configuration[-1].append(self.processor.shift[0])
            bit = tdi
            for tap in self.taps:
                bit = tap.step(bit)
        self.state = NEXT[self.state][tms]
        if self.state == "reset":
            for tap in self.taps:
                tap.reset()
        elif self.state in ("capture_dr", "capture_ir"):
            for tap in self.taps:
                tap.capture(self.state == "capture_ir")
            if self.state == "capture_dr" and self.fabric.instruction == CFG_IN:
                self.configuration.append([])
        elif self.state == "update_ir":
            for tap in self.taps:
                tap.update_instruction()

    def read(self) -> int:
        return self.fabric.shift[0] if self.fabric.shift else 1


class Adapter:
    """Serves the chain on a port of this machine until OpenOCD closes the connection."""

    def __init__(self, chain: Chain) -> None:
        self.chain = chain
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.port: int = self.listener.getsockname()[1]
        self.thread = threading.Thread(target=self._serve, daemon=True)
        self.thread.start()

    def _serve(self) -> None:
        connection, _ = self.listener.accept()
        with connection:
            while data := connection.recv(65536):
                answer = bytearray()
                for byte in data:
                    if 0x30 <= byte <= 0x37:
                        code = byte - 0x30
                        self.chain.drive(code >> 2, code >> 1 & 1, code & 1)
                    elif byte == ord("R"):
                        answer.append(0x30 + self.chain.read())
                    elif byte == ord("Q"):
                        return
                if answer:
                    connection.sendall(bytes(answer))

    def wait(self) -> None:
        """Wait until the adapter has processed all bits that OpenOCD sent, because OpenOCD ends
        earlier."""
        self.thread.join(30.0)
        assert not self.thread.is_alive()
