"""The paper's ten cycles in its own way: a servo moves the table to each face and stops it."""
