"""Communicates with the device from the host, over the device's serial port."""
