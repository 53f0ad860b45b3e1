"""Compares methods of calibrating a rotary table, on one simulated table with equal measuring time.

Each method has one file. ``world`` contains the table and the instruments; ``compare`` runs the
methods and compares each corrected angle with the true angle.
"""
