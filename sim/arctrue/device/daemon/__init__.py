"""``arctrue device run``: one program owns the serial port of a device, many watch it.

``run`` starts it. The serial link gives lines to the record and to the server; the server gives
events to any number of watchers and the console to one operator at a time.
"""
