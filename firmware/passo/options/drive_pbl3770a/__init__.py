"""Bipolar motors by two PBL3770A chips each."""
