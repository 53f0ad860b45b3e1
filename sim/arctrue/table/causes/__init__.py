"""Physical causes of a wrong reading, one file each; the registry finds them by their files."""
