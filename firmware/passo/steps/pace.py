"""Pacing: gives the step masks of a segment their ticks, and takes off them what a change of direction owes. How, stands in
pace_plain.py."""

try:
    from passo.steps.pace_viper import pace, repay
except (ImportError, NameError, ValueError):  # an interpreter that has no machine code of its own
    from passo.steps.pace_plain import pace, repay
