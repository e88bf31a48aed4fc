"""Unipolar motors by four transistors each."""
