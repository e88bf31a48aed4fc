"""Pacing: gives the step masks of a segment their ticks, and takes off them what a change of direction owes. How, stands in
pace_viper.py; kernels.py may put a port's own pace() in the place of this one."""

from passo.steps.pace_viper import pace, repay  # noqa: F401
