"""The device on its serial port, from the host's side."""
