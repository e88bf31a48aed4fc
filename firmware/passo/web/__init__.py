"""The page, and what it may ask for: orders as dicts in, state and answers as dicts out.

    page ─► server ─► Session (who?) ─► Api (may it, now?) ─► machine (a language: bytes) ─► the board
                                          └─► Jog (a lease)

The page is a link like any other. It speaks a language of the board, so the same code serves a board on a cable and the virtual
board. Nothing here moves a motor by itself, and nothing here knows a step. On a PC the server is host_tools/panel/server.py; a board's
own, for its requests by HTTP, is http.py.
"""
