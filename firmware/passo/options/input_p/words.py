"""The texts of M66 for people. No board has this file."""

STATUS = {"In": "input of M66"}
PORTUGUESE = {
    "input of M66": "entrada do M66",
}
