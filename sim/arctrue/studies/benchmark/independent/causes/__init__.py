"""Contains the physical causes of the second generator, in one module for each place where they
act."""
