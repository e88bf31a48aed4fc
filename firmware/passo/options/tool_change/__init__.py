"""M6 in five ways, and the length of the new tool."""
