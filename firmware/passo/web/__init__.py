"""A board's network: requests by HTTP, WebSockets, who may order, and the files of the page.

    page ─► server ─► Session (who?) ─► the language of pages (protocols/page: may it, now?) ─► commands, as on any link

Nothing here moves a motor by itself, and nothing here knows a step. `passo panel` has a server of its own, host_tools/panel/server.py, with
the same rules for orders.
"""
