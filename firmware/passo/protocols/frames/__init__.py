"""Frames around any of the languages, on the links whose board file says "frames": True."""

from passo.protocols.frames.line import FramedLine as FramedLine
