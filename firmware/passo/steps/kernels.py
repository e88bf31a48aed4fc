"""Lets a port put machine code of its own in the place of the inner loops. It must give the same bits."""

from passo.motion import line
from passo.steps import pace as pacing


def use(walk, pace):
    """`walk` for motion.line_viper.walk, `pace` for steps.pace_viper.pace."""
    line.walk = walk
    pacing.pace = pace
