"""The key `tool_change`: where tools are changed and measured, and the settings $341 to $344. Only loaded if the board file has it."""

from passo.config.board_error import BoardError, want_input

RULES = {
    "tool_change": {
        "at": (list, ..., 2, 2),  # machine coordinates of X and Y, mm: where tools are changed
        "sensor": (list, ..., 2, 2),  # and where their length is found
        "distance_mm": (int, 30, 1, 1000),  # how far down from Z's top a tool has to touch
        "seek_mm_min": (int, 200, 1, 10_000),
        "locate_mm_min": (int, 25, 1, 1000),
    },
}


def check(board):
    """Check axes, probe and the two positions, whole mm; add the language's part and $341 to $344. Raises BoardError."""
    config = board["tool_change"]
    if len(board["axes"]) < 3 or not board["homing"] or "z" not in board["homing"]["sensors"]:
        raise BoardError("tool_change: it wants axes x, y, z that home")
    want_input(board, "tool_change", "probe")
    board["additions"].languages.append("passo.options.tool_change.language_grbl")
    rules = {
        341: ("tool_change_way", 0, 3, 0, 4),
        342: ("tool_change_distance", 3, config["distance_mm"] * 1000, 1000, 1_000_000),
        343: ("tool_change_locate", 3, config["locate_mm_min"] * 1000, 1000, 1_000_000),
        344: ("tool_change_seek", 3, config["seek_mm_min"] * 1000, 1000, 10_000_000),
    }
    board["additions"].settings.update(rules)
    for key in ("at", "sensor"):
        for axis in range(2):
            item = board["axes"][axis]
            travel_mm = item["travel_steps"] * 1000 // item["steps_per_m"]
            low, high = (-travel_mm, 0) if item["name"] in board["homing"]["high_end"] else (0, travel_mm)
            if not isinstance(config[key][axis], int) or not low <= config[key][axis] <= high:
                raise BoardError("tool_change.%s: whole mm within %d … %d on %s" % (key, low, high, item["name"]))
