"""How public names are found: each when it is first used, and for one release where it was."""
