"""Implements ``arctrue device run``: one program, the daemon, owns the serial port of a device;
many programs watch the device through it.

``run`` starts the daemon. The serial link sends lines to the record and to the server; the server
sends events to any number of watchers and gives the console to one operator at a time.
"""
