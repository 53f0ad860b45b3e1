"""The paper's ten cycles as they are made: a servo brings the table to each face, and it stops."""
