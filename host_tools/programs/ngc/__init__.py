"""RS274/NGC: programs with parameters, expressions, subroutines and loops, as LinuxCNC's manual describes them."""
